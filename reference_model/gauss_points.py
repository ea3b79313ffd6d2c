"""The polynomial through Gauss points: its integrals to each of them, and its values between them."""

import numpy as np
from numpy.polynomial import legendre
from numpy.typing import NDArray

Array = NDArray[np.float64]


def integrals_to_points(points: Array, weights: Array) -> Array:
    """Weights of each Gauss point in the integrals from -1 to each point, and to 1; shape (G, G + 1).

    By the polynomial's Legendre series, which Gauss quadrature gives exactly; through its powers 15 points would leave 1e-7.

    Args:
        points: of Gauss and Legendre on (-1, 1), shape (G,).
        weights: theirs, shape (G,).
    """
    G = len(points)
    series = legendre.legvander(points, G - 1) * weights[:, None] * (np.arange(G) + 0.5)  # row j: coefficients of point j's polynomial
    integrals = legendre.legint(series.T, lbnd=-1)
    return np.ascontiguousarray(legendre.legval(np.append(points, 1.0), integrals))


def lagrange_weights(points: Array) -> Array:
    """One over the product of each point's distances from the others, shape (G,): what makes Lagrange's polynomials 1 at their points."""
    distances = points[:, None] - points + np.eye(len(points))
    return np.asarray(1.0 / np.prod(distances, axis=1), dtype=np.float64)
