"""Flexible-multibody engines on a quick-return mechanism.

    import quickreturn as qr
    case = qr.case("thesis-24", {"crank.length": "5 in"})
    print(qr.simulate(case, "reference", accuracy=1e-3))

Notebooks, engine authors and the command line use the names of `__init__.pyi`. Each is imported on its first use.
"""

import re
from functools import cache
from importlib import import_module
from typing import Any


@cache
def _homes() -> dict[str, str]:
    """Public name -> the module that defines it."""
    with open(f"{__file__}i", encoding="utf-8") as names:  # `__init__.pyi`
        return {name: module for module, name in re.findall(r"^from (\S+) import (\w+) as", names.read(), re.MULTILINE)}


def __getattr__(name: str) -> Any:
    if name == "__version__":
        from importlib.metadata import version

        return version("quickreturn")
    if name == "__all__":  # `from quickreturn import *` asks for it
        return sorted(_homes())
    if name not in _homes():
        from difflib import get_close_matches

        near = get_close_matches(name, _homes(), 1)
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}" + "".join(f"; the nearest one is {each}" for each in near))
    value = getattr(import_module(_homes()[name]), name)
    globals()[name] = value
    return value


def __dir__() -> list[str]:
    return [*sorted(_homes()), "__version__"]
