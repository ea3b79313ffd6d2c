"""A slender flexible beam in a moving frame, as mass points at Gauss abscissae (thesis, section 4.2)."""

from collections.abc import Callable, Sequence
from functools import partial, reduce
from itertools import pairwise
from typing import Any, Final, NamedTuple

import casadi as ca
import numpy as np
from numpy.polynomial import Polynomial, legendre
from scipy.linalg import eigh

from quickreturn.plugins.derive.checks import check_shear
from quickreturn.plugins.derive.system import System, column, turned
from quickreturn.plugins.derive.units import Array, DescriptionError, told

#: A quantity along the beam: arc lengths (m, a column) to values, a column.
Field = Callable[[ca.SX], ca.SX]


#: Support of an end -> number of derivatives that vanish there, counted from the deflection itself.
_HELD: Final = {"free": 0, "pinned": 1, "clamped": 2}


class _Line(NamedTuple):
    """Arc lengths, tangent's angles and places in the frame at all points and ends of cells; lengths of the cells."""

    s: ca.SX
    psi: ca.SX
    x: ca.SX
    y: ca.SX
    lengths: list[ca.SX]


class Beam:
    """An Euler beam that leaves `origin` at `angle`, inextensible unless `stretch` is given, without shear and inertia of its sections.

    Args:
        system: the system that contains the beam.
        name: name of the beam.
        origin: place of its beginning, m.
        angle: angle of its frame from n1, rad.
        edges: arc lengths (m) of the ends of the cells, from 0 to the end. Each cell has Gauss points; a moving slider's place is a frozen
            edge.
        mass_per_length: kg/m. This, both stiffnesses and the damping may be functions of the arc length.
        tangent: angle of the tangent in the frame, rad, from which the places follow exactly. Give this or `deflection`.
        deflection: displacement across the frame's first axis, m.
        stretch: displacement along that axis, m; only with `deflection`.
        foreshortening: whether a deflection moves the points towards the origin, by half the integral of its squared slope (thesis, section
            4.2); only with `deflection`.
        bending_stiffness: N m^2; 0 if the strain energy is given separately.
        axial_stiffness: N.
        damping: damping per length of the velocity relative to the frame, N s/m^2.
        points: Gauss points per cell.

    Attributes:
        x: places of all Gauss points along the frame's first axis, m, a column.
        y: places of all Gauss points along its second axis, m, a column.
        shares: the length that each Gauss point represents, m, a column.
        lengths: lengths of the cells, m.
    """

    @told("beam")
    def __init__(
        self,
        system: System,
        name: str,
        *,
        origin: Any,
        angle: Any,
        edges: Sequence[Any],
        mass_per_length: Any,
        tangent: Field | None = None,
        deflection: Field | None = None,
        stretch: Field | None = None,
        foreshortening: bool = True,
        bending_stiffness: Any = 0.0,
        axial_stiffness: Any = 0.0,
        damping: Any = 0.0,
        points: int = 6,
    ) -> None:
        if (tangent is None) == (deflection is None):
            raise DescriptionError(f"beam {name!r} needs one of tangent and deflection")
        for field, what in ((tangent or deflection, "tangent" if tangent else "deflection"), (stretch or tangent or deflection, "stretch")):
            if not callable(field):
                raise DescriptionError(
                    f"the {what} of beam {name!r} is no function; write one of the arc length, such as lambda x: w * (x / L)**2"
                )
        if tangent and (stretch or not foreshortening):
            raise DescriptionError(f"beam {name!r} with tangent= keeps its length exactly; stretch= and foreshortening= need deflection=")
        if not stretch and (callable(axial_stiffness) or not ca.SX(axial_stiffness).is_zero()):
            raise DescriptionError(f"beam {name!r} has an axial stiffness but does not stretch; give stretch=, or leave the stiffness out")
        if len(edges) < 2 or not (isinstance(points, int) and points > 0):
            raise DescriptionError(
                f"beam {name!r} needs two or more edges, from 0 to its end, and one or more points, not {edges}, {points}"
            )
        self._tangent, self._deflection, self._stretch, self._shortens = tangent, deflection, stretch, foreshortening
        self.origin, self.angle, self._points = origin, ca.SX(angle), points
        self._system, self.name, self._stiffness = system, name, bending_stiffness
        self._full_line = line = self._line(edges, points)
        inner, dx = _inner(line, points)
        self.x, self.y, self.shares, self.lengths = x, y, _, _ = line.x[inner], line.y[inner], dx, line.lengths
        mass, drag = (self._along(what, v, line.s[inner]) for what, v in (("mass_per_length", mass_per_length), ("damping", damping)))
        bending = self._along("bending_stiffness", bending_stiffness, line.s)
        axial = self._along("axial_stiffness", axial_stiffness, line.s)
        system.mass_points(name, mass * dx, x, y, origin, angle)
        strain = _derivative(stretch, line.s) if stretch else ca.SX(line.s.numel(), 1)
        system.energy(name, 0.5 * ca.dot(dx, (bending * self._curvature(line.s) ** 2 + axial * strain**2)[inner]))
        more = ca.SX.sym("s", (len(edges) - 1) * (2 * points + 1))
        system.slopes += [(name, line.psi)] if deflection else []
        field = tangent or deflection
        if field and field(more).numel() == more.numel():  # others are tables of values at the points
            system.integrals.append((name, self._squares(edges, points), self._squares(edges, 2 * points)))
        system.damper(name, column(x, y), column(drag * dx, drag * dx))

    @told("place of beam")
    def place(self, s: Any) -> ca.SX:
        """Place of the line at an arc length (m). If the arc length moves, the rate of the place is that of a travelling load."""
        return self._end(self._line([0, s], self._points), -1)

    @told("slope of beam")
    def slope(self, s: Any) -> ca.SX:
        """The tangent's angle from n1 at a fixed or moving arc length (m)."""
        return self.angle + self._line([0, s], self._points).psi[-1]

    @told("moment of beam")
    def moment(self, s: Any) -> ca.SX:
        """Bending moment (N m) at a fixed or moving arc length: what the part beyond it exerts on the part before it, counter-clockwise.

        It is the stiffness times the curvature of the shapes, and no better than these.
        """
        s = ca.SX(s)
        stiffness = self._along("bending_stiffness", self._stiffness, s)
        if stiffness.is_zero():
            raise DescriptionError(f"beam {self.name!r} of {self._system.name!r} has no bending stiffness, and so no moment")
        return stiffness * self._curvature(s)

    @told("shear of beam")
    def shear(self, s: Any) -> ca.SX:
        """Shear force (N) at an arc length: what the part beyond it exerts on the part before it, a quarter turn from the tangent.

        It is minus the slope of the moment. A warning says that the shapes are natural ones, or that the stiffness varies: such shapes have
        it only if they are many.
        """
        fields: list[Any] = [self._tangent or self._deflection]
        for _ in range(4):
            fields.append(partial(_derivative, fields[-1]))
        inner = _inner(self._full_line, self._points)[0]
        cut = len(inner) // 4  # at the ends the fourth derivatives are not accurate
        middle = self._full_line.s[inner[cut : len(inner) - cut]]
        check_shear(self._system, self.name, [field(middle) for field in fields[::2]], callable(self._stiffness))
        return -_derivative(self.moment, ca.SX(s))

    def end(self, cell: int = -1) -> ca.SX:
        """Place of a cell's end, by default the last cell's."""
        return self._end(self._full_line, cell)

    def end_slope(self, cell: int = -1) -> ca.SX:
        """The tangent's angle from n1 at a cell's end."""
        return self.angle + self._full_line.psi[self._points :: self._points + 1][cell]

    def directions(self, cell: int) -> ca.SX:
        """Directions of the tangent in the frame at a cell's Gauss points, as columns."""
        psi = self._full_line.psi[cell * (self._points + 1) : (cell + 1) * (self._points + 1) - 1]
        return ca.horzcat(ca.cos(psi), ca.sin(psi)).T

    def corner(self, cell: int) -> ca.SX:
        """Place of a cell's end in the frame, m."""
        return ca.vertcat(*(each[self._points :: self._points + 1][cell] for each in (self._full_line.x, self._full_line.y)))

    def slider(self, cell: int, advance: ca.SX, curvature: Any) -> ca.SX:
        """Place of a slider at a cell's end; `advance` is its arc length minus the frozen one.

        The line there is a parabola along the tangent: exact in place, velocity and acceleration where advance is zero.
        """
        return self.end(cell) + turned(self.end_slope(cell), advance, 0.5 * curvature * advance**2)

    def _end(self, line: _Line, cell: int) -> ca.SX:
        return self.origin + turned(self.angle, *(each[self._points :: self._points + 1][cell] for each in (line.x, line.y)))

    def _along(self, what: str, value: Any, s: ca.SX) -> ca.SX:
        """A number, an expression, or a function of the arc length, at arc lengths s (m, a column)."""
        found = ca.SX(value(s) if callable(value) else value)
        if found.numel() not in (1, s.numel()):
            raise DescriptionError(
                f"the {what} of beam {self.name!r} of {self._system.name!r} has {found.numel()} values; give one, or a function of the arc"
                " length, such as lambda x: EI * (1 - x / L)"
            )
        return found

    def _curvature(self, s: ca.SX) -> ca.SX:
        return _derivative(self._tangent or (lambda x: _derivative(self._deflection, x)), s)

    def _squares(self, edges: Sequence[Any], points: int) -> ca.SX:
        """Integrals of the squared deflection and curvature along the beam, by a number of points in each cell."""
        line = self._line(edges, points)
        inner, dx = _inner(line, points)
        return column(*(ca.dot(dx, each[inner] ** 2) for each in (line.y, self._curvature(line.s))))

    def _line(self, edges: Sequence[Any], points: int) -> _Line:
        u = ca.SX(np.append(0.5 * (legendre.leggauss(points)[0] + 1.0), 1.0))
        lengths = [ca.SX(b) - a for a, b in pairwise(edges)]
        s = column(*(a + h * u for a, h in zip(edges[:-1], lengths, strict=True)))
        if self._tangent:
            psi = self._tangent(s)
            return _Line(s, psi, self._integral(ca.cos(psi), lengths, points), self._integral(ca.sin(psi), lengths, points), lengths)
        deflection = self._deflection or (lambda s: 0.0 * s)
        slope = _derivative(deflection, s)
        x = s + (self._stretch(s) if self._stretch else 0.0)
        x -= self._integral(0.5 * slope**2, lengths, points) if self._shortens else 0.0
        return _Line(s, slope, x, deflection(s), lengths)

    def _integral(self, f: ca.SX, lengths: list[ca.SX], n: int) -> ca.SX:
        """Integral from the beginning to every point and end, of the polynomial through the points of each cell."""
        places = np.append(legendre.leggauss(n)[0], 1.0)
        to_points = ca.SX(0.5 * legendre.legval(places, legendre.legint(legendre_series(n), lbnd=-1)).T)
        parts = [ca.SX(0)]
        for k, h in enumerate(lengths):
            parts.append(parts[-1][-1] + h * (to_points @ f[k * (n + 1) : k * (n + 1) + n]))
        return column(*parts[1:])


def legendre_series(points: int) -> Array:
    """The matrix that turns values at the Gauss points of (-1, 1) into coefficients of Legendre's polynomials, shape (points, points)."""
    gauss, weights = legendre.leggauss(points)
    return np.asarray((np.arange(points)[:, None] + 0.5) * (legendre.legvander(gauss, points - 1) * weights[:, None]).T)


def _inner(line: _Line, points: int) -> tuple[list[int], ca.SX]:
    """Indices of the Gauss points of a line, and the length that each represents."""
    inner = [k for k in range(line.s.numel()) if (k + 1) % (points + 1)]
    return inner, column(*(h * ca.SX(0.5 * legendre.leggauss(points)[1]) for h in line.lengths))


def _derivative(field: Any, s: ca.SX) -> ca.SX:
    """The derivative of a field by the arc length."""
    at = ca.SX.sym("s", s.numel())
    return ca.substitute(ca.jtimes(field(at), at, ca.SX.ones(s.numel())), at, s)


def natural_shapes(supports: str, count: int) -> list[Field]:
    """Deflections of the first natural modes of a uniform beam as functions of x/L, by Ritz's method in polynomials.

    Args:
        supports: supports of the beginning and the end, each free, pinned or clamped, such as "clamped-free".
        count: number of modes; motions of the rigid beam come first and count.
    """
    ends = [_HELD.get(each, -1) for each in supports.split("-")]
    if len(ends) != 2 or min(ends) < 0 or count < 1:
        accepted = "one or more, between two ends that are free, pinned or clamped, such as 'clamped-free'"
        raise DescriptionError(f"{count} shapes between {supports!r} cannot be; give {accepted}")
    begin, end = ends
    held = Polynomial([0.0, 1.0]) ** begin * Polynomial([1.0, -1.0]) ** end
    basis = [held * legendre.Legendre.basis(k, domain=[0.0, 1.0]).convert(kind=Polynomial) for k in range(count + 8)]
    gauss, weights = legendre.leggauss(count + 12)
    value, curvature = (np.array([each.deriv(order)(0.5 * gauss + 0.5) for each in basis]) for order in (0, 2))
    _, vectors = eigh(curvature * weights @ curvature.T, value * weights @ value.T)
    powers = np.array([np.pad(each.coef, (0, begin + end + len(basis) - len(each.coef))) for each in basis])
    return [partial(_polynomial, vectors[:, k] @ powers) for k in range(count)]


def _polynomial(coefficients: Array, u: ca.SX) -> ca.SX:
    return reduce(lambda value, c: value * u + float(c), coefficients[::-1], 0.0 * u)
