"""The compiled functions that Python calls for a beam: its equations, the observables of its states, and two integrators.

Each is imported, and with it the compiler, where no object of it is on the disk.
"""

from collections.abc import Callable
from typing import Final

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


#: The equations of motion, and the observables of states.
KERNEL: Final = Entry(_equations, 4 * "i")
OBSERVATIONS: Final = Entry(_observations, 8 * "i")
#: The integrator, and its steps in the crank angle.
LOOP: Final = Entry(_loop, 6 * "i" + "fiii" + "fff" + "iiii")
STEPS: Final = Entry(_steps, 5 * "i" + "fii")
