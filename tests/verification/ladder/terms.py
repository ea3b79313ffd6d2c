"""Second rung: the parts of the equations of motion, one by one, in one given state.

Every engine is put into the same bent and moving state. What it says there of places, rates and energies is held against quadratures
over the given state, which no engine is part of. Kinetic energies of several velocities give the entries of the mass matrix along common
motions, M(u, v) = K(u + v) - K(u) - K(v); energies of neighbouring states the generalized forces along them.

Accelerations and forces are compared as means over some milliseconds. In the instant itself they are no property of the state alone:
a line bent in any other way than the loads of that instant bend it starts vibrations of every frequency, and the more of them the finer
the model; an extensible cable begins without the tension that an inextensible one has at once.
"""

import dataclasses
import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import partial
from types import MappingProxyType
from typing import Final

import numpy as np
from scipy.interpolate import PPoly

from quickreturn.engines.exudyn.settings import ExudynSettings
from quickreturn.engines.mujoco.settings import ChainSettings
from quickreturn.engines.own.reference import ReferenceSettings
from quickreturn.engines.registry import engine
from quickreturn.engines.settings import Settings
from quickreturn.engines.start import Start, standard_start
from quickreturn.engines.start_state import StartState, reconstruct
from quickreturn.plugins.methods.rivals.fixed_shapes import FixedShapesSettings
from quickreturn.plugins.methods.rivals.multiplier import MultiplierSettings
from quickreturn.reference_model.arrays import Array
from quickreturn.reference_model.mechanism import Mechanism, TorqueDrive
from quickreturn.reference_model.tip import Tip
from tests.verification.row import Row, smoothed

#: Of the reference, whose state it is.
OWN: Final = ReferenceSettings(modes=8, tolerance=1e-9)
#: Relative error of what is read off differences over `INSTANT`, and of the projection on other shapes.
FLOOR: Final = 2e-5
CRANK: Final = "mass matrix: crank, crank (the follower's part)"
BENDING: Final = "mass matrix: bending, bending"
MIXED: Final = "mass matrix: crank, bending"
ELASTIC: Final = "elastic force along the bending"
WEIGHT: Final = "weight along the bending"
#: What rates are good to that are read off the first rows. In the power of the dampers the state's own vibrations show: between 0 and
#: 0.2 ms it falls by 1.6 %, alike in Exudyn with 48 and 96 elements and in MuJoCo, as the light base block gives way.
READ_OFF: Final = MappingProxyType({"follower_rate": 1e-3, "slider_speed": 1e-3, "damping_power": 0.03})
INSTANT: Final = 1e-5  # s, output step where rates of the state are read off
SHIFT: Final = 0.02  # part of the rate's own shape by which neighbouring states are bent more and less
SPAN: Final = 5e-3  # s, of which the last four fifths are averaged: at first Exudyn's multiplier rings for a hundred steps


@dataclass(frozen=True)
class Candidate:
    """An engine with settings, and what these leave of a state and of its motion."""

    name: str
    settings: Settings
    label: str
    state: float  # relative error of quantities of the state: what the discretization cannot represent of the given line
    motion: float  # the same of mean accelerations and forces
    reason: str  # where both come from


@dataclass(frozen=True)
class Terms:
    """Of a state: places (m, rad), their rates, energies (J), power of the dampers of follower and base (W)."""

    follower_angle: float
    slider_position: float
    tip_x: float
    tip_y: float
    follower_rate: float
    slider_speed: float
    kinetic_energy: float
    strain_energy: float
    gravity_energy: float
    damping_power: float


def candidates(fineness: int) -> tuple[Candidate, ...]:
    """Engines to be compared; discretizations become finer in proportion to `fineness`."""
    shapes, elements, links = 16 * fineness, 24 * fineness, 30 * fineness
    modes, nodes, hinges = 0.025 / shapes**1.5 + FLOOR, 0.06 / elements**2 + FLOOR, 0.1 / links**2 + FLOOR
    forces = 0.8 / shapes**2
    fixed = "an offset tip body bends the end, clamped-free modes do not: order 3/2 in their number"
    cable, chain = "curvature between nodes: second order", "bending in hinges: second order"
    return (
        Candidate("reference", OWN, "reference", 0.15 / OWN.modes**3, 0.0, "projection on its modes: third order"),
        Candidate("fixed-shapes", FixedShapesSettings(shapes=shapes, tolerance=1e-9), f"fixed-shapes, {shapes}", modes, forces, fixed),
        Candidate("multiplier", MultiplierSettings(shapes=shapes, tolerance=1e-9), f"multiplier, {shapes}", modes, forces, fixed),
        Candidate("exudyn", ExudynSettings(elements=elements, step=1e-5), f"exudyn, {elements} elements", nodes, 1e-3, cable),
        Candidate("mujoco", ChainSettings(links=links), f"mujoco, {links} links", hinges, 1e-3, chain),
    )


def state_of(mechanism: Mechanism, time: float) -> Start:
    """Where the reference's motion from the standard start has led at `time` (s), a multiple of 10 ms."""
    simulation = engine("reference").prepare(mechanism, standard_start(mechanism), OWN)
    simulation.advance(time, 1e-2)
    start = simulation.present_start()
    assert start is not None
    return start


def term_rows(mechanism: Mechanism, scene: str, state: Start, fineness: int) -> Iterator[Row]:
    """Places, rates, energies, mass matrix and forces of every engine against quadratures over the state."""
    exact = _exact_terms(mechanism, state)
    pairs = _pairs(mechanism, state, _exact_terms)
    scales = _pair_scales(pairs, exact, mechanism)
    for candidate in candidates(fineness):
        found = _engine_terms(candidate, mechanism, state)
        for name, scale in _scales(exact, mechanism).items():
            yield _row(scene, candidate, name, getattr(found, name), getattr(exact, name), scale)
        for name, value in _pairs(mechanism, state, partial(_engine_terms, candidate, rates=False)).items():
            yield _row(scene, candidate, name, value, pairs[name], scales[name])


def mean_rows(mechanism: Mechanism, scene: str, state: Start, fineness: int) -> Iterator[Row]:
    """Mean accelerations and forces of every engine against the reference's."""
    first, *others = candidates(fineness)
    expected = _means(first, mechanism, state)
    for candidate in others:
        for name, value in _means(candidate, mechanism, state).items():
            yield Row(
                scene=scene, engine=candidate.label, quantity=f"mean {name}", value=value, expected=expected[name],
                tolerance=candidate.motion, reason="what these settings leave of forces in a run, measured",
            )  # fmt: skip


def _row(scene: str, candidate: Candidate, name: str, value: float, expected: float, scale: float) -> Row:
    read_off = name in READ_OFF
    return Row(
        scene=scene, engine=candidate.label, quantity=name, value=value, expected=expected, scale=scale,
        tolerance=READ_OFF[name] if read_off else candidate.state,
        reason="read off rows of the first 40 us, in which the fastest vibrations start" if read_off else candidate.reason,
    )  # fmt: skip


def _scales(exact: Terms, mechanism: Mechanism) -> dict[str, float]:
    """Sizes of the quantities of a state; without those that are zero."""
    length = mechanism.follower.length
    places = {"follower_angle": 1.0, "slider_position": length, "tip_x": length, "tip_y": length}
    return places | {name: abs(value) for name, value in dataclasses.asdict(exact).items() if name not in places and value != 0.0}


def _pair_scales(pairs: dict[str, float], exact: Terms, mechanism: Mechanism) -> dict[str, float]:
    """Sizes of the entries: a straight follower's inertia on the crank, and what bends; the weight is as small as it is against bending."""
    tip, beam = mechanism.tip_body, mechanism.follower
    inertia = beam.mass_per_length * beam.length**3 / 3.0 + tip.mass * beam.length**2
    crank, bending = inertia * (mechanism.crank.length / exact.slider_position) ** 2, abs(pairs[BENDING])
    scales = {CRANK: crank, BENDING: bending, MIXED: math.sqrt(crank * bending), ELASTIC: abs(pairs[ELASTIC])}
    return scales | {WEIGHT: abs(pairs[ELASTIC])}


def _pairs(mechanism: Mechanism, state: Start, terms: Callable[[Mechanism, Start], Terms]) -> dict[str, float]:
    """Entries of the mass matrix along the crank's turning and the line's bending, and generalized forces along the bending."""
    line, rate = state.deflection, state.deflection_rate
    assert isinstance(line, PPoly)
    assert isinstance(rate, PPoly)
    turning = terms(mechanism, dataclasses.replace(state, deflection_rate=None)).kinetic_energy
    both = terms(mechanism, state).kinetic_energy
    twice = terms(mechanism, dataclasses.replace(state, deflection_rate=PPoly(2.0 * rate.c, rate.x))).kinetic_energy
    # K is quadratic in the rate's size: its values at 0, 1 and 2
    bending, mixed = 0.5 * (twice - 2.0 * both + turning), 0.5 * (4.0 * both - twice - 3.0 * turning)
    carried = mechanism.crank.inertia_about_pivot + mechanism.slider.mass * mechanism.crank.length**2
    step = SHIFT * _size(line, mechanism) / _size(rate, mechanism)
    more, less = (
        terms(mechanism, dataclasses.replace(state, deflection=PPoly(line.c + sign * step * rate.c, line.x))) for sign in (1.0, -1.0)
    )
    found = {
        CRANK: 2.0 * turning / state.crank_speed**2 - carried,
        BENDING: 2.0 * bending,
        MIXED: mixed / state.crank_speed,
        ELASTIC: (more.strain_energy - less.strain_energy) / (2.0 * step),
    }
    if mechanism.has_gravity:
        found[WEIGHT] = (more.gravity_energy - less.gravity_energy) / (2.0 * step)
    return found


def _size(field: PPoly, mechanism: Mechanism) -> float:
    return float(np.abs(field(np.linspace(0.0, mechanism.follower.length, 50))).max())


def _exact_terms(mechanism: Mechanism, start: Start) -> Terms:
    """By quadrature over the given line, split at its knots."""
    state, beam, crank = reconstruct(mechanism, start), mechanism.follower, mechanism.crank
    tip, base, slider = mechanism.tip_body, mechanism.base, mechanism.slider
    assert isinstance(start.deflection, PPoly)
    x, weights = _quadrature(start.deflection.x)
    velocity, end = state.velocity(x), np.array([beam.length])
    relative = velocity - state.follower_rate * _quarter_turn(state.position(x) - [mechanism.pivot_distance, 0.0])
    carried = crank.inertia_about_pivot + slider.mass * crank.length**2
    kinetic = 0.5 * beam.mass_per_length * float(weights @ np.sum(velocity**2, axis=1))
    kinetic += 0.5 * (carried * start.crank_speed**2 + base.inertia * state.follower_rate**2)
    centre, centre_velocity, turn_rate = _tip(state, tip, end)
    kinetic += 0.5 * (tip.mass * float(centre_velocity @ centre_velocity) + tip.inertia * turn_rate**2)
    slope, bent = start.deflection(x, 1), start.deflection(x, 2)
    moment = beam.mass_per_length * (weights @ state.position(x)) + tip.mass * centre
    first = crank.mass * crank.center_of_mass + slider.mass * crank.length
    moment = moment + first * np.array([math.cos(start.crank_angle), math.sin(start.crank_angle)])
    place = state.position(end)[0]
    return Terms(
        follower_angle=state.follower_angle,
        slider_position=state.slider_position,
        tip_x=float(place[0]),
        tip_y=float(place[1]),
        follower_rate=state.follower_rate,
        slider_speed=state.slider_speed,
        kinetic_energy=kinetic,
        strain_energy=0.5 * beam.bending_stiffness * float(weights @ (bent**2 / (1.0 - slope**2))),
        gravity_energy=-float(moment @ np.array(mechanism.gravity)),
        damping_power=base.damping * state.follower_rate**2 + beam.damping * float(weights @ np.sum(relative**2, axis=1)),
    )


def _tip(state: StartState, tip: Tip, end: Array) -> tuple[Array, Array, float]:
    """Place and velocity of the tip body's centre, and its rate of rotation."""
    angle, rate = float(state.tangent(end)[0]), float(state.tangent_rate(end)[0])
    direction = np.array([math.cos(angle), math.sin(angle)])
    out = tip.center_of_mass
    return state.position(end)[0] + out * direction, state.velocity(end)[0] + out * rate * _quarter_turn(direction), rate


def _engine_terms(candidate: Candidate, mechanism: Mechanism, state: Start, rates: bool = True) -> Terms:
    """As the engine's first rows show them; rates by differences of fourth order."""
    simulation = engine(candidate.name).prepare(mechanism, state, candidate.settings)
    rows = simulation.advance(4 * INSTANT if rates else INSTANT, INSTANT)

    def rate(name: str) -> float:
        return float(np.array([-25.0, 48.0, -36.0, 16.0, -3.0]) @ rows[name][:5]) / (12.0 * INSTANT) if rates else math.nan

    places = ("follower_angle", "slider_position", "tip_x", "tip_y", "kinetic_energy", "strain_energy", "gravity_energy")
    drive = mechanism.crank.drive
    crank = drive.damping * state.crank_speed**2 if isinstance(drive, TorqueDrive) else 0.0
    return Terms(
        **{name: float(rows[name][0]) for name in places},
        follower_rate=rate("follower_angle"),
        slider_speed=rate("slider_position"),
        damping_power=rate("dissipated_energy") - crank,
    )


def _means(candidate: Candidate, mechanism: Mechanism, state: Start) -> dict[str, float]:
    rows = engine(candidate.name).prepare(mechanism, state, candidate.settings).advance(SPAN, INSTANT)
    columns = {
        "crank's angular acceleration, rad/s^2": np.gradient(rows["crank_speed"], INSTANT),
        "tip acceleration, m/s^2": rows["tip_acceleration"],
        "slider force, N": rows["slider_force"],
        "torque of the drive, N m": rows["crank_torque"],
    }
    if isinstance(mechanism.crank.drive, TorqueDrive):
        del columns["torque of the drive, N m"]
    else:
        del columns["crank's angular acceleration, rad/s^2"]
    window = round(0.8 * SPAN / INSTANT)
    return {name: float(smoothed(values, window)[-1]) for name, values in columns.items()}


def _quadrature(edges: Array) -> tuple[Array, Array]:
    points, weights = np.polynomial.legendre.leggauss(4)
    half, middle = np.diff(edges) / 2.0, (edges[1:] + edges[:-1]) / 2.0
    return (middle[:, None] + half[:, None] * points).ravel(), (half[:, None] * weights).ravel()


def _quarter_turn(p: Array) -> Array:
    return np.stack([-p[..., 1], p[..., 0]], axis=-1)
