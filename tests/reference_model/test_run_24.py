"""Run 24 from the standard start over 2 s: numbers on which independent formulations agree, and one method against another."""

import math

import numpy as np
import pytest
from scipy.interpolate import CubicHermiteSpline

from reference_model.dynamics import right_hand_side
from reference_model.mechanism import Slider
from reference_model.model import ExplicitModel
from reference_model.observables import COLUMNS, observe
from reference_model.parameters import build_parameters, build_workspace
from reference_model.rigid import rigid_motion
from reference_model.shapes import hermite_elements
from reference_model.tables import build_tables
from tests.engines.scenes import run_24
from tests.reference_model.motion import Array, error, reference, run, thesis


@pytest.fixture(scope="module")
def converged() -> dict[str, Array]:
    """16 modes: 7.5e-4 of the tip deflection."""
    return run(reference(run_24(), 16), 2.0, 2000, 1e-8)[1]


def test_known_numbers(converged: dict[str, Array]) -> None:
    """Minimal coordinates, ANCF with a sliding joint and a link chain agree on these to 0.04 %; half a unit of the last digit besides."""
    thickness = run_24().follower.thickness
    deflection = 1e3 * converged["tip_deflection"]
    assert np.max(np.abs(deflection)) == pytest.approx(27.27, abs=0.02)  # mm
    assert np.sqrt(np.mean(deflection**2)) == pytest.approx(11.22, abs=0.012)
    curvatures = [np.max(np.abs(converged[f"strain_{gauge}"])) / (0.5 * thickness) for gauge in (1, 2, 3)]
    np.testing.assert_allclose(curvatures, [0.122, 0.251, 0.167], atol=7e-4)  # 1/m
    assert np.max(np.abs(converged["tip_acceleration"])) == pytest.approx(88.9, abs=0.15)  # m/s^2
    assert converged["crank_angle"][-1] == pytest.approx(36.38754, abs=4e-5)  # rad; 16 modes are 3e-5 off


def test_the_standard_start_is_the_rigid_mechanism(converged: dict[str, Array]) -> None:
    mechanism = run_24()
    motion = rigid_motion(mechanism, np.array(math.pi), mechanism.crank.drive.initial_speed)
    assert converged["slider_position"][0] == pytest.approx(float(motion.slider_position), rel=1e-14)
    assert abs(converged["tip_deflection"][0]) < 1e-11  # m, recovered from a moment of zero
    assert converged["tip_x"][0] == pytest.approx(mechanism.pivot_distance - mechanism.follower.length, abs=1e-15)


def test_one_cubic_misses_by_eighty_percent(converged: dict[str, Array]) -> None:
    columns = run(thesis(run_24()), 2.0, 2000, 1e-9)[1]
    assert error(columns["tip_deflection"], converged["tip_deflection"]) == pytest.approx(0.80, abs=0.02)  # the printed figure's digits


def test_exact_geometry_of_one_cubic_differs_little() -> None:
    second_order = run(thesis(run_24()), 2.0, 2000, 1e-9)[1]["tip_deflection"]
    exact = run(thesis(run_24(), exact=True), 2.0, 2000, 1e-9)[1]["tip_deflection"]
    assert error(exact, second_order) == pytest.approx(0.026, abs=0.002)


def test_errors_fall_with_the_number_of_modes(converged: dict[str, Array]) -> None:
    for shapes, expected in ((4, 3.0e-2), (6, 1.25e-2), (10, 2.8e-3)):
        columns = run(reference(run_24(), shapes), 2.0, 2000, 1e-7)[1]
        # measured against 32 modes 3.06e-2, 1.30e-2, 3.4e-3; 16 modes stand in for these, 6.6e-4 away
        assert error(columns["tip_deflection"], converged["tip_deflection"]) == pytest.approx(expected, rel=0.1)


def test_hermite_elements_go_to_the_same_motion(converged: dict[str, Array]) -> None:
    mechanism = run_24()
    model = ExplicitModel(mechanism, hermite_elements(mechanism.follower.length, 8), True, True)
    columns = run(model, 1.0, 1000, 1e-7)[1]
    # 8 elements are 2.6e-3 off over 2 s
    assert error(columns["tip_deflection"], converged["tip_deflection"][:1001]) < 5e-3


@pytest.mark.parametrize("shapes", [0, 6])
def test_lsoda_and_dop853_integrate_the_same_equations(shapes: int) -> None:
    model = reference(run_24(), shapes) if shapes else thesis(run_24())
    one, other = (run(model, 2.0, 2000, 1e-9, method=method)[1] for method in ("DOP853", "LSODA"))
    for name in ("tip_deflection", "crank_angle", "slider_force", "tip_acceleration"):
        # LSODA's error at tolerance 1e-9 is 1e-7 of the deflection, a decade more in the accelerations
        assert error(one[name], other[name]) < 2e-5, name


def test_recovered_strain_is_where_the_modal_strain_goes() -> None:
    """The modal curvature converges slowly; with more modes it comes closer to the recovered one, which hardly moves."""
    mechanism = run_24()
    distances = []
    for shapes in (6, 12, 24):
        states, recovered = run(reference(mechanism, shapes), 0.3, 300, 1e-8)
        modal = reference(mechanism, shapes, recover=False).observe(states)
        distances.append(max(error(modal[f"strain_{gauge}"][10:], recovered[f"strain_{gauge}"][10:]) for gauge in (1, 2, 3)))
    assert distances[0] > 2.0 * distances[1] > 4.0 * distances[2]
    assert distances[2] < 0.02


def test_recovery_closes_the_loop_and_keeps_the_tip() -> None:
    states, recovered = run(reference(run_24(), 12), 0.4, 200, 1e-8)
    modal = reference(run_24(), 12, recover=False).observe(states)
    # one Newton step from a place that is 1e-5 m off leaves its square over a length
    assert np.max(recovered["constraint_gap"]) < 1e-9
    assert np.max(modal["constraint_gap"]) < 1e-15
    # the tip's place is insensitive: both descriptions of the same motion
    assert np.max(np.abs(recovered["tip_y"] - modal["tip_y"])) < 1e-5
    assert error(recovered["tip_deflection"], modal["tip_deflection"]) < 5e-3


def test_recovered_curvature_balances_the_loads_outboard() -> None:
    """Moment about each gauge of mass times differenced acceleration, tip body, gravity and slider, from places alone."""
    mechanism = run_24(
        gravity=(3.0, -9.81), slider=Slider(mass=0.1, inertia=3e-4), tip={"center_of_mass": 0.0127}, follower={"damping": 2.0}
    )
    n, h = 4, 3e-5
    model = reference(mechanism, n)
    parameters = build_parameters(mechanism, model.shapes, exact_geometry=True, cells=24)  # quadrature error 1e-8
    # bent and moving so much that every term of second order counts
    begin = model.initial_state(2.0, 20.0, np.array([0.015, -0.004, 0.001, -0.0005]), np.array([2.0, -3.0, 2.0, 1.0]))
    rate = np.empty_like(begin)
    right_hand_side(parameters, build_workspace(parameters.tables), begin, rate)
    # a parabola in time through the state with its rates and accelerations: what is differenced has no error of integration
    steps = begin + np.outer(h * np.arange(-2, 3), rate)
    steps[:, : n + 1] += 0.5 * np.outer((h * np.arange(-2, 3)) ** 2, rate[n + 1 : 2 * n + 2])

    def observed(recover: bool) -> dict[str, Array]:
        mesh, out = build_tables(model.shapes, 24), np.zeros((len(steps), len(COLUMNS)))
        assert observe(parameters, build_workspace(parameters.tables), mesh, build_workspace(mesh), steps, recover, out) == len(steps)
        return dict(zip(COLUMNS, out.T, strict=True))

    shown, plain = observed(True), observed(False)
    beam, tip, shapes = mechanism.follower, mechanism.tip, model.shapes
    assert tip is not None
    nodes, weights = np.polynomial.legendre.leggauss(40)
    s = plain["slider_position"][2]
    gauges = np.array(beam.strain_gauges)
    fine = np.linspace(0.0, beam.length, 4001)

    def line(row: int, x: Array) -> tuple[Array, Array]:
        """Places (complex, from O) and tangent angles at x, by a spline through exactly integrated tangents."""
        eta = steps[row, 1 : n + 1]
        slope = shapes.evaluate(fine, 1) @ eta
        cosine = np.sqrt(1.0 - slope**2)
        gradient = -slope * (shapes.evaluate(fine, 2) @ eta) / cosine
        along = CubicHermiteSpline(fine, cosine, gradient).antiderivative()
        turn = np.exp(1j * plain["follower_angle"][row])
        place = mechanism.pivot_distance + turn * (along(x) + 1j * (shapes.evaluate(x) @ eta))
        return place, plain["follower_angle"][row] + np.arcsin(shapes.evaluate(x, 1) @ eta)

    def accelerated(values: list[Array]) -> Array:
        return (-values[0] + 16 * values[1] - 30 * values[2] + 16 * values[3] - values[4]) / (12 * h * h)

    def first(values: list[Array]) -> Array:
        return (values[0] - 8 * values[1] + 8 * values[3] - values[4]) / (12 * h)

    gravity = complex(*mechanism.gravity)
    end = np.array([beam.length])
    for number, gauge in enumerate(gauges):
        x = gauge + 0.5 * (beam.length - gauge) * (nodes + 1)
        mass = 0.5 * (beam.length - gauge) * weights * beam.mass_per_length
        places = [line(row, x)[0] for row in range(5)]
        at_gauge = line(2, np.array([gauge]))[0][0]
        force = mass * (gravity - accelerated(places))
        relative = [(place - mechanism.pivot_distance) * np.exp(-1j * plain["follower_angle"][row]) for row, place in enumerate(places)]
        force -= mass / beam.mass_per_length * beam.damping * first(relative) * np.exp(1j * plain["follower_angle"][2])
        moment = np.sum(np.imag(np.conj(places[2] - at_gauge) * force))
        centres = [line(row, end)[0] + tip.center_of_mass * np.exp(1j * line(row, end)[1]) for row in range(5)]
        tip_force = tip.mass * (gravity - accelerated(centres)[0])
        moment += np.imag(np.conj(centres[2][0] - at_gauge) * tip_force)
        moment -= tip.inertia * accelerated([line(row, end)[1] for row in range(5)])[0]
        if gauge < s:
            turns = [line(row, plain["slider_position"][row : row + 1])[1] for row in range(5)]
            slider_moment = -mechanism.slider.inertia * accelerated(turns)[0]
            here, tangent = line(2, np.array([s]))
            curvature = shapes.evaluate(np.array([s]), 2)[0] @ steps[2, 1 : n + 1]
            curvature /= math.cos(float(tangent[0]) - plain["follower_angle"][2])
            contact = (1j * plain["slider_force"][2] - slider_moment * curvature) * np.exp(1j * tangent[0])
            moment += slider_moment + np.imag(np.conj(here[0] - at_gauge) * contact)
        strain = 0.5 * beam.thickness * moment / beam.bending_stiffness
        # differences over 3e-5 s: rounding 1e-16 m / h^2 is 1e-7 m/s^2; a flipped sign of any load moves this by 1e-5 or more
        assert shown[f"strain_{number + 1}"][2] == pytest.approx(strain, rel=1e-7)
