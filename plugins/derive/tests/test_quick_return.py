"""The quick-return with one cubic from its description against the thesis' model derived by hand, at random bent and moving states."""

from typing import Final

import numpy as np
import pytest

from quickreturn.derive import Model, natural_frequencies
from quickreturn.plugins.derive.tests.descriptions import described
from quickreturn.plugins.derive.tests.reference.oracle_scene import draw_case, mechanism_of
from quickreturn.plugins.derive.units import in_si
from quickreturn.reference_model.arrays import Array
from quickreturn.reference_model.shapes import hermite_elements
from quickreturn.reference_model.thesis.model import ThesisModel

DESCRIBED = described("quick_return")
#: Rounding in systems of condition up to 1e4.
SAME: Final = 1e-10


def accelerations(model: Model, start: dict[str, float], values: dict[str, float]) -> dict[str, float]:
    """Rates of the free speeds, by the names of the speeds, and the outputs; values in SI."""
    values = {name: value / in_si(model.system.parameters[name][2])[0] for name, value in values.items()}
    y, p = model.start(start, values), model.values(values)
    model.check(y, p)
    speeds = [model.system.coordinates[k].rate_name for k in model.equations.free]
    rate = model.rates(0.0, y, p)[len(model.system.coordinates) :]
    return dict(model.observe(np.zeros(1), y[None], p).iloc[0]) | {f"{name}_rate": value for name, value in zip(speeds, rate, strict=False)}


def assert_same(found: list[float], expected: Array | list[float]) -> None:
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


@pytest.mark.parametrize(("degrees", "published"), [(180.0, (22.94, 74.96)), (90.0, (19.76, 61.29)), (0.0, (12.71, 84.90))])
def test_frequencies_of_one_cubic_with_the_crank_held_are_those_published(
    cubic: Model, degrees: float, published: tuple[float, float]
) -> None:
    found = natural_frequencies(cubic, {"crank_angle": np.radians(degrees)}, hold=["crank_angle"])
    np.testing.assert_allclose(found, published, rtol=5e-4)  # four digits
