"""The error estimate and the ladder, on an engine whose error is known in closed form."""

import math
import os
import subprocess
import sys
import time
from pathlib import Path
from typing import Any, ClassVar

import numpy as np
import pytest
from threadpoolctl import threadpool_info, threadpool_limits

from quickreturn.engines.accurate import TIP, Result, simulate
from quickreturn.engines.base import Comparison, Engine, EngineFailure, EstimateOf, Refusal, Simulation
from quickreturn.engines.error_parts import LARGEST_REST, LEAST_FACTOR, Compared, ErrorPart, shown_factor
from quickreturn.engines.one_run import run_once
from quickreturn.engines.own.reference import ReferenceEngine, ReferenceSettings
from quickreturn.engines.registry import engine
from quickreturn.engines.relative import rms
from quickreturn.engines.settings import SettingError, Settings
from quickreturn.engines.start import Start, standard_start
from quickreturn.engines.trajectory import Trajectory
from quickreturn.reference_model.mechanism import Mechanism
from tests.engines.fake_engine import FakeEngine, FakeSettings, FakeSimulation, error_of
from tests.engines.scenes import run_24

DURATION = 2.0 * math.pi * 0.999  # s: close to a whole period, so that sine and cosine have nearly the same RMS
STEP = DURATION / 1000


def run(settings: dict[str, str] | None = None, accuracy: float | None = None, engine: Engine | None = None) -> Result:
    scene = run_24()
    return simulate(engine or FakeEngine(), scene, standard_start(scene), DURATION, STEP, settings, accuracy)


def misbehaving(behaviour: str) -> Engine:
    """The fake engine whose own choice of settings, not the user's, misbehaves."""

    class Misbehaving(FakeEngine):
        def settings_for(self, accuracy: float, mechanism: Mechanism) -> FakeSettings:
            return FakeSettings(step=0.1, behaviour=behaviour)

    return Misbehaving()


def step_of(result: Result) -> float:
    assert isinstance(result.settings, FakeSettings)
    return result.settings.step


@pytest.mark.parametrize("step", [0.2, 0.05])
def test_estimate_is_the_known_error(step: float) -> None:
    result = run({"step": str(step)})
    # The estimate divides by the RMS of the run itself, which differs from the exact one by half the error squared: < 1e-3.
    assert result.error_estimate == pytest.approx(error_of(step), rel=2e-3)
    assert result.error_estimates["strain_1"] == pytest.approx(error_of(step), rel=2e-3)
    assert result.error_estimates["slider_force"] is None, "zero throughout: no relative error"


def test_no_part_of_a_call_takes_longer_than_the_call() -> None:
    begin = time.perf_counter()
    result = run(engine=ReferenceEngine())
    call = time.perf_counter() - begin
    parts = result.setup_seconds, result.solve_seconds, result.compile_seconds, result.estimate_seconds
    assert min(parts) >= 0.0
    assert 0.0 < max(parts) <= call  # a table from an earlier run keeps its seconds, so that the sum may be larger


def test_linear_algebra_keeps_to_one_thread_and_gives_the_others_back() -> None:
    seen = []

    class Watching(FakeEngine):
        def settings_for(self, accuracy: float, mechanism: Mechanism) -> FakeSettings:
            seen.append(threads())
            return FakeSettings()

    with threadpool_limits(limits=2, user_api="blas"):
        given = threads()
        run(engine=Watching())
        assert threads() == given
    assert set(seen[0]) == {1}


def test_the_first_simulation_of_a_process_does_so_too() -> None:
    """Its engine is the first that loads scipy's linear algebra."""
    code = """
from tests.engines.test_accurate import FakeEngine, run, threads
class Watching(FakeEngine):
    def settings_for(self, accuracy, mechanism):
        import scipy.linalg
        print(set(threads()))
        return super().settings_for(accuracy, mechanism)
run(engine=Watching())
"""
    environment = {name: value for name, value in os.environ.items() if not name.endswith("_NUM_THREADS")}
    found = subprocess.run([sys.executable, "-c", code], env=environment, capture_output=True, text=True, check=True)
    assert found.stdout.split() == ["{1}"]


def threads() -> list[int]:
    """Threads that each library of linear algebra may use."""
    return [library["num_threads"] for library in threadpool_info() if library["user_api"] == "blas"]


def test_ladder_climbs_until_the_estimate_is_good_enough() -> None:
    result = run(accuracy=4e-4)
    # error_of: 0.005 at 0.1, 0.00125 at 0.05, 0.0003125 at 0.025
    assert step_of(result) == pytest.approx(0.025)
    assert result.reached
    assert result.remark == ""


def test_default_accuracy_is_the_engines() -> None:
    result = run()
    assert result.accuracy == FakeEngine.default_accuracy
    assert step_of(result) == pytest.approx(0.1), "error_of(0.2) = 0.02 misses the default of 0.01"


def test_end_of_the_ladder_is_kept_and_flagged() -> None:
    result = run(accuracy=1e-4)
    assert not result.reached
    assert step_of(result) == pytest.approx(0.025)
    assert len(result.trajectory) == 1001
    assert "misses the accuracy 0.0001" in result.remark


def test_explicit_settings_switch_the_ladder_off() -> None:
    result = run({"step": "0.2"}, accuracy=1e-3)
    assert step_of(result) == pytest.approx(0.2)
    assert not result.reached
    assert run({"step": "0.2"}).reached, "no accuracy was asked"


def test_an_estimate_that_nobody_verified_does_not_reach_what_was_asked() -> None:
    class Unverified(FakeEngine):
        estimates: ClassVar[EstimateOf] = "unverified"

    assert run().estimate_of == "total"
    result = run(accuracy=1e-2, engine=Unverified())
    assert (result.estimate_of, result.error_estimate) == ("unverified", run(accuracy=1e-2).error_estimate)
    assert not result.reached
    assert "not verified" in result.remark
    assert run(engine=Unverified()).reached, "nothing was asked"


def test_an_integration_error_is_called_so_where_it_misses() -> None:
    class Integration(FakeEngine):
        estimates: ClassVar[EstimateOf] = "integration"

    assert run(accuracy=1e-2, engine=Integration()).reached
    assert "the estimated integration error" in run(accuracy=1e-4, engine=Integration()).remark


def test_a_comparison_with_the_same_motion_tells_nothing() -> None:
    class Deceived(FakeEngine):
        def comparisons(self, settings: Settings, mechanism: Mechanism, output_step: float) -> tuple[Comparison, ...]:
            return (Comparison(settings, settings.replaced(behaviour="prints"), 4.0),)

    result = run(accuracy=1e-2, engine=Deceived())
    assert result.error_estimate is None
    assert not result.reached
    assert "the same to the last digit" in result.remark


def test_times_are_of_the_delivered_run_only() -> None:
    result = run(accuracy=4e-4)
    assert (result.setup_seconds, result.solve_seconds) == (0.25, 0.125)
    assert result.estimate_seconds >= 0.0


def test_an_engine_whose_library_gets_no_memory_is_not_accused() -> None:
    """The caller, who knows the limit, tells of the lack."""

    class Hungry(ReferenceEngine):
        def prepare(self, *_: Any) -> Any:
            raise ValueError("Error: engine error: Could not allocate memory")

    scene = run_24()
    with pytest.raises(MemoryError, match="Could not allocate memory"):
        run_once(Hungry(), scene, standard_start(scene), 0.01, 1e-3, ReferenceSettings())


def test_without_an_estimate_there_is_one_run_and_nothing_is_claimed() -> None:
    scene, engine = run_24(), FakeEngine()
    result = simulate(engine, scene, standard_start(scene), DURATION, STEP, estimate=False)
    assert list(result.runs) == [engine.settings_for(engine.default_accuracy, scene)]
    assert (result.error_estimate, result.accuracy, result.reached) == (None, None, True)
    assert set(result.error_estimates.values()) == {None}
    assert result.remark == "the error is not estimated, as asked"
    with pytest.raises(ValueError, match=r"^accuracy=0\.01 without an estimate: .*give one of them"):
        simulate(engine, scene, standard_start(scene), DURATION, STEP, accuracy=1e-2, estimate=False)


class LoadsAtItsFirstModel(FakeEngine):
    """Takes `LOADING` for its first model, as engines do that compile then."""

    compiles = True

    def __init__(self) -> None:
        self.loaded = False

    def prepare(self, mechanism: Mechanism, start: Start, settings: FakeSettings) -> Simulation:
        time.sleep(0.0 if self.loaded else LOADING)
        self.loaded = True
        return super().prepare(mechanism, start, settings)


LOADING = 0.2  # s


@pytest.mark.parametrize("estimate", [True, False])
def test_what_is_compiled_or_loaded_is_booked_apart(estimate: bool) -> None:
    scene = run_24()
    result = simulate(LoadsAtItsFirstModel(), scene, standard_start(scene), DURATION, STEP, estimate=estimate)
    assert result.compile_seconds >= LOADING
    assert result.estimate_seconds < LOADING


@pytest.mark.verify
@pytest.mark.parametrize("name", ["mujoco", "reference"])
def test_an_engine_that_compiles_says_so(name: str, tmp_path: Path) -> None:
    """On a machine without compiled code, where compiling takes 15 to 40 s and all else a second or two."""
    code = f"import quickreturn as qr; r = qr.simulate(qr.case('thesis-24', duration=0.1), '{name}', store=False).result"
    code += "; print(r.compile_seconds, r.setup_seconds + r.solve_seconds + r.estimate_seconds)"
    environment = {**os.environ, "NUMBA_CACHE_DIR": str(tmp_path)}
    found = subprocess.run([sys.executable, "-c", code], env=environment, capture_output=True, text=True, check=True)
    compiling, rest = map(float, found.stdout.split())
    assert compiling > 5.0
    assert rest < 0.3 * compiling
    assert f"{name}: compiling its equations" in found.stderr


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
            assert isinstance(settings, FakeSettings)
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
            assert isinstance(settings, FakeSettings)
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


@pytest.mark.parametrize("name", ["reference", "mujoco", "stiff-spring"])
def test_the_runs_that_a_claim_names_give_that_claim(name: str) -> None:
    """Each run is made anew from the named settings alone."""
    chosen, scene = engine(name), run_24()
    result = simulate(chosen, scene, standard_start(scene), 0.05, 1e-3)

    def made(settings: dict[str, Any]) -> Trajectory:
        return run_once(chosen, scene, standard_start(scene), 0.05, 1e-3, chosen.settings_type(**settings)).trajectory

    for column, estimate in (("tip_deflection", result.error_estimate), ("strain_2", result.error_estimates["strain_2"])):
        parts = result.error_parts[column if column != "tip_deflection" else TIP]
        differences = [rms(made(part.run)[column] - made(part.other)[column]) / rms(result.trajectory[column]) for part in parts]
        assert differences == pytest.approx([part.difference for part in parts], rel=1e-9)
        assert estimate == pytest.approx(sum(part.counted * found for part, found in zip(parts, differences, strict=True)), rel=1e-9)
    assert {part.of for part in result.error_parts[TIP]} <= {"modes", "space", "spring"}


def test_a_part_of_an_error_in_words() -> None:
    part = ErrorPart("modes", {"modes": 4, "tolerance": 1e-6}, {"modes": 7, "tolerance": 1e-6}, 7.2e-4, 0.2, 1.25)
    assert str(part) == "9.0e-4 by modes: modes 4 against 7 (1.2 times their difference of 7.2e-4)"


def test_ladder_gets_past_an_unstable_step() -> None:
    result = run(engine=misbehaving("unstable"))
    # 0.1 turns to NaN; so does the coarser run of 0.05, whose estimate is therefore unknown; 0.025 has a good one.
    assert step_of(result) == pytest.approx(0.025)
    assert result.reached


def test_scene_that_cannot_go_on_fails_with_what_was_computed() -> None:
    with pytest.raises(EngineFailure, match="the beam snapped") as caught:
        run(engine=misbehaving("fails"))
    assert caught.value.partial is not None
    assert len(caught.value.partial) == 3


@pytest.mark.parametrize(
    ("behaviour", "words"),
    [
        ("nan", "strain_2 is no longer a finite number"),
        ("short", "500 rows"),
        ("raises", r"at fake_engine.py, line \d+: a bug"),
    ],
)
def test_wrong_trajectories_are_failures(behaviour: str, words: str) -> None:
    scene = run_24()
    with pytest.raises(EngineFailure, match=words):
        run_once(FakeEngine(), scene, standard_start(scene), DURATION, STEP, FakeSettings(behaviour=behaviour))


def test_values_that_are_no_numbers_end_the_kept_part() -> None:
    with pytest.raises(EngineFailure) as caught:
        run({"behaviour": "nan"})
    assert caught.value.partial is not None
    assert len(caught.value.partial) == 5
    assert caught.value.time == pytest.approx(4 * STEP)
    assert np.isfinite(caught.value.partial["strain_2"]).all()


def test_rigid_follower_is_judged_by_the_place_of_its_tip() -> None:
    result = run({"step": "0.1", "behaviour": "rigid"})
    # tip_x is off by error_of(step) cos(t): RMS error_of / sqrt(2), over the follower's length; the window is 0.1 % short of a period.
    expected = error_of(0.1) / math.sqrt(2.0) / run_24().follower.length
    assert result.error_estimate == pytest.approx(expected, rel=2e-3)
    assert result.error_estimates["tip_deflection"] is None


def test_refusals_and_settings_pass_through() -> None:
    heavy = run_24(slider={"mass": 0.5})
    with pytest.raises(Refusal, match=r"slider\.mass"):
        simulate(FakeEngine(), heavy, standard_start(heavy), DURATION, STEP)
    with pytest.raises(SettingError, match=r"engine\.step"):
        run({"step": "7"})


class Further(FakeEngine):
    """Compares with a finer run, and that with one finer still; its strain errs by `worse` times what the tip does."""

    def __init__(self, worse: float) -> None:
        self.worse, self.made = worse, list[float]()

    def comparisons(self, settings: Settings, mechanism: Mechanism, output_step: float) -> tuple[Comparison, ...]:
        assert isinstance(settings, FakeSettings)
        finer, further = (settings.replaced(step=settings.step / part) for part in (2.0, 4.0))
        return (Comparison(settings, finer, 0.25, Comparison(finer, further, 0.25), alike=2.0),)

    def prepare(self, mechanism: Mechanism, start: Start, settings: Settings) -> Simulation:
        assert isinstance(settings, FakeSettings)
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


def test_the_time_of_an_estimate_is_at_least_that_of_its_runs() -> None:
    """Also if the tables of all runs are there already, whose making every run counts as its set-up."""
    for _ in range(2):
        result = simulate(ReferenceEngine(), run_24(), standard_start(run_24()), 0.2, 1e-3)
    others = [made for settings, made in result.runs.items() if settings != result.settings]
    assert others
    assert result.estimate_seconds >= sum(made.trajectory.solve_seconds for made in others)
