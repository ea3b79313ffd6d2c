"""The oracles themselves: against each other, against conservation laws and against numbers known from elsewhere."""

import math
from collections.abc import Iterable, Mapping
from typing import Any

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.linalg import eigh

from tests.symbolic import exact_model, symbolic_model
from tests.symbolic.random_states import LEFT_OUT, RUN_24, random_case
from tests.symbolic.symbolic_model import FREE, evaluate

COMMON = (
    "projected_mass_matrix",
    "projected_force",
    "multiplier",
    "slider_force",
    "kinetic_energy",
    "strain_energy",
    "gravity_energy",
    "tip_position",
    "tip_acceleration",
)


def assert_same(found: Mapping[str, Any], expected: Mapping[str, Any], keys: Iterable[str], tolerance: float) -> None:
    """Equal to `tolerance`, element by element or relative to the largest element."""
    for key in keys:
        largest = float(np.max(np.abs(expected[key])))
        np.testing.assert_allclose(found[key], expected[key], rtol=tolerance, atol=tolerance * largest, err_msg=key)


def amplitudes(state: dict[str, float]) -> tuple[list[float], list[float]]:
    return [state["tip_deflection"], state["tip_slope"]], [state["tip_deflection_rate"], state["tip_slope_rate"]]


@pytest.mark.parametrize("seed", range(12))
def test_lagrange_with_multipliers_equals_dalembert_without(seed: int) -> None:
    parameters, state = random_case(np.random.default_rng(seed))
    ours = evaluate(parameters, state)
    shapes = exact_model.cubic_shapes(parameters["length"])
    other = exact_model.accelerations(parameters, shapes, state, *amplitudes(state), geometry="second order")
    # Both are exact but for the shapes' coefficients, rounded to 1e-16 and amplified by the mass matrix' condition (below 1e4).
    assert_same(other, ours, COMMON, 1e-12)
    largest = np.max(np.abs(ours["accelerations"]))
    np.testing.assert_allclose(other["accelerations"], ours["accelerations"][list(FREE)], rtol=0, atol=1e-12 * largest)
    dependent = [other["follower_angle"], other["slider_position"], other["follower_speed"], other["slider_speed"]]
    np.testing.assert_allclose(dependent, [*ours["coordinates"][[1, 4]], *ours["rates"][[1, 4]]], rtol=1e-12)


@pytest.mark.parametrize("seed", range(5))
def test_projection_and_multipliers_give_the_same_motion(seed: int) -> None:
    value = evaluate(*random_case(np.random.default_rng(100 + seed)))
    reduced = np.linalg.solve(value["projected_mass_matrix"], value["projected_force"])
    # Double-precision solution of a 3 x 3 system of condition up to 1e4.
    np.testing.assert_allclose(reduced, value["accelerations"][list(FREE)], rtol=1e-10)
    residual = value["mass_matrix"] @ value["accelerations"] - value["force"] - value["constraint_jacobian"].T @ value["multiplier"]
    assert np.max(np.abs(residual)) < 1e-12 * np.max(np.abs(value["mass_matrix"] @ value["accelerations"]))
    assert np.all(np.linalg.eigvalsh(value["projected_mass_matrix"]) > 0)


@pytest.mark.parametrize("inertia", [0.0, 3e-4])
def test_a_slider_without_inertia_does_not_push_along_the_follower(inertia: float) -> None:
    parameters, state = random_case(np.random.default_rng(7))
    value = evaluate(parameters | {"slider_inertia": inertia}, state)
    tangential = math.sqrt(max(float(np.dot(value["multiplier"], value["multiplier"])) - value["slider_force"] ** 2, 0.0))
    # The square root turns the rounding error 1e-16 of the difference into 1e-8.
    assert (tangential < 1e-7 * abs(value["slider_force"])) == (inertia == 0)


@pytest.mark.parametrize("seed", range(3))
def test_dependent_accelerations_are_second_derivatives_of_the_loop(seed: int) -> None:
    parameters, state = random_case(np.random.default_rng(200 + seed))
    value = evaluate(parameters, state)
    y, rate, acceleration = (value[key][list(FREE)] for key in ("coordinates", "rates", "accelerations"))
    step = 1e-4  # s

    def dependent(time: float) -> np.ndarray:
        there = y + rate * time + acceleration * time**2 / 2
        names = ("crank_angle", "tip_deflection", "tip_slope")
        return evaluate(parameters, state | dict(zip(names, there.tolist(), strict=True)))["coordinates"][[1, 4]]

    weights = np.array([-1, 16, -30, 16, -1]) / (12 * step**2)
    second = sum(weight * dependent(k * step) for weight, k in zip(weights, range(-2, 3), strict=True))
    # Fourth-order stencil: truncation (rate x step)^4, at most 1e-7 relative; rounding 1e-16 / step^2 = 1e-8 on values up to 5e4.
    np.testing.assert_allclose(second, value["accelerations"][[1, 4]], rtol=1e-5, atol=1e-3)


@pytest.mark.verify
def test_energy_changes_by_the_work_done() -> None:
    parameters, state = random_case(np.random.default_rng(3), present=1.0)
    names = list(symbolic_model.STATE)

    def right_hand_side(_: float, y: np.ndarray) -> np.ndarray:
        value = evaluate(parameters, dict(zip(names, y[:6].tolist(), strict=True)))
        return np.r_[y[3:6], value["accelerations"][list(FREE)], value["drive_power"] - value["dissipated_power"]]

    def energy(y: np.ndarray) -> float:
        value = evaluate(parameters, dict(zip(names, y[:6].tolist(), strict=True)))
        return value["kinetic_energy"] + value["strain_energy"] + value["gravity_energy"]

    start = np.r_[[state[name] for name in names], 0.0]
    solution = solve_ivp(right_hand_side, (0.0, 0.01), start, method="DOP853", rtol=1e-11, atol=1e-13)
    end = solution.y[:, -1]
    stored = [evaluate(parameters, dict(zip(names, y[:6].tolist(), strict=True)))["strain_energy"] for y in (start, end)]
    exchanged = abs(stored[1] - stored[0])
    assert exchanged > 0.1  # J: there is something to conserve
    # A hundred times the integration tolerance of the energies exchanged.
    assert abs(energy(end) - energy(start) - end[6]) < 1e-9 * exchanged


@pytest.mark.parametrize(
    ("crank_angle", "one_cubic", "converged"),
    [
        (180, (22.94, 74.96), (20.354, 62.287, 112.95)),
        (90, (19.76, 61.29), (17.779, 45.604, 135.26)),
        (0, (12.71, 84.90), (10.925, 63.787, 123.83)),
    ],
)
def test_frozen_crank_frequencies_of_run_24(crank_angle: float, one_cubic: tuple[float, ...], converged: tuple[float, ...]) -> None:
    L, EI = RUN_24["length"], RUN_24["bending_stiffness"]
    rest = dict.fromkeys(symbolic_model.STATE, 0.0) | {"crank_angle": math.radians(crank_angle)}

    stiffness = EI / L * np.array([[12 / L**2, -6 / L], [-6 / L, 4]])
    mass = evaluate(RUN_24, rest)["projected_mass_matrix"][1:, 1:]
    found = np.sqrt(eigh(stiffness, mass, eigvals_only=True)) / (2 * math.pi)
    np.testing.assert_allclose(found, one_cubic, rtol=5e-4)  # four printed digits

    k = np.arange(2, 10)  # shapes (x/L)^2 .. (x/L)^9
    shapes = np.zeros((len(k), 1, k[-1] + 1))
    shapes[np.arange(len(k)), 0, k] = L ** -k.astype(float)
    curvature = k * (k - 1)
    stiffness = EI / L**3 * np.outer(curvature, curvature) / (k[:, None] + k - 3)
    zero = np.zeros(len(k))
    mass = exact_model.accelerations(RUN_24, shapes, rest, zero, zero)["projected_mass_matrix"][1:, 1:]
    found = np.sqrt(eigh(stiffness, mass, eigvals_only=True))[:3] / (2 * math.pi)
    # Ritz: from above; polynomials of degree 9 do not follow the kink at the slider: up to 1.1 % in the third.
    assert np.all(found > np.array(converged) * 0.9999)
    np.testing.assert_allclose(found, converged, rtol=0.015)


def test_every_parameter_matters_at_random_states() -> None:
    parameters, state = random_case(np.random.default_rng(11), present=1.0)
    assert all(parameters[name] for name in LEFT_OUT)
    here = evaluate(parameters, state)
    for name, value in parameters.items():
        there = evaluate(parameters | {name: value * 1.01}, state)
        change = np.abs(there["accelerations"] / here["accelerations"] - 1)
        # A hundredth of any term moves the result by ten thousand times the 1e-10 to which models are held.
        assert max(np.max(change), abs(there["slider_force"] / here["slider_force"] - 1)) > 1e-6, name


@pytest.mark.parametrize("geometry", ["exact", "second order"])
def test_two_hermite_elements_that_form_one_cubic_move_like_it(geometry: exact_model.Geometry) -> None:
    parameters, state = random_case(np.random.default_rng(13), present=1.0)
    L = parameters["length"]
    value, rate = amplitudes(state)
    # Deflection and slope of the cubic at L/2, then at L.
    refine = np.array([[1 / 2, -L / 8], [3 / (2 * L), -1 / 4], [1, 0], [0, 1]])
    one = exact_model.accelerations(parameters, exact_model.cubic_shapes(L), state, value, rate, geometry=geometry)
    two = exact_model.accelerations(parameters, exact_model.cubic_shapes(L, 2), state, refine @ value, refine @ rate, geometry=geometry)
    embedding = np.zeros((5, 3))
    embedding[0, 0], embedding[1:, 1:] = 1, refine
    # Same field: same energies, and the finer model restricted to it is the coarse one. Tolerance: coefficients rounded to 1e-16.
    assert_same(two, one, ("follower_angle", "slider_position", "kinetic_energy", "strain_energy", "gravity_energy"), 1e-12)
    mass, force = embedding.T @ two["projected_mass_matrix"] @ embedding, embedding.T @ two["projected_force"]
    np.testing.assert_allclose(mass, one["projected_mass_matrix"], rtol=1e-11)
    np.testing.assert_allclose(force, one["projected_force"], rtol=1e-11)


def test_quadrature_of_the_exact_geometry_has_converged(monkeypatch: pytest.MonkeyPatch) -> None:
    parameters, state = random_case(np.random.default_rng(5), present=1.0)
    arguments = (parameters, exact_model.cubic_shapes(parameters["length"]), state, *amplitudes(state))
    coarse = exact_model.accelerations(*arguments)
    monkeypatch.setattr(exact_model, "GAUSS_DEGREE", exact_model.GAUSS_DEGREE + 1)
    exact_model._unit_rule.cache_clear()
    fine = exact_model.accelerations(*arguments)
    exact_model._unit_rule.cache_clear()
    # Twice the points: what differs is the quadrature error; slopes up to 0.5 leave none above rounding.
    assert_same(coarse, fine, ("accelerations", *COMMON), 1e-12)
