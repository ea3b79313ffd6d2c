"""Time integration by a compiled DOP853 loop that knows no model: only a right-hand side, a state, error scales and an event.

DOP853 (Hairer, Norsett and Wanner, Solving Ordinary Differential Equations I, section II.5): order 8, error control by the embedded
formulas of orders 5 and 3. Output rows within a step are interpolated from its stages. A step that needs a state in which the loop cannot
close is rejected like one with too large an error.
"""

import math
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from quickreturn.reference_model.dop853 import E3, E5, INTERPOLATED, INTERPOLATION, A
from quickreturn.reference_model.machine.compilation import compiled, without_references
from quickreturn.reference_model.machine.pointers import call_equations

STAGES: Final = 12

#: Largest product of the step and the equations' highest angular frequency. DOP853 shrinks an undamped oscillation to 0.70 to 0.75 of
#: itself in a step of 5.5 to 5.75, keeps it at 5.95 and makes it grow beyond. Without a ceiling steps pass that again and again, and the
#: acceleration rings as much as the tolerance allows (DERIVATION.md, section 5).
CEILING: Final = 5.7

REACHED_END, LEFT_FOLLOWER, STEP_TOO_SMALL, TOO_MANY_CALLS, NOT_A_NUMBER = range(5)
MAX_CALLS: Final = 200_000_000


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
        first_step: step size to begin with, s; 0 chooses one.
    """
    size, y = len(y), np.array(y)
    states, scratch, K = np.empty((intervals + 1, size)), np.empty((2, size)), np.empty((STAGES + 1, size))
    at = (equations.function, equations.parameters, equations.workspace, equations.watched)
    status, rows, time, calls, step = _dop853(*at, y, output_step, intervals, scales, limit, first_step, states, K, scratch)
    if status == LEFT_FOLLOWER:  # within the step of size `step` from `time` and `y`, whose stages are in K
        time_left = step * _leaving_time(*at, y, K, step, limit)
        while rows <= intervals and rows * output_step <= time + time_left * (1.0 + 1e-12):
            _interpolate(y, K, step, min((rows * output_step - time) / step, 1.0), states[rows])
            rows += 1
        time += time_left
    return Integration(states[:rows], status, time, calls, step)


@compiled
def _leaving_time(
    function: int,
    parameters: int,
    workspace: int,
    watched: NDArray[np.float64],
    y: NDArray[np.float64],
    K: NDArray[np.float64],
    h: float,
    limit: float,
) -> float:
    """Fraction of the step `h` from `y` at which the slider passes `limit`, by bisection."""
    state, rate = np.empty(len(y)), np.empty(len(y))
    low, high = 0.0, 1.0
    for _ in range(45):
        middle = 0.5 * (low + high)
        _interpolate(y, K, h, middle, state)
        if call_equations(function, parameters, workspace, state.ctypes.data, rate.ctypes.data, 0) == 1 and watched[0] <= limit:
            low = middle
        else:
            high = middle
    return low


@without_references
def _dop853(
    function: int,
    parameters: int,
    workspace: int,
    watched: NDArray[np.float64],
    y: NDArray[np.float64],
    output_step: float,
    intervals: int,
    scales: NDArray[np.float64],
    limit: float,
    step: float,
    states: NDArray[np.float64],
    K: NDArray[np.float64],
    scratch: NDArray[np.float64],
) -> tuple[int, int, float, int, float]:
    """Status, rows filled, time (s), right-hand sides evaluated and next step (s); for LEFT_FOLLOWER begin and size of the last step."""
    controlled = len(scales)
    end = output_step * intervals
    t = 0.0
    new, trial = scratch[0], scratch[1]
    _copy(y, states[0])
    rows, calls = 1, 0
    if step <= 0.0:
        step = min(1e-5, end)
    rejected, first_stage = False, 0
    while t < end:
        if step < 1e-13 or calls > MAX_CALLS:
            return (STEP_TOO_SMALL if step < 1e-13 else TOO_MANY_CALLS), rows, t, calls, step
        h = min(step, end - t)
        last = h >= end - t
        for stage in range(first_stage, STAGES + 1):
            state = new if stage == STAGES else trial
            _stage_state(y, K, stage, h, state)
            calls += 1
            if call_equations(function, parameters, workspace, state.ctypes.data, K[stage].ctypes.data, 0) == 0:
                if stage == 0:
                    return NOT_A_NUMBER, rows, t, calls, step
                norm = 1e9
                break
        else:
            norm = _error_norm(K, h, scales, controlled)
        first_stage = 1
        if not norm < 1.0:  # also where the norm is nan
            step = h * (max(0.333, 0.9 * norm**-0.125) if norm < 1e8 else 0.25)
            rejected = True
            continue
        if watched[0] > limit:
            return LEFT_FOLLOWER, rows, t, calls, h
        while rows <= intervals and rows * output_step <= t + h * (1.0 + 1e-12):
            _interpolate(y, K, h, min((rows * output_step - t) / h, 1.0), states[rows])
            rows += 1
        t = end if last else t + h
        _copy(new, y)
        _copy(K[STAGES], K[0])
        growth = 5.0 if norm < 1e-12 else min(5.0, 0.9 * norm**-0.125)
        # a step cut at the end of the interval says nothing about the next
        step = max(step, h) if last and h < step else h * (min(growth, 1.0) if rejected else growth)
        if step * watched[1] > CEILING:
            step = CEILING / watched[1]
        rejected = False
    return REACHED_END, rows, t, calls, step


@without_references
def _copy(source: NDArray[np.float64], target: NDArray[np.float64]) -> None:
    for i in range(len(source)):
        target[i] = source[i]


@without_references
def _stage_state(y: NDArray[np.float64], K: NDArray[np.float64], stage: int, h: float, out: NDArray[np.float64]) -> None:
    """To `out`: the state at which a stage of the step `h` from `y` is evaluated."""
    for i in range(len(y)):
        out[i] = y[i]
    for j in range(stage):
        weight = h * A[stage, j]
        if weight != 0.0:
            for i in range(len(y)):
                out[i] += weight * K[j, i]


@without_references
def _error_norm(K: NDArray[np.float64], h: float, scales: NDArray[np.float64], controlled: int) -> float:
    """Error of the step relative to `scales`, as in `dop853.f`: a step is accepted below 1."""
    error5 = error3 = 0.0
    for i in range(controlled):
        e5 = e3 = 0.0
        for stage in range(STAGES + 1):
            e5 += E5[stage] * K[stage, i]
            e3 += E3[stage] * K[stage, i]
        error5 += (e5 / scales[i]) ** 2
        error3 += (e3 / scales[i]) ** 2
    if error5 == 0.0 and error3 == 0.0:
        return 0.0
    return h * error5 / math.sqrt((error5 + 0.01 * error3) * controlled)


@without_references
def _interpolate(y: NDArray[np.float64], K: NDArray[np.float64], h: float, u: float, out: NDArray[np.float64]) -> None:
    """The state at the fraction `u` of the step from `y` on, by its stages' rates `K` (equation 5.16)."""
    _copy(y, out)
    for j in range(len(INTERPOLATED)):
        weight = 0.0
        for power in range(INTERPOLATION.shape[1] - 1, -1, -1):
            weight = weight * (2.0 * u - 1.0) + INTERPOLATION[j, power]
        for i in range(len(y)):
            out[i] += h * weight * K[INTERPOLATED[j], i]
