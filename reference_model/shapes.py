"""Fixed shape functions of the follower, apart from the mechanics that use them.

Every family has one form: polynomials on cells. The mechanics (`beam.tables`, `thesis`) do not know the family. All shapes are clamped
at the base, phi(0) = phi'(0) = 0, so that q2 is the tangent there (DERIVATION.md, equation 2.10).
"""

import math
from dataclasses import dataclass

import numpy as np
import scipy

from quickreturn.reference_model.arrays import Array, eigh

#: Degree of the polynomials that represent a transcendental mode on one cell; with at most a quarter of a wave per cell the
#: representation error is below 1e-12 of the mode's amplitude and 1e-9 of its curvature.
MODE_DEGREE = 13


@dataclass(frozen=True)
class ShapeSet:
    """Shape functions phi_i(x), i < n, on 0 <= x <= L.

    Attributes:
        edges: cell boundaries, m, shape (cells + 1,), from 0 to L.
        coefficients: shape (cells, degree + 1, n): phi_i on cell c is sum_k coefficients[c, k, i] u^k, u = x - edges[c] over the cell's
            length, 0 <= u <= 1.
        has_continuous_curvature: whether phi'' is continuous, which a slider with rotary inertia needs.
    """

    edges: Array
    coefficients: Array
    has_continuous_curvature: bool

    @property
    def count(self) -> int:
        """Number of shapes n."""
        return self.coefficients.shape[2]

    def evaluate(self, x: Array, derivative: int = 0) -> Array:
        """Values of the given derivative with respect to x at arc lengths `x` (m, shape (k,)); shape (k, n)."""
        x = np.asarray(x, dtype=float)
        cell = np.clip(np.searchsorted(self.edges, x, side="right") - 1, 0, len(self.edges) - 2)
        lengths = np.diff(self.edges)[cell]
        u = (x - self.edges[cell]) / lengths
        values = np.zeros((len(x), self.count))
        degree = self.coefficients.shape[1] - 1
        for power in range(degree, derivative - 1, -1):
            factor = np.prod(np.arange(power - derivative + 1, power + 1)) if derivative else 1.0
            values = values * u[:, None] + factor * self.coefficients[cell, power]
        return values / lengths[:, None] ** derivative


def hermite_elements(length: float, elements: int) -> ShapeSet:
    """Cubic Hermite elements of equal size; coordinates are deflection (m) and slope at each node but the clamped one.

    One element is the thesis' model (thesis, equations 4.2 and 4.3): tip deflection and tip slope.

    Args:
        length: L, m.
        elements: number of elements; 2 shapes each.
    """
    return hermite_between(np.linspace(0.0, length, elements + 1))


def hermite_between(nodes: Array) -> ShapeSet:
    """Cubic Hermite elements between given nodes (m, ascending, from 0 to L); coordinates as in `hermite_elements`."""
    elements = len(nodes) - 1
    coefficients = np.zeros((elements, 4, 2 * elements + 2))
    for e, h in enumerate(np.diff(nodes)):
        # rows: deflection left, slope left, deflection right, slope right; columns: powers of u
        cubic = np.array([[1, 0, -3, 2], [0, h, -2 * h, h], [0, 0, 3, -2], [0, 0, -h, h]], dtype=float)
        coefficients[e, :, 2 * e : 2 * e + 4] = cubic.T
    return ShapeSet(nodes, coefficients[:, :, 2:].copy(), elements == 1)


def clamped_free_modes(length: float, count: int) -> ShapeSet:
    """The first `count` bending modes of the uniform clamped-free beam, scaled to phi(L) = +-2, so that their coordinates are in m.

    Args:
        length: L, m.
        count: number of modes, at least 1.
    """
    cells = 2 * count
    edges = np.linspace(0.0, length, cells + 1)
    middles = 0.5 * (edges[:-1] + edges[1:]) / length
    # Taylor series about the middle of each cell, then moved to its left end: a fit through values would lose half the digits
    taylor = np.empty((cells, MODE_DEGREE + 1, count))
    for power in range(MODE_DEGREE + 1):
        scale = cells**power * math.factorial(power)
        for k in range(count):
            taylor[:, power, k] = _clamped_free_mode(k, middles, power) / scale
    shift = np.array(
        [[math.comb(m, k) * (-0.5) ** (m - k) if m >= k else 0.0 for m in range(MODE_DEGREE + 1)] for k in range(MODE_DEGREE + 1)]
    )
    return ShapeSet(edges, np.ascontiguousarray(np.einsum("km,cmi->cki", shift, taylor)), True)


def _clamped_free_mode(k: int, xi: Array, derivative: int) -> Array:
    """A derivative by xi = x/L of mode k of the clamped-free beam, with decaying exponentials so that high modes keep all digits."""
    guess = (k + 0.5) * np.pi
    b = scipy.optimize.brentq(lambda z: np.cos(z) + 1.0 / np.cosh(z), max(guess - 0.6, 1.0), guess + 0.6, xtol=1e-14, rtol=1e-14)
    one_minus_sigma = (np.sin(b) - np.cos(b) - np.exp(-b)) / (np.sinh(b) + np.sin(b))  # 1 - sigma without cancellation
    sigma = 1.0 - one_minus_sigma
    growing = 0.5 * one_minus_sigma * np.exp(b * xi)
    decaying = 0.5 * (1.0 + sigma) * (-1.0) ** derivative * np.exp(-b * xi)
    phase = b * xi + 0.5 * np.pi * derivative
    return b**derivative * (growing + decaying - np.cos(phase) + sigma * np.sin(phase))


def no_shapes(length: float) -> ShapeSet:
    """The rigid follower: no shape at all."""
    return ShapeSet(np.array([0.0, length]), np.zeros((1, 1, 0)), True)


def decoupled(shapes: ShapeSet, mass_per_length: float, bending_stiffness: float) -> tuple[ShapeSet, Array]:
    """Combinations of shapes for which the mass and stiffness matrices of the clamped beam are diagonal (equation 2.10).

    Args:
        shapes: any clamped shapes.
        mass_per_length: kg/m; in place of 0 the shapes are scaled with 1 kg/m.
        bending_stiffness: N m^2.

    Returns:
        Shapes whose coordinates are amplitudes (kg^(1/2) m), and their squared angular frequencies, shape (n,), 1/s^2.
    """
    if shapes.count == 0:
        return shapes, np.zeros(0)
    gauss, weights = np.polynomial.legendre.leggauss(shapes.coefficients.shape[1])
    lengths = np.diff(shapes.edges)
    x = (shapes.edges[:-1, None] + 0.5 * (gauss + 1.0) * lengths[:, None]).ravel()
    dx = (0.5 * weights * lengths[:, None]).ravel()
    value, curvature = shapes.evaluate(x), shapes.evaluate(x, 2)
    mass = (mass_per_length or 1.0) * value.T @ (dx[:, None] * value)
    stiffness = bending_stiffness * curvature.T @ (dx[:, None] * curvature)
    # M v = v / omega^2 K v: rounding errors are relative to the largest eigenvalue, which then belongs to the lowest mode
    inverse_squares, vectors = eigh(mass, stiffness)
    inverse_squares, vectors = inverse_squares[::-1], vectors[:, ::-1] / np.sqrt(inverse_squares[::-1])
    return ShapeSet(shapes.edges, shapes.coefficients @ vectors, shapes.has_continuous_curvature), 1.0 / inverse_squares
