"""The quick-return from its descriptions against the models that were derived by hand, at random bent and moving states."""

from dataclasses import replace
from typing import Any, Final

import numpy as np
import pytest
from numpy.typing import NDArray

from quickreturn.derive import Model, natural_frequencies
from quickreturn.plugins.derive.tests.descriptions import described
from quickreturn.plugins.derive.tests.reference.oracle_scene import draw_case, mechanism_of
from quickreturn.plugins.derive.units import in_si
from quickreturn.plugins.derive.witness.description import constants
from quickreturn.reference_model.mechanism import Mechanism
from quickreturn.reference_model.model import BeamModel
from quickreturn.reference_model.motion.layout import state_size
from quickreturn.reference_model.shapes import decoupled, hermite_elements
from quickreturn.reference_model.thesis.model import ThesisModel
from tests.engines.scenes import run_24
from tests.reference_model.motion.beam_states import EVERYTHING, rates

DESCRIBED = described("quick_return")
#: Rounding in systems of condition up to 1e4.
SAME: Final = 1e-10
#: Everything that the descriptions have.
SCENE: Final = replace(EVERYTHING, tip=replace(EVERYTHING.tip_body, force=(0.0, 0.0), force_ramp=1.0))
BARE: Final = replace(SCENE, slider=replace(SCENE.slider, inertia=0.0))


#: Parameter of the descriptions -> its name in the engine's.
NAMES: Final = {"crank_center_of_mass": "crank_center", "tip_center_of_mass": "tip_center", "crank_torque": "torque"}


def values_of(scene: Mechanism) -> dict[str, float]:
    """Parameters of the descriptions."""
    given = constants(scene) | {"bending_stiffness": scene.follower.bending_stiffness}
    return {name: given[NAMES.get(name, name)] for name in DESCRIBED.quick_return(DESCRIBED.one_cubic).parameters}


def in_units(model: Model, values: dict[str, float]) -> dict[str, float]:
    """Of values in SI."""
    return {name: value / in_si(model.system.parameters[name][2])[0] for name, value in values.items()}


def accelerations(model: Model, start: dict[str, float], values: dict[str, float]) -> dict[str, float]:
    """Rates of the free speeds, by the names of the speeds, and the outputs; values in SI."""
    values = in_units(model, values)
    y, p = model.start(start, values), model.values(values)
    model.check(y, p)
    speeds = [model.system.coordinates[k].rate_name for k in model.equations.free]
    rate = model.rates(0.0, y, p)[len(model.system.coordinates) :]
    return dict(model.observe(np.zeros(1), y[None], p).iloc[0]) | {f"{name}_rate": value for name, value in zip(speeds, rate, strict=False)}


def assert_same(found: list[float], expected: NDArray[np.float64] | list[float]) -> None:
    np.testing.assert_allclose(found, expected, rtol=0, atol=SAME * float(np.max(np.abs(expected))))


CUBIC_SPEEDS: Final = ["crank_speed_rate", "tip_deflection_rate_rate", "tip_slope_rate_rate"]


@pytest.fixture(scope="module", params=["projection", "multipliers"])
def cubic(request: pytest.FixtureRequest) -> Model:
    return Model(DESCRIBED.quick_return(DESCRIBED.one_cubic), request.param)


@pytest.mark.parametrize("seed", range(6))
def test_one_cubic_moves_as_the_thesis_model_derived_by_hand(cubic: Model, seed: int) -> None:
    parameters, state = draw_case(seed, present=1.0, lacking=("slider_inertia",) if seed % 2 else ())
    found = accelerations(cubic, {name: state[name] for name in state}, parameters)
    model = ThesisModel(mechanism_of(parameters), hermite_elements(parameters["length"], 1), exact_geometry=False)
    eta, eta_rate = (np.array([state[f"tip_{name}{rate}"] for name in ("deflection", "slope")]) for rate in ("", "_rate"))
    y = model.initial_state(state["crank_angle"], state["crank_speed"], eta, eta_rate)
    rate = np.empty_like(y)
    assert model.right_hand_side(y, rate)
    assert_same([found[name] for name in CUBIC_SPEEDS], rate[3:6])
    shown = {name: values[0] for name, values in model.observe(y[None]).items()}
    for name in ("tip_x", "tip_y", "kinetic_energy", *([] if parameters["slider_inertia"] else ["slider_force"])):
        assert_same([found[name]], [shown[name]])
    assert_same([found["potential_energy"]], [shown["strain_energy"] + shown["gravity_energy"]])


@pytest.mark.parametrize("scene", [SCENE, BARE], ids=["with a heavy slider", "without"])
def test_staying_shapes_move_as_those_of_fixed_shapes(scene: Mechanism) -> None:
    model, length = Model(DESCRIBED.quick_return(DESCRIBED.staying)), scene.follower.length
    by_hand = BeamModel.staying(scene, hermite_elements(length, 1))
    own, _ = decoupled(hermite_elements(length, 1), scene.follower.mass_per_length, scene.follower.bending_stiffness)
    end = np.array([length])
    to_tip = np.vstack([own.evaluate(end), own.evaluate(end, 1)])  # amplitudes to deflection and slope of the deflection at the tip
    for seed in range(5):
        rng = np.random.default_rng(seed)
        tip, tip_rate = rng.uniform(-1, 1, 2) * [0.05, 0.2], rng.uniform(-1, 1, 2) * [1.0, 5.0]
        start = {"crank_angle": float(rng.uniform(0, 2 * np.pi)), "crank_speed": 17.0}
        names = ("tip_deflection", "tip_slope")
        start |= dict(zip(names, tip, strict=True)) | {f"{name}_rate": v for name, v in zip(names, tip_rate, strict=True)}
        found = accelerations(model, start, values_of(scene))
        eta, eta_rate = np.linalg.solve(to_tip, tip), np.linalg.solve(to_tip, tip_rate)
        compare(
            by_hand,
            found,
            start,
            eta,
            eta_rate,
            [found["crank_speed_rate"], *np.linalg.solve(to_tip, [found[n] for n in CUBIC_SPEEDS[1:]])],
        )


def compare(by_hand: BeamModel, found: dict[str, Any], start: dict[str, float], eta: Any, eta_rate: Any, ours: list[float]) -> None:
    n = len(eta)
    y = np.zeros(state_size(by_hand.parameters))
    y[0], y[1 : n + 1], y[n + 1] = start["crank_angle"], eta, found["slider_position"]
    y[n + 2], y[n + 3 : 2 * n + 3] = start["crank_speed"], eta_rate
    rate = rates(by_hand, y)
    assert_same([found["slider_position_rate"]], rate[n + 1 : n + 2])
    assert_same(ours, rate[n + 2 : 2 * n + 3])
    if not by_hand.parameters.slider_inertia:
        assert_same([found["slider_force"]], by_hand.observe(y[None])["slider_force"])


@pytest.mark.parametrize(("degrees", "published"), [(180.0, (22.94, 74.96)), (90.0, (19.76, 61.29)), (0.0, (12.71, 84.90))])
def test_frequencies_of_one_cubic_with_the_crank_held_are_those_published(
    cubic: Model, degrees: float, published: tuple[float, float]
) -> None:
    found = natural_frequencies(cubic, {"crank_angle": np.radians(degrees)}, hold=["crank_angle"])
    np.testing.assert_allclose(found, published, rtol=5e-4)  # four digits


def test_half_a_cycle_of_run_24_keeps_the_energy_and_follows_reference() -> None:
    scene = run_24()
    by_hand = BeamModel.following(scene, 2)
    model = Model(DESCRIBED.quick_return(DESCRIBED.following(by_hand.parameters.tables, 2)))
    start = {"crank_angle": np.pi, "crank_speed": 16.617773}
    found = model.simulate(start, 0.2, 0.01, tolerance=1e-10, parameters=in_units(model, values_of(scene)))
    y = np.zeros(state_size(by_hand.parameters))
    y[0], y[3], y[4] = np.pi, scene.pivot_distance + scene.crank.length, 16.617773
    expected = by_hand.integrate(y, 0.01, 20, 1e-11).states
    np.testing.assert_allclose(found["eta_1"], expected[:, 1], atol=1e-8 * np.max(np.abs(expected[:, 1])))
    np.testing.assert_allclose(found["crank_angle"], expected[:, 0], rtol=1e-10)
    # the tables' interpolation, see DERIVATION.md, section 2
    assert np.ptp(found["energy_balance"]) < 1e-5 * found["potential_energy"].max()
