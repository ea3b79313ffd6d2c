"""Shapes and quadrature tables against closed forms."""

import math

import numpy as np
import pytest
from numpy.polynomial import legendre
from scipy.integrate import quad
from scipy.optimize import brentq

from quickreturn.reference_model.interpolation import integrals_to_points, lagrange_weights
from quickreturn.reference_model.shapes import ShapeSet, clamped_free_modes, decoupled, hermite_between, hermite_elements, no_shapes
from quickreturn.reference_model.thesis.parameters import (
    POINTS,
    TO_POINTS,
    UNIT_POINTS,
    UNIT_WEIGHTS,
    build_tables,
    cumulate,
    partial_weights,
)

L = 0.7


def wave_number(k: int) -> float:
    """Root of cos z cosh z = -1 (k from 0), from a form without overflow."""
    guess = (k + 0.5) * math.pi
    return float(brentq(lambda z: math.cos(z) + 1.0 / math.cosh(z), max(guess - 0.4, 1.0), guess + 0.4, xtol=1e-14))


def gram(shapes: ShapeSet, derivative: int) -> np.ndarray:
    """Integrals of products over the length, by the fields' own quadrature on a fine mesh."""
    t = build_tables(shapes, 4 * shapes.count)
    values = shapes.evaluate(t.x, derivative)
    return values.T @ (t.weights[:, None] * values)


@pytest.mark.parametrize("count", [1, 2, 5, 16, 32])
def test_clamped_free_modes_are_orthogonal_with_the_known_wave_numbers(count: int) -> None:
    shapes = clamped_free_modes(L, count)
    # amplitude 2 at the tip: the integral of phi^2 is L; representation 1e-12, rounding of products 1e-13
    np.testing.assert_allclose(gram(shapes, 0) / L, np.eye(count), atol=1e-11)
    expected = np.array([wave_number(k) for k in range(count)]) ** 4 / L**3
    stiffness = gram(shapes, 2)
    # the curvature of the highest mode is represented to 1e-9 of itself, which counts squared on the diagonal
    np.testing.assert_allclose(stiffness / np.sqrt(np.outer(expected, expected)), np.eye(count), atol=1e-9)


@pytest.mark.parametrize("shapes", [clamped_free_modes(L, 20), hermite_elements(L, 3), hermite_elements(L, 1)])
def test_all_shapes_are_clamped_and_smooth(shapes: ShapeSet) -> None:
    zero = np.zeros(1)
    for derivative in (0, 1):
        scale = np.max(np.abs(shapes.evaluate(np.linspace(0, L, 50), derivative)))
        assert np.max(np.abs(shapes.evaluate(zero, derivative))) < 1e-11 * scale
    inner, step = shapes.edges[1:-1], 1e-13
    for derivative in range(3 if shapes.has_continuous_curvature else 2):
        jump = shapes.evaluate(inner, derivative) - shapes.evaluate(inner - step, derivative)
        # representation error at the cells' ends, largest in the highest derivative
        assert np.max(np.abs(jump), initial=0.0) < 1e-9 * np.max(np.abs(shapes.evaluate(shapes.edges, derivative)))


def test_free_end_of_the_modes_carries_neither_moment_nor_shear() -> None:
    shapes = clamped_free_modes(L, 12)
    end = np.array([L])
    for derivative in (2, 3):
        scale = np.max(np.abs(shapes.evaluate(np.linspace(0, L, 200), derivative)), axis=0)
        assert np.all(np.abs(shapes.evaluate(end, derivative)[0]) < 1e-7 * scale)
    np.testing.assert_allclose(np.abs(shapes.evaluate(end)[0]), 2.0, rtol=1e-11)


@pytest.mark.parametrize("nodes", [[0.0, L], [0.0, L / 2.0, L], [0.0, 0.1, 0.45, L]], ids=len)
def test_hermite_elements_reproduce_every_clamped_cubic(nodes: list[float]) -> None:
    cubic, ends = np.polynomial.Polynomial([0.0, 0.0, 0.3, -1.7]), np.array(nodes[1:])
    eta = np.column_stack([cubic(ends), cubic.deriv()(ends)]).ravel()
    x, inverse = np.linspace(0.0, L, 40), L / np.min(np.diff(nodes))
    for derivative in range(4):
        expected = cubic.deriv(derivative)(x) if derivative else cubic(x)
        # rounding, multiplied by the elements' inverse length at each derivative
        found = hermite_between(np.array(nodes)).evaluate(x, derivative) @ eta
        np.testing.assert_allclose(found, expected, atol=1e-13 * inverse * (inverse / L) ** derivative)


@pytest.mark.parametrize("shapes", [clamped_free_modes(L, 9), hermite_elements(L, 4)])
def test_derivatives_are_derivatives(shapes: ShapeSet) -> None:
    x, h = np.linspace(0.011, 0.99 * L, 37), 1e-5
    for derivative in range(1, 4):
        differenced = (shapes.evaluate(x + h, derivative - 1) - shapes.evaluate(x - h, derivative - 1)) / (2 * h)
        exact = shapes.evaluate(x, derivative)
        # central difference: (h wave number)^2 / 6 < 3e-8 plus rounding 1e-16 / h of the value before
        np.testing.assert_allclose(differenced, exact, atol=1e-6 * np.max(np.abs(exact)))


@pytest.mark.parametrize("degree", range(2 * POINTS))
def test_gauss_points_integrate_degree_eleven_over_a_cell(degree: int) -> None:
    assert float(UNIT_WEIGHTS @ UNIT_POINTS**degree) == pytest.approx(1 / (degree + 1), rel=1e-14)


@pytest.mark.parametrize("degree", range(POINTS))
@pytest.mark.parametrize("u", [-0.1, 0.0, 0.3, 0.77, 1.0, 1.2])
def test_partial_weights_are_exact_to_degree_five(degree: int, u: float) -> None:
    length = 0.4
    weights = np.empty((3, POINTS))
    partial_weights.py_func(u, length, weights)
    integral, value, slope = weights
    samples = UNIT_POINTS**degree
    # rounding of the Lagrange coefficients, which reach 1e3
    assert integral @ samples == pytest.approx(length * u ** (degree + 1) / (degree + 1), abs=1e-13)
    assert value @ samples == pytest.approx(u**degree, abs=1e-11)
    assert slope @ samples == pytest.approx(degree * u ** max(degree - 1, 0) / length, abs=1e-10)
    np.testing.assert_allclose(TO_POINTS @ samples, UNIT_POINTS ** (degree + 1) / (degree + 1), atol=1e-13)


def test_cumulated_integrals_equal_adaptive_quadrature() -> None:
    t = build_tables(no_shapes(L), 8)
    at_points, at_edges = np.empty_like(t.x), np.empty_like(t.edges)
    cumulate.py_func(t.edges, np.sin(9.0 * t.x) ** 2, at_points, at_edges)
    for x, found in zip([*t.x[::7], *t.edges], [*at_points[::7], *at_edges], strict=True):
        # a ninth of a wave of sin^2 per cell: sixth-order interpolation errs by 1e-7
        assert found == pytest.approx(quad(lambda z: math.sin(9.0 * z) ** 2, 0.0, x, epsabs=1e-13)[0], abs=1e-7)


@pytest.mark.parametrize("shapes", [clamped_free_modes(L, 5), hermite_elements(L, 3)], ids=["modes", "elements"])
def test_vibrating_shapes_span_the_same_and_are_orthogonal(shapes: ShapeSet) -> None:
    own, squares = decoupled(shapes, 0.4, 5.0)
    np.testing.assert_allclose(0.4 * gram(own, 0), np.eye(own.count), atol=1e-9)
    np.testing.assert_allclose(5.0 * gram(own, 2) / np.sqrt(np.outer(squares, squares)), np.eye(own.count), atol=1e-7)
    x = np.linspace(0.0, L, 50)
    there = own.evaluate(x)
    combined = there @ np.linalg.lstsq(there, shapes.evaluate(x), rcond=None)[0]
    np.testing.assert_allclose(combined, shapes.evaluate(x), atol=1e-9)
    # the lowest is the clamped beam's first mode, from above
    lowest = math.sqrt(5.0 / 0.4) * (wave_number(0) / L) ** 2
    assert lowest <= math.sqrt(squares[0]) * (1.0 + 1e-12) < 1.001 * lowest


@pytest.mark.parametrize("count", [1, 7, 15, 31])
def test_powers_are_integrated_to_round_off(count: int) -> None:
    points, weights = legendre.leggauss(count)
    to = integrals_to_points(points, weights)
    ends = np.append(points, 1.0)
    for power in range(count):
        exact = (ends ** (power + 1) - (-1.0) ** (power + 1)) / (power + 1)
        np.testing.assert_allclose(points**power @ to, exact, rtol=0.0, atol=1e-14)


def test_the_last_integral_is_gauss_quadrature() -> None:
    points, weights = legendre.leggauss(11)
    np.testing.assert_allclose(integrals_to_points(points, weights)[:, -1], weights, rtol=1e-13)


def test_a_smooth_function_is_interpolated_to_round_off() -> None:
    points, _ = legendre.leggauss(15)
    at = np.linspace(-0.99, 0.99, 50)
    value = np.zeros(50)
    for point, weight in zip(points, lagrange_weights(points), strict=True):
        value += np.exp(point) * weight * np.prod(at[:, None] - points[points != point], axis=1)
    np.testing.assert_allclose(value, np.exp(at), rtol=1e-13)
