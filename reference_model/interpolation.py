"""Piecewise polynomials: cubic splines, and the polynomial through Gauss points.

The first two and last two pieces of a spline are one cubic each ("not a knot"), as in scipy, whose module takes 0.3 s to import.
"""

import numpy as np
from numpy.polynomial import legendre

from quickreturn.reference_model.arrays import Array


class CubicSpline:
    """The spline through values (k,) or (k, m) at increasing nodes (k,); through two or three it is a polynomial."""

    def __init__(self, nodes: Array, values: Array) -> None:
        self.nodes, self.coefficients = nodes, spline_coefficients(nodes, values)

    def __call__(self, x: Array, derivative: int = 0) -> Array:
        """Its values at `x` (n,), or those of its first or second derivative, shape (n,) or (n, m)."""
        piece = np.clip(np.searchsorted(self.nodes, x, side="right") - 1, 0, len(self.nodes) - 2)
        u = (x - self.nodes[piece]).reshape(-1, *[1] * (self.coefficients.ndim - 2))
        third, second, first, value = np.moveaxis(self.coefficients[piece], 1, 0)
        if derivative == 2:
            return np.asarray(6.0 * third * u + 2.0 * second)
        if derivative == 1:
            return np.asarray((3.0 * third * u + 2.0 * second) * u + first)
        return np.asarray(((third * u + second) * u + first) * u + value)

    def turning_points(self) -> Array:
        """Where its derivative vanishes between the nodes, but for level pieces; values of shape (k,)."""
        a, b, c = 3.0 * self.coefficients[:, 0], self.coefficients[:, 1], self.coefficients[:, 2]  # a u^2 + 2 b u + c = 0
        with np.errstate(divide="ignore", invalid="ignore"):
            q = -(b + np.copysign(np.sqrt(b * b - a * c), b))
            found = np.stack([q / a, c / q])
            inside = (found >= 0.0) & (found <= np.diff(self.nodes))
        return np.sort((self.nodes[:-1] + found)[inside])


def spline_coefficients(nodes: Array, values: Array) -> Array:
    """Coefficients of a spline's pieces by powers of the distance from the left node, the third power first, (k - 1, 4) or (k - 1, 4, m).

    Args:
        nodes: increasing, shape (k,), at least two.
        values: shape (k,) or (k, m).
    """
    steps = np.diff(nodes)
    h = steps.reshape(-1, *[1] * (values.ndim - 1))
    slope = np.diff(values, axis=0) / h
    rates = _rates(h, slope) if len(nodes) > 3 else _rates_of_few(nodes, steps, slope)
    third = (rates[:-1] + rates[1:] - 2.0 * slope) / h
    return np.stack([third / h, (slope - rates[:-1]) / h - third, rates[:-1], values[:-1]], axis=1)


def _rates(h: Array, slope: Array) -> Array:
    """The spline's derivative at the nodes, from a tridiagonal system."""
    first, last = h[0] + h[1], h[-2] + h[-1]
    begin = ((h[0] + 2.0 * first) * h[1] * slope[0] + h[0] ** 2 * slope[1]) / first
    end = (h[-1] ** 2 * slope[-2] + (2.0 * last + h[-1]) * h[-2] * slope[-1]) / last
    right = np.concatenate([begin[None], 3.0 * (h[1:] * slope[:-1] + h[:-1] * slope[1:]), end[None]])
    diagonal = np.concatenate([h[1:2], 2.0 * (h[:-1] + h[1:]), h[-2:-1]])
    return _tridiagonal(np.concatenate([h[1:], last[None]]), diagonal, np.concatenate([first[None], h[:-1]]), right)


def _tridiagonal(below: Array, diagonal: Array, above: Array, right: Array) -> Array:
    """Solution of a tridiagonal system by cyclic reduction: every other unknown is eliminated, until one is left.

    Args:
        below: coefficients of the unknown before, in all equations but the first, (k - 1,) or (k - 1, 1).
        diagonal: (k,) or (k, 1).
        above: coefficients of the unknown after, in all equations but the last.
        right: (k,) or (k, m).
    """
    if len(diagonal) == 1:
        return right / diagonal
    odd, count = slice(1, None, 2), len(diagonal) // 2
    before, after = below[odd] / diagonal[odd][: len(below) // 2], above[::2] / diagonal[odd]  # of the equations that stay
    kept, kept_right = diagonal[::2].copy(), right[::2].copy()
    kept[1:] -= before * above[odd]
    kept[:count] -= after * below[::2]
    kept_right[1:] -= before * right[odd][: len(before)]
    kept_right[:count] -= after * right[odd]
    solution = np.empty_like(right)
    solution[::2] = _tridiagonal(-before * below[::2][: len(before)], kept, -after[: len(before)] * above[odd], kept_right)
    known = right[odd] - below[::2] * solution[:-1:2]
    known[: len(before)] -= above[odd] * solution[2::2]
    solution[odd] = known / diagonal[odd]
    return solution


def _rates_of_few(nodes: Array, steps: Array, slope: Array) -> Array:
    """The derivative at the nodes of the polynomial through two or three."""
    if len(nodes) == 2:
        return np.concatenate([slope, slope])
    middle = (steps[1] * slope[0] + steps[0] * slope[1]) / (steps[0] + steps[1])
    return np.stack([2.0 * slope[0] - middle, middle, 2.0 * slope[1] - middle])


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
