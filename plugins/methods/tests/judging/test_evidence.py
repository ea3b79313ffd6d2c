"""What a run shows about itself, on an engine whose motion and error are known in closed form."""

from dataclasses import replace

import numpy as np
import pytest

from quickreturn.cases.files.case_file import load_case
from quickreturn.engines.base import Comparison, EngineFailure, Refusal
from quickreturn.engines.relative import relative_error
from quickreturn.engines.settings import Settings
from quickreturn.engines.start import Start
from quickreturn.engines.trajectory import Trajectory
from quickreturn.plugins.methods.judging.evidence import TrialScene, gather
from quickreturn.plugins.methods.judging.verdicts import ACCURATE, DIVERGED, ENDED, NOT_CONVERGED, REFUSED, Evidence, judge
from quickreturn.reference_model.mechanism import Mechanism
from quickreturn.reference_model.slider import Slider
from tests.engines.fake_engine import FakeEngine, FakeSettings, FakeSimulation, error_of

SCENE = TrialScene(mechanism=load_case("thesis-24").mechanism, duration=10.0, output_step=0.1, horizon=10.0)
LENGTH = SCENE.mechanism.follower.length


class Behaving(FakeEngine):
    """The fake engine, behaving in one of its ways from the first rung on."""

    def __init__(self, behaviour: str = "good", step: float = 0.2) -> None:
        self.first = FakeSettings(step=step, behaviour=behaviour)

        self.optimism = 1.0  # what the estimate shows of the error

    def settings_for(self, accuracy: float, mechanism: Mechanism) -> FakeSettings:
        return self.first

    def comparisons(self, settings: Settings, mechanism: Mechanism, output_step: float) -> tuple[Comparison, ...]:
        return tuple(replace(pair, factor=1.0 + 3.0 / self.optimism) for pair in super().comparisons(settings, mechanism, output_step))


def run(engine: FakeEngine, requested: float = 0.01, scene: TrialScene = SCENE) -> Evidence:
    return gather("fake", scene, requested, lambda _: engine)


def test_the_first_rung_that_is_good_enough_is_taken_and_its_claim_holds() -> None:
    found = run(Behaving(step=0.4))
    verdict = judge(found)
    # second order: steps of 0.4, 0.2 and 0.1 leave 0.08, 0.02 and 0.005 times a cosine
    assert (verdict.kind, found.settings["step"]) == (ACCURATE, pytest.approx(0.1))
    truth = np.sin(found.columns["time"])
    assert verdict.claimed_error is not None
    assert relative_error(found.columns["tip_deflection"], truth) <= 1.05 * verdict.claimed_error  # cosine and sine differ in RMS
    assert found.finer_difference == pytest.approx(error_of(0.1) - error_of(0.05), rel=0.1)


def test_a_ladder_too_short_ends_in_doubt() -> None:
    assert judge(run(Behaving(step=0.4), requested=1e-5)).kind == NOT_CONVERGED


@pytest.mark.parametrize("behaviour", ["fails", "raises", "nan", "short"])
def test_whatever_breaks_down_is_told(behaviour: str) -> None:
    verdict = judge(run(Behaving(behaviour)))
    assert verdict.kind == DIVERGED
    told = {"fails": "the beam snapped", "raises": "ZeroDivisionError", "nan": "strain_2 is no longer", "short": "rows"}
    assert told[behaviour] in verdict.reason


def test_an_unstable_step_is_cured_by_a_finer_one() -> None:
    found = run(Behaving("unstable", step=0.1))
    assert (judge(found).kind, found.settings["step"]) == (ACCURATE, pytest.approx(0.025))


def test_what_finer_settings_doubt_is_asked_for_more_accurately() -> None:
    engine = Behaving(step=0.2)
    engine.optimism = 0.05
    found = run(engine)
    # its own estimate of the first rung, 0.02, is said to be 0.001, but the next finer one is 0.015 away
    assert (judge(found).kind, found.settings["step"]) == (ACCURATE, pytest.approx(0.1))
    assert found.finer_difference == pytest.approx(error_of(0.1) - error_of(0.05), rel=0.1)


class Gaping(Behaving):
    """Leaves a gap of a millimetre."""

    def prepare(self, mechanism: Mechanism, start: Start, settings: Settings) -> FakeSimulation:
        simulation = super().prepare(mechanism, start, settings)
        advance = simulation.advance

        def with_gap(duration: float, output_step: float) -> Trajectory:
            whole = advance(duration, output_step)
            whole.columns["constraint_gap"] = np.full_like(whole["time"], 1e-3)
            return whole

        simulation.advance = with_gap  # type: ignore[method-assign]
        return simulation


def test_finer_settings_that_break_down_are_a_doubt() -> None:
    class Brittle(Behaving):
        def finer(self, settings: Settings, excess: tuple[float, ...], output_step: float) -> FakeSettings | None:
            return FakeSettings(step=0.05, behaviour="fails")

    verdict = judge(run(Brittle(step=0.1)))
    assert verdict.kind == NOT_CONVERGED
    assert "with finer settings it failed at t = 0.2 s: the beam snapped" in verdict.reason


def test_a_gap_is_a_doubt_unless_the_joint_is_soft() -> None:
    verdict = judge(run(Gaping()))
    assert verdict.kind == NOT_CONVERGED
    assert "off the centre line by up to 0.001 m" in verdict.reason
    soft = replace(SCENE, mechanism=replace(SCENE.mechanism, slider=Slider(joint_stiffness=1e4)))
    assert judge(run(Gaping(), scene=soft)).kind == ACCURATE


def test_a_refusal_is_kept() -> None:
    scene = replace(SCENE, mechanism=replace(SCENE.mechanism, slider=Slider(mass=1.0)))
    verdict = judge(run(FakeEngine(), scene=scene))
    assert (verdict.kind, verdict.reason) == (REFUSED, "slider.mass: engine fake models a massless slider only")

    def unusable(name: str) -> FakeEngine:
        raise Refusal(f"engine {name} is not available: no library")

    assert judge(gather("fake", SCENE, 0.01, unusable)).kind == REFUSED


class Leaving(Behaving):
    """The slider leaves the follower at 5 s, or later by `drift` times the step."""

    def __init__(self, drift: float) -> None:
        super().__init__()
        self.drift = drift

    def prepare(self, mechanism: Mechanism, start: Start, settings: Settings) -> FakeSimulation:
        simulation = super().prepare(mechanism, start, settings)
        assert isinstance(settings, FakeSettings)
        end, advance = 5.0 + self.drift * settings.step, simulation.advance

        def until_the_end(duration: float, output_step: float) -> Trajectory:
            whole = advance(duration, output_step)
            whole.columns["slider_position"] = LENGTH * (0.5 + 0.5 * whole["time"] / end)
            if duration < end:
                return whole
            rows = int(np.searchsorted(whole["time"], end))
            partial = Trajectory({name: values[:rows] for name, values in whole.columns.items()}, 0.0)
            raise EngineFailure(end, "the slider left the follower", "lengthen it", partial)

        simulation.advance = until_the_end  # type: ignore[method-assign]
        return simulation


def test_the_end_of_a_scene_is_told_with_its_time_and_the_error_until_then() -> None:
    verdict = judge(run(Leaving(0.0)))
    assert (verdict.kind, verdict.time) == (ENDED, 5.0)
    assert verdict.stretch == pytest.approx(4.7)  # 95 % of it, on the grid
    assert verdict.claimed_error is not None


def test_an_end_that_moves_with_the_settings_is_none() -> None:
    assert judge(run(Leaving(10.0))).kind == NOT_CONVERGED
