"""The polynomial through Gauss points: its integrals to each of them, and its values between them."""

import numpy as np
from numpy.polynomial import legendre
from numpy.typing import NDArray

Array = NDArray[np.float64]


def integrals_to_points(points: Array, weights: Array) -> Array:
    """Weight of each Gauss point (row) in the integral from -1 to each point, and to 1 (columns); shape (G, G + 1).

    Gauss quadrature gives the polynomial's Legendre series exactly; with a power series the error would be 1e-7 for 15 points.

    Args:
        points: Gauss-Legendre points on (-1, 1), shape (G,).
        weights: their quadrature weights, shape (G,).
    """
    G = len(points)
    series = legendre.legvander(points, G - 1) * weights[:, None] * (np.arange(G) + 0.5)  # row j: coefficients of point j's polynomial
    integrals = legendre.legint(series.T, lbnd=-1)
    return np.ascontiguousarray(legendre.legval(np.append(points, 1.0), integrals))


def lagrange_weights(points: Array) -> Array:
    """One over the product of each point's differences from the others, shape (G,): it makes Lagrange's polynomials 1 at their points."""
    distances = points[:, None] - points + np.eye(len(points))
    return np.asarray(1.0 / np.prod(distances, axis=1), dtype=np.float64)
