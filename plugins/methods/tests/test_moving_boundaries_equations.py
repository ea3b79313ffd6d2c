"""Moving boundaries: its equations against Lagrange's by a symbolic program, its tables against places and speeds, limits, stability."""

import dataclasses
import math
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from scipy.integrate import trapezoid

from quickreturn.plugins.methods.moving_boundaries import tables as t
from quickreturn.plugins.methods.moving_boundaries.equations import FORCE, KINETIC, TORQUE
from quickreturn.plugins.methods.moving_boundaries.model import MovingBoundariesModel
from quickreturn.reference_model.arrays import Array
from quickreturn.reference_model.mechanism import Mechanism, PrescribedSpeed
from quickreturn.reference_model.model import BeamModel
from quickreturn.reference_model.natural_modes import supported_modes
from quickreturn.reference_model.rigid import rigid_kinetostatics, rigid_motion
from tests.engines.scenes import run_24
from tests.reference_model.motion.beam_runs import balance, run
from tests.reference_model.motion.moving_support import monodromy
from tests.reference_model.multipliers import linear_multipliers

SPEED = 10.0 / 0.60176535  # rad/s, of run 24
UNDAMPED: dict[str, Any] = {"base": {"damping": 0.0}, "follower": {"damping": 0.0}}
#: All that the model has.
EVERYTHING: dict[str, Any] = {
    "gravity": (2.0, -9.81),
    "base": {"damping": 0.02, "inertia": 5e-4},
    "follower": {"damping": 1.0},
    "tip": {"center_of_mass": 0.0127, "force": (3.0, -2.0), "force_from": 0.5, "force_to": 5.0},
}


def turning(speed: float = SPEED, **changes: Any) -> Mechanism:
    """Run 24 with the crank at a speed, rad/s."""
    scene = run_24(**changes)
    return dataclasses.replace(scene, crank=dataclasses.replace(scene.crank, drive=PrescribedSpeed(speed=speed)))


def some_state(model: MovingBoundariesModel, seed: int, size: float) -> Array:
    """A state with amplitudes of about `size`, and rates as of their own vibration."""
    n, random = model.shapes, np.random.default_rng(seed)
    y = model.straight_state(random.uniform(0.0, 2.0 * math.pi), random.uniform(5.0, 30.0))
    y[1 : n + 1] = size * random.standard_normal(n)
    y[n + 2 : 2 * n + 2] = size * 100.0 * random.standard_normal(n)
    return y


def lagrange(model: MovingBoundariesModel) -> Callable[[Array, Array], tuple[Any, float, float]]:
    """Accelerations, slider force and torque by Lagrange's equations for (3.1) to (3.4), theta and l being coordinates like the others.

    Returns:
        A function of the state and of the force on the tip, N. The table's entries are Taylor series in l about the state's place.
    """
    import sympy as sp  # takes a second, which every process of the tests would spend at the head of the file

    p, n = model.parameters, model.shapes
    x, v, a = (sp.symbols(f"{name}:{n + 2}") for name in "xva")
    theta, distance, turn, slide = x[n], x[n + 1], v[n], v[n + 1]
    entries = [sp.symbols(f"r{order}_:{p.coefficients.shape[2]}") for order in range(3)]
    place = sp.Symbol("place")
    row = [value + by_l * (distance - place) + by_ll * (distance - place) ** 2 / 2 for value, by_l, by_ll in zip(*entries, strict=True)]
    eta, rate = sp.Matrix(x[:n]), sp.Matrix(v[:n])

    def after(quantity: Any) -> Any:
        """Rate of a quantity."""
        return sum(sp.diff(quantity, q) * dq + sp.diff(quantity, dq) * ddq for q, dq, ddq in zip(x, v, a, strict=True))

    def vector(kind: int) -> Any:
        return sp.Matrix(row[kind * n : (kind + 1) * n])

    def form(kind: int, one: Any, other: Any) -> Any:
        first = t.VECTORS * n + kind * n * n
        return (one.T * sp.Matrix(n, n, row[first : first + n * n]) * other)[0]

    half = {kind: form(kind, eta, eta) / 2 for kind in range(t.SYMMETRIC, t.MATRICES)}
    along = {kind: (vector(kind).T * eta)[0] for kind in range(t.VECTORS)}
    kinetic = (rate.T * rate)[0] / 2 + slide * form(t.CARRIED, rate, eta) + slide**2 * half[t.CARRIED_TWICE]
    kinetic += turn * after(along[t.TURNING]) + turn**2 * (p.inertia / 2 + half[t.ROTATED])
    force = sp.symbols("force_1 force_2")
    work = 0
    for (one, two), arm, short, across in (
        ((p.gravity_1, p.gravity_2), p.moment, half[t.HANGING], along[t.WEIGHT]),
        (force, p.L, half[t.PULLED], along[t.END]),
    ):
        work += (sp.cos(theta) * one + sp.sin(theta) * two) * (arm - short) + (sp.cos(theta) * two - sp.sin(theta) * one) * across
    lagrangian = kinetic - sum(vector(t.SQUARES)[i] * eta[i] ** 2 for i in range(n)) / 2 + work
    lost = form(t.DRAG, rate, rate) + 2 * slide * form(t.DRAG_CARRIED, rate, eta) + slide**2 * form(t.DRAG_CARRIED_TWICE, eta, eta)
    dissipation = p.beam_damping * lost / 2 + p.base_damping * (turn + after(along[t.BASE])) ** 2 / 2
    equations = [after(sp.diff(lagrangian, dq)) - sp.diff(lagrangian, q) + sp.diff(dissipation, dq) for q, dq in zip(x, v, strict=True)]
    evaluate = sp.lambdify([a, v, x, *entries, place, force], equations, "math", cse=True)

    def solved(y: Array, tool: Array) -> tuple[Any, float, float]:
        line = rigid_motion(model.scene, np.array(y[0]), y[n + 1])
        rows = model.workspace.rows.copy()  # of the state evaluated last

        def at(acceleration: Any) -> Array:
            return np.array(
                evaluate(
                    [*acceleration, line.follower_acceleration, line.slider_acceleration],
                    [*y[n + 2 : 2 * n + 2], line.follower_speed, line.slider_speed],
                    [*y[1 : n + 1], line.follower_angle, line.slider_position],
                    *rows,
                    line.slider_position,
                    tool,
                )
            )

        rest = at(np.zeros(n))[:n]
        mass = np.column_stack([at(column)[:n] - rest for column in np.eye(n)])
        acceleration = np.linalg.solve(mass, -rest)
        moment, force = at(acceleration)[n:]
        crank, l_now = y[0] - line.follower_angle, line.slider_position
        weight = p.crank_moment * (math.cos(y[0]) * p.gravity_2 - math.sin(y[0]) * p.gravity_1)
        torque = p.LA * (moment * np.cos(crank) / l_now - force * np.sin(crank)) - weight
        return acceleration, float(moment / l_now), float(torque)

    return solved


@pytest.mark.parametrize("foreshortening", [pytest.param(False, marks=pytest.mark.verify), True])
def test_equations_are_lagranges(foreshortening: bool) -> None:
    """Relative to the largest acceleration; the force on the tip acts over the whole turn here, its share is 1."""
    force = np.array([3.0, -2.0])
    changes = EVERYTHING | {"tip": {"center_of_mass": 0.0127, "force": (3.0, -2.0), "force_from": 0.0, "force_to": 2.0 * math.pi}}
    model = MovingBoundariesModel(turning(**changes), 2, foreshortening)
    solved = lagrange(model)
    for seed in range(5):
        y = some_state(model, seed, 0.02)
        rate, facts = model.rate(y), model.workspace.facts.copy()
        acceleration, of_slider, torque = solved(y, force)
        np.testing.assert_allclose(rate[4:6], acceleration, rtol=0.0, atol=1e-10 * np.max(np.abs(acceleration)))
        assert facts[FORCE] == pytest.approx(of_slider, rel=1e-10)
        assert facts[TORQUE] == pytest.approx(torque, rel=1e-9)  # a difference of larger numbers


@pytest.mark.parametrize("foreshortening", [False, True])
def test_kinetic_energy_is_that_of_the_places(foreshortening: bool) -> None:
    """Points are placed by modes found anew a little earlier and later; half the sum over either sign of a bend is of second order.

    Tables, differences in time and terms of fourth order leave some 1e-6.
    """
    scene = turning(**EVERYTHING)
    model = MovingBoundariesModel(scene, 6, foreshortening)  # of which the first three move: the last ones' tables are the coarsest
    L, tip, e = scene.follower.length, scene.tip_body, scene.tip_body.center_of_mass
    x, h = np.linspace(0.0, L, 4001), 1e-5

    def places(y: Array, after: float) -> tuple[Any, Any, Any]:
        """Of the points and of the tip's centre, and what base block and tip are turned by."""
        q1, eta = y[0] + after * y[7], y[1:7] + after * y[8:14]
        line = rigid_motion(scene, np.array(q1), 0.0)
        modes = supported_modes(scene, float(line.slider_position), 6)
        w, slope = eta @ modes.deflection(x), eta @ modes.deflection(x, 1)
        short, end, unit = np.zeros_like(x), slope[-1], np.exp(1j * line.follower_angle)
        if foreshortening:
            short[1:] = np.cumsum(0.25 * (slope[1:] ** 2 + slope[:-1] ** 2) * np.diff(x))
        centre = L - short[-1] + e - (0.5 * e * end**2 if foreshortening else 0.0) + 1j * (w[-1] + e * end)
        return unit * (x - short + 1j * w), unit * centre, float(line.follower_angle) + np.array([slope[0], end])

    def of_places(y: Array) -> float:
        points, centre, turned = ((after - before) / (2.0 * h) for before, after in zip(places(y, -h), places(y, h), strict=True))
        energy = scene.follower.mass_per_length * trapezoid(np.abs(points) ** 2, x) + tip.mass * abs(centre) ** 2
        return float(0.5 * (energy + scene.base.inertia * turned[0] ** 2 + tip.inertia * turned[1] ** 2))

    def of_model(y: Array) -> float:
        model.rate(y)
        return float(model.workspace.facts[KINETIC])

    for seed in range(3):
        bent = some_state(model, seed, 1e-5)
        straight = model.straight_state(bent[0], bent[7])
        bent[4:7] = bent[11:14] = 0.0
        other = 2.0 * straight - bent
        found = 0.5 * (of_model(bent) + of_model(other)) - of_model(straight)
        expected = 0.5 * (of_places(bent) + of_places(other)) - of_places(straight)
        assert found == pytest.approx(expected, rel=0.0, abs=1e-5 * 0.5 * float(np.sum(bent[8:11] ** 2)))  # parts cancel
        assert of_model(bent) - of_model(other) == pytest.approx(of_places(bent) - of_places(other), rel=1e-5)  # of first order


def test_frozen_crank_vibrates_as_the_natural_modes() -> None:
    """The table's polynomials and Chebyshev series leave 1e-9 of the first of six frequencies and 1e-5 of the last."""
    model = MovingBoundariesModel(turning(0.0, **UNDAMPED), 6, True)
    for angle in (math.pi, 0.5 * math.pi, 0.0):
        straight = model.straight_state(angle, 0.0)
        force = model.rate(straight)[8:14]
        stiffness = np.empty((6, 6))
        for i in range(6):
            bent = straight.copy()
            bent[1 + i] = 1.0
            stiffness[:, i] = force - model.rate(bent)[8:14]
        found = np.sqrt(np.sort(np.linalg.eigvals(stiffness).real)) / (2.0 * math.pi)
        distance = float(rigid_motion(model.scene, np.array(angle), 0.0).slider_position)
        np.testing.assert_allclose(found, supported_modes(model.scene, distance, 6).frequencies, rtol=5e-5)
        np.testing.assert_allclose(found[:2], supported_modes(model.scene, distance, 2).frequencies, rtol=1e-8)


def test_rigid_follower_is_the_closed_form() -> None:
    scene = turning(**EVERYTHING | {"follower": {"bending_stiffness": math.inf}})
    model = MovingBoundariesModel(scene, 2, True)
    for angle in np.linspace(0.0, 6.0, 7):
        model.rate(model.straight_state(angle, SPEED))
        expected = rigid_kinetostatics(scene, np.array(angle), SPEED)
        np.testing.assert_allclose(model.workspace.facts[[FORCE, TORQUE]], expected, rtol=1e-12)


@pytest.mark.parametrize(("foreshortening", "order"), [(False, 1), (True, 2)])
def test_what_is_neglected_falls_with_the_stiffness(foreshortening: bool, order: int) -> None:
    """Same modes as exact geometry: linear terms of order theta_dot^2/omega^2 are missed without foreshortening, cubic ones with it."""
    differences = []
    for factor in (16.0, 64.0):
        scene = turning(follower={"bending_stiffness": factor * run_24().follower.bending_stiffness})
        exact, ours = (
            model.integrate(model.straight_state(math.pi, SPEED), 1e-3, 200, 1e-11).states[:, 1:3]
            for model in (BeamModel.following(scene, 2), MovingBoundariesModel(scene, 2, foreshortening))
        )
        differences.append(np.sqrt(np.mean((ours - exact) ** 2) / np.mean(exact**2)))
    assert differences[0] / differences[1] == pytest.approx(4.0**order, rel=0.1)


@pytest.mark.parametrize("foreshortening", [False, True])
def test_stored_energy_is_work_less_dissipation(foreshortening: bool) -> None:
    """The torque shown does the work: N of (4.3) makes up for the modes that are missing."""
    model = MovingBoundariesModel(turning(**EVERYTHING), 2, foreshortening)
    _, columns = run(model, 1.0, 2000, 1e-10)
    assert columns["dissipated_energy"][-1] > 0.1  # J
    assert np.ptp(balance(columns)) < 1e-7 * np.ptp(columns["drive_work"])
    model = MovingBoundariesModel(turning(), 2, foreshortening)
    _, columns = run(model, 1.0, 2000, 1e-10)
    work = np.concatenate([[0.0], np.cumsum(0.5 * (columns["crank_torque"][1:] + columns["crank_torque"][:-1])) * SPEED / 2000])
    assert np.max(np.abs(work - columns["drive_work"])) < 2e-3 * np.ptp(columns["drive_work"])  # trapezoidal rule


def test_determinant_of_the_monodromy_matrix_is_liouvilles() -> None:
    """Equation 5.4, with the damping's trace around a turn."""
    model = MovingBoundariesModel(turning(**EVERYTHING), 2, True)
    angles = np.linspace(0.0, 2.0 * math.pi, 400, endpoint=False)
    trace = 0.0
    for angle in angles:
        model.rate(model.straight_state(angle, SPEED))
        row, n = model.workspace.rows[0], 2
        drag = row[t.VECTORS * n + t.DRAG * n * n :][: n * n].reshape(n, n)
        base = row[t.BASE * n :][:n]
        trace += float(model.parameters.beam_damping * np.trace(drag) + model.parameters.base_damping * base @ base) / len(angles)
    expected = math.exp(-trace * 2.0 * math.pi / SPEED)
    assert np.prod(linear_multipliers(model, SPEED)).real == pytest.approx(expected, rel=1e-6)


@pytest.mark.verify
def test_elements_on_a_moving_spring_have_the_same_multipliers() -> None:
    """Another formulation of the same beam: elements that stay, and a spring at the support, whose softness is most of what differs."""
    scene = turning(**UNDAMPED)
    largest = linear_multipliers(MovingBoundariesModel(scene, 4, False), 66.0)[0]
    assert abs(largest) == pytest.approx(np.max(np.abs(np.linalg.eigvals(monodromy(scene, 66.0, foreshortening=False)))), abs=2e-3)
    assert abs(largest) > 1.09
    others = np.linalg.eigvals(monodromy(scene, 66.0, foreshortening=True))
    # all have the modulus 1, so that their order is that of rounding; two modes are as good as the spring, two others feel the truncation
    missed = np.sort(
        [np.min(np.abs(others - multiplier)) for multiplier in linear_multipliers(MovingBoundariesModel(scene, 4, True), 66.0)]
    )
    assert np.all(missed[:4] < 2e-3)
    assert np.all(missed < 3e-2)
