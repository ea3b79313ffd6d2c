"""Recovers the bending moment from the equilibrium of all loads outboard of a place, and from the moment curvature and shape.

A few shapes give an accurate motion but an inaccurate curvature. So the moments are computed from the forces and from the accelerations of
the points (reference_model/DERIVATION.md, section 6). Vectors are complex numbers, x + i y, from P along n1 and n2; arrays have a row for
each instant.
"""

from collections.abc import Mapping
from typing import Any, Final, NamedTuple

import numpy as np
from numpy.polynomial import legendre
from numpy.typing import NDArray

from quickreturn.plugins.derive.beam import legendre_series
from quickreturn.reference_model.arrays import Array
from quickreturn.reference_model.columns import AXIAL, BENDING, PLACES, SHAPE
from quickreturn.reference_model.mechanism import Mechanism
from quickreturn.reference_model.rigid import follower_angle

Vectors = NDArray[np.complex128]

#: Outputs of the description that become columns of a trajectory unchanged.
AS_THEY_ARE: Final = (
    "crank_angle",
    "crank_speed",
    "follower_rate",
    "follower_acceleration",
    "tip_acceleration",
    "slider_force",
    "crank_torque",
    "kinetic_energy",
    "strain_energy",
)


class _Span(NamedTuple):
    """Gauss points of a cell."""

    begin: Array  # arc lengths, m, shape (rows, 1)
    length: Array  # arc lengths, m, shape (rows, 1)
    series: Array  # matrix that turns values at the points into coefficients of Legendre's polynomials, shape (points, points)

    def at(self, values: Any, x: Any) -> Any:
        """The polynomial through values (rows, points) at arc lengths (rows, k) or (k,)."""
        t = 2.0 * (x - self.begin) / self.length - 1.0
        return np.einsum("rp,rkp->rk", values @ self.series.T, legendre.legvander(t, len(self.series) - 1))

    def integral(self, values: Any, t: Any) -> Any:
        """Integral of the polynomial through values (rows, points), from the beginning of the span to places t (k,) of (-1, 1)."""
        return 0.5 * self.length * (values @ legendre.legval(t, legendre.legint(self.series, lbnd=-1)))

    def up_to(self, values: Any, x: float) -> Any:
        """The same to an arc length, shape (rows, 1)."""
        weights = legendre.legval(2.0 * (x - self.begin[:, 0]) / self.length[:, 0] - 1.0, legendre.legint(self.series, lbnd=-1))
        return 0.5 * self.length * np.sum(values * weights.T, axis=1, keepdims=True)


class _Line(NamedTuple):
    """The centre line in the base's frame by its curvature: at the Gauss points of each cell, and at the cells' ends."""

    bent: list[Array]  # 1/m, shape (rows, points), as the next
    lines: list[Any]  # places, m
    ends: list[Any]  # places, shape (rows,), as the last
    tangents: list[Any]
    angles: list[Array]  # rad, shape (rows, points + 1)

    @classmethod
    def of(cls, spans: list[_Span], bent: list[Array], gauss: Array, turned: Any = 0.0, moved: Any = 0.0) -> "_Line":
        """From P along the base's tangent, but for an angle (rad) and a displacement (m), each of shape (rows, 1) or a number."""
        found, angle, line = cls(bent, [], [], [], []), turned + 0.0 * spans[0].begin, moved + 0j * spans[0].begin
        for span, curvature in zip(spans, bent, strict=True):
            angles = angle + span.integral(curvature, np.append(gauss, 1.0))
            directions = np.exp(1j * angles)
            places = line + span.integral(directions[:, :-1], np.append(gauss, 1.0))
            angle, line = angles[:, -1:], places[:, -1:]
            for fields, field in zip(found[1:], (places[:, :-1], line[:, 0], directions[:, -1], angles), strict=True):
                fields.append(field)
        return found

    def at(self, spans: list[_Span], x: float) -> tuple[Any, Any]:
        """Angle (rad) and place (m) at an arc length, each of shape (rows, 1)."""
        angle: Any = 0.0
        line: Any = 0.0
        found: Any = None
        for k, span in enumerate(spans):
            here = angle + span.up_to(self.bent[k], x), line + span.up_to(np.exp(1j * self.angles[k][:, :-1]), x)
            found = here if k == 0 else tuple(np.where(x > span.begin, *each) for each in zip(here, found, strict=True))
            angle, line = self.angles[k][:, -1:], self.ends[k][:, None]
        return found

    def on_from(self, other: "_Line", spans: list[_Span], x: float, gauss: Array) -> "_Line":
        """The line with this curvature that has the angle and the place of another one at the arc length x."""
        angle, place = other.at(spans, x)
        turned = angle - self.at(spans, x)[0]
        return _Line.of(spans, self.bent, gauss, turned, place - _Line.of(spans, self.bent, gauss, turned).at(spans, x)[1])


def columns(scene: Mechanism, shown: Mapping[str, Array], damping_time: float) -> dict[str, Array]:
    """Columns of a trajectory from outputs of the description, each of shape (rows,).

    Args:
        scene: the mechanism.
        shown: outputs by name; quantities of the points are NAME_k.
        damping_time: damping moment over elastic moment per curvature rate, s.
    """
    beam, gravity = scene.follower, complex(*scene.gravity)

    def vector(name: str) -> Vectors:
        return np.asarray(shown[f"{name}_0"] + 1j * shown[f"{name}_1"])

    def along(name: str) -> Array:
        count = sum(key.startswith(f"{name}_") and key.removeprefix(f"{name}_").isdigit() for key in shown)
        return np.column_stack([shown[f"{name}_{k}"] for k in range(count)])

    place, drift = along("place_x") + 1j * along("place_y"), along("drift_x") + 1j * along("drift_y")
    weight = along("acceleration_x") + 1j * along("acceleration_y") - gravity
    lengths = along("lengths")
    cells, begins = lengths.shape[1], np.cumsum(lengths, axis=1) - lengths
    points = place.shape[1] // cells
    gauss, weights = legendre.leggauss(points)
    series = legendre_series(points)
    s = shown["slider_position"][:, None]
    spans = [_Span(begins[:, [k]], lengths[:, [k]], series) for k in range(cells)]
    parts = [slice(k * points, (k + 1) * points) for k in range(cells)]
    slider_cell = int(np.argmin(np.abs(begins + lengths - s)[0]))  # ends at the slider

    # forces outboard of a place, and their moment about P: from inertia, weight, damping, tip body, tool and slider
    force = -beam.mass_per_length * weight - beam.damping * drift
    tip, center, on_follower, foot = vector("tip"), vector("tip_center"), vector("slider_on_follower"), vector("foot")
    body = -scene.tip_body.mass * (vector("tip_center_acceleration") - gravity)
    tool = vector("tool") + vector("slide")
    end_force = body + tool
    end_moment = _cross(center, body) + _cross(tip, tool) - scene.tip_body.inertia * shown["tip_turning"]
    # a spring's moment has a kink within a cell: `moments` lacks it, `inner` has it everywhere, and each side is recovered from its own
    nothing: Vectors = np.zeros(len(s), complex)
    spring, held, pull, hung = scene.acting_spring, nothing, nothing, beam.length
    if spring is not None:
        held, pull, hung = vector("spring_foot"), vector("spring_on_follower"), spring.place_on(beam.length)
    moments, at_slider, at_tip_body = [np.empty(0)] * cells, np.empty(0), end_moment - _cross(tip, end_force)
    at_base, at_foot, at_end = np.exp(1j * along("tangent")).T
    pulled_at_tip, pulled = _dot(at_end, end_force), np.empty(0)
    for k in reversed(range(cells)):
        span, f, z = spans[k], force[:, parts[k]], place[:, parts[k]]
        turning = _cross(z, f)
        if k == slider_cell:
            at_slider = end_moment - _cross(foot, end_force) + np.where(s[:, 0] < hung, _cross(held - foot, pull), 0.0)
            pulled = _dot(at_foot, end_force) + np.where(s[:, 0] < hung, _dot(at_foot, pull), 0.0)
            end_force, end_moment = end_force + on_follower, end_moment + _cross(foot, on_follower) + shown["slider_moment"]
        inboard_force, inboard_moment = span.integral(f, np.append(gauss, 1.0)), span.integral(turning, np.append(gauss, 1.0))
        outboard = (end_force + inboard_force[:, -1])[:, None] - inboard_force[:, :-1]
        moments[k] = (end_moment + inboard_moment[:, -1])[:, None] - inboard_moment[:, :-1] - _cross(z, outboard)
        end_force, end_moment = end_force + inboard_force[:, -1], end_moment + inboard_moment[:, -1]

    # curvature, from it the tangent's angle, the line, and the place where it meets the crank tip
    rate = along("bending_rate")
    inner = [m + _cross(held[:, None] - place[:, part], pull) for m, part in zip(moments, parts, strict=True)]
    near, far = (
        _Line.of(spans, [m / beam.bending_stiffness - damping_time * rate[:, part] for m, part in zip(side, parts, strict=True)], gauss)
        for side in (inner, moments)
    )
    if spring is not None:
        far = far.on_from(near, spans, hung, gauss)

    def recovered(field: str, x: Array) -> Any:
        return np.where(x <= hung, _along(spans, getattr(near, field), x), _along(spans, getattr(far, field), x))

    chord = follower_angle(scene, shown["crank_angle"])
    crank_tip = scene.crank.length * np.exp(1j * shown["crank_angle"]) - scene.pivot_distance
    gap = shown.get("gap", np.zeros(len(s)))
    inboard = s[:, 0] <= hung
    tangent = np.where(inboard, near.tangents[slider_cell], far.tangents[slider_cell])
    slider_place = np.where(inboard, near.ends[slider_cell], far.ends[slider_cell]) + 1j * gap * tangent
    ahead = 0.5 * (np.abs(crank_tip) ** 2 - np.abs(slider_place) ** 2) / (slider_place * tangent.conj()).real
    base = crank_tip / (slider_place + ahead * tangent)
    base /= np.abs(base)
    at_tip = base * far.ends[-1]

    pivot = np.sum(beam.mass_per_length * weight * np.hstack([0.5 * span.length * weights for span in spans]), axis=1)
    pivot = pivot - body - tool - on_follower - pull
    crank = vector("crank_force")
    twelfths = np.arange(1, PLACES + 1) * beam.length / (PLACES + 1)
    table = {name: shown[name] for name in (*AS_THEY_ARE, *(() if spring is None else ("spring_force",)))}
    table |= {
        "follower_angle": chord + np.angle(base * np.exp(-1j * chord)),
        "slider_position": s[:, 0] + ahead,
        "tip_x": scene.pivot_distance + at_tip.real,
        "tip_y": at_tip.imag,
        "tip_deflection": far.ends[-1].imag,
        "dissipated_energy": shown["dissipated_energy"],
        "drive_work": shown["work"],
        "gravity_energy": shown["potential_energy"] - shown["strain_energy"],
        "constraint_gap": np.abs(shown.get("gap", np.abs(foot) - np.abs(crank_tip))),
        "pivot_force_x": pivot.real,
        "pivot_force_y": pivot.imag,
        "crank_force_x": crank.real,
        "crank_force_y": crank.imag,
    }
    strains = beam.extreme_fibre * recovered("bent", np.array(beam.strain_gauges))
    table |= {f"strain_{k + 1}": strains[:, k] for k in range(3)}
    table |= dict(zip(SHAPE, recovered("lines", twelfths).imag.T, strict=True))
    # what is outboard of the base is everything
    end_moment, end_force = end_moment + _cross(held, pull), end_force + pull
    of_moments = np.where(twelfths <= hung, _along(spans, inner, twelfths), _along(spans, moments, twelfths))
    of_moments = np.column_stack([of_moments, at_slider, at_slider + shown["slider_moment"], end_moment, at_tip_body])
    if hung == beam.length:
        pulled_at_tip = pulled_at_tip + _dot(at_end, pull)
    of_forces = _dot(at_base, end_force), pulled + _dot(at_foot, on_follower), pulled, pulled_at_tip
    return table | dict(zip(BENDING, of_moments.T, strict=True)) | dict(zip(AXIAL, of_forces, strict=True))


def _along(spans: list[_Span], values: list[Array], x: Array) -> Array:
    """A field that may jump or kink between cells, at arc lengths (k,); shape (rows, k)."""
    field, x = spans[0].at(values[0], x), np.broadcast_to(x, (len(spans[0].begin), len(x)))
    for span, each in zip(spans[1:], values[1:], strict=True):
        field = np.where(x > span.begin * (1.0 + 1e-12), span.at(each, x), field)
    return np.asarray(field)


def _dot(a: Vectors, b: Vectors) -> Array:
    """Part of the vectors b along the unit vectors a."""
    return (np.conj(a) * b).real


def _cross(a: Any, b: Any) -> Any:
    """Moment of the vectors b with the arms a. A row with one vector has it at all of its places."""
    b = b[:, None] if np.ndim(b) < np.ndim(a) else b
    return (np.conj(a) * b).imag
