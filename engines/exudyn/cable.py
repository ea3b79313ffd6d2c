"""Mechanics of a chain of planar ANCF cable elements in numpy, for observables from recorded coordinates.

Nodal coordinates are (x, y, x', y'), the place and its derivative by arc length. Between nodes the centre line is the cubic
Hermite polynomial (Gerstmayr and Irschik, Journal of Sound and Vibration 318, 2008). All elements have the same length h.
Arrays of nodal coordinates have shape (rows, nodes, 4), one row per instant.
"""

from dataclasses import dataclass
from typing import Final

import numpy as np

from quickreturn.reference_model.arrays import Array

#: Gauss points of the elements' bending moments and axial forces, as `flexible.section_of` asks for them.
_BENDING_POINTS, _BENDING_WEIGHTS = np.polynomial.legendre.leggauss(2)
_AXIAL_POINTS, _AXIAL_WEIGHTS = np.polynomial.legendre.leggauss(4)


#: Iterations to the nearest place of the line to a point: from 5 % of the length away four reach rounding.
FOOT_ITERATIONS: Final = 6


@dataclass(frozen=True)
class Kink:
    """A point force, at which the third derivative of the centre line jumps."""

    place: Array  # its arc length, m, shape (rows,)
    jump: Array  # r''' outboard of it less r''' inboard, 1/m²: the force over EI, shape (rows, 2)


@dataclass(frozen=True)
class Cable:
    """A uniform cable of equal elements."""

    length: float  # m
    elements: int  # number of elements
    mass_per_length: float  # kg/m
    bending_stiffness: float  # N m^2
    axial_stiffness: float  # N
    bending_damping: float = 0.0  # N m^2 s

    @property
    def element_length(self) -> float:
        """Length h of one element, m."""
        return self.length / self.elements

    @property
    def nodes(self) -> Array:
        """Arc lengths of the nodes, m, shape (elements + 1,)."""
        return np.linspace(0.0, self.length, self.elements + 1)

    def quadrature(self, every: int = 1) -> Array:
        """Weights of every so many nodes in ∫ dx, m, shape (elements/every + 1,): the trapezoidal rule with Gregory's end correction.

        It is of fourth order, and needs six intervals; `every` divides the elements.
        """
        interval = every * self.element_length
        weights = np.full(self.elements // every + 1, interval)
        for i, factor in enumerate((3.0 / 8.0, 7.0 / 6.0, 23.0 / 24.0)):
            weights[[i, -1 - i]] = factor * interval
        return weights

    @property
    def to_nodes(self) -> Array:
        """Weights of the nodes (columns) in the integrals from x = 0 to each node (rows), m: of fourth order, like `quadrature`."""
        h, count = self.element_length, self.elements + 1
        weights = np.zeros((count, count))
        for k in range(self.elements):
            first = min(max(k - 1, 0), count - 4)
            parts = {1: (9, 19, -5, 1), 0: (-1, 13, 13, -1), -1: (1, -5, 19, 9)}[first - (k - 1)]
            weights[k + 1 :, first : first + 4] += np.array(parts) * h / 24.0
        return weights

    def evaluate(self, q: Array, x: Array, nu: int = 0) -> Array:
        """The `nu`-th derivative (0 to 2) of the centre line at one arc length per row; the second jumps at nodes.

        Args:
            q: nodal coordinates or their rates, shape (rows, nodes, 4).
            x: arc lengths, m, shape (rows,).
            nu: order of the derivative.

        Returns:
            Shape (rows, 2).
        """
        h = self.element_length
        element = np.clip((x / h).astype(int), 0, self.elements - 1)
        rows = np.arange(len(x))
        shapes = _hermite((x - element * h) / h, h, nu)
        ends = np.concatenate([q[rows, element], q[rows, element + 1]], axis=1).reshape(len(x), 4, 2)
        return np.einsum("rs,rsc->rc", shapes, ends)

    def foot(self, q: Array, points: Array, near: Array) -> Array:
        """Arc lengths of the places nearest to `points` (m, shape (rows, 2)), from arc lengths `near` them; m, shape (rows,)."""
        x = near
        for _ in range(FOOT_ITERATIONS):
            slope = self.evaluate(q, x, 1)
            x = x + dot(points - self.evaluate(q, x), slope) / dot(slope, slope)
        return x

    def curvatures(self, q: Array, places: Array, *kinks: Kink) -> Array:
        """Curvature at arc lengths, 1/m.

        An element's own second derivative jumps at nodes and is only of second order there. r'' at a node therefore comes from places
        and slopes of the two neighbours, 2 (r₊ - 2 r + r₋)/h² - (r'₊ - r'₋)/2h, which is of fourth order; r'' between nodes comes from
        the quintic polynomial through places, slopes and r'' at the nodes.

        A kink would be rounded off, with an error of up to j h/8 where r''' jumps by j. The places and slopes at the nodes are those of
        the kinked line, because cubic elements have them exactly under a point force. So j (s - x)³/6 is subtracted from the line inboard
        of the kink, r'' of the rest is interpolated, and the ramp j (s - x) is added.

        Args:
            q: nodal coordinates, shape (rows, nodes, 4).
            places: arc lengths, m, shape (places, rows).
            kinks: of the line.

        Returns:
            Shape (places, rows).
        """
        smooth, h = q, self.element_length
        for kink in kinks:
            lever = np.maximum(0.0, kink.place[:, None] - self.nodes)[:, :, None]
            smooth = smooth - np.concatenate([lever**3 / 6.0 * kink.jump[:, None], -(lever**2) / 2.0 * kink.jump[:, None]], axis=2)
        nodal = np.concatenate([q, smooth, self._second_derivatives(smooth)], axis=2)
        left = np.clip((places / h * (1.0 + 1e-12)).astype(int), 0, self.elements - 1)
        xi, rows = places / h - left, np.arange(len(q))
        ends = np.stack([nodal[rows, left], nodal[rows, left + 1]], axis=2)  # places, rows, 2, 10
        of_line, of_smooth = ends[..., :4].reshape(*xi.shape, 4, 2), ends[..., 4:].reshape(*xi.shape, 6, 2)
        slope = np.einsum("prs,prsc->prc", _hermite(xi, h, 1), of_line)
        bent = np.einsum("prs,prsc->prc", _quintic_second_derivative(xi, h), of_smooth)
        for kink in kinks:
            bent += np.maximum(0.0, kink.place - places)[:, :, None] * kink.jump
        return _cross(slope, bent) / dot(slope, slope)

    def _second_derivatives(self, q: Array) -> Array:
        """Second derivative r'' at all nodes, 1/m, shape (rows, nodes, 2)."""
        h, place, slope = self.element_length, q[..., :2], q[..., 2:]
        inner = 2.0 * (place[:, 2:] - 2.0 * place[:, 1:-1] + place[:, :-2]) / h**2 - (slope[:, 2:] - slope[:, :-2]) / (2.0 * h)
        # At an end of the cable: the quintic through the neighbour's r'' and the element's own four coordinates is not determined;
        # the cubic's r'' at the neighbour errs as much as at the end, with the same sign.
        first, last = (q[:, ends].reshape(len(q), 4, 2) for ends in ([0, 1], [-2, -1]))
        begin, end = _hermite(np.array([0.0, 1.0]), h, 2)
        change = begin - end
        ends = np.einsum("s,rsc->rc", change, first), -np.einsum("s,rsc->rc", change, last)
        return np.concatenate([(inner[:, 0] + ends[0])[:, None], inner, (inner[:, -1] + ends[1])[:, None]], axis=1)

    def kinetic_energy(self, rates: Array) -> Array:
        """Kinetic energy for nodal rates, J, shape (rows,)."""
        h = self.element_length
        shares = np.array(
            [
                [156.0, 22.0 * h, 54.0, -13.0 * h],
                [22.0 * h, 4.0 * h**2, 13.0 * h, -3.0 * h**2],
                [54.0, 13.0 * h, 156.0, -22.0 * h],
                [-13.0 * h, -3.0 * h**2, -22.0 * h, 4.0 * h**2],
            ]
        )
        mass = self.mass_per_length * h / 420.0 * shares
        ends = self._ends(rates)
        return 0.5 * np.einsum("resc,st,retc->r", ends, mass, ends, optimize=True)

    def strain_energy(self, q: Array) -> Array:
        """Bending and stretching energy, with the quadrature rules of the element's forces, J, shape (rows,)."""
        h = self.element_length
        ends = self._ends(q)
        bending = _BENDING_WEIGHTS * h / 2.0 * self.bending_stiffness
        stretching = _AXIAL_WEIGHTS * h / 2.0 * self.axial_stiffness
        slope, bent = (np.einsum("ps,resc->repc", _hermite((1.0 + _BENDING_POINTS) / 2.0, h, nu), ends) for nu in (1, 2))
        curvature = _cross(slope, bent) / np.sum(slope**2, axis=-1)
        slope = np.einsum("ps,resc->repc", _hermite((1.0 + _AXIAL_POINTS) / 2.0, h, 1), ends)
        strain = np.sqrt(np.sum(slope**2, axis=-1)) - 1.0
        return 0.5 * (np.einsum("rep,p->r", curvature**2, bending) + np.einsum("rep,p->r", strain**2, stretching))

    def bending_loss(self, q: Array, rates: Array) -> Array:
        """Power that the material's damping dissipates, W, shape (rows,), with the quadrature rule of the element's forces."""
        h, points = self.element_length, (1.0 + _BENDING_POINTS) / 2.0
        slope, bent = (np.einsum("ps,resc->repc", _hermite(points, h, nu), self._ends(q)) for nu in (1, 2))
        slope_rate, bent_rate = (np.einsum("ps,resc->repc", _hermite(points, h, nu), self._ends(rates)) for nu in (1, 2))
        squared = np.sum(slope**2, axis=-1)
        stretched = 2.0 * np.sum(slope * slope_rate, axis=-1) / squared
        rate = (_cross(slope_rate, bent) + _cross(slope, bent_rate) - stretched * _cross(slope, bent)) / squared
        return np.asarray(np.einsum("rep,p->r", rate**2, _BENDING_WEIGHTS * h / 2.0 * self.bending_damping))

    def stretch(self, q: Array) -> Array:
        """Length of the centre line less the undeformed length, m, shape (rows,)."""
        h = self.element_length
        slope = np.einsum("ps,resc->repc", _hermite((1.0 + _AXIAL_POINTS) / 2.0, h, 1), self._ends(q))
        return np.einsum("rep,p->r", np.sqrt(np.sum(slope**2, axis=-1)) - 1.0, _AXIAL_WEIGHTS * h / 2.0)

    def first_moment(self, q: Array) -> Array:
        """∫ ρA r dx, kg m, shape (rows, 2)."""
        h = self.element_length
        weights = self.mass_per_length * h * np.array([0.5, h / 12.0, 0.5, -h / 12.0])
        return np.einsum("s,resc->rc", weights, self._ends(q))

    def _ends(self, q: Array) -> Array:
        """Coordinates of both nodes of every element, shape (rows, elements, 4 shapes, 2 components)."""
        return np.concatenate([q[:, :-1], q[:, 1:]], axis=2).reshape(len(q), self.elements, 4, 2)


def _hermite(xi: Array, h: float, nu: int) -> Array:
    """Cubic Hermite shapes (place, slope, place, slope) at xi = x/h in [0, 1] or their derivatives in x, shape (*that of xi, 4)."""
    one = np.ones_like(xi)
    if nu == 0:
        columns = [1 - 3 * xi**2 + 2 * xi**3, h * (xi - 2 * xi**2 + xi**3), 3 * xi**2 - 2 * xi**3, h * (xi**3 - xi**2)]
    elif nu == 1:
        columns = [6 * (xi**2 - xi) / h, 1 - 4 * xi + 3 * xi**2, 6 * (xi - xi**2) / h, 3 * xi**2 - 2 * xi]
    else:
        columns = [(12 * xi - 6) / h**2, (6 * xi - 4) / h, (6 * one - 12 * xi) / h**2, (6 * xi - 2) / h]
    return np.stack(columns, axis=-1)


def _quintic_second_derivative(xi: Array, h: float) -> Array:
    """r''(xi h) from (r, r', r'') at both ends of an element, weights of shape (*that of xi, 6)."""
    columns = [
        (-60 * xi + 180 * xi**2 - 120 * xi**3) / h**2,
        (-36 * xi + 96 * xi**2 - 60 * xi**3) / h,
        1 - 9 * xi + 18 * xi**2 - 10 * xi**3,
        (60 * xi - 180 * xi**2 + 120 * xi**3) / h**2,
        (-24 * xi + 84 * xi**2 - 60 * xi**3) / h,
        3 * xi - 12 * xi**2 + 10 * xi**3,
    ]
    return np.stack(columns, axis=-1)


def _cross(a: Array, b: Array) -> Array:
    """Vector products along the last axis."""
    return a[..., 0] * b[..., 1] - a[..., 1] * b[..., 0]


def direction(slope: Array, slope_rate: Array, slope_acceleration: Array) -> tuple[Array, Array, Array]:
    """Unit vector along `slope` (rows, 2), its angular rate and angular acceleration (rows,)."""
    squared = dot(slope, slope)
    rate = dot(turned(slope), slope_rate) / squared
    acceleration = dot(turned(slope), slope_acceleration) / squared - 2.0 * rate * dot(slope, slope_rate) / squared
    return slope / np.sqrt(squared)[:, None], rate, acceleration


def turned(a: Array) -> Array:
    """Vectors (..., 2) turned by a quarter turn, counter-clockwise."""
    result = np.empty_like(a)
    result[..., 0], result[..., 1] = -a[..., 1], a[..., 0]
    return result


def dot(a: Array, b: Array) -> Array:
    """Scalar products of vectors (..., 2)."""
    return np.asarray(a[..., 0] * b[..., 0] + a[..., 1] * b[..., 1])
