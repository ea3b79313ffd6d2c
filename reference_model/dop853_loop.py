"""The compiled loop of DOP853 (see `integrate`), and Runge-Kutta steps of the equations of motion in the crank angle.

All rows of numbers of the loop are padded with zeros to a multiple of four.
"""

import math
from typing import Final

import numpy as np
from scipy.integrate import DOP853  # takes 0.3 s to import: only the compiled loop imports this module

from quickreturn.reference_model.arrays import Array
from quickreturn.reference_model.integrate import LEFT_FOLLOWER, NOT_A_NUMBER, REACHED_END, STAGES, STEP_TOO_SMALL, TOO_MANY_CALLS
from quickreturn.reference_model.native.compilation import inner
from quickreturn.reference_model.native.pointers import call_equations, matrix_at, numbers_at
from quickreturn.reference_model.native.simd import load, plus, spread, store, total

#: Largest product of the step and the equations' highest angular frequency. DOP853 shrinks an undamped oscillation to 0.70 to 0.75 of
#: itself in a step of 5.5 to 5.75, keeps it at 5.95 and makes it grow beyond. Without a ceiling steps pass that again and again, and the
#: acceleration rings as much as the tolerance allows (DERIVATION.md, section 5).
CEILING: Final = 5.7
MAX_CALLS: Final = 200_000_000


@inner
def _leaving_fraction(
    function: int,
    parameters: int,
    workspace: int,
    watched: Array,
    y: Array,
    K: Array,
    h: float,
    limit: float,
    scratch: Array,
) -> float:
    """Fraction of the step of size h that begins in y, where the slider passes `limit`; by bisection. K: the step's stages."""
    state, rate = scratch[0], scratch[1]
    low, high = 0.0, 1.0
    for _ in range(45):
        middle = 0.5 * (low + high)
        _interpolate(y, K, h, middle, state)
        if call_equations(function, parameters, workspace, state.ctypes.data, rate.ctypes.data) == 1 and watched[0] <= limit:
            low = middle
        else:
            high = middle
    return low


@inner
def _dop853(
    function: int,
    parameters: int,
    workspace: int,
    watched: Array,
    y: Array,
    output_step: float,
    intervals: int,
    precisions: Array,
    controlled: int,
    limit: float,
    step: float,
    least_step: float,
    states: Array,
    K: Array,
    scratch: Array,
) -> tuple[int, int, float, int, float]:
    """Integrates `y` over `intervals` output steps, as `integrate.dop853` describes; rows go into `states`, K and scratch are overwritten.

    `precisions`: one over the accepted local error, 0 for the states that are not controlled.

    Returns: status; number of rows written; last instant that was reached, s; evaluations; size of the step that would follow, s.
    """
    end = output_step * intervals
    t = 0.0
    new, trial = scratch[0], scratch[1]
    _copy(y, states[0])
    rows, calls = 1, 0
    rejected, first_stage = False, 0
    while t < end:
        too_small = step < least_step or t + step == t
        if too_small or calls > MAX_CALLS:
            return (STEP_TOO_SMALL if too_small else TOO_MANY_CALLS), rows, t, calls, step
        h = min(step, end - t)
        last = h >= end - t
        for stage in range(first_stage, STAGES + 1):
            state = new if stage == STAGES else trial
            _stage_state(y, K, stage, h, state)
            calls += 1
            if call_equations(function, parameters, workspace, state.ctypes.data, K[stage].ctypes.data) == 0:
                if stage == 0:
                    return NOT_A_NUMBER, rows, t, calls, step
                norm = 1e9
                break
        else:
            norm = _error_norm(K, h, precisions, controlled)
        first_stage = 1
        if not norm < 1.0:  # also where the norm is nan
            step = h * (max(0.333, 0.9 * norm**-0.125) if norm < 1e8 else 0.25)
            rejected = True
            continue
        left = watched[0] > limit
        made = h * _leaving_fraction(function, parameters, workspace, watched, y, K, h, limit, scratch) if left else h
        while rows <= intervals and rows * output_step <= t + made * (1.0 + 1e-12):
            _interpolate(y, K, h, min((rows * output_step - t) / h, 1.0), states[rows])
            rows += 1
        if left:
            return LEFT_FOLLOWER, rows, t + made, calls, h
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


@inner
def _copy(source: Array, target: Array) -> None:
    for i in range(len(source)):
        target[i] = source[i]


@inner
def _stage_state(y: Array, K: Array, stage: int, h: float, out: Array) -> None:
    for i in range(0, len(y), 4):
        rate = spread(0.0)
        for j in range(stage):
            if A[stage, j] != 0.0:
                rate = plus(rate, A[stage, j], load(K[j], i))
        store(out, i, plus(load(y, i), h, rate))


@inner
def _error_norm(K: Array, h: float, precisions: Array, controlled: int) -> float:
    squares5 = squares3 = spread(0.0)
    for i in range(0, len(precisions), 4):
        e5 = e3 = spread(0.0)
        for stage in range(STAGES + 1):
            e5 = plus(e5, E5[stage], load(K[stage], i))
            e3 = plus(e3, E3[stage], load(K[stage], i))
        e5, e3 = plus(spread(0.0), e5, load(precisions, i)), plus(spread(0.0), e3, load(precisions, i))
        squares5, squares3 = plus(squares5, e5, e5), plus(squares3, e3, e3)
    error5, error3 = total(squares5), total(squares3)
    if error5 == 0.0 and error3 == 0.0:
        return 0.0
    return h * error5 / math.sqrt((error5 + 0.01 * error3) * controlled)


@inner
def _interpolate(y: Array, K: Array, h: float, u: float, out: Array) -> None:
    """The state at the fraction `u` of the step from `y` on, by its stages' rates `K` (equation 5.16)."""
    _copy(y, out)
    for j in range(len(INTERPOLATED)):
        weight = 0.0
        for power in range(INTERPOLATION.shape[1] - 1, -1, -1):
            weight = weight * (2.0 * u - 1.0) + INTERPOLATION[j, power]
        for i in range(0, len(y), 4):
            store(out, i, plus(load(out, i), h * weight, load(K[INTERPOLATED[j]], i)))


def loop(
    function: int,
    parameters: int,
    workspace: int,
    watched: int,
    y: int,
    size: int,
    output_step: float,
    intervals: int,
    precisions: int,
    controlled: int,
    limit: float,
    step: float,
    least_step: float,
    states: int,
    K: int,
    scratch: int,
    reached: int,
) -> int:
    """As `_dop853`, with arrays by address; the status, and in `reached` (4,) number of rows, last instant, calls and next step."""
    at = function, parameters, workspace, numbers_at(watched, 2), numbers_at(y, size)
    how = output_step, intervals, numbers_at(precisions, size), controlled
    arrays = matrix_at(states, intervals + 1, size), matrix_at(K, STAGES + 1, size), matrix_at(scratch, 2, size)
    ended = numbers_at(reached, 4)
    status, ended[0], ended[1], ended[2], ended[3] = _dop853(*at, *how, limit, step, least_step, *arrays)
    return status


#: Weights of the stages before each stage, shape (13, 13): twelve of the step, and its end.
A: Final = np.vstack([np.pad(DOP853.A, ((0, 0), (0, 1))), np.append(DOP853.B, 0.0)])
#: Errors of orders 3 and 5: weights of the step's stages and its end, shape (13,).
E3: Final[Array] = DOP853.E3
E5: Final[Array] = DOP853.E5
#: Stages that the interpolation uses: those with a weight in the step, and the step's end.
INTERPOLATED: Final = (0, *range(5, 13))


def _interpolation() -> Array:
    """Weights of the `INTERPOLATED` stages at the fraction u of a step (equation 5.17), in powers of 2 u - 1, shape (9, 8)."""
    c = A.sum(axis=1)
    powers = np.vander(2.0 * c - 1.0, 7, increasing=True).T
    conditions = np.array([*powers, A @ A @ c**3 - c**5 / 20, A @ A @ A @ A @ c - c**5 / 120])[:, INTERPOLATED]
    integrals = np.zeros((len(INTERPOLATED), 8))  # of the powers from 0 to u; the last two conditions have the right side 0
    for k in range(7):
        integrals[k, k + 1], integrals[k, 0] = 0.5 / (k + 1), 0.5 * (-1) ** k / (k + 1)
    return np.linalg.solve(conditions, integrals)


INTERPOLATION: Final = _interpolation()


def steps_to(function: int, parameters: int, workspace: int, state: int, size: int, angle: float, parts: int, scratch: int) -> int:
    """Move a state, in place, to a crank angle (rad) by `parts` classical Runge-Kutta steps of equal angle (equation 10.3).

    `poincare.turn_to` calls it.

    Args:
        function: address of the equations of motion.
        parameters: address of their parameters.
        workspace: address of their workspace.
        state: address of the state (size,), whose first entry is the crank angle.
        size: of the state.
        angle: where it ends, rad.
        parts: number of steps.
        scratch: address of memory (6, size): four stages, a trial state, and first in the last row the time (s) that passes.

    Returns:
        1; or 0 if a state on the way is impossible.
    """
    y, K = numbers_at(state, size), matrix_at(scratch, 6, size)
    h = (angle - y[0]) / parts
    elapsed = 0.0
    trial = K[4]
    for _ in range(parts):
        for stage in range(4):
            reach = 0.0 if stage == 0 else h if stage == 3 else 0.5 * h
            for i in range(size):
                trial[i] = y[i] + (reach * K[stage - 1, i] if stage > 0 else 0.0)
            if call_equations(function, parameters, workspace, trial.ctypes.data, K[stage].ctypes.data) == 0:
                return 0
            time_by_angle = 1.0 / K[stage, 0]
            elapsed += h * time_by_angle * (1.0 if stage in (0, 3) else 2.0) / 6.0
            for i in range(size):
                K[stage, i] *= time_by_angle
        for i in range(size):
            y[i] += h * (K[0, i] + 2.0 * K[1, i] + 2.0 * K[2, i] + K[3, i]) / 6.0
    y[0] = angle
    K[5, 0] = elapsed
    return 1
