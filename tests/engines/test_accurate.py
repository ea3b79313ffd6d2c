"""The error estimate and the ladder, on engines whose error is known in closed form or that misbehave as told."""

import math
import os
import subprocess
import sys
import time
from typing import Any, ClassVar

import numpy as np
import pytest
from threadpoolctl import threadpool_info, threadpool_limits

from quickreturn.engines.accurate import Result, simulate
from quickreturn.engines.base import Engine, EngineFailure, EstimateOf, Simulation
from quickreturn.engines.one_run import run_once
from quickreturn.engines.own.reference import ReferenceEngine, ReferenceSettings
from quickreturn.engines.start import Start, standard_start
from quickreturn.reference_model.mechanism import Mechanism
from tests.engines.fake_engine import FakeEngine, FakeSettings, error_of
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
    step: float = result.settings["step"]
    return step


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


@pytest.mark.verify
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


def test_rigid_follower_is_judged_by_the_place_of_its_tip() -> None:
    result = run({"step": "0.1", "behaviour": "rigid"})
    # tip_x is off by error_of(step) cos(t): RMS error_of / sqrt(2), over the follower's length; the window is 0.1 % short of a period.
    expected = error_of(0.1) / math.sqrt(2.0) / run_24().follower.length
    assert result.error_estimate == pytest.approx(expected, rel=2e-3)
    assert result.error_estimates["tip_deflection"] is None


def test_the_time_of_an_estimate_is_at_least_that_of_its_runs() -> None:
    """Also if the tables of all runs are there already, whose making every run counts as its set-up."""
    for _ in range(2):
        result = simulate(ReferenceEngine(), run_24(), standard_start(run_24()), 0.2, 1e-3)
    others = [made for settings, made in result.runs.items() if settings != result.delivered]
    assert others
    assert result.estimate_seconds >= sum(made.trajectory.solve_seconds for made in others)


def test_an_engine_whose_library_gets_no_memory_is_not_accused() -> None:
    """The caller, who knows the limit, tells of the lack."""

    class Hungry(ReferenceEngine):
        def prepare(self, *_: Any) -> Any:
            raise ValueError("Error: engine error: Could not allocate memory")

    scene = run_24()
    with pytest.raises(MemoryError, match="Could not allocate memory"):
        run_once(Hungry(), scene, standard_start(scene), 0.01, 1e-3, ReferenceSettings())


def test_ladder_gets_past_an_unstable_step() -> None:
    result = run(engine=misbehaving("unstable"))
    # 0.1 turns to NaN; so does the coarser run of 0.05, whose estimate is therefore unknown; 0.025 has a good one.
    assert step_of(result) == pytest.approx(0.025)
    assert result.reached


@pytest.mark.parametrize(
    ("behaviour", "words"),
    [("nan", "strain_2 is no longer a finite number"), ("short", "500 rows"), ("raises", r"at fake_engine.py, line \d+: a bug")],
)
def test_wrong_trajectories_are_failures(behaviour: str, words: str) -> None:
    scene = run_24()
    with pytest.raises(EngineFailure, match=words):
        run_once(FakeEngine(), scene, standard_start(scene), DURATION, STEP, FakeSettings(behaviour=behaviour))


def test_values_that_are_no_numbers_end_the_kept_part() -> None:
    with pytest.raises(EngineFailure) as caught:
        run({"behaviour": "nan"})
    assert len(caught.value.partial) == 5
    assert caught.value.time == pytest.approx(4 * STEP)
    assert np.isfinite(caught.value.partial["strain_2"]).all()
