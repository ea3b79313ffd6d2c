"""Time integration by a compiled DOP853 loop (`dop853_loop`) that knows no model: a right-hand side, a state, error scales and an event.

DOP853 (Hairer, Norsett and Wanner, Solving Ordinary Differential Equations I, section II.5): order 8, error control by the embedded
formulas of orders 5 and 3. Output rows within a step are interpolated from its stages. A step that needs a state in which the loop cannot
close is rejected like one with too large an error.
"""

import math
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from quickreturn.reference_model.entries import LOOP

#: Stages of a step of DOP853; the rate at its end is the first stage of the next.
STAGES: Final = 12
#: How an integration ends.
REACHED_END, LEFT_FOLLOWER, STEP_TOO_SMALL, TOO_MANY_CALLS, NOT_A_NUMBER = range(5)


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


#: Size of the first step, and of the least, over the time of the motion: that of the output would make the rows change the steps.
FIRST_STEP: Final = 1e-3
LEAST_STEP: Final = 1e-11


@dataclass(frozen=True)
class Equations:
    """A right-hand side in compiled code, and its first arguments, by address.

    Attributes:
        function: address of the equations (see `reference_model.motion.equations.kernel`). They write dy/dt of a state, and return 0 where
            the state is impossible.
        parameters, workspace: addresses of its first two arguments.
        watched: slider position (m) and highest angular frequency (rad/s, 0 if unknown) of the state evaluated last; shape (2,), part of
            the workspace.
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
    pace: float,
    first_step: float = 0.0,
) -> Integration:
    """Integrate from the state `y` over `intervals` output steps with the compiled DOP853.

    Args:
        equations: the right-hand side.
        y: state at the start; not changed.
        output_step: grid of the output, s.
        intervals: number of output steps.
        scales: accepted local error of each controlled state, in its unit, shape (number of them,). The controlled states come first.
        limit: slider position at which the integration ends, m.
        pace: rate of the motion, 1/s, such as `constants.pace`, which gives the sizes of the first step and of the least.
        first_step: step size to begin with, s; 0 for `FIRST_STEP`.
    """
    size, controlled = len(y), len(scales)
    width = 4 * math.ceil(size / 4)  # four numbers take one register
    padded, precisions = np.zeros(width), np.zeros(width)
    padded[:size], precisions[:controlled] = y, 1.0 / scales
    states, scratch, K = np.zeros((intervals + 1, width)), np.zeros((2, width)), np.zeros((STAGES + 1, width))
    watched, end = equations.watched, np.empty(4)
    at = equations.function, equations.parameters, equations.workspace
    sizes = width, output_step, intervals, precisions.ctypes.data, controlled, limit, first_step or FIRST_STEP / pace, LEAST_STEP / pace
    status = LOOP(*at, watched.ctypes.data, padded.ctypes.data, *sizes, *(each.ctypes.data for each in (states, K, scratch, end)))
    rows, calls, (time, step) = int(end[0]), int(end[2]), end[1::2].tolist()
    return Integration(np.ascontiguousarray(states[:rows, :size]), status, time, calls, step)
