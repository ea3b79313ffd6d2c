"""The quick-return with a flexible follower, described for `quickreturn.derive`: parts, joint, drive and outputs.

It contains no equation derived by hand. With the equations that are, it shares only the table of the follower's shapes.
"""

from collections.abc import Callable
from functools import cache
from math import pi
from typing import Any, Final, NamedTuple

import casadi as ca
import numpy as np
from numpy.polynomial import legendre

from quickreturn.plugins.derive.beam import Beam, legendre_series
from quickreturn.plugins.derive.system import System, column, turned, vector
from quickreturn.plugins.derive.witness.tool import ForceRows, share_of_turn
from quickreturn.reference_model.mechanism import Mechanism, TorqueDrive
from quickreturn.reference_model.motion.layout import BeamTables, ShapeRow
from quickreturn.reference_model.spring import Spring

#: A function of a system with its follower that gives place, angle from n1 (rad) and curvature (1/m) of the slider's line at the slider.
Line = Callable[[System, "Follower"], tuple[ca.SX, ca.SX, ca.SX]]
#: Units of the constants; all are SI, so that a scene's values need no conversion.
UNITS: Final = {
    "pivot_distance": "m", "crank_length": "m", "length": "m",
    "crank_mass": "kg", "crank_center": "m", "crank_inertia": "kg*m^2",
    "torque": "N*m", "crank_damping": "N*m*s/rad", "start_angle": "rad", "speed": "rad/s",
    "base_inertia": "kg*m^2", "base_damping": "N*m*s/rad", "pivot_friction": "N*m", "pivot_friction_rate": "rad/s",
    "mass_per_length": "kg/m", "beam_damping": "N*s/m^2", "damping_moment": "N*m^2*s",
    "tip_mass": "kg", "tip_inertia": "kg*m^2", "tip_center": "m",
    "force_1": "N", "force_2": "N", "force_from": "rad", "force_span": "rad", "force_ramp": "rad", "force_follows": "1",
    "slide_friction": "N", "slide_speed": "m/s",
    "slider_mass": "kg", "slider_inertia": "kg*m^2", "gravity_1": "m/s^2", "gravity_2": "m/s^2",
    "joint_stiffness": "N/m", "joint_damping": "N*s/m", "joint_inertia": "kg", "joint_force": "N", "friction": "N",
    "anchor_1": "m", "anchor_2": "m", "spring_place": "m", "spring_stiffness": "N/m", "spring_rest": "m", "spring_preload": "N",
    "spring_damping": "N*s/m", "spring_shortest": "m", "spring_longest": "m", "stop_stiffness": "N/m", "stop_ramp": "m",
}  # fmt: skip


def constants(scene: Mechanism) -> dict[str, float]:
    """The scene's values by the names of `UNITS`; those of a compliant joint are zero if the joint is rigid."""
    crank, drive, base, follower, tip, slider = scene.crank, scene.crank.drive, scene.base, scene.follower, scene.tip_body, scene.slider
    torque, damping = (drive.torque, drive.damping) if isinstance(drive, TorqueDrive) else (0.0, 0.0)
    spring = scene.acting_spring or Spring(anchor=(0.0, 0.0))
    law = spring.law
    return dict.fromkeys(UNITS, 0.0) | {
        "pivot_distance": scene.pivot_distance, "crank_length": crank.length, "length": follower.length,
        "crank_mass": crank.mass, "crank_center": crank.center_of_mass, "crank_inertia": crank.inertia,
        "torque": torque, "crank_damping": damping, "start_angle": crank.initial_angle, "speed": drive.initial_speed,
        "base_inertia": base.inertia, "base_damping": base.damping,
        "pivot_friction": base.friction_torque, "pivot_friction_rate": base.friction_rate,
        "mass_per_length": follower.mass_per_length, "beam_damping": follower.damping,
        "damping_moment": follower.bending_stiffness * follower.material_damping,
        "tip_mass": tip.mass, "tip_inertia": tip.inertia, "tip_center": tip.center_of_mass,
        "force_1": tip.force_scale * tip.components[0], "force_2": tip.force_scale * tip.components[1],
        "force_from": tip.force_from, "force_span": tip.force_to - tip.force_from, "force_ramp": tip.force_ramp,
        "force_follows": float(tip.follows), "slide_friction": tip.friction_force, "slide_speed": tip.friction_speed,
        "slider_mass": slider.mass, "slider_inertia": slider.inertia, "gravity_1": scene.gravity[0], "gravity_2": scene.gravity[1],
        "joint_stiffness": 0.0 if slider.is_rigid else slider.sides[0], "joint_damping": slider.joint_damping,
        "anchor_1": spring.anchor[0], "anchor_2": spring.anchor[1], "spring_place": spring.place_on(follower.length),
        "spring_stiffness": law.stiffness, "spring_rest": law.rest, "spring_preload": law.preload, "spring_damping": law.damping,
        "spring_shortest": law.shortest, "spring_longest": law.longest, "stop_stiffness": law.stop, "stop_ramp": law.ramp,
    }  # fmt: skip


class Follower(NamedTuple):
    """The follower in the description."""

    beam: Beam
    end: ca.SX  # place of its flexible end, m
    turn: ca.SX  # angle of the tangent there, rad
    strain: ca.SX  # strain energy, J
    slider_cell: int  # index of the cell that ends at the slider
    place: ca.SX  # of the centre line at the slider, m
    angle: ca.SX  # of the tangent there, rad
    curvature: ca.SX  # there, 1/m


def quick_return(
    tables: BeamTables,
    shapes: int,
    *,
    rigid: bool = True,
    prescribed: bool = False,
    spring: bool = False,
    line: Line | None = None,
    tabulated: bool = False,
) -> System:
    """The description of the mechanism: crank, slider, follower, tip body and base.

    Args:
        tables: shapes of the follower at the Gauss points of cells that move with the slider.
        shapes: number of shapes.
        rigid: whether the slider stays on its line; otherwise there is a gap, across which joint and friction act.
        prescribed: whether the crank turns at a known speed; otherwise a torque drives it.
        spring: whether a spring holds the follower.
        line: the line on which the slider rides; None: the follower itself.
        tabulated: whether the tool's force comes from the system's second table.
    """
    system = System("quick-return")
    p = system.constants(**{name: (1.0, unit) for name, unit in UNITS.items()})
    system.gravity = vector(p.gravity_1, p.gravity_2)
    q1 = system.coordinate("crank_angle", "rad", rate="crank_speed")
    q2 = system.coordinate("follower_angle", "rad", rate="follower_rate", guess=pi)
    s = system.coordinate("slider_position", "m", guess=0.5 * (tables.low + tables.high))
    arm = follower(system, p, q2, s, tables, shapes)
    center, crank_tip = turned(q1, p.crank_center), turned(q1, p.crank_length)
    pivot, torque, strain = vector(p.pivot_distance, 0), p.torque, arm.strain

    # bodies and drive
    system.body("crank", p.crank_mass, center, p.crank_inertia, q1)
    system.body("slider", p.slider_mass, crank_tip, p.slider_inertia, arm.angle)
    components = share_of_turn(q1, p) * vector(p.force_1, p.force_2)
    if tabulated:
        force = ForceRows(0, "rad", q1 - system.freeze(q1))
        system.tables.append(force)
        components = force.function("N", [0, 1])
    tool = turned(p.force_follows * arm.turn, components[0], components[1])
    system.load("tool", arm.end, tool)
    # friction as a damper, as in the pivot
    velocity = system.rate(arm.end)
    u = ca.sqrt(ca.dot(velocity, velocity) / p.slide_speed**2 + 1e-24)
    slide = p.slide_friction / p.slide_speed * ca.tanh(u) / u
    system.damper("slide of the tool", arm.end, slide)
    system.damper("crank bearing", q1, p.crank_damping)
    if spring:
        strain += _hold(system, p, arm, q2)
    if prescribed:
        system.loop("drive", q1 - p.start_angle - p.speed * system.time, "rad", gives=[q1])
    else:
        system.load("motor", q1, torque)

    # the joint: the slider on the line, or beside it by a gap along the normal, towards +n
    foot, slope, curvature = line(system, arm) if line else (arm.place, arm.angle, arm.curvature)
    gap, normal = ca.SX(0), turned(slope, 0, 1)
    if rigid:
        held = system.loop("slider", foot - crank_tip, gives=[q2, s])
    else:
        gap = system.coordinate("gap", "m", size=1e-3)
        system.loop("slider", foot + gap * normal - crank_tip, gives=[s, gap])
        strain += p.joint_stiffness * gap**2 / 2
        system.energy("joint", p.joint_stiffness * gap**2 / 2)
        system.damper("joint", gap, p.joint_damping)
        system.body("joint", p.joint_inertia, vector(gap, 0))
        system.load("rollers", gap, -p.joint_force)
        system.load("friction", s, -p.friction)

    # the slider's force on the follower: its rotary inertia makes a moment, which a force along the bent line must balance
    arc_ratio = 1 - gap * curvature  # length of the slider's path over that of the line beside it
    moment = -p.slider_inertia * system.rate(system.rate(slope)) / arc_ratio
    along, tangent, lever = -moment * curvature, turned(slope, 1), foot - pivot
    if rigid:  # the residual of few shapes along the tangent is ignored: only the moment about P counts
        across = (_cross(lever, held) - along * _cross(lever, tangent)) / ca.dot(lever, tangent)
    else:
        across = p.joint_stiffness * gap + p.joint_damping * system.rate(gap) + p.joint_force
        across += p.joint_inertia * system.rate(system.rate(gap))
        along, moment = along + p.friction / arc_ratio, moment - gap * p.friction / arc_ratio
    on_follower = across * normal + along * tangent
    of_crank = p.crank_mass * (_acceleration(system, center) - system.gravity)
    of_slider = p.slider_mass * (_acceleration(system, crank_tip) - system.gravity) + on_follower
    if prescribed:  # the torque that balances the force on the follower; the drive's own force differs by the residual of few shapes
        torque = p.crank_inertia * system.rate(system.rate(q1)) + _cross(center, of_crank) + _cross(crank_tip, of_slider)
    _show(
        system,
        ("slider_force", across, "N"), ("slider_on_follower", on_follower, "N"), ("slider_moment", moment, "N*m"),
        ("tool", tool, "N"), ("slide", -slide * velocity, "N"),
        ("crank_torque", torque, "N*m"), ("crank_force", of_crank + of_slider, "N"), ("strain_energy", strain, "J"), ("foot", lever, "m"),
    )  # fmt: skip
    return system


def _hold(system: System, p: Any, arm: "Follower", q2: ca.SX) -> ca.SX:
    """Add the spring between a place of the follower and a fixed point, and its outputs; returns its energy, J."""
    place = _at_arc_length(arm.beam, p.spring_place)
    held = turned(q2, place[0], place[1])
    away = vector(p.anchor_1 - p.pivot_distance, p.anchor_2) - held
    now, length = ca.SX.sym("length"), ca.sqrt(ca.dot(away, away))
    beyond = ca.fmax(now - p.spring_longest, 0) + ca.fmax(p.spring_shortest - now, 0)
    soft = ca.fmin(beyond, p.stop_ramp)  # way over which the stop's stiffness rises as 3 u^2 - 2 u^3, and the way behind it
    hard, u = beyond - soft, soft / p.stop_ramp
    stop = p.stop_stiffness * (p.stop_ramp**2 * (u**4 / 4 - u**5 / 10) + p.stop_ramp * hard / 2 + hard**2 / 2)
    law = p.spring_preload * (now - p.spring_rest) + p.spring_stiffness * (now - p.spring_rest) ** 2 / 2 + stop
    energy, force = (ca.substitute(each, now, length) for each in (law, ca.jacobian(law, now)))
    system.energy("spring", energy)
    system.damper("spring", length, p.spring_damping)
    tension = force + p.spring_damping * system.rate(length)
    _show(
        system,
        ("spring_force", tension, "N"), ("spring_length", length, "m"), ("spring_on_follower", tension * away / length, "N"),
        ("spring_foot", held, "m"),
    )  # fmt: skip
    return energy


def _at_arc_length(beam: Beam, x: ca.SX) -> ca.SX:
    """Place in the beam's frame of the point at an arc length (m): on its cell the integral of the polynomial through the points."""
    begin, corner, found = ca.SX(0), vector(0, 0), vector(0, 0)
    for k, h in enumerate(beam.lengths):
        cosines, end = beam.directions(k), beam.corner(k)
        place = corner + h * cosines @ _integrals((x - begin) / h, cosines.size2())
        found = place if k == 0 else ca.if_else(x > begin, place, found)
        begin, corner = begin + h, end
    return found


def _integrals(u: ca.SX, points: int) -> ca.SX:
    """Weights of the values at a cell's Gauss points in the integral from its begin to the fraction u of it, as a part of its length."""
    t = 2 * u - 1
    polynomials = [ca.SX(1), t]
    for k in range(1, points):
        polynomials.append(((2 * k + 1) * t * polynomials[k] - k * polynomials[k - 1]) / (k + 1))
    integrals = [u, *((polynomials[k + 1] - polynomials[k - 1]) / (4 * k + 2) for k in range(1, points))]
    return ca.DM(legendre_series(points)).T @ ca.vertcat(*integrals)


def follower(system: System, p: Any, q2: ca.SX, s: ca.SX, tables: BeamTables, shapes: int) -> Follower:
    """Follower, tip body and base at an angle q2, with the slider at s, and their outputs; otherwise as for `quick_return`."""
    eta = system.amplitudes("eta", shapes, "kg**0.5*m")
    pivot = vector(p.pivot_distance, 0)

    # the tangent's angle is a sum of shapes at points that move with the slider
    now = system.freeze(s)
    table = system.tabulated(s, tables.low, tables.step, tables.coefficients)
    where, angle, points = columns_of_shapes(tables, shapes), "1/(kg**0.5*m)", tables.cells * (tables.gauss_points + 1)
    psi = ca.reshape(table.function(angle, *where["psi"]), points, shapes) @ eta
    slope = q2 + ca.dot(table.function(angle, *where["at slider"]), eta)
    curvature = ca.dot(table.function(f"{angle}/m", where["curvature"]), eta)
    edges = [0, now, p.length]
    if tables.cells > 2:  # shapes that stay: more cells to either side of the slider
        edges = [0, *ca.vertsplit(ca.cumsum(table.function("m", where["lengths"])))]
    beam = Beam(
        system, "follower", origin=pivot, angle=q2, edges=edges, tangent=lambda _: psi, points=tables.gauss_points,
        mass_per_length=p.mass_per_length, damping=p.beam_damping,
    )  # fmt: skip
    strain = ca.dot(table.function("1/s^2", *where["squares"]), eta**2) / 2
    system.energy("follower", strain)
    bent = _curvatures(psi, beam.lengths, tables.gauss_points)
    system.damper("material", bent, p.damping_moment * beam.shares)

    # bodies and friction of the pivot
    end, turn = beam.end(), beam.end_slope()
    tip = end + turned(turn, p.tip_center)
    system.body("base", inertia=p.base_inertia, angle=q2)
    system.body("tip", p.tip_mass, tip, p.tip_inertia, turn)
    system.damper("pivot", q2, p.base_damping)
    # friction as a damper, so that its work counts as dissipated: tanh(u)/u, which is 1 at a rate of zero
    u = ca.sqrt((system.rate(q2) / p.pivot_friction_rate) ** 2 + 1e-24)
    system.damper("friction of the pivot", q2, p.pivot_friction / p.pivot_friction_rate * ca.tanh(u) / u)

    # of the points: place from P, velocity against the base's frame, acceleration
    c, n = ca.cos(q2), ca.sin(q2)
    place_x, place_y = c * beam.x - n * beam.y, n * beam.x + c * beam.y
    drift_x, drift_y = system.rate(beam.x), system.rate(beam.y)
    _show(
        system,
        ("tip", end - pivot, "m"), ("tip_center", tip - pivot, "m"),
        ("tip_center_acceleration", _acceleration(system, tip), "m/s^2"), ("tip_turning", system.rate(system.rate(turn)), "rad/s^2"),
        ("tip_acceleration", ca.dot(_acceleration(system, end), turned(turn, 0, 1)), "m/s^2"),
        ("follower_acceleration", system.rate(system.rate(q2)), "rad/s^2"), ("lengths", column(*beam.lengths), "m"),
        ("place_x", place_x, "m"), ("place_y", place_y, "m"),
        ("drift_x", c * drift_x - n * drift_y, "m/s"), ("drift_y", n * drift_x + c * drift_y, "m/s"),
        ("acceleration_x", _acceleration(system, place_x), "m/s^2"), ("acceleration_y", _acceleration(system, place_y), "m/s^2"),
        ("bending_rate", system.rate(bent), "rad/(m*s)"), ("tangent", column(q2, slope, turn), "rad"),
    )  # fmt: skip
    cell = int(tables.slider_cell[0])
    return Follower(beam, end, turn, strain, cell, beam.slider(cell, s - now, curvature), slope, curvature)


def _show(system: System, *outputs: tuple[str, Any, str]) -> None:
    """Declare outputs by name, value and unit; the entries of a column are called NAME_k."""
    for name, value, unit in outputs:
        for k, each in enumerate(ca.vertsplit(ca.SX(value))):
            system.output(name if ca.SX(value).numel() == 1 else f"{name}_{k}", each, unit)


def _curvatures(psi: ca.SX, lengths: list[ca.SX], points: int) -> ca.SX:
    """Curvature at the Gauss points of every cell: slope of the polynomial through the tangent's angles at these points."""
    slopes = _slopes(points)
    return ca.vertcat(*(2.0 * (slopes @ psi[k * (points + 1) : k * (points + 1) + points]) / h for k, h in enumerate(lengths)))


@cache
def _slopes(points: int) -> ca.DM:
    """The matrix that turns values at the Gauss points of (-1, 1) into slopes at these points."""
    return ca.DM(legendre.legval(legendre.leggauss(points)[0], legendre.legder(legendre_series(points))).T)


def _cross(a: ca.SX, b: ca.SX) -> ca.SX:
    return a[0] * b[1] - a[1] * b[0]


def _acceleration(system: System, place: ca.SX) -> ca.SX:
    return system.rate(system.rate(place))


def columns_of_shapes(tables: BeamTables, shapes: int) -> dict[str, Any]:
    """Columns of the table that hold the shapes' angles and related quantities, each with its derivatives by s.

    The points are the Gauss points of a cell and its end, cell by cell.
    """
    row = ShapeRow.of(np.arange(tables.coefficients.shape[2], dtype=np.float64), shapes, tables)
    row = ShapeRow(*(part.astype(int) for part in row))
    fields = (row.psi_i, row.psi_i_s, row.psi_i_ss)[: 3 if tables.moves else 1]
    kinds = [field.reshape(shapes, tables.cells, tables.cell_size) for field in fields]
    return {
        "psi": [kind[:, :, : tables.gauss_points + 1].ravel().tolist() for kind in kinds],
        "squares": [row.squares.tolist(), row.squares_s.tolist()],
        "curvature": row.curvature_at_slider.tolist(),
        "at slider": [
            kinds[0][:, int(tables.slider_cell[0]), tables.gauss_points].tolist(),
            row.angle_at_slider_s.tolist(), row.angle_at_slider_ss.tolist(),
        ],
        "lengths": row.length.tolist(),
    }  # fmt: skip
