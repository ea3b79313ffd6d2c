"""The integrator's interpolation and rows against order conditions and closed forms, the splines of its tables against those of scipy."""

import math
from typing import Any

import numba
import numpy as np
import pytest
import scipy
from numba import types
from numpy.polynomial.polynomial import polyval

from quickreturn.reference_model import dop853_loop as dop853
from quickreturn.reference_model import integrate
from quickreturn.reference_model.interpolation import spline_coefficients
from quickreturn.reference_model.native.pointers import numbers_at


def trees(order: int) -> list[tuple[Any, ...]]:
    """Rooted trees of so many nodes, each the tuple of its branches."""
    if order == 1:
        return [()]
    found: set[tuple[Any, ...]] = set()
    for largest in range(1, order):
        for branch in trees(largest):
            for rest in trees(order - largest):
                found.add(tuple(sorted((branch, *rest))))
    return sorted(found)


def nodes_of(tree: tuple[Any, ...]) -> int:
    return 1 + sum(map(nodes_of, tree))


def density(tree: tuple[Any, ...]) -> int:
    return nodes_of(tree) * math.prod(map(density, tree))


def of_stages(tree: tuple[Any, ...]) -> np.ndarray:
    """The product of the weights along the branches of a tree, for every stage as its root."""
    return np.prod([np.ones(13), *(dop853.A @ of_stages(branch) for branch in tree)], axis=0)


@pytest.mark.parametrize("u", [0.0, 0.2, 0.55, 0.9, 1.0])
def test_interpolation_meets_every_condition_of_order_six(u: float) -> None:
    """The sum over the stages for each tree is the power of u by its density (Hairer, Norsett and Wanner, theorem II.2.13)."""
    assert [len(trees(order)) for order in range(1, 7)] == [1, 1, 2, 4, 9, 20]
    weights = np.zeros(13)
    weights[list(dop853.INTERPOLATED)] = polyval(2.0 * u - 1.0, dop853.INTERPOLATION.T)
    for order in range(1, 7):
        for tree in trees(order):
            assert weights @ of_stages(tree) == pytest.approx(u**order / density(tree), abs=1e-13)
    if u == 1.0:
        np.testing.assert_allclose(weights, dop853.A[12], rtol=0.0, atol=1e-10)


@pytest.mark.parametrize("count", [2, 3, 4, 5, 6, 7, 8, 9, 25, 2001, 2002])
def test_splines_are_those_of_scipy(count: int) -> None:
    random = np.random.default_rng(5)
    nodes, values = np.cumsum(random.uniform(0.1, 1.0, count)), random.normal(size=(count, 6))
    found, theirs = spline_coefficients(nodes, values), scipy.interpolate.CubicSpline(nodes, values).c.transpose(1, 0, 2)
    assert np.abs(found - theirs).max() <= 1e-12 * np.abs(theirs).max()
    np.testing.assert_array_equal(spline_coefficients(nodes, values[:, 0]), found[..., 0])


def _oscillator(parameters: int, workspace: int, state: int, rate: int, with_forces: int) -> int:
    """States q, its rate, and the work of the rate against a unit damper; angular frequency 1."""
    y, out = numbers_at(state, 3), numbers_at(rate, 3)
    out[0], out[1], out[2] = y[1], -y[0], y[1] ** 2
    return 1


def _equations() -> integrate.Equations:
    return integrate.Equations(numba.cfunc(types.int64(*[types.uintp] * 5))(_oscillator).address, 0, 0, np.zeros(2))


@pytest.mark.parametrize("intervals", [1, 3, 800, 12000])
def test_steps_do_not_depend_on_the_rows(intervals: int) -> None:
    """Whatever is shown of 30 rad, the same rates are asked, and the same state is the last; to round-off of the rows' times."""
    start, scales = np.array([1.0, 0.0, 0.0]), np.full(2, 1e-9)
    expected = integrate.dop853(_equations(), start, 0.5, 60, scales, math.inf, 1.0)
    found = integrate.dop853(_equations(), start, 30.0 / intervals, intervals, scales, math.inf, 1.0)
    assert found.calls == expected.calls
    np.testing.assert_allclose(found.states[-1], expected.states[-1], rtol=0.0, atol=1e-13)


@pytest.mark.parametrize("tolerance", [1e-5, 1e-8, 1e-11])
def test_rows_are_as_exact_as_steps(tolerance: float) -> None:
    """An oscillator over 200 rad; what ends of steps are off is seen from integrations of 10 rad each, which end there."""
    equations = _equations()
    start, scales = np.array([1.0, 0.0, 0.0]), np.full(2, tolerance)
    ends = [start]
    for _ in range(20):
        ends.append(integrate.dop853(equations, ends[-1], 10.0, 1, scales, math.inf, 1.0).states[-1])
    rows = integrate.dop853(equations, start, 0.05, 4000, scales, math.inf, 1.0).states

    def error(states: np.ndarray, t: np.ndarray) -> np.ndarray:
        exact = np.column_stack([np.cos(t), -np.sin(t), 0.5 * t - 0.25 * np.sin(2.0 * t)])
        return np.max(np.abs(states - exact), axis=0)

    assert np.all(error(rows, 0.05 * np.arange(4001)) < 1.5 * error(np.array(ends), 10.0 * np.arange(21)))
