"""Exudyn's names for the model: from its module without range checks, which takes a seventh less time and differs in rounding alone.

A process that has loaded Exudyn, has set `sys.exudynFast`, or has EXUDYN_MODULE in its environment keeps what it chose.
"""

import contextlib
import io
import os
import sys

if not ("exudyn" in sys.modules or hasattr(sys, "exudynFast") or "EXUDYN_MODULE" in os.environ):
    vars(sys)["exudynFast"] = True
with contextlib.redirect_stdout(io.StringIO()):  # it prints which module it loads
    import exudyn as exu
    from exudyn import itemInterface as items  # noqa: N813

__all__ = ["exu", "items"]
