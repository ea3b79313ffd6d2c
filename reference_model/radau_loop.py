"""The compiled loop of Radau IIA, order 5 (see `integrate`); equation numbers are those of RADAU.md."""

import math
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from quickreturn.reference_model.arrays import Array
from quickreturn.reference_model.integrate import LEFT_FOLLOWER, NOT_A_NUMBER, REACHED_END, STEP_TOO_SMALL, TOO_MANY_CALLS, RadauRun
from quickreturn.reference_model.native.compilation import inner
from quickreturn.reference_model.native.pointers import call_equations, reader

#: Newton's iteration ends where what is left is this fraction of the accepted local error, and fails after so many iterations.
NEWTON: Final = 0.03
MAX_ITERATIONS: Final = 10
#: Largest ratio of successive changes for which the step may grow; the ratio grows with the square of the step.
CONTRACTION: Final = 0.5
MAX_CALLS: Final = 200_000_000

_ROOT: Final = math.sqrt(6.0)
#: Instants of the stages as fractions of a step, and weights of their rates (equation 1).
C: Final = np.array([(4.0 - _ROOT) / 10.0, (4.0 + _ROOT) / 10.0, 1.0])
A: Final = (C[:, None] ** [1, 2, 3] / [1, 2, 3]) @ np.linalg.inv(np.vander(C, increasing=True))
#: Rates of the stages from their increments.
RATES: Final = np.linalg.inv(A)
#: Coefficients of u, u^2 and u^3 in the weights of the increments, shape (3, 3): the collocation polynomial (equation 8).
DENSE: Final = np.linalg.inv(C[:, None] ** np.arange(1, 4))
#: Weights of the increments, over the step, in the error of order 3 (equation 7).
ERROR: Final = np.array([-13.0 - 7.0 * _ROOT, -13.0 + 7.0 * _ROOT, -1.0]) / 3.0

_eigenvalues, _vectors = np.linalg.eig(RATES)
_of_real, _of_complex = int(np.argmin(np.abs(_eigenvalues.imag))), int(np.argmax(_eigenvalues.imag))
_turn = np.conj(_vectors[0, _of_real]) / abs(_vectors[0, _of_real])
_inverse = np.linalg.inv(_vectors)
#: Eigenvalues of `RATES`, and what transforms stages to them and back (equation 5); the third is the second's conjugate.
REAL: Final = float(_eigenvalues[_of_real].real)
COMPLEX: Final = complex(_eigenvalues[_of_complex])
TO_REAL: Final = (_inverse[_of_real] / _turn).real.copy()
FROM_REAL: Final = (_vectors[:, _of_real] * _turn).real.copy()
TO_COMPLEX: Final = _inverse[_of_complex].copy()
FROM_COMPLEX: Final = _vectors[:, _of_complex].copy()

run_at = reader(RadauRun)


@inner
def _factor(matrix: Any) -> None:
    """Factors L U of a matrix in its place, without exchanges of rows: its leading parts are definite (RADAU.md, section 3)."""
    for k in range(len(matrix)):
        reciprocal = 1.0 / matrix[k, k]
        for i in range(k + 1, len(matrix)):
            factor = matrix[i, k] * reciprocal
            matrix[i, k] = factor
            for j in range(k + 1, len(matrix)):
                matrix[i, j] -= factor * matrix[k, j]


@inner
def _substitute(factors: Any, b: Any) -> None:
    """Solve with the factors of `_factor`, in place of `b`."""
    for i in range(len(b)):
        total = b[i]
        for j in range(i):
            total -= factors[i, j] * b[j]
        b[i] = total
    for i in range(len(b) - 1, -1, -1):
        total = b[i]
        for j in range(i + 1, len(b)):
            total -= factors[i, j] * b[j]
        b[i] = total / factors[i, i]


@inner
def _form(run: RadauRun, h: float) -> None:
    """Newton's matrices for a step of size h, factored (equation 6)."""
    M, D, K = run.matrices[0], run.matrices[1], run.matrices[2]
    real, other = REAL / h, COMPLEX / h
    for i in range(len(M)):
        for j in range(len(M)):
            run.factors[i, j] = (real * M[i, j] + D[i, j]) * real + K[i, j]
            run.complex_factors[i, j] = (other * M[i, j] + D[i, j]) * other + K[i, j]
    _factor(run.factors)
    _factor(run.complex_factors)


@inner
def _solve(run: RadauRun, eigenvalue: Any, factors: Any, residual: Any, force: Any) -> None:
    """In place of a residual: the change of the state that removes it (equation 6). `force`: the speeds' part as forces; overwritten."""
    m, first, M, D = run.speeds, run.first_speed, run.matrices[0], run.matrices[1]
    for i in range(len(force)):
        total = force[i]
        for j in range(m):
            total += (eigenvalue * M[i, j] + D[i, j]) * residual[j]
        force[i] = total
    _substitute(factors, force)
    for i in range(m, len(residual)):
        residual[i] = residual[i] / eigenvalue
    for i in range(m):
        residual[first + i] = eigenvalue * force[i] - residual[i]
        residual[i] = force[i]


@inner
def _evaluate(run: RadauRun, state: Array, rate: Array) -> bool:
    return call_equations(run.function, run.parameters, run.workspace, state.ctypes.data, rate.ctypes.data) == 1


@inner
def _add_to(run: RadauRun, change: Array, state: Array) -> None:
    for i in range(len(state)):
        state[i] = run.y[i] + change[i]


@inner
def _interpolate(run: RadauRun, u: float, out: Array) -> None:
    """The state at the fraction `u` of the step (equation 8)."""
    weights = (_weight(0, u), _weight(1, u), _weight(2, u))
    for i in range(len(out)):
        out[i] = run.y[i] + weights[0] * run.Z[0, i] + weights[1] * run.Z[1, i] + weights[2] * run.Z[2, i]


@inner
def _weight(stage: int, u: float) -> float:
    return float(u * (DENSE[0, stage] + u * (DENSE[1, stage] + u * DENSE[2, stage])))


@inner
def _predict(run: RadauRun, h: float, before: float) -> None:
    """First guess of the increments: the polynomial of the step before, of size `before`, or the rate at the begin where there is none."""
    Z, of = run.Z, run.Z_before
    for stage in range(3):
        u = 1.0 + C[stage] * h / before if before > 0.0 else 0.0
        weights = (_weight(0, u), _weight(1, u), _weight(2, u) - 1.0)
        for i in range(len(run.y)):
            if before > 0.0:
                Z[stage, i] = weights[0] * of[0, i] + weights[1] * of[1, i] + weights[2] * of[2, i]
            else:
                Z[stage, i] = C[stage] * h * run.rate[i]


@inner
def _find_residuals(run: RadauRun, h: float) -> bool:
    """Residuals of the stages (equation 3), those of the speeds as forces, too; False for an impossible state."""
    Z, R = run.Z, run.residuals
    for stage in range(3):
        _add_to(run, Z[stage], run.trial)
        if not _evaluate(run, run.trial, R[stage]):
            return False
        for i in range(len(run.y)):
            R[stage, i] -= (RATES[stage, 0] * Z[0, i] + RATES[stage, 1] * Z[1, i] + RATES[stage, 2] * Z[2, i]) / h
        accelerations = R[stage].ctypes.data + 8 * run.first_speed
        call_equations(run.weigh, run.parameters, run.workspace, accelerations, run.forces[stage].ctypes.data)
    return True


@inner
def _transform(stages: Array, real: Array, other: NDArray[np.complex128]) -> None:
    """To the eigenvectors of the method (equation 5)."""
    for i in range(len(real)):
        real[i] = TO_REAL[0] * stages[0, i] + TO_REAL[1] * stages[1, i] + TO_REAL[2] * stages[2, i]
        other[i] = TO_COMPLEX[0] * stages[0, i] + TO_COMPLEX[1] * stages[1, i] + TO_COMPLEX[2] * stages[2, i]


@inner
def _correct(run: RadauRun, h: float) -> float:
    """One iteration of Newton's from the residuals; the norm of the change, over the accepted local error."""
    real, other = run.residual, run.complex_residual
    _transform(run.residuals, real, other)
    _transform(run.forces, run.force, run.complex_force)
    _solve(run, REAL / h, run.factors, real, run.force)
    _solve(run, COMPLEX / h, run.complex_factors, other, run.complex_force)
    squares = 0.0
    for stage in range(3):
        for i in range(len(run.y)):
            change = FROM_REAL[stage] * real[i] + 2.0 * (FROM_COMPLEX[stage] * other[i]).real
            run.Z[stage, i] += change
            if i < len(run.precisions):
                squares += (change * run.precisions[i]) ** 2
    return math.sqrt(squares / (3 * len(run.precisions)))


@inner
def _converge(run: RadauRun, h: float) -> int:
    """Newton's iteration for the increments; the number of right-hand sides, negative where it fails."""
    norm, ratio = 0.0, 0.5
    for iteration in range(1, MAX_ITERATIONS + 1):
        if not _find_residuals(run, h):
            return -3 * iteration
        last, norm = norm, _correct(run, h)
        if not norm < 1e6:  # also where it is nan
            return -3 * iteration
        if iteration > 1:
            ratio = norm / last
            if ratio > 2.0:
                return -3 * iteration
        if norm * (ratio / (1.0 - ratio) if ratio < 0.9 else 10.0) < NEWTON or norm < 1e-3 * NEWTON:
            run.contraction[0] = ratio if iteration > 1 else 0.0
            return 3 * iteration
    return -3 * MAX_ITERATIONS


@inner
def _error_norm(run: RadauRun, h: float) -> float:
    """The local error of order 3 over the accepted one (equation 7)."""
    error, first = run.residual, run.first_speed
    for i in range(len(error)):
        error[i] = run.rate[i] + (ERROR[0] * run.Z[0, i] + ERROR[1] * run.Z[1, i] + ERROR[2] * run.Z[2, i]) / h
    for i in range(len(run.force)):
        total = 0.0
        for j in range(run.speeds):
            total += run.matrices[0, i, j] * error[first + j]
        run.force[i] = total
    _solve(run, REAL / h, run.factors, error, run.force)
    squares = 0.0
    for i in range(len(run.precisions)):
        squares += (error[i] * run.precisions[i]) ** 2
    return math.sqrt(squares / len(run.precisions))


@inner
def _leaving_fraction(run: RadauRun) -> float:
    """Fraction of the step where the slider passes the limit; by bisection."""
    low, high = 0.0, 1.0
    for _ in range(45):
        middle = 0.5 * (low + high)
        _interpolate(run, middle, run.trial)
        if _evaluate(run, run.trial, run.trial_rate) and run.watched[0] <= run.limit:
            low = middle
        else:
            high = middle
    return low


@inner
def _linearise(run: RadauRun) -> None:
    call_equations(run.linearise, run.parameters, run.workspace, run.matrices.ctypes.data, len(run.force))


@inner
def _copy(source: Array, target: Array) -> None:
    for i in range(len(target)):
        target[i] = source[i]


@inner
def _radau(run: RadauRun) -> tuple[int, int, float, int, float]:
    """Integrates as `implicit.radau` describes: status, number of rows, last instant (s), right-hand sides, next step (s)."""
    end, t, step, before = run.output_step * run.intervals, 0.0, run.first_step, 0.0
    rows, calls, rejected = 1, 1, False
    _copy(run.y, run.states[0])
    if not _evaluate(run, run.y, run.rate):
        return NOT_A_NUMBER, rows, t, calls, step
    _linearise(run)
    while t < end:
        too_small = step < run.least_step or t + step == t
        if too_small or calls > MAX_CALLS:
            return (STEP_TOO_SMALL if too_small else TOO_MANY_CALLS), rows, t, calls, step
        h = min(step, end - t)
        last = h >= end - t
        _form(run, h)
        _predict(run, h, before)
        made = _converge(run, h)
        calls += abs(made)
        norm = _error_norm(run, h) if made > 0 else math.inf
        if norm < 1.0:
            _add_to(run, run.Z[2], run.trial)
            calls += 1
            norm = norm if _evaluate(run, run.trial, run.trial_rate) else math.inf
        if not norm < 1.0:  # also where the norm is nan
            step = h * (max(0.2, 0.8 * norm**-0.25) if norm < 1e8 else 0.4)
            rejected = True
            continue
        left = run.watched[0] > run.limit
        share = _leaving_fraction(run) if left else 1.0
        while rows <= run.intervals and rows * run.output_step <= t + share * h * (1.0 + 1e-12):
            _interpolate(run, min((rows * run.output_step - t) / h, 1.0), run.states[rows])
            rows += 1
        if left:
            return LEFT_FOLLOWER, rows, t + share * h, calls, h
        t, before = end if last else t + h, h
        _copy(run.trial, run.y)
        _copy(run.trial_rate, run.rate)
        for stage in range(3):
            _copy(run.Z[stage], run.Z_before[stage])
        _linearise(run)
        growth = min(3.0, max(0.2, 0.85 * max(norm, 1e-6) ** -0.25), math.sqrt(CONTRACTION / max(run.contraction[0], 1e-3)))
        # a step cut at the end of the interval says nothing about the next
        step = max(step, h) if last and h < step else h * (min(growth, 1.0) if rejected else growth)
        rejected = False
    return REACHED_END, rows, t, calls, step


def loop(address: int) -> int:
    """As `_radau`, for the `RadauRun` at an address; the status."""
    run = run_at(address)
    ended = run.ended
    status, ended[0], ended[1], ended[2], ended[3] = _radau(run)
    return status
