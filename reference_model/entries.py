"""The compiled functions that Python calls for a beam: its equations, the observables of its states, and two integrators.

Each is imported, and with it the compiler, where no object of it is on the disk.
"""

import os
from collections.abc import Callable
from contextlib import AbstractContextManager, nullcontext
from pathlib import Path
from typing import Any, Final

from quickreturn.reference_model.native.cache_folder import VARIABLE
from quickreturn.reference_model.native.objects import Entry


def _equations() -> Callable[..., int]:
    from quickreturn.reference_model.motion.equations import kernel

    return kernel


def _observations() -> Callable[..., int]:
    from quickreturn.reference_model.motion.observe import observe_states

    return observe_states


def _loop() -> Callable[..., int]:
    from quickreturn.reference_model.dop853_loop import loop

    return loop


def _steps() -> Callable[..., int]:
    from quickreturn.reference_model.crank_angle_steps import steps_to

    return steps_to


def _second_process() -> AbstractContextManager[Any]:
    """The process of `first_start`, whose end is that of the context; none if the equations of motion are on the disk."""
    import subprocess
    import sys

    if any(Path(os.environ[VARIABLE]).glob("*/equations.kernel-*.nbi")):
        return nullcontext()
    quiet = subprocess.DEVNULL
    return subprocess.Popen([sys.executable, "-P", "-m", f"{__package__}.first_start"], stdin=quiet, stdout=quiet, stderr=quiet)


#: The equations of motion, and the observables of states.
KERNEL: Final = Entry(_equations, 4 * "i", _second_process)
OBSERVATIONS: Final = Entry(_observations, 8 * "i")
#: The integrator, and its steps in the crank angle.
LOOP: Final = Entry(_loop, 6 * "i" + "fiii" + "fff" + "iiii")
STEPS: Final = Entry(_steps, 5 * "i" + "fii")
