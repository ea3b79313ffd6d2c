"""The engines `thesis` and `reference` behind the engine interface."""

import math

import numpy as np
import pytest

from quickreturn.engines.base import Engine, EngineFailure, Refusal
from quickreturn.engines.own.thesis import ThesisEngine, ThesisSettings
from quickreturn.engines.start import standard_start
from quickreturn.plugins.methods.rivals import fixed_shapes
from quickreturn.plugins.methods.rivals.fixed_shapes import FixedShapesSettings
from quickreturn.reference_model.arrays import Array
from quickreturn.reference_model.model import ObservationFailed
from quickreturn.reference_model.natural_modes import frozen_crank_modes
from quickreturn.reference_model.thesis.model import ThesisModel
from tests.engines.scenes import run_24, violent

THESIS, FIXED = ThesisEngine(), fixed_shapes.ENGINE


@pytest.mark.parametrize(("degrees", "one_cubic"), [(180, (22.94, 74.96)), (90, (19.76, 61.29)), (0, (12.71, 84.90))])
def test_frozen_crank_frequencies_of_run_24(degrees: int, one_cubic: tuple[float, ...]) -> None:
    angle = math.radians(degrees)
    found = FIXED.natural_frequencies(run_24(), angle, 4, FixedShapesSettings())
    # cubic elements against spans with polynomials of high degree: a sixteenth of the engine's own tolerance of convergence
    np.testing.assert_allclose(found, frozen_crank_modes(run_24(), angle, 4).frequencies, rtol=2e-7)
    cubic = THESIS.natural_frequencies(run_24(), angle, 4, ThesisSettings())
    np.testing.assert_allclose(cubic, one_cubic, rtol=5e-4)  # printed to 0.01; the model has no more than two


def test_frequencies_with_everything_that_vibrates() -> None:
    mechanism = run_24(slider={"inertia": 2e-4}, tip={"center_of_mass": 0.0127})
    found = FIXED.natural_frequencies(mechanism, 1.0, 4, FixedShapesSettings())
    np.testing.assert_allclose(found, frozen_crank_modes(mechanism, 1.0, 4).frequencies, rtol=2e-7)


@pytest.mark.parametrize("engine", [THESIS, FIXED])
def test_a_slider_that_leaves_the_follower_is_a_failure_at_its_time(engine: Engine) -> None:
    mechanism = violent()
    settings = ThesisSettings(tolerance=1e-9) if engine is THESIS else FixedShapesSettings(shapes=8)
    with pytest.raises(EngineFailure, match="left the follower") as caught:
        engine.prepare(mechanism, standard_start(mechanism), settings).advance(0.5, 1e-3)
    failure, partial = caught.value, caught.value.partial
    # the last row lies before the failure, which is less than one output step later
    assert 0.0 <= failure.time - partial["time"][-1] <= 1.001e-3
    s, length = partial["slider_position"], mechanism.follower.length
    assert np.all(s <= length + 1e-5)  # the recovered place differs from the model's by what recovery corrects
    assert 2.0 * s[-1] - s[-2] > length - 1e-4  # one more row at this speed and it is gone


def test_a_follower_bent_beyond_description_fails_with_what_was_computed() -> None:
    """A thousandth of the stiffness: slopes reach 1."""
    mechanism = run_24(follower={"bending_stiffness": 1e-3 * run_24().follower.bending_stiffness})
    for engine, settings in ((THESIS, ThesisSettings()), (FIXED, FixedShapesSettings(shapes=6))):
        with pytest.raises(EngineFailure) as caught:
            engine.prepare(mechanism, standard_start(mechanism), settings).advance(1.0, 1e-3)
        partial = caught.value.partial
        assert all(np.all(np.isfinite(column)) for column in partial.columns.values())
        assert caught.value.time >= partial["time"][-1] - 1e-9


def test_a_row_that_cannot_be_observed_ends_the_run_at_the_one_before(monkeypatch: pytest.MonkeyPatch) -> None:
    observe = ThesisModel.observe

    def up_to_row_4(model: ThesisModel, states: Array) -> dict[str, Array]:
        if len(states) > 5:
            raise ObservationFailed(5)
        return observe(model, states)

    monkeypatch.setattr(ThesisModel, "observe", up_to_row_4)
    simulation = ThesisEngine().prepare(run_24(), standard_start(run_24()), ThesisSettings())
    with pytest.raises(EngineFailure) as failure:
        simulation.advance(0.01, 1e-3)
    assert failure.value.time == failure.value.partial["time"][-1] == pytest.approx(4e-3)


@pytest.mark.parametrize("settings", [FixedShapesSettings(shapes=8), FixedShapesSettings(shapes=8, family="hermite")])
def test_a_start_from_the_shapes_of_a_running_simulation_continues_it(settings: FixedShapesSettings) -> None:
    simulation = FIXED.prepare(run_24(), standard_start(run_24()), settings)
    simulation.advance(0.2, 1e-3)
    state, n = simulation.state.copy(), simulation.model.parameters.n
    again = FIXED.prepare(run_24(), simulation.present_start(), settings)
    # the start is a spline through 241 slopes: fourth order in a spacing of 2.5 mm
    np.testing.assert_allclose(again.state[: 2 * n + 3], state[: 2 * n + 3], atol=1e-6 * np.max(np.abs(state[: 2 * n + 3])))
    one, other = simulation.advance(0.2, 1e-3), again.advance(0.2, 1e-3)
    # what that leaves of 14 mm, most where the curvature of elements has kinks
    np.testing.assert_allclose(one["tip_deflection"], other["tip_deflection"], rtol=0.0, atol=2e-7)


def test_a_compliant_joint_is_refused() -> None:
    for engine in (THESIS, FIXED):
        with pytest.raises(Refusal, match=r"slider\.joint_stiffness"):
            engine.check(run_24(slider={"joint_stiffness": 2e4}))


def test_rotary_inertia_on_elements_is_refused() -> None:
    mechanism = run_24(slider={"inertia": 1e-4})
    with pytest.raises(Refusal, match=r"slider\.inertia"):
        FIXED.prepare(mechanism, standard_start(mechanism), FixedShapesSettings(shapes=8, family="hermite"))
    THESIS.prepare(mechanism, standard_start(mechanism), ThesisSettings())


def test_a_thesis_simulation_has_no_start_for_other_engines() -> None:
    assert ThesisEngine().prepare(run_24(), standard_start(run_24()), ThesisSettings()).present_start() is None
