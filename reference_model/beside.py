"""A second process that compiles what an integration needs beside the equations of motion, while the first compiles those.

Compiling takes one core; on two the first start is shorter by a third. Where the second process cannot be had, or compiles what is not
asked for, the first compiles what it misses: then only time is lost.
"""

import gc
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from numba import config, types

from quickreturn.reference_model.motion.address import MEMBERS


def wanted() -> list[tuple[Any, tuple[types.Type, ...]]]:
    """What is compiled beside: functions, each with the types of its arguments."""
    from quickreturn.reference_model.integrate import _dop853
    from quickreturn.reference_model.motion.equations import observe_states

    whole, real, vector, matrix = types.int64, types.float64, MEMBERS["Vector"], MEMBERS["Matrix"]
    addresses = (whole, whole, whole)
    return [
        (observe_states, (*addresses, matrix, matrix)),
        (_dop853, (*addresses, vector, vector, real, whole, vector, real, real, matrix, matrix, matrix)),
    ]


@contextmanager
def helped() -> Iterator[None]:
    """What is compiled in the meantime is not to be compiled here: at the end it is on the disk. Does nothing if it is there already."""
    if any(Path(config.CACHE_DIR).glob("*/equations._kernel-*.nbi")):  # type: ignore[attr-defined]
        yield
        return
    command = [sys.executable, "-P", "-m", __name__]
    quiet = subprocess.DEVNULL
    with subprocess.Popen(command, stdin=quiet, stdout=quiet, stderr=quiet):
        yield


if __name__ == "__main__":
    gc.disable()  # as engines.accurate has it while it compiles
    for function, signature in wanted():
        function.compile(signature)
