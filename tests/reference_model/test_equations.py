"""The equations of the one beam for all shapes and treatments, at random bent and moving states, against definitions and Lagrange."""

import dataclasses
import itertools
import math
from functools import cache
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.interpolate import CubicHermiteSpline

from reference_model.mechanism import FollowerAlone, Mechanism, PrescribedSpeed, Slider, SpinUp
from reference_model.model import BeamModel
from reference_model.motion.layout import (
    CHORDS,
    FORCE,
    GAP,
    GAP_REMAINDER,
    LEVER,
    MULTIPLIER,
    S_RATE,
    S_REMAINDER,
    SPRING,
    TANGENT_1,
    TANGENT_2,
)
from reference_model.motion.parameters import Treatment
from reference_model.shapes import clamped_free_modes, hermite_elements
from tests.engines.scenes import run_24
from tests.reference_model.beam_runs import with_fine_tables
from tests.reference_model.lagrange import (
    Point,
    angle_of_base,
    closed,
    course,
    fourth_order,
    point,
    residual,
    second_difference,
)

Array = NDArray[np.float64]

EVERYTHING = run_24(
    gravity=(3.0, -9.81),
    slider=Slider(mass=0.1, inertia=3e-4),
    tip={"center_of_mass": 0.0127},
    follower={"damping": 2.0},
    base={"damping": 0.02},
)
#: The same with a crank at a prescribed speed.
HELD = dataclasses.replace(EVERYTHING, crank=dataclasses.replace(EVERYTHING.crank, drive=PrescribedSpeed(speed=17.0)))
#: Elements have no continuous curvature, which a slider with rotary inertia would need.
PLAIN = dataclasses.replace(EVERYTHING, slider=Slider(mass=0.1))
ALONE = FollowerAlone(
    spin_up=SpinUp(speed=9.0, time=1.5),
    base=EVERYTHING.base,
    follower=EVERYTHING.follower,
    tip=EVERYTHING.tip,
    gravity=EVERYTHING.gravity,
)
LENGTH = EVERYTHING.follower.length
NODES = np.linspace(0.0, LENGTH, 5)
SPRUNG = Treatment(kind=SPRING, stiffness=3e4, damping=20.0, inertia=0.05)
HELD_BY_FORCE = Treatment(kind=MULTIPLIER, stabilization=80.0, bending_damping=1e-4)


def smooth(mechanism: Mechanism, treatment: Treatment, **options: Any) -> BeamModel:
    return BeamModel.staying(mechanism, clamped_free_modes(LENGTH, 3), treatment, **options)


def nodal(treatment: Treatment, elements: int = 4) -> BeamModel:
    """Four elements have seven Gauss points a cell; from five on three leave 6e-5 of the forces of their highest shapes."""
    return BeamModel.staying(PLAIN, hermite_elements(LENGTH, elements), treatment)


@cache
def model(name: str) -> BeamModel:
    made = {
        "follows": lambda: with_fine_tables(EVERYTHING, 3, points=15),
        "follows, held": lambda: with_fine_tables(HELD, 2, points=15),
        "follows, sprung": lambda: with_fine_tables(EVERYTHING, 3, points=15, treatment=SPRUNG),
        "follows, sprung, held": lambda: with_fine_tables(HELD, 2, points=15, treatment=SPRUNG),
        "stays": lambda: smooth(EVERYTHING, Treatment()),
        "stays, transverse damping": lambda: smooth(EVERYTHING, Treatment(), transverse_damping=True),
        "stays, multiplier": lambda: smooth(EVERYTHING, HELD_BY_FORCE),
        "stays, multiplier, held": lambda: smooth(HELD, HELD_BY_FORCE),
        "stays, sprung": lambda: smooth(EVERYTHING, SPRUNG),
        "stays, sprung, held": lambda: smooth(HELD, SPRUNG),
        "elements": lambda: nodal(HELD_BY_FORCE),
        "elements, lever": lambda: nodal(dataclasses.replace(HELD_BY_FORCE, kind=LEVER)),
        "elements, chords": lambda: nodal(dataclasses.replace(HELD_BY_FORCE, kind=CHORDS)),
        "alone": lambda: BeamModel.alone(ALONE, 3),
    }
    return made[name]()


FOLLOWING = ("follows", "follows, sprung")
CLOSED = ("follows", "follows, held", "stays", "stays, transverse damping")
OPEN = ("follows, sprung", "follows, sprung, held", "stays, multiplier", "stays, multiplier, held", "stays, sprung")
NODAL = ("elements", "elements, lever", "elements, chords")


@cache
def state(name: str, seed: int = 1) -> Point:
    """Bent by a fiftieth of the length and moving, with a gap of a millimetre where there may be one."""
    chosen, rng = model(name), np.random.default_rng(seed)
    p = chosen.parameters
    n, m = p.n, p.speeds
    squares = chosen.workspace.row  # filled by the first evaluation
    if isinstance(chosen.scene, FollowerAlone):
        y = chosen.state_at_rest()
        y[0] = 0.8
    else:
        y = chosen.straight_state(float(rng.uniform(1.8, 2.6)), 16.0)
    assert chosen.can_move(y)
    first = p.tables.kinds * n * p.tables.cells * p.tables.S
    frequencies = np.sqrt(squares[first : first + n])
    size = 0.2 * math.sqrt(0.1) * 0.6 / np.arange(1, n + 1) ** (2 if n < 5 else 4) / 10.0
    y[1 : n + 1] = rng.uniform(0.5, 1.0, n) * rng.choice([-1.0, 1.0], n) * size
    y[m + 2 : m + 2 + n] = rng.uniform(0.5, 1.0, n) * rng.choice([-1.0, 1.0], n) * size * np.minimum(frequencies, 200.0)
    if m > n + 1:
        y[n + 1] += 0.002
        y[m + 2 + n] += 0.2
    return point(chosen, y)


def close(found: Any, expected: Any, tolerance: float, size: Any = None) -> None:
    scale = np.max(np.abs(expected)) if size is None else size
    assert np.all(np.abs(np.asarray(found) - expected) <= tolerance * scale), (found, expected, scale)


#: Relative error of the differences, and of tables that are cubic in the slider's place and not differentiated ...
DIFFERENCES = 2e-6
#: ... and what seven points a cell leave of the forces of elements' highest shapes: quadrature is not differentiated either.
OF_ELEMENTS = 1e-5


@pytest.mark.parametrize("name", [*CLOSED, *OPEN, *NODAL, "alone"])
def test_accelerations_satisfy_lagranges_equations(name: str) -> None:
    """The slider's force is the only one that energies do not know: - F times `spread`; of a closed loop and the base nothing is left."""
    at = state(name)
    found, size = residual(at)
    assert at.model.can_move(at.y)
    w, p = at.model.workspace, at.model.parameters
    expected = -w.facts[FORCE] * w.spread if at.m > p.n + 1 and p.treatment != SPRING else np.zeros(at.m)
    free = slice(p.first, at.m)
    close(found[free], expected[free], OF_ELEMENTS if name in NODAL else DIFFERENCES, np.maximum(size, np.abs(expected))[free].max())


@pytest.mark.parametrize("name", ["stays, multiplier, held", "stays, sprung, held"])
def test_the_torque_of_a_prescribed_speed_is_the_crank_s_own_equation(name: str) -> None:
    at = state(name)
    change, size = residual(at)
    w, m = at.model.workspace, at.m
    shown = at.model.observe(at.y[None])["crank_torque"][0]
    assert at.model.can_move(at.y)
    q, u, unit = at.y[:m], at.y[m + 1 : 2 * m + 1], np.eye(m)[0]
    by_force = float(w.facts[FORCE] * w.spread[0])
    damped = at.model.parameters.joint_damping * float(w.row_of_gap @ u) * float(w.row_of_gap[0])

    def lagrangian(shift: float) -> float:
        y = at.y.copy()
        y[:m], y[m + 1 : 2 * m + 1] = q + shift * unit, u
        seen = at.model.observe(closed(at.model, y)[None])
        # the spring's energy is part of the force
        return float(seen["kinetic_energy"][0] - seen["gravity_energy"][0] - seen["strain_energy"][0])

    by_place = fourth_order(lagrangian, 2e-3)
    spring = at.model.parameters.treatment == SPRING
    expected = change[0] - by_place + (damped if spring else by_force)
    assert shown == pytest.approx(expected, abs=DIFFERENCES * max(size[0], abs(by_place)))


@pytest.mark.parametrize("name", [*OPEN, *NODAL])
def test_gap_and_slider_move_as_their_rates_say(name: str) -> None:
    """First and second derivatives of gap and slider's place along a course, the loop closed anew at every instant."""
    at = state(name)
    chosen, w, m = at.model, at.model.workspace, at.m
    u = at.y[m + 1 : 2 * m + 1]
    assert chosen.can_move(at.y)
    row, sigma = w.row_of_gap.copy(), w.sigma.copy()
    gap_rate, s_rate = float(row @ u), float(w.facts[S_RATE])
    gap_second, s_second = float(w.facts[GAP_REMAINDER] + row @ at.acceleration), float(w.facts[S_REMAINDER] + sigma @ at.acceleration)

    def gap(time: float) -> float:
        assert chosen.can_move(course(at, time))
        return float(w.facts[GAP])

    def place(time: float) -> float:
        return float(course(at, time)[m])

    assert abs(gap(0.0)) > 5e-4
    for function, first, second in ((gap, gap_rate, gap_second), (place, s_rate, s_second)):
        assert fourth_order(function, 1e-5) == pytest.approx(first, rel=1e-6, abs=1e-7)
        assert second_difference(function, 4e-5) == pytest.approx(second, rel=2e-5, abs=2e-4)
    p = chosen.parameters
    if p.treatment != SPRING:
        wanted = -p.stabilization * (2.0 * gap_rate + p.stabilization * gap(0.0))
        assert gap_second == pytest.approx(wanted, rel=1e-9, abs=1e-7)
    else:
        force = p.joint_stiffness * gap(0.0) + p.joint_damping * gap_rate + p.joint_inertia * gap_second
        assert chosen.can_move(at.y)
        assert w.facts[FORCE] == pytest.approx(force, rel=1e-9)


def line(at: Point, y: Array, x: Array) -> Array:
    """Places (complex, frame B) of arc lengths x from the tangent's angle, by a spline through exactly integrated directions."""
    n, s = at.model.parameters.n, float(y[at.m])
    fine = np.unique(np.concatenate([np.linspace(0.0, s, 3001), np.linspace(s, LENGTH, 1501)]))
    angle = at.model._shapes(s, fine)[0] @ y[1 : n + 1]
    parts = [CubicHermiteSpline(fine, f, np.gradient(f, fine)).antiderivative() for f in (np.cos(angle), np.sin(angle))]
    return np.asarray(parts[0](x) + 1j * parts[1](x))


@pytest.mark.parametrize("name", [*OPEN, *NODAL])
def test_the_gap_is_the_distance_of_the_crank_tip_along_the_normal(name: str) -> None:
    at = state(name)
    p, y = at.model.parameters, at.y
    turn = np.exp(-1j * angle_of_base(at.model, y))
    tip = turn * (p.LA * np.exp(1j * y[0]) - p.d)
    s = float(y[at.m])
    if p.treatment == CHORDS:
        left = int(np.searchsorted(NODES, s)) - 1
        a, b = line(at, y, NODES[left : left + 2])
        tangent = (b - a) / abs(b - a)
        foot = a + (s - NODES[left]) / NODES[1] * (b - a)
    else:
        foot = complex(line(at, y, np.array([s]))[0])
        tangent = np.exp(1j * float(at.model._shapes(s, np.array([s]))[0][0] @ y[1 : p.n + 1]))
    beside = np.conj(tangent) * (tip - foot)
    assert abs(beside.real) < 1e-7  # the foot; tables and spline
    assert at.model.can_move(y)
    assert at.model.workspace.facts[GAP] == pytest.approx(beside.imag, abs=1e-7)


def test_the_lever_rule_is_two_forces_on_the_nodes() -> None:
    """Virtual work of the shares of a unit force along the slider's normal on crank tip and nodes, that normal and the shares kept."""
    at = state("elements, lever")
    p, y, m = at.model.parameters, at.y, at.m
    assert at.model.can_move(y)
    spread = at.model.workspace.spread.copy()
    facts = at.model.workspace.facts
    q2, s = y[p.n + 1], float(y[m])
    normal = 1j * complex(facts[TANGENT_1], facts[TANGENT_2]) * np.exp(1j * q2)
    left = int(np.searchsorted(NODES, s)) - 1
    share = (s - NODES[left]) / NODES[1]

    def along(coordinates: Array) -> float:
        moved = y.copy()
        moved[:m] = coordinates
        a, b = np.exp(1j * coordinates[p.n + 1]) * line(at, moved, NODES[left : left + 2])
        arm = p.LA * np.exp(1j * coordinates[0]) - p.d
        return float(np.real(np.conj(normal) * (arm - (1.0 - share) * a - share * b)))

    expected = [fourth_order(lambda e, k=k: along(y[:m] + e * np.eye(m)[k]), 1e-5) for k in range(m)]
    close(spread, expected, 1e-5)  # the spline of the test rounds off the kinks of the curvature at nodes


@pytest.mark.parametrize("name", ["follows", "follows, sprung", "stays, multiplier"])
def test_recovered_curvature_balances_the_loads_outboard(name: str) -> None:
    """Moment about each gauge of mass times differenced acceleration, tip body, gravity, damping and slider, from places alone."""
    at, h = state(name), 1e-4
    chosen, p, m = at.model, at.model.parameters, at.m
    scene = chosen.scene
    assert isinstance(scene, Mechanism)
    assert scene.tip is not None
    tip, beam = scene.tip, scene.follower
    shown = chosen.observe(at.y[None])
    times = [course(at, k * h) for k in (-2, -1, 0, 1, 2)]
    angles = [angle_of_base(chosen, y) for y in times]
    s = float(at.y[m])
    nodes, weights = np.polynomial.legendre.leggauss(30)

    def tangent(row: int, x: float) -> float:
        y = times[row]
        return angles[row] + float(chosen._shapes(float(y[m]), np.array([x]))[0][0] @ y[1 : p.n + 1])

    def places(row: int, x: Array) -> Array:
        return np.exp(1j * angles[row]) * line(at, times[row], x)

    def second(values: list[Any]) -> Any:
        return (-values[0] + 16 * values[1] - 30 * values[2] + 16 * values[3] - values[4]) / (12 * h * h)

    def first(values: list[Any]) -> Any:
        return (values[0] - 8 * values[1] + 8 * values[3] - values[4]) / (12 * h)

    gravity = complex(*scene.gravity)
    largest = max(abs(shown[f"strain_{number}"][0]) for number in (1, 2, 3))
    for number, gauge in enumerate(beam.strain_gauges):
        edges = [gauge, s, LENGTH] if gauge < s else [gauge, LENGTH]
        x = np.concatenate([a + 0.5 * (b - a) * (nodes + 1) for a, b in itertools.pairwise(edges)])
        dx = np.concatenate([0.5 * (b - a) * weights for a, b in itertools.pairwise(edges)])
        lines = [places(row, x) for row in range(5)]
        here = places(2, np.array([gauge]))[0]
        force = beam.mass_per_length * dx * (gravity - second(lines))
        relative = [line(at, y, x) for y in times]
        force = force - beam.damping * dx * first(relative) * np.exp(1j * angles[2])
        moment = np.sum(np.imag(np.conj(lines[2] - here) * force))
        centres = [places(row, np.array([LENGTH]))[0] + tip.center_of_mass * np.exp(1j * tangent(row, LENGTH)) for row in range(5)]
        moment += np.imag(np.conj(centres[2] - here) * tip.mass * (gravity - second(centres)))
        moment -= tip.inertia * second([tangent(row, LENGTH) for row in range(5)])
        if gauge < s:
            turns = [tangent(row, float(times[row][m])) for row in range(5)]
            bend = 1e-4
            curvature = (tangent(2, s + bend) - tangent(2, s - bend)) / (2 * bend)
            assert chosen.can_move(at.y)
            contact_moment = -scene.slider.inertia * second(turns) / (1.0 - float(chosen.workspace.facts[GAP]) * curvature)
            contact = (1j * shown["slider_force"][0] - contact_moment * curvature) * np.exp(1j * tangent(2, s))
            moment += contact_moment + np.imag(np.conj(places(2, np.array([s]))[0] - here) * contact)
        strain = 0.5 * beam.thickness * moment / beam.bending_stiffness
        # splines of 0.2 mm and differences over 1e-4 s; a flipped sign of any load moves this by 1e-3 or more
        assert shown[f"strain_{number + 1}"][0] == pytest.approx(strain, rel=2e-4, abs=1e-5 * largest), number
