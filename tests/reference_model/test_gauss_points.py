"""Integration and interpolation through Gauss points against powers and against the closed form of a smooth function."""

import numpy as np
import pytest
from numpy.polynomial import legendre

from quickreturn.reference_model.interpolation import integrals_to_points, lagrange_weights


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
