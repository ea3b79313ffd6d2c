"""Time integration of the explicit model: a compiled DOP853 loop, and LSODA as the thesis used it.

DOP853 (Hairer, Norsett and Wanner, Solving Ordinary Differential Equations I, section II.5): order 8, error control by the embedded
formulas of orders 5 and 3, dense output of order 7. The coefficients are those of scipy. A step that asks for a state in which the
loop cannot close is rejected like one with too large an error.
"""

import math
import warnings
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray
from scipy.integrate import DOP853, ODEintWarning, odeint

from reference_model.clamped_parameters import ClampedParameters
from reference_model.compilation import borrowing
from reference_model.equations import AnyParameters, AnyWorkspace, right_hand_side
from reference_model.moving_parameters import MovingParameters

STAGES: Final = 12
_A = np.vstack([np.hstack([DOP853.A, np.zeros((STAGES, 4))]), np.zeros((1, 16)), DOP853.A_EXTRA])
_A[STAGES, :STAGES] = DOP853.B
_E3, _E5, _D = (np.ascontiguousarray(a) for a in (DOP853.E3, DOP853.E5, DOP853.D))

#: Largest step times the highest angular frequency that the equations have. On the imaginary axis DOP853 damps an oscillation to 0.70 to
#: 0.75 of itself in a step of 5.5 to 5.75, keeps it at 5.95 and makes it grow beyond; without a ceiling steps creep past that again and
#: again, and the acceleration rings as loud as the tolerance lets it (DERIVATION.md, section 6).
CEILING: Final = 5.7

#: A right-hand side: writes dy/dt of a state to its last argument; False where the state cannot be.
Equations = Callable[[Any, Any, NDArray[np.float64], NDArray[np.float64]], bool]

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


def error_scales(p: AnyParameters, speed: float) -> NDArray[np.float64]:
    """Sizes against which the relative tolerance is taken, one per controlled state: fixed, so that none vanishes.

    The scene's `deflection_scale` for coordinates of the shapes (times the root of the follower's mass where the shapes are
    mass-normalised) and that times a characteristic frequency for their rates, a hundredth of the length for the slider, a tenth of
    a radian for the crank and a tenth of its speed. The energies at the end of the state are quadratures and not controlled.
    """
    n, frequency = p.n, 10.0 * math.sqrt(p.EI / p.rhoA) / p.L**2 if p.n else 1.0
    crank = [0.1, 0.1 * max(abs(speed), 1.0)]
    if isinstance(p, ClampedParameters):
        shape = 0.01 * p.L * math.sqrt(p.rhoA * p.L)
        return np.array([crank[0], *[shape] * n, crank[1], *[shape * frequency] * n])
    if isinstance(p, MovingParameters):
        shape = p.deflection_scale * math.sqrt(p.rhoA * p.L)
        return np.array([crank[0], *[shape] * n, 0.01 * p.L, crank[1], *[shape * frequency] * n])
    shape = p.deflection_scale
    return np.array([crank[0], *[shape] * n, crank[1], *[shape * frequency] * n])


def integrate_dop853(
    p: AnyParameters, w: AnyWorkspace, y: NDArray[np.float64], output_step: float, intervals: int, tolerance: float, first_step: float = 0.0
) -> Integration:
    """Integrate from the state `y` over `intervals` output steps (s) with the compiled DOP853.

    Args:
        p: parameters of the model.
        w: its workspace.
        y: state at the start; not changed.
        output_step: grid of the output, s.
        intervals: number of output steps.
        tolerance: local error relative to `error_scales`.
        first_step: step size to begin with, s; 0 chooses one.
    """
    limit = p.reach if isinstance(p, MovingParameters) else p.L
    scales = error_scales(p, _crank_speed(p, y)) * tolerance
    return dop853(right_hand_side, p, w, y, output_step, intervals, scales, limit, first_step)


def dop853(
    equations: Equations,
    p: Any,
    w: Any,
    y: NDArray[np.float64],
    output_step: float,
    intervals: int,
    scales: NDArray[np.float64],
    limit: float,
    first_step: float,
) -> Integration:
    """The same with any equations, absolute local errors and limit of the slider.

    Args:
        equations: the right-hand side of `p` and `w` in Python.
        p: parameters of a model whose equations `right_hand_side` knows in compiled code.
        w: its workspace; `w.slider` holds where the slider is in the state evaluated last, m, and the highest angular frequency there,
            rad/s, 0 where nobody knows it.
        y: state at the start; not changed.
        output_step: grid of the output, s.
        intervals: number of output steps.
        scales: local error of each state that is controlled, shape (number of them,).
        limit: slider position at which the integration ends, m.
        first_step: step size to begin with, s; 0 chooses one.
    """
    size, y = len(y), y.copy()
    states, scratch = np.empty((intervals + 1, size)), np.empty((9, size))
    loop = (p, w, y, output_step, intervals, scales, limit, first_step, states, np.empty((16, size)), scratch)
    status, rows, time, calls, step = _dop853(*loop)
    if status == LEFT_FOLLOWER:  # in the step from `time` and `y` on, whose interpolation is left in the scratch
        F = scratch[2:]
        time_left = step * _leaving_time(equations, p, w, y, F, limit)
        while rows <= intervals and rows * output_step <= time + time_left * (1.0 + 1e-12):
            _interpolate(y, F, min((rows * output_step - time) / step, 1.0), states[rows])
            rows += 1
        time += time_left
    return Integration(states[:rows], status, time, calls, step)


def _leaving_time(equations: Equations, p: Any, w: Any, y: NDArray[np.float64], F: NDArray[np.float64], limit: float) -> float:
    """Fraction of the step at which the slider passes `limit`, by bisection.

    In Python: compiled, it took 5 to 7 s of compiling for each model, since it brings in the equations a second time.
    """
    state, rate = np.empty(len(y)), np.empty(len(y))
    low, high = 0.0, 1.0
    for _ in range(45):
        middle = 0.5 * (low + high)
        _interpolate(y, F, middle, state)
        if equations(p, w, state, rate) and w.slider[0] <= limit:
            low = middle
        else:
            high = middle
    return low


@borrowing
def _dop853(
    p: AnyParameters,
    w: AnyWorkspace,
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
    controlled = len(scales)
    end = output_step * intervals
    t = 0.0
    new, trial, F = scratch[0], scratch[1], scratch[2:]
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
        left, shown = False, False
        norm = 1e9
        # one call of the equations serves the stages of the step and, where the step is accepted and shown, those of its interpolation
        for stage in range(first_stage, 16):
            state = new if stage == STAGES else trial
            _stage_state(y, K, stage, h, state)
            calls += 1
            if not right_hand_side(p, w, state, K[stage]):
                if stage == 0:
                    return NOT_A_NUMBER, rows, t, calls, step
                norm = 1e9
                break
            if stage == STAGES:
                norm = _error_norm(K, h, scales, controlled)
                left = w.slider[0] > limit
                shown = left or (rows <= intervals and rows * output_step <= t + h * (1.0 + 1e-12))
                if not (norm < 1.0 and shown):
                    break
        first_stage = 1
        if not norm < 1.0:  # also where the norm is nan
            step = h * (max(0.333, 0.9 * norm**-0.125) if norm < 1e8 else 0.25)
            rejected = True
            continue
        if shown:
            _dense_coefficients(y, new, K, h, F)
            if left:
                return LEFT_FOLLOWER, rows, t, calls, h
            while rows <= intervals and rows * output_step <= t + h * (1.0 + 1e-12):
                _interpolate(y, F, min((rows * output_step - t) / h, 1.0), states[rows])
                rows += 1
        t = end if last else t + h
        _copy(new, y)
        _copy(K[STAGES], K[0])
        growth = 5.0 if norm < 1e-12 else min(5.0, 0.9 * norm**-0.125)
        # a step cut at the end of the interval says nothing about the next
        step = max(step, h) if last and h < step else h * (min(growth, 1.0) if rejected else growth)
        if step * w.slider[1] > CEILING:
            step = CEILING / w.slider[1]
        rejected = False
    return REACHED_END, rows, t, calls, step


@borrowing
def _copy(source: NDArray[np.float64], target: NDArray[np.float64]) -> None:
    for i in range(len(source)):
        target[i] = source[i]


@borrowing
def _stage_state(y: NDArray[np.float64], K: NDArray[np.float64], stage: int, h: float, out: NDArray[np.float64]) -> None:
    for i in range(len(y)):
        out[i] = y[i]
    for j in range(stage):
        weight = h * _A[stage, j]
        if weight != 0.0:
            for i in range(len(y)):
                out[i] += weight * K[j, i]


@borrowing
def _error_norm(K: NDArray[np.float64], h: float, scales: NDArray[np.float64], controlled: int) -> float:
    error5 = error3 = 0.0
    for i in range(controlled):
        e5 = e3 = 0.0
        for stage in range(STAGES + 1):
            e5 += _E5[stage] * K[stage, i]
            e3 += _E3[stage] * K[stage, i]
        error5 += (e5 / scales[i]) ** 2
        error3 += (e3 / scales[i]) ** 2
    if error5 == 0.0 and error3 == 0.0:
        return 0.0
    return h * error5 / math.sqrt((error5 + 0.01 * error3) * controlled)


@borrowing
def _dense_coefficients(y: NDArray[np.float64], new: NDArray[np.float64], K: NDArray[np.float64], h: float, F: NDArray[np.float64]) -> None:
    for i in range(len(y)):
        delta = new[i] - y[i]
        F[0, i] = delta
        F[1, i] = h * K[0, i] - delta
        F[2, i] = 2.0 * delta - h * (K[STAGES, i] + K[0, i])
        for m in range(4):
            total = 0.0
            for stage in range(16):
                total += _D[m, stage] * K[stage, i]
            F[3 + m, i] = h * total


@borrowing
def _interpolate(y: NDArray[np.float64], F: NDArray[np.float64], u: float, out: NDArray[np.float64]) -> None:
    for i in range(len(y)):
        value = 0.0
        for m in range(7):
            value = (value + F[6 - m, i]) * (u if m % 2 == 0 else 1.0 - u)
        out[i] = y[i] + value


def integrate_lsoda(
    p: AnyParameters, w: AnyWorkspace, y: NDArray[np.float64], output_step: float, intervals: int, tolerance: float
) -> Integration:
    """The same with LSODA (thesis, section 5.2), called once per output step as there; arguments as in `integrate_dop853`."""
    size = len(y)
    rate = np.empty(size)

    def fun(_: float, state: NDArray[np.float64]) -> NDArray[np.float64]:
        right_hand_side(p, w, state, rate)
        return rate

    scales = np.full(size, 1e3)  # energies are quadratures: not controlled
    controlled = error_scales(p, _crank_speed(p, y))
    scales[: len(controlled)] = controlled
    times = output_step * np.arange(intervals + 1)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", ODEintWarning)
        states, info = odeint(
            fun, y, times, tfirst=True, rtol=1e-14, atol=tolerance * scales, mxstep=100_000, full_output=True, printmessg=False
        )
    good, status = len(states), REACHED_END
    if info["message"] != "Integration successful.":
        # the rows after the first one not reached are not even initialised
        good, status = 1 + int(np.argmax(info["tcur"] < times[1:] - 1e-12)), STEP_TOO_SMALL
    for row in range(good):
        if not (np.all(np.isfinite(states[row])) and right_hand_side(p, w, states[row], rate)):
            good, status = row, NOT_A_NUMBER
            break
        if w.slider[0] > p.L:
            good, status = row, LEFT_FOLLOWER
            break
    return Integration(states[:good], status, times[max(good - 1, 0)], int(info["nfe"][-1]), 0.0)


def _crank_speed(p: AnyParameters, y: NDArray[np.float64]) -> float:
    return float(y[p.n + (2 if isinstance(p, MovingParameters) else 1)])
