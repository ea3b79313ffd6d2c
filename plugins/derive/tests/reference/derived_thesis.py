"""The thesis' model a second time, by the computer: the terms of its equations, energies, powers and forces at a state.

The description is `examples/derive/quick_return.py`. CasADi differentiates it; the slider's force is the multiplier of the loop, bearing
forces are what the masses on either side of it lack (d'Alembert). Nothing of `reference_model.thesis` is used.
"""

import math
from collections.abc import Callable, Mapping
from functools import cache
from typing import Any, Final

import casadi as ca
import numpy as np

from quickreturn.derive import Beam, System, turned, vector
from quickreturn.plugins.derive.equations import Equations
from quickreturn.plugins.derive.system import Points, column
from quickreturn.plugins.derive.tests.descriptions import described
from quickreturn.reference_model.arrays import Array
from quickreturn.reference_model.shapes import ShapeSet

Values = dict[str, Array]

#: Gauss points a cell: exact for places of shapes up to the fourth degree, and below rounding for the roots of exact geometry.
POINTS: Final = 16


class DerivedThesis:
    """The quick-return with one of the followers of `examples/derive/quick_return.py`, or with `of_shapes`.

    Args:
        follower: describes it.
        inboard: number of its mass points between base and slider; None if a cell holds points on both sides.
    """

    def __init__(self, follower: Callable[..., tuple[Beam, ca.SX, ca.SX, ca.SX]], inboard: int | None = None) -> None:
        built: list[tuple[Beam, ca.SX, ca.SX, ca.SX]] = []

        def keeps(*arguments: Any, **common: Any) -> tuple[Beam, ca.SX, ca.SX, ca.SX]:
            built.append(follower(*arguments, **common))
            return built[-1]

        system = described("quick_return").quick_return(keeps)
        ((beam, _, slider_angle, tangent),) = built
        p = {name: symbol for name, (symbol, _, _) in system.parameters.items()}
        (slider,) = (loop.force for loop in system.loops)
        of_beam, of_crank, of_slider, of_tip = (_lacking(system, points) for points in system.points)
        turn, turning_of_slider = beam.end_slope(), system.rate(system.rate(slider_angle))
        masses, x, y, _, _ = system.points[0]
        damped = ca.dot(masses, x * system.rate(y) - y * system.rate(x)) / p["mass_per_length"] * p["beam_damping"]
        at_base = p["base_inertia"] * system.rate(system.rate(beam.angle)) + p["base_damping"] * system.rate(beam.angle) - damped
        center = turned(turn, p["tip_center_of_mass"])
        at_tip = -p["tip_inertia"] * system.rate(system.rate(turn)) - center[0] * of_tip[1] + center[1] * of_tip[0]
        tool = vector(p["force_1"], p["force_2"])
        pivot = of_beam + of_tip - tool - slider

        def beyond(first: int) -> ca.SX:
            """The force (N) of the mass points from `first` on, of the tip body and of the tool on the arm inboard of them."""
            part = Points(*(each[first:] for each in system.points[0][:3]), *system.points[0][3:])
            drift = (-ca.dot(part.mass, system.rate(each)) / p["mass_per_length"] * p["beam_damping"] for each in (part.x, part.y))
            return tool - of_tip - _lacking(system, part) + turned(beam.angle, *drift)

        results = {
            "normal_forces": (
                column(
                    ca.dot(turned(beam.angle, 1, 0), beyond(0) + slider), ca.dot(turned(turn, 1, 0), tool - of_tip), ca.dot(tangent, slider)
                ),
                "N",
            ),
            "slider_force": (ca.dot(slider, vector(-tangent[1], tangent[0])), "N"),
            "bearings": (column(pivot, of_crank + of_slider + slider), "N"),
            "end_moments": (column(-p["slider_inertia"] * turning_of_slider, at_base, at_tip), "N*m"),
            "strain_energy": (sum(system.energies, ca.SX(0)), "J"),
            "gravity_energy": (-sum((ca.dot(system.gravity, _first_moment(points)) for points in system.points), ca.SX(0)), "J"),
            "tip_position": (beam.end(), "m"),
            "tip_acceleration": (ca.dot(system.rate(system.rate(beam.end())), turned(beam.end_slope(), 0, 1)), "m/s^2"),
        }
        if inboard is not None:
            results["normal_force_at_slider"] = (ca.dot(tangent, beyond(inboard)), "N")
        for name, (value, unit) in results.items():
            for k, component in enumerate(ca.vertsplit(ca.SX(value))):
                system.output(f"thesis {name} {k}", component, unit)
        e = Equations(system)
        shown = (column(*(e.outputs[f"thesis {name} {k}"][0] for k in range(ca.SX(value).numel()))) for name, (value, _) in results.items())
        self.parameters, self.results = list(p), [*results]
        names = [each.name for each in system.coordinates]
        self.given = [names.index("follower_angle"), names.index("slider_position")]
        self.free = [k for k in range(len(names)) if k not in self.given]
        constants = column(*p.values())
        self.loop = ca.Function("loop", [e.q, constants], [e.gap, e.G[:, self.given]])
        velocity = column(*(e.outputs[each.rate_name][0] for each in system.coordinates))
        inverse = ca.inv_minor(e.G[:, self.given])
        B, rest = ca.SX(len(names), len(self.free)), ca.SX(len(names), 1)
        B[self.free, :], B[self.given, :], rest[self.given] = ca.SX.eye(len(self.free)), -inverse @ e.G[:, self.free], -inverse @ e.bias
        M, Q = e.M[:-1, :-1], e.Q[:-1]
        projected = ca.substitute([B.T @ M @ B, B.T @ (Q - M @ rest)], [e.v], [velocity])
        self.function = ca.Function(
            "terms", [e.q, e.v, constants], [velocity, e.acceleration, e.rates[-2:], *projected, e.outputs["kinetic_energy"][0], *shown]
        )  # fmt: skip

    def at(self, parameters: Mapping[str, float], state: Mapping[str, float], amplitudes: Array, rates: Array) -> Values:
        """Everything about a state, SI.

        Args:
            parameters: of the scene, as `oracle_scene.draw_case` gives them.
            state: `crank_angle` and `crank_speed`; other names are ignored.
            amplitudes: of the shapes, shape (n,).
            rates: theirs.

        Raises:
            ValueError: the loop does not close.
        """
        towards = parameters["crank_length"] * np.exp(1j * state["crank_angle"]) - parameters["pivot_distance"]
        p = [parameters[name] for name in self.parameters]
        q, v = np.zeros(len(self.free) + 2), np.zeros(len(self.free) + 2)
        q[self.free], q[self.given] = [state["crank_angle"], *amplitudes], [np.angle(towards) % (2.0 * math.pi), abs(towards)]
        v[self.free] = [state["crank_speed"], *rates]
        for _ in range(50):
            gap, G = (np.array(each) for each in self.loop(q, p))
            step = np.linalg.solve(G, gap).ravel()
            q[self.given] -= step
            if np.max(np.abs(step)) < 1e-15:
                break
        if not np.max(np.abs(step)) < 1e-12:
            raise ValueError("the loop does not close")
        velocity, acceleration, powers, mass, force, kinetic, *results = (np.array(each) for each in self.function(q, v, p))
        (follower, follower_rate), (slider, slider_rate) = ((q[k], velocity[k, 0]) for k in self.given)
        return {
            "follower": np.array([follower, follower_rate]),
            "slider": np.array([slider, slider_rate]),
            "projected_mass_matrix": mass,
            "projected_force": force[:, 0],
            "accelerations": acceleration[self.free, 0],
            "follower_acceleration": acceleration[self.given[0]],
            "dissipated_power": powers[0],
            "drive_power": powers[1],
            "kinetic_energy": kinetic[0],
        } | {name: value[:, 0] for name, value in zip(self.results, results, strict=True)}  # fmt: skip


@cache
def one_cubic() -> DerivedThesis:
    """With the thesis' follower, whose amplitudes are deflection and slope of its tip."""
    return DerivedThesis(described("quick_return").one_cubic)


def of_shapes(shapes: ShapeSet, near: float, *, exact: bool) -> DerivedThesis:
    """Any piecewise polynomial deflections W.

    A point of the centre line stands at (x - F, W) in frame B, with F the integral of g from the base:

        exact         g = 1 - sqrt(1 - W'^2), tangent angle asin W'
        second order  g = W'^2 / 2,           tangent angle W'

    Args:
        shapes: on cells of equal length.
        near: about where the slider is, m: it decides on which cell.
        exact: the geometry.
    """
    cell, h = int(np.searchsorted(shapes.edges, near)) - 1, float(shapes.edges[1])

    def follower(system: System, s: ca.SX, p: Any, **common: Any) -> tuple[Beam, ca.SX, ca.SX, ca.SX]:
        eta, now = system.amplitudes("eta", shapes.count, "m"), system.freeze(s)
        edges = [*shapes.edges[: cell + 1].tolist(), now, *shapes.edges[cell + 1 :].tolist()]
        cells = [*range(cell + 1), *range(cell, len(shapes.edges) - 1)]

        def polynomial(x: ca.SX, k: int, order: int) -> ca.SX:
            powers = (x - float(shapes.edges[k])) / h
            terms = shapes.coefficients[k]
            for _ in range(order):
                terms = terms[1:] * np.arange(1, len(terms))[:, None] / h
            return sum((powers**power * ca.dot(ca.DM(row), eta) for power, row in enumerate(terms)), 0.0 * x)

        def along(order: int) -> Callable[[ca.SX], ca.SX]:
            def values(x: ca.SX) -> ca.SX:
                parts = ca.vertsplit(x, x.numel() // len(cells))
                return column(*(polynomial(part, k, order) for part, k in zip(parts, cells, strict=True)))

            return values

        kind = {"tangent": lambda x: ca.asin(along(1)(x))} if exact else {"deflection": along(0)}
        beam = Beam(system, "follower", edges=edges, points=POINTS, bending_stiffness=p.bending_stiffness, **kind, **common)
        # the line at the slider to the second order: exact in place, velocity and acceleration
        ahead, slope, bend = s - now, polynomial(now, cell, 1), polynomial(now, cell, 2)
        forwards = ca.sqrt(1 - slope**2) if exact else 1 - slope**2 / 2
        drawn = -slope * bend / forwards if exact else -slope * bend
        place = beam.end(cell) + turned(beam.angle, forwards * ahead + drawn * ahead**2 / 2, slope * ahead + bend * ahead**2 / 2)
        turn = polynomial(s, cell, 1)
        tangent = turned(beam.angle, forwards, slope)
        return beam, place, beam.angle + (ca.asin(turn) if exact else turn), tangent / ca.norm_2(tangent)

    return DerivedThesis(follower, POINTS * (cell + 1))


def _first_moment(points: Points) -> ca.SX:
    """Mass times place of all, kg m."""
    m, x, y, origin, angle = points
    return ca.sum1(m) * origin + turned(angle, ca.dot(m, x), ca.dot(m, y))


def _lacking(system: System, points: Points) -> ca.SX:
    """The force that points need besides their weight to move as they do, N."""
    return system.rate(system.rate(_first_moment(points))) - ca.sum1(points.mass) * system.gravity
