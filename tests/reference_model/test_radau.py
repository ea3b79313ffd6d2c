"""The implicit integrator against order conditions and closed forms."""

import math
from typing import Any

import numba
import numpy as np
import pytest
from numba import types

from quickreturn.reference_model import radau_loop
from quickreturn.reference_model.integrate import LEFT_FOLLOWER, REACHED_END, Equations, Integration, Linearisation, radau
from quickreturn.reference_model.native.pointers import matrix_at, numbers_at

#: Mass of the second coordinate, kg: residuals are forces.
MASS = 1e-3


def _equations(parameters: int, workspace: int, state: int, rate: int) -> int:
    """Rates of x'' = -x, of z on a spring to x and a damper to the ground, MASS z'' = -k (z - x) - d z', and of the integral of x.

    State: x, z, the integral, x', z'.
    """
    p, watched, y, out = numbers_at(parameters, 2), numbers_at(workspace, 2), numbers_at(state, 5), numbers_at(rate, 5)
    watched[0] = y[2]
    out[0], out[1], out[2] = y[3], y[4], y[0]
    out[3], out[4] = -y[0], -(p[0] * (y[1] - y[0]) + p[1] * y[4]) / 1e-3
    return 1


def _linearise(parameters: int, workspace: int, matrices: int, size: int) -> int:
    p, of = numbers_at(parameters, 2), matrix_at(matrices, 3 * size, size)
    of[0, 0], of[1, 1], of[3, 1] = 1.0, 1e-3, p[1]
    of[4, 0], of[5, 0], of[5, 1] = 1.0, -p[0], p[0]
    return 1


def _weigh(parameters: int, workspace: int, accelerations: int, forces: int) -> int:
    a, out = numbers_at(accelerations, 2), numbers_at(forces, 2)
    out[0], out[1] = a[0], 1e-3 * a[1]
    return 1


def _address(function: Any) -> int:
    compiled = numba.cfunc(types.int64(*[types.uintp] * 4))(function)
    _kept.append(compiled)
    return int(compiled.address)


_kept: list[Any] = []


def integrated(
    k: float, d: float, tolerance: float, *, output_step: float = 0.25, intervals: int = 80, limit: float = math.inf
) -> tuple[Integration, np.ndarray]:
    """An integration from the state in which z follows x without vibrations of its own, and the exact states."""
    constants, watched = np.array([k, d]), np.zeros(2)
    equations = Equations(_address(_equations), constants.ctypes.data, watched.ctypes.data, watched)
    linearisation = Linearisation(_address(_linearise), _address(_weigh), 2, 3, 2)
    t = output_step * np.arange(intervals + 1)
    follows = k / (k - MASS + 1j * d) * np.exp(1j * t)
    exact = np.column_stack([np.cos(t), follows.real, np.sin(t), -np.sin(t), (1j * follows).real])
    scales = np.full(5, tolerance)
    return radau(equations, linearisation, exact[0], output_step, intervals, scales, limit, 1.0), exact


def test_stages_meet_the_conditions_of_order_five() -> None:
    """Collocation of order 3, and a quadrature of order 5 (Hairer and Wanner, theorem IV.5.1)."""
    A, c = radau_loop.A, radau_loop.C
    for power in range(3):
        np.testing.assert_allclose(A @ c**power, c ** (power + 1) / (power + 1), atol=1e-14)
    for power in range(5):
        assert A[2] @ c**power == pytest.approx(1.0 / (power + 1), abs=1e-14)
    assert abs(A[2] @ c**5 - 1.0 / 6.0) > 1e-4
    stages = np.random.default_rng(3).normal(size=3)
    back = radau_loop.FROM_REAL * (radau_loop.TO_REAL @ stages) + 2.0 * (radau_loop.FROM_COMPLEX * (radau_loop.TO_COMPLEX @ stages)).real
    np.testing.assert_allclose(back, stages, atol=1e-13)


@pytest.mark.parametrize(
    ("k", "d"), [(1e9, 1.0), *(pytest.param(*each, marks=pytest.mark.verify) for each in ((4e-3, 0.0), (1e3, 0.0), (4e-3, 1e6)))]
)
def test_order_five_whatever_the_stiffness(k: float, d: float) -> None:
    """At the end of an interval; natural frequencies of z are 2, 1e3 and 1e6 rad/s; the last damper holds z where it is."""
    work, error = [], []
    for tolerance in (1e-4, 1e-6, 1e-8):
        found, exact = integrated(k, d, tolerance)
        assert found.status == REACHED_END
        work.append(found.calls)
        error.append(np.abs(found.states[-1] - exact[-1])[[0, 1, 2, 3]].max())
    slopes = -np.diff(np.log(error)) / np.diff(np.log(work))
    assert np.all(slopes > 4.5), slopes
    assert work[-1] < 1.3 * integrated(4e-3, 0.0, 1e-8)[0].calls


def test_fast_vibrations_decay_at_once() -> None:
    """A start off the slow motion: at 1e6 rad/s undamped, z is back on it before the first row, as a stiffly accurate method has it."""
    constants, watched = np.array([1e9, 0.0]), np.zeros(2)
    equations = Equations(_address(_equations), constants.ctypes.data, watched.ctypes.data, watched)
    linearisation = Linearisation(_address(_linearise), _address(_weigh), 2, 3, 2)
    start = np.array([1.0, 1.0 + 1e-6, 0.0, 0.0, 0.0])
    rows = radau(equations, linearisation, start, 0.25, 8, np.full(5, 1e-3), math.inf, 1.0).states
    assert np.abs(rows[1:, 1] - rows[1:, 0]).max() < 1e-9


@pytest.mark.parametrize("tolerance", [1e-4, 1e-6, 1e-8])
def test_rows_have_the_accuracy_for_which_steps_were_accepted(tolerance: float) -> None:
    """Between the steps the polynomial is off by order 4 in the step, as the estimate is, and does not accumulate it."""
    found, exact = integrated(1e3, 0.0, tolerance, output_step=0.01, intervals=2000)
    assert np.abs(found.states - exact)[:, :4].max() < 2.0 * tolerance


def test_the_polynomial_is_exact_for_cubics() -> None:
    c, u = radau_loop.C, 0.37
    weights = (u ** np.arange(1, 4)) @ radau_loop.DENSE
    for power in (1, 2, 3):
        assert weights @ c**power == pytest.approx(u**power, abs=1e-14)
    assert abs(weights @ c**4 - u**4) > 1e-3


def test_it_ends_where_the_slider_leaves() -> None:
    """The integral of x, which stands for the slider's place, is sin t and passes 0.5 at pi / 6."""
    found, _ = integrated(1e3, 0.0, 1e-9, output_step=0.01, limit=0.5)
    assert found.status == LEFT_FOLLOWER
    assert found.end_time == pytest.approx(math.pi / 6.0, abs=1e-8)
    assert len(found.states) == 53
