"""A slender flexible beam in a frame that moves, as mass points at Gauss abscissae (thesis, section 4.2)."""

from collections.abc import Callable, Sequence
from typing import Any

import casadi as ca
import numpy as np

from quickreturn.derive.system import Points, System, turned
from quickreturn.derive.units import DescriptionError

#: A field along the beam: arc lengths (m, a column) to values, a column.
Field = Callable[[ca.SX], ca.SX]


class Beam:
    """An Euler beam that leaves `origin` at `angle`, inextensible unless `stretch` is given.

    Args:
        system: that it is part of.
        name: of the beam.
        origin: place of its begin.
        angle: of its frame from n1, rad.
        edges: arc lengths (m) of the cells, from the begin to the end. Each has Gauss points; a moving slider's place is a frozen edge.
        tangent: angle of the tangent in the frame, rad: places follow without approximation. Or
        deflection: across the frame's first axis, m, with
        stretch: displacement along it, m, and
        foreshortening: whether a deflection draws the points back, by half the integral of its slope's square (thesis, section 4.2).
        mass_per_length: kg/m.
        bending_stiffness: N m^2; none where the strain energy is stated otherwise.
        axial_stiffness: N.
        damping: per length, on the velocity in the frame, N s/m^2.
        points: Gauss points per cell.
    """

    def __init__(
        self,
        system: System,
        name: str,
        origin: Any,
        angle: Any,
        edges: Sequence[Any],
        *,
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
            raise DescriptionError(f"beam {name!r} needs its tangent's angle or its deflection, one of the two")
        self._tangent, self._deflection, self._stretch, self._shortens = tangent, deflection, stretch, foreshortening
        self.origin, self.angle, self._points = origin, ca.SX(angle), points
        x, self._psi, place, cells = self._line(edges)
        inner = [k for k in range(x.numel()) if (k + 1) % (points + 1)]
        self._ends = place[points :: points + 1, :]
        dx = ca.vertcat(*(h * ca.SX(0.5 * np.polynomial.legendre.leggauss(points)[1]) for h in cells))
        at_points = place[inner, :]
        system.points.append(Points(name, mass_per_length * dx, at_points[:, 0], at_points[:, 1], origin, self.angle))
        curvature = _derivative(tangent, x) if tangent else _derivative(lambda at: _derivative(deflection, at), x)
        energy = 0.5 * ca.dot(bending_stiffness * dx, curvature[inner] ** 2)
        if stretch:
            energy += 0.5 * ca.dot(axial_stiffness * dx, _derivative(stretch, x)[inner] ** 2)
        system.energy(f"bending of {name}", energy)
        system.damper(f"damping of {name}", ca.vec(at_points), ca.vertcat(damping * dx, damping * dx))
        system.states(f"points of beam {name!r}", ca.vec(at_points), "m")
        system.states(f"mass per length of beam {name!r}", mass_per_length, "kg/m")

    def place(self, x: Any) -> ca.SX:
        """Place of the centre line at an arc length (m), which may move: then its rate is that of a load which travels on the beam."""
        return self._fixed(self._line([0, x])[2][-1, :])

    def slope(self, x: Any) -> ca.SX:
        """The tangent's angle from n1 at an arc length (m)."""
        return self.angle + self._line([0, x])[1][-1]

    def end(self, cell: int = -1) -> ca.SX:
        """Place of a cell's end, the last one's unless said otherwise."""
        return self._fixed(self._ends[cell, :])

    def end_slope(self, cell: int = -1) -> ca.SX:
        """The tangent's angle from n1 at a cell's end."""
        return self.angle + self._psi[self._points :: self._points + 1][cell]

    def slider(self, cell: int, advance: ca.SX, curvature: Any) -> ca.SX:
        """Place of a slider at the end of a cell that it takes along, which is `advance` = s less its frozen value from that end.

        The line there is a parabola in the tangent's direction: exact in place, velocity and acceleration, for advance is zero.
        """
        psi, bent = self.end_slope(cell), 0.5 * curvature * advance**2
        return self.end(cell) + turned(psi, advance, bent)

    def _fixed(self, local: ca.SX) -> ca.SX:
        return self.origin + turned(self.angle, local[0], local[1])

    def _line(self, edges: Sequence[Any]) -> tuple[ca.SX, ca.SX, ca.SX, list[ca.SX]]:
        """Arc lengths, tangent's angles and places (x, y) in the frame at all points and ends of cells, and the cells' lengths."""
        gauss = np.polynomial.legendre.leggauss(self._points)[0]
        u = ca.SX(np.append(0.5 * (gauss + 1.0), 1.0))
        starts, cells = [ca.SX(edge) for edge in edges[:-1]], [ca.SX(b) - ca.SX(a) for a, b in zip(edges[:-1], edges[1:], strict=True)]
        x = ca.vertcat(*(a + h * u for a, h in zip(starts, cells, strict=True)))
        if self._tangent:
            psi = self._tangent(x)
            return x, psi, ca.horzcat(self._integral(ca.cos(psi), cells), self._integral(ca.sin(psi), cells)), cells
        assert self._deflection
        slope = _derivative(self._deflection, x)
        along = x + (self._stretch(x) if self._stretch else 0.0)
        if self._shortens:
            along -= self._integral(0.5 * slope**2, cells)
        return x, slope, ca.horzcat(along, self._deflection(x)), cells

    def _integral(self, f: ca.SX, cells: list[ca.SX]) -> ca.SX:
        """From the begin to every point and end, of the polynomial through the points of each cell."""
        gauss, weights = np.polynomial.legendre.leggauss(self._points)
        legendre = np.polynomial.legendre
        series = (np.arange(self._points)[:, None] + 0.5) * (legendre.legvander(gauss, self._points - 1) * weights[:, None]).T
        upper = legendre.legval(np.append(gauss, 1.0), legendre.legint(series, lbnd=-1)).T  # (points + 1, points)
        found, begin = [], ca.SX(0)
        for k, h in enumerate(cells):
            inside = f[k * (self._points + 1) : (k + 1) * (self._points + 1) - 1]
            found.append(begin + h * ca.mtimes(ca.SX(0.5 * upper), inside))
            begin = found[-1][-1]
        return ca.vertcat(*found)


def _derivative(field: Field, x: ca.SX) -> ca.SX:
    """The derivative of a field by the arc length."""
    at = ca.SX.sym("x", x.numel())
    return ca.substitute(ca.jtimes(field(at), at, ca.SX.ones(x.numel())), at, x)
