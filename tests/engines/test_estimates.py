"""Estimates within a time limit, and what further runs show, on an engine whose error is known in closed form."""

from typing import Any

import numpy as np
import pytest

from quickreturn.engines.accurate import Result, simulate
from quickreturn.engines.base import Comparison, Simulation
from quickreturn.engines.error_parts import LARGEST_REST, LEAST_FACTOR, TIP, Compared, ErrorPart, shown_factor
from quickreturn.engines.one_run import run_once
from quickreturn.engines.registry import engine
from quickreturn.engines.settings import Settings
from quickreturn.engines.start import Start, standard_start
from quickreturn.engines.trajectory import Trajectory, rms
from quickreturn.reference_model.mechanism import Mechanism
from tests.engines.fake_engine import FakeEngine, FakeSimulation, error_of
from tests.engines.scenes import run_24
from tests.engines.test_accurate import DURATION, STEP, run, step_of


def test_a_comparison_with_the_same_motion_tells_nothing() -> None:
    class Deceived(FakeEngine):
        def comparisons(self, settings: Settings, mechanism: Mechanism, output_step: float) -> tuple[Comparison, ...]:
            return (Comparison(settings, settings.replaced(behaviour="prints"), 4.0),)

    result = run(accuracy=1e-2, engine=Deceived())
    assert result.error_estimate is None
    assert not result.reached
    assert "the same to the last digit" in result.remark


def test_failing_coarse_run_makes_the_estimate_unknown() -> None:
    result = run({"step": "0.05", "behaviour": "coarse fails"})
    assert result.error_estimate is None
    assert result.reached, "nothing was asked"
    assert "the step is too large" in result.remark
    assert not run({"step": "0.05", "behaviour": "coarse fails"}, accuracy=1e-2).reached


def test_an_accuracy_is_not_reached_where_all_runs_for_an_estimate_fail() -> None:
    """Nor is the engine's default one; settings that are given aim at none."""

    class Alone(FakeEngine):
        def comparisons(self, settings: Settings, mechanism: Mechanism, output_step: float) -> tuple[Comparison, ...]:
            return (Comparison(settings, settings.replaced(behaviour="fails"), 4.0),)

    result = run(engine=Alone())
    assert (result.reached, result.error_estimate, result.hurried) == (False, None, False)
    assert result.remark.startswith("the error is unknown: the run for its estimate failed")
    assert run({"step": "0.05"}, engine=Alone()).reached


def test_finer_run_serves_where_the_coarser_one_fails() -> None:
    class WithSpare(FakeEngine):
        def comparisons(self, settings: Settings, mechanism: Mechanism, output_step: float) -> tuple[Comparison, ...]:
            coarse, fine = (settings.replaced(step=factor * settings.step) for factor in (2.0, 0.5))
            return (Comparison(settings, coarse, 4.0, instead=Comparison(settings, fine, 0.25)),)

    result = run({"step": "0.05", "behaviour": "coarse fails"}, engine=WithSpare())
    assert result.error_estimate == pytest.approx(error_of(0.05), rel=2e-3)
    assert result.remark == ""


class Slow(FakeEngine):
    """Every run takes 10 s of a clock of its own, so that 40 s must be left for another."""

    def __init__(self, monkeypatch: pytest.MonkeyPatch) -> None:
        self.seconds = 0.0
        monkeypatch.setattr("quickreturn.engines.accurate.time.perf_counter", lambda: self.seconds)

    def prepare(self, mechanism: Mechanism, start: Start, settings: Settings) -> FakeSimulation:
        self.seconds += 10.0
        return super().prepare(mechanism, start, settings)

    def within(self, time_limit: float, settings: dict[str, str] | None, accuracy: float | None) -> Result:
        scene, self.seconds = run_24(), 0.0
        return simulate(self, scene, standard_start(scene), DURATION, STEP, settings, accuracy, time_limit=time_limit)


@pytest.mark.parametrize("ratio", [1.2, 2.0])
@pytest.mark.parametrize("finer", [True, False])
def test_claims_hold_whatever_the_time_limit(monkeypatch: pytest.MonkeyPatch, ratio: float, finer: bool) -> None:
    """Errors fall by the square of `ratio` from run to run where the engine states a factor of four: with 1.2 far more slowly."""

    class Compares(Slow):
        def comparisons(self, settings: Settings, mechanism: Mechanism, output_step: float) -> tuple[Comparison, ...]:
            by, factor = (1.0 / ratio, 0.25) if finer else (ratio, 4.0)
            other, further = (settings.replaced(step=settings.step * by**power) for power in (1, 2))
            return (Comparison(settings, other, factor, Comparison(other, further, factor)),)

    # to coarser runs that hardly differ no more than the least factor is credited, with a time limit or without
    least = 0.6 if not finer and ratio == 1.2 else 0.98
    engine, found = Compares(monkeypatch), dict[bool, Result]()
    for seconds in (50.0, 56.0, 60.0, 67.0, 80.0, 1000.0):
        result = engine.within(seconds, {"step": "0.1"}, None)
        if result.error_estimate is None:
            assert f"could take longer than is left of the time limit of {seconds:g} s" in result.remark
            continue
        found[result.hurried] = result
        assert result.error_estimate >= least * error_of(0.1)
    assert set(found) == {True, False}
    sentence = "the estimate assumes the slowest convergence: the run that would show how fast the error falls could take longer"
    assert sentence in found[True].remark
    assert found[False].remark == ""
    assert found[True].error_estimate >= found[False].error_estimate  # type: ignore[operator]


@pytest.mark.parametrize(("before", "counted"), [(0.2, 4.0), (0.1, LEAST_FACTOR), (None, LEAST_FACTOR)])
def test_differences_that_do_not_fall_as_they_should_count_for_more(before: float | None, counted: float) -> None:
    """The runs with steps of 0.05 and 0.1 are compared; before them 0.2, the very 0.1, or one that breaks down."""

    class Watched(FakeEngine):
        def comparisons(self, settings: Settings, mechanism: Mechanism, output_step: float) -> tuple[Comparison, ...]:
            other = settings.replaced(step=0.1)
            coarsest = other.replaced(behaviour="fails") if before is None else other.replaced(step=before)
            return (Comparison(settings, other, 4.0, before=Comparison(other, coarsest, 4.0)),)

    found = run({"step": "0.05"}, engine=Watched())
    assert found.error_estimate == pytest.approx(3.0 * error_of(0.05) / (counted - 1.0), rel=2e-3)
    assert found.error_estimates["strain_1"] == pytest.approx(found.error_estimate)


def test_factor_that_differences_show() -> None:
    # errors of 1, 3 and 6: factors 3 and 2, differences 2 and 3
    assert shown_factor(3.0, 2.0, 2.0, 3.0) == pytest.approx(3.0)
    assert shown_factor(3.0, 2.0, 2.0, 9.0) == 3.0, "no more than the order"
    assert shown_factor(3.0, 2.0, 2.0, 2.5) == pytest.approx(2.5)
    assert shown_factor(3.0, 2.0, 2.0, 0.1) == LEAST_FACTOR
    assert shown_factor(3.0, 2.0, 0.0, 0.0) == 3.0, "runs that agree"


def test_rest_that_differences_to_finer_runs_show() -> None:
    # errors of 8, 4 and 2: differences 4 and 2
    assert shown_factor(0.5, 0.5, 4.0, 2.0) == pytest.approx(0.5)
    assert shown_factor(0.5, 0.5, 4.0, 0.1) == 0.5, "no less than is known"
    assert shown_factor(0.25, 0.5, 4.0, 1.2) == pytest.approx(0.45), "it falls more slowly than it should"
    assert shown_factor(0.25, 0.5, 4.0, 9.0) == LARGEST_REST, "it does not fall"
    ringing = Compared(0.0, 4.0, 0.25, (13.0, 0.5))
    assert ringing.part(lambda a, b: abs(a - b)).error == pytest.approx(9.0 / (1.0 - LARGEST_REST)), "the larger difference counts"


@pytest.mark.parametrize("name", ["reference", "mujoco", pytest.param("stiff-spring", marks=pytest.mark.verify)])
def test_the_runs_that_a_claim_names_give_that_claim(name: str) -> None:
    """Each run is made anew from the named settings alone."""
    chosen, scene = engine(name), run_24()
    result = simulate(chosen, scene, standard_start(scene), 0.05, 1e-3)

    def made(settings: dict[str, Any]) -> Trajectory:
        return run_once(chosen, scene, standard_start(scene), 0.05, 1e-3, chosen.settings_type(**settings)).trajectory

    for column, estimate in (("tip_deflection", result.error_estimate), ("strain_2", result.error_estimates["strain_2"])):
        parts = [part.complete(result.settings) for part in result.error_parts[column if column != "tip_deflection" else TIP]]
        differences = [rms(made(part.run)[column] - made(part.other)[column]) / rms(result.trajectory[column]) for part in parts]
        assert differences == pytest.approx([part.difference for part in parts], rel=1e-9)
        assert estimate == pytest.approx(sum(part.counted * found for part, found in zip(parts, differences, strict=True)), rel=1e-9)
        assert [part.run.keys() | part.other.keys() for part in result.error_parts[column if column != "tip_deflection" else TIP]] == [
            {name for name, value in result.settings.items() if {part.run[name], part.other[name]} != {value}} for part in parts
        ], "a part has no setting that both runs share with the delivered one"
    assert {part.of for part in result.error_parts[TIP]} <= {"modes", "space", "spring"}


def test_a_part_of_an_error_in_words() -> None:
    part = ErrorPart("modes", {"modes": 4, "tolerance": 1e-6}, {"modes": 7, "tolerance": 1e-6}, 7.2e-4, 0.2, 1.25)
    assert str(part) == "9.0e-4 by modes: modes 4 against 7 (1.25 times their difference of 7.2e-4)"


class Further(FakeEngine):
    """Compares with a finer run, and that with one finer still; its strain errs by `worse` times what the tip does."""

    def __init__(self, worse: float) -> None:
        self.worse, self.made = worse, list[float]()

    def comparisons(self, settings: Settings, mechanism: Mechanism, output_step: float) -> tuple[Comparison, ...]:
        finer, further = (settings.replaced(step=settings.step / part) for part in (2.0, 4.0))
        return (Comparison(settings, finer, 0.25, Comparison(finer, further, 0.25), alike=2.0),)

    def prepare(self, mechanism: Mechanism, start: Start, settings: Settings) -> Simulation:
        self.made.append(settings.step)
        simulation, worse = super().prepare(mechanism, start, settings), self.worse
        plain = simulation.advance

        def advance(duration: float, output_step: float) -> Trajectory:
            found = plain(duration, output_step)
            times = found["time"]
            found.columns["strain_1"] = 0.001 * (np.sin(times) + worse * error_of(settings.step) * np.cos(times))
            return found

        simulation.advance = advance  # type: ignore[method-assign]
        return simulation


@pytest.mark.parametrize(("worse", "made"), [(1.9, [0.1, 0.05]), (2.1, [0.1, 0.05, 0.025])])
def test_a_further_run_is_made_only_where_columns_do_not_converge_alike(worse: float, made: list[float]) -> None:
    engine = Further(worse)
    result = run({"step": "0.1"}, engine=engine)
    assert engine.made == made
    assert result.further_run_skipped is (len(made) == 2)
    assert result.error_estimate == pytest.approx(error_of(0.1), rel=1e-2)


def test_what_would_not_be_done_in_time_is_not_begun(monkeypatch: pytest.MonkeyPatch) -> None:
    engine = Slow(monkeypatch)

    def within(seconds: float) -> Result:
        return engine.within(seconds, None, 1e-3)

    alone, first, all_rungs = within(55.0), within(60.0), within(1000.0)
    assert (alone.error_estimate, alone.reached) == (None, False)
    assert "the run for its estimate could take longer than is left of the time limit of 55 s" in alone.remark
    assert first.error_estimate == pytest.approx(error_of(step_of(first)), rel=1e-2)
    assert not first.reached
    assert "the next finer settings could take longer than is left of the time limit of 60 s" in first.remark
    assert step_of(alone) == step_of(first) > step_of(all_rungs)
    assert all_rungs.reached
