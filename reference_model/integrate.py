"""Time integration by a compiled DOP853 loop (`dop853_loop`), which knows a right-hand side, a state, scales and an event, and no model.

DOP853 (Hairer, Norsett and Wanner, Solving Ordinary Differential Equations I, section II.5): order 8, error control by the embedded
formulas of orders 5 and 3. Rows between the ends of steps are interpolated from the steps' own
stages. A step that asks for a state in which the loop cannot close is rejected like one with too large an error.
"""

from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from quickreturn.reference_model.machine.objects import Entry

STAGES: Final = 12

#: Largest step times the highest angular frequency that the equations have. On the imaginary axis DOP853 damps an oscillation to 0.70 to
#: 0.75 of itself in a step of 5.5 to 5.75, keeps it at 5.95 and makes it grow beyond; without a ceiling steps creep past that again and
#: again, and the acceleration rings as loud as the tolerance lets it (DERIVATION.md, section 5).
CEILING: Final = 5.7

REACHED_END, LEFT_FOLLOWER, STEP_TOO_SMALL, TOO_MANY_CALLS, NOT_A_NUMBER = range(5)
MAX_CALLS: Final = 200_000_000


#: The loop.
LOOP: Final = Entry("quickreturn.reference_model.dop853_loop:loop", 6 * "i" + "fiii" + "ff" + "iiii")


@dataclass(frozen=True)
class Integration:
    """What an integration delivered.

    Attributes:
        states: rows of the state vector on the output grid, as far as it was reached, shape (k, size of the state).
        status: one of the module's constants.
        end_time: s since the start of this integration, the last instant reached.
        calls: right-hand sides evaluated.
        next_step: step size (s) to continue with where the end was reached (0 for LSODA).
    """

    states: NDArray[np.float64]
    status: int
    end_time: float
    calls: int
    next_step: float


@dataclass(frozen=True)
class Equations:
    """A right-hand side in compiled code, and what it needs, by address.

    Attributes:
        function: of the equations (`reference_model.motion.equations.kernel`): dy/dt of a state; 0 where the state cannot be.
        parameters, workspace: its first two arguments.
        watched: of the state evaluated last the slider's place, m, and the highest angular frequency, rad/s, 0 where nobody knows it;
            shape (2,), part of the workspace.
    """

    function: int
    parameters: int
    workspace: int
    watched: NDArray[np.float64]


def dop853(
    equations: Equations,
    y: NDArray[np.float64],
    output_step: float,
    intervals: int,
    scales: NDArray[np.float64],
    limit: float,
    first_step: float = 0.0,
) -> Integration:
    """Integrate from the state `y` over `intervals` output steps with the compiled DOP853.

    Args:
        equations: the right-hand side.
        y: state at the start; not changed.
        output_step: grid of the output, s.
        intervals: number of output steps.
        scales: absolute local error of each state that is controlled, shape (number of them,): the first ones of the state.
        limit: slider position at which the integration ends, m.
        first_step: step size to begin with, s; 0 chooses one.
    """
    size, y, scales = len(y), np.array(y, dtype=float), np.ascontiguousarray(scales, dtype=float)
    states, scratch, K = np.empty((intervals + 1, size)), np.empty((2, size)), np.empty((STAGES + 1, size))
    watched, end = equations.watched, np.empty(4)
    at = equations.function, equations.parameters, equations.workspace
    sizes = size, output_step, intervals, scales.ctypes.data, len(scales), limit, first_step
    status = LOOP(*at, watched.ctypes.data, y.ctypes.data, *sizes, *(each.ctypes.data for each in (states, K, scratch, end)))
    rows, calls, (time, step) = int(end[0]), int(end[2]), end[1::2].tolist()
    if status == LEFT_FOLLOWER:  # in the step from `time` and `y` on, whose stages are left in K
        from quickreturn.reference_model.dop853_loop import interpolate, leaving_time

        time_left = step * leaving_time(*at, watched, y, K, step, limit)
        while rows <= intervals and rows * output_step <= time + time_left * (1.0 + 1e-12):
            interpolate(y, K, step, min((rows * output_step - time) / step, 1.0), states[rows])
            rows += 1
        time += time_left
    return Integration(states[:rows], status, time, calls, step)
