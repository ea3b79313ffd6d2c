"""Cubic splines whose first two and last two pieces are one cubic each ("not a knot"): scipy's, whose module takes 0.3 s to import."""

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


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
    rates = _rates(nodes, steps, h, slope) if len(nodes) > 3 else _rates_of_few(nodes, steps, slope)
    third = (rates[:-1] + rates[1:] - 2.0 * slope) / h
    return np.stack([third / h, (slope - rates[:-1]) / h - third, rates[:-1], values[:-1]], axis=1)


def _rates(nodes: Array, steps: Array, h: Array, slope: Array) -> Array:
    """The spline's derivative at the nodes: Gauss' elimination of a tridiagonal matrix."""
    first, last = nodes[2] - nodes[0], nodes[-1] - nodes[-3]
    begin = ((h[0] + 2.0 * first) * h[1] * slope[0] + h[0] ** 2 * slope[1]) / first
    end = (h[-1] ** 2 * slope[-2] + (2.0 * last + h[-1]) * h[-2] * slope[-1]) / last
    right = np.concatenate([begin[None], 3.0 * (h[1:] * slope[:-1] + h[:-1] * slope[1:]), end[None]])
    diagonal = [steps[1].item(), *(2.0 * (steps[:-1] + steps[1:])).tolist(), steps[-2].item()]
    below, above = [*steps[1:].tolist(), last.item()], [first.item(), *steps[:-1].tolist()]
    rates = right.tolist() if right.ndim == 1 else list(right)
    for k in range(1, len(nodes)):
        part = below[k - 1] / diagonal[k - 1]
        diagonal[k] -= part * above[k - 1]
        rates[k] = rates[k] - part * rates[k - 1]
    rates[-1] = rates[-1] / diagonal[-1]
    for k in reversed(range(len(nodes) - 1)):
        rates[k] = (rates[k] - above[k] * rates[k + 1]) / diagonal[k]
    return np.array(rates)


def _rates_of_few(nodes: Array, steps: Array, slope: Array) -> Array:
    """The derivative at the nodes of the polynomial through two or three."""
    if len(nodes) == 2:
        return np.concatenate([slope, slope])
    middle = (steps[1] * slope[0] + steps[0] * slope[1]) / (steps[0] + steps[1])
    return np.stack([2.0 * slope[0] - middle, middle, 2.0 * slope[1] - middle])
