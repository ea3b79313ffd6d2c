"""Speed against error: fronts and orders of known points, and a real table on a short stretch of run 24."""

import dataclasses
import os
from collections.abc import Iterator, Sequence
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from quickreturn.cases.files.case import Case
from quickreturn.cases.files.case_file import load_case
from quickreturn.cases.running.job import Job, Limits, Outcome
from quickreturn.cases.running.processes import LocalProcesses
from quickreturn.cases.running.store import Store
from quickreturn.cases.running.workshop import Workshop
from quickreturn.engines.base import EngineFailure
from quickreturn.engines.registry import UnknownEngine
from quickreturn.plugins.methods.benchmark import SCENES, Benchmark, compiling, measure, measurement, stored
from quickreturn.plugins.methods.rivals import RIVALS
from quickreturn.plugins.methods.trials import truth
from quickreturn.plugins.methods.trials.methods import Method, methods
from quickreturn.plugins.methods.trials.queries import LEVELS, changing, fastest_at, observed_order, pareto_front, soonest_at
from quickreturn.plugins.methods.trials.trial import Trial, repeated
from tests.engines.fake_engine import FakeEngine, FakeSettings


def trial(seconds: float, error: float | None, engine: str = "a", free: int = 3) -> Trial:
    if error is None:
        return Trial(scene="one", engine=engine, status="failed")
    errors: dict[str, float | None] = {"tip_deflection": error}
    return Trial(scene="one", engine=engine, degrees_of_freedom=free, errors=errors, solve_seconds=seconds, setup_seconds=0.0)


def times_and_errors(trials: Sequence[Trial]) -> list[tuple[float, float | None]]:
    return [(each.seconds, each.error) for each in trials if each.completed]


def short(name: str = "thesis-24") -> Case:
    return dataclasses.replace(load_case(name), duration=0.05)


positive = st.floats(1e-6, 1e3)


@given(st.lists(st.tuples(positive, st.none() | positive), max_size=12))
def test_the_front_is_what_no_point_beats(values: list[tuple[float, float | None]]) -> None:
    trials = [trial(*value) for value in values]
    front = pareto_front(trials)
    done = times_and_errors(trials)
    of_front = times_and_errors(front)
    assert of_front == sorted(of_front)
    for seconds, error in done:
        beaten = any(s <= seconds and e <= error and (s, e) != (seconds, error) for s, e in done)
        assert beaten != ((seconds, error) in of_front)


def test_the_fastest_that_is_good_enough() -> None:
    trials = [trial(1.0, 0.1), trial(2.0, 0.01), trial(3.0, 0.001), trial(0.5, 0.009, "b"), trial(9.0, None, "c")]
    found = fastest_at(trials, 0.01)
    assert list(found) == ["b", "a"]
    assert found["a"].solve_seconds == 2.0
    assert fastest_at(trials, 1e-4) == {}


@given(st.floats(0.5, 6.0), st.floats(1e-3, 1e3))
def test_the_order_of_a_power_law(order: float, size: float) -> None:
    trials = [trial(1.0, size * free**-order, free=free) for free in (3, 5, 9, 17)]
    trials += [trial(1.0, 7.0 * size * free**-order, free=free) for free in (3, 5)]  # the same elements, a larger step
    assert observed_order(trials, "a") == pytest.approx(order, rel=1e-9)
    assert observed_order(trials, "b") is None
    assert observed_order(trials[:2], "a") is None


def test_the_worst_gauge_stands_for_strain() -> None:
    errors = {"strain_1": 0.1, "strain_2": 0.3, "strain_3": None}
    assert dataclasses.replace(trial(1.0, 0.1), errors=errors).error_of("strain") == 0.3
    assert trial(1.0, None).error_of("strain") is None


def test_every_rival_has_a_ladder_from_coarse_to_fine() -> None:
    case = load_case("thesis-24", {"crank.prescribed_speed": "16.6 rad/s"})  # which all of them take
    for method in methods(("reference", *RIVALS), case):
        free = [method.engine.describe(case.mechanism, settings).degrees_of_freedom for settings in method.ladder]
        assert len(free) >= 5, method.name
        assert free == sorted(free), method.name


def test_settings_that_a_ladder_changes() -> None:
    case = load_case("thesis-24")
    ladders = [[Trial(**plan.about) for plan in method.plans(case)] for method in methods(("exudyn", "stiff-spring"), case)]
    every = [each for ladder in ladders for each in ladder]
    assert set(changing(ladders[0][0], every)) == {"elements", "step", "extrapolated", "newton_tolerance"}
    assert set(changing(ladders[1][0], every)) == {"shapes", "stiffness", "damping", "tolerance"}
    assert changing(ladders[1][0], ladders[1][:1]) == ladders[1][0].settings  # one rung changes nothing


def test_of_repetitions_the_fastest_counts_and_a_failed_one_is_the_result() -> None:
    times = [dataclasses.replace(trial(seconds, 0.01), setup_seconds=setup) for seconds, setup in ((2.0, 0.3), (1.0, 0.5), (4.0, 0.4))]
    found = repeated(times)
    assert (found.solve_seconds, found.solve_seconds_median, found.solve_seconds_largest) == (1.0, 2.0, 4.0)
    assert (found.repetitions, found.setup_seconds) == (3, 0.3)
    assert repeated([*times, trial(1.0, None)]).status == "failed"


def test_scenes_are_in_the_library() -> None:
    assert [load_case(name).name for name in SCENES] == list(SCENES)


@pytest.fixture(scope="module")
def table() -> Benchmark:
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(truth, "CONFIRMING", {"mujoco": ({"links": "8"}, {"links": "16"})})
        return measurement.benchmark(short(), ("reference", "thesis"), repetitions=2)


def test_a_table_has_every_point_with_its_errors_and_times(table: Benchmark) -> None:
    ladder = methods(("reference",), short())[0].ladder
    reference = [p for p in table.trials if p.engine == "reference"]
    assert [p.settings for p in reference] == [settings.as_dict() for settings in ladder]
    for p in table.trials:
        assert p.status == "completed"
        assert p.repetitions == 2
        assert p.solve_seconds_median is not None
        assert p.solve_seconds_largest is not None
        assert 0.0 < p.seconds <= p.solve_seconds_median <= p.solve_seconds_largest
        assert set(p.errors) == set(table.truth.sizes)


def test_the_estimate_is_timed_of_each_methods_fastest_settings_to_an_error(table: Benchmark) -> None:
    best = {id(each) for level in LEVELS for each in fastest_at(table.trials, level).values()}
    assert best
    for each in table.trials:
        assert (each.estimate_seconds is not None) == (id(each) in best), each.settings
        if each.estimate_seconds is not None and each.waited_seconds is not None:
            assert each.estimate_seconds > 0.0
            assert each.waited_seconds > each.estimate_seconds + each.seconds


def test_who_is_done_first_is_told_by_all_that_one_waits_for() -> None:
    slow, quick, unknown = trial(1.0, 0.01), trial(2.0, 0.01, "b"), trial(0.5, 0.01, "c")
    slow = dataclasses.replace(slow, estimate_seconds=9.0)
    quick = dataclasses.replace(quick, estimate_seconds=1.0, setup_seconds=0.5)
    assert soonest_at([slow, quick, unknown], 0.01) == [("b", 3.5), ("a", 10.0)]


@pytest.mark.verify
def test_compiling_takes_longer_than_loading_what_was_compiled(tmp_path: Any) -> None:
    workshop = Workshop(Store(tmp_path))
    assert compiling(workshop.as_it_is, ("thesis", "exudyn")) == []
    (found,) = compiling(workshop, ("thesis", "exudyn"))  # exudyn compiles nothing
    assert found.engine == "thesis"
    assert 0.0 < 3.0 * found.load_seconds < found.compile_seconds
    assert compiling(workshop.as_it_is, ("thesis",)) == [found]


def test_errors_are_against_a_solution_that_another_engine_confirms(table: Benchmark) -> None:
    # 16 links are within 1e-3 over 2 s of run 24 (engines.mujoco.settings.LADDER); the first 0.05 s are no harder
    assert table.confirmation.settings["links"] == 16  # eight were not enough
    assert 0.0 < (table.confirmation.error or 0.0) < 2e-3
    errors = [p.error for p in table.trials if p.engine == "reference"]
    assert errors[0] is not None
    assert errors[-1] is not None
    assert errors[-1] < 1e-4 < errors[0]  # one mode, and the most of the ladder
    assert all((p.error or 0.0) > 0.05 for p in table.trials if p.engine == "thesis")  # one cubic


def test_calls_per_period_are_those_of_the_highest_mode_kept(table: Benchmark) -> None:
    done = table.trials
    assert all("calls_per_period" not in p.statistics for p in done if p.engine == "thesis")
    # one mode: 20.354 Hz with the slider farthest, published beside the mechanism's numbers
    first = next(p.statistics for p in done if p.engine == "reference")
    calls = first["right_hand_side_calls"]
    assert first["calls_per_period"] == pytest.approx(calls / (0.05 * 20.354), rel=1e-4)


def test_what_fails_is_listed_and_what_is_too_slow_is_not_tried_further(monkeypatch: pytest.MonkeyPatch) -> None:
    ladder = tuple(FakeSettings(step=step, behaviour=kind) for step, kind in ((0.1, "fails"), (0.1, "good"), (0.05, "good")))
    monkeypatch.setattr(measurement, "methods", lambda *_: [Method("fake", FakeEngine(), ladder)])
    monkeypatch.setattr(truth, "CONFIRMING", {"mujoco": ({"links": "4"},)})
    found = measurement.benchmark(short(), (), repetitions=2, longest=0.1).trials  # the fake engine claims 0.125 s
    assert found[0].status == "failed at t = 0.002 s: the beam snapped; try another beam"
    assert found[0].solve_seconds is None
    assert found[1].status == "completed"
    assert found[1].solve_seconds == 0.125
    assert found[2].status == "not tried: coarser settings took longer than 0.1 s"


def test_a_result_is_kept_for_its_scene_engines_and_code_alone(tmp_path: Any, monkeypatch: pytest.MonkeyPatch) -> None:
    workshop, case, affinity = Workshop(Store(tmp_path)), short(), os.sched_getaffinity(0)
    monkeypatch.setattr("quickreturn.plugins.methods.benchmark.scenes.pinned", _quick)
    monkeypatch.setattr("quickreturn.plugins.methods.benchmark.scenes.unsafe_engines", lambda *_: {})
    assert stored(case, workshop, ("thesis",)) is None
    made = measure(case, workshop, ("thesis",), 1)
    assert stored(case, workshop, ("thesis",)) == made
    assert stored(dataclasses.replace(case, duration=0.1), workshop, ("thesis",)) is None
    assert stored(case, workshop, ("thesis", "reference")) is None
    assert os.sched_getaffinity(0) == affinity  # only the worker is pinned


def test_a_truth_that_cannot_be_had_is_a_failure(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("quickreturn.plugins.methods.benchmark.scenes.pinned", _broken)
    monkeypatch.setattr("quickreturn.plugins.methods.benchmark.scenes.unsafe_engines", lambda *_: {})
    with pytest.raises(EngineFailure, match="the loop cannot close"):
        measure(short(), Workshop(Store()), ("thesis",), 1)
    with pytest.raises(UnknownEngine):
        measurement.benchmark(short(), ("nobody",), 1)


@pytest.mark.verify
def test_an_engine_that_dies_at_finer_settings_is_left_out(tmp_path: Any, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("quickreturn.plugins.methods.benchmark.scenes.pinned", _deadly)
    monkeypatch.setattr("quickreturn.plugins.methods.benchmark.scenes.unsafe_engines", lambda *_: {"mujoco": "killed by SIGSEGV"})
    case, names = short(), ("mujoco", "exudyn", "thesis", "reference")
    made = measure(case, Workshop(Store(tmp_path)), names, 1)
    assert made.failures == {
        "mujoco": "killed by SIGSEGV",
        "exudyn": "killed by SIGABRT, at finer settings",
        "thesis": "raised ZeroDivisionError: a bug, at finer settings",
    }
    assert stored(case, Workshop(Store(tmp_path)), names) is None


def test_who_is_at_work_is_announced(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    monkeypatch.setattr(os, "sched_setaffinity", lambda *_: None)
    monkeypatch.setattr(truth, "CONFIRMING", {"mujoco": ({"links": "4"},)})
    monkeypatch.setattr(truth, "TRUTH", ("thesis", {}))
    measurement.pinned(short(), ("thesis",), 1)
    assert measurement.last_at_work(capsys.readouterr().out)[0] == "thesis"
    assert measurement.last_at_work("something else") == (None, 0.0)


def overrun(monkeypatch: pytest.MonkeyPatch, since: float) -> list[tuple[str, ...]]:
    """Makes the first process of a benchmark end at its time limit of 3 s, `exudyn` at work `since` then (s); who was measured, in turn."""
    measured: list[tuple[str, ...]] = []

    def run(_: object, jobs: Sequence[Job[Any]], *__: object) -> Iterator[Outcome[Any]]:
        (job,) = jobs
        measured.append(job.arguments[1])
        if len(measured) > 1:
            yield Outcome(job, value=_quick(*job.arguments), seconds=1.0)
            return
        assert job.limits is not None
        failure = f"stopped at the time limit of {job.limits.seconds:g} s"
        yield Outcome(job, failure=failure, seconds=3.0, output=f"\nat work: 0.1 thesis\n\nat work: {since} exudyn\n")

    monkeypatch.setattr(LocalProcesses, "run", run)
    monkeypatch.setattr("quickreturn.plugins.methods.benchmark.scenes.unsafe_engines", lambda *_: {})
    return measured


def test_at_the_time_limit_who_took_longer_than_one_may_is_left_out(tmp_path: Any, monkeypatch: pytest.MonkeyPatch) -> None:
    measured = overrun(monkeypatch, since=1.9)
    made = measure(short(), Workshop(Store(tmp_path), LocalProcesses(limits=Limits(seconds=1.0))), ("exudyn", "thesis"), 1)
    assert made.failures == {"exudyn": "stopped at the time limit of 3 s, at finer settings"}
    assert measured == [("exudyn", "thesis"), ("thesis",)]


def test_at_the_time_limit_of_all_nobody_is_blamed_who_took_less(tmp_path: Any, monkeypatch: pytest.MonkeyPatch) -> None:
    measured = overrun(monkeypatch, since=2.1)
    with pytest.raises(EngineFailure, match="although no single engine exceeded its limit; try a longer --time-limit"):
        measure(short(), Workshop(Store(tmp_path), LocalProcesses(limits=Limits(seconds=1.0))), ("exudyn", "thesis"), 1)
    assert len(measured) == 1


def _deadly(case: Case, names: tuple[str, ...], repetitions: int) -> Benchmark:
    for name in names:
        print(f"\nat work: 0.0 {name}", flush=True)
        if name == "exudyn":
            os.abort()
        if name == "thesis":
            raise ZeroDivisionError("a bug")
    return _quick(case, names, repetitions)


def _quick(case: Case, names: tuple[str, ...], repetitions: int) -> Benchmark:
    sizes = dict.fromkeys(("tip_deflection",), float(np.float64(1.0)))
    none, confirmation = truth.Truth("none", {}, sizes), Trial(scene=case.name, engine="none", status="no")
    return Benchmark(case.name, case.title, case.duration, none, confirmation, (), repetitions, 10.0, {})


def _broken(case: Case, names: tuple[str, ...], repetitions: int) -> Benchmark:
    raise EngineFailure(0.1, "the loop cannot close any more", "check the scene")
