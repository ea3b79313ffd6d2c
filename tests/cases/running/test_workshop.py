"""A campaign continues where it stopped: what was computed is not computed again, what was stopped from outside is.

The work is done by functions of the standard library, so that every worker can import them.
"""

import copy
import operator
import signal
import time
from collections.abc import Callable, Generator, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from quickreturn.cases.library import load_case
from quickreturn.cases.motion.request import RunRequest
from quickreturn.cases.motion.solving import TrajectoryRequest
from quickreturn.cases.motion.steady_state import steady_state
from quickreturn.cases.running.isolation import LocalProcesses
from quickreturn.cases.running.job import Job, Limits, Outcome, ThisProcess, V, Watch
from quickreturn.cases.running.store import Record, Store
from quickreturn.cases.running.workshop import Workshop
from tests.engines.fake_package import FAKE_ENGINE, install


class Watched(LocalProcesses):
    """Notes the names of the jobs that it was given."""

    def __init__(self, limits: Limits | None = None) -> None:
        super().__init__(2, limits)
        self.started: list[str] = []

    def run(self, jobs: Sequence[Job[V]], watch: Watch | None = None) -> Generator[Outcome[V], None, None]:
        self.started += [job.name for job in jobs]
        return super().run(jobs, watch)


def job(number: int, function: Any = copy.copy, arguments: tuple[Any, ...] | None = None, **changes: Any) -> Job[Any]:
    value = {"value": number, "row": np.full(3, number)}
    return Job(f"{number}", function, arguments or (value,), **({"kind": "trial"} | changes))


@pytest.fixture
def executor() -> Watched:
    return Watched()


@pytest.fixture
def workshop(tmp_path: Path, executor: Watched) -> Workshop:
    return Workshop(Store(tmp_path), executor)


def test_only_what_is_missing_is_computed(workshop: Workshop, executor: Watched) -> None:
    (first,) = workshop.outcomes([job(1)], "trials")
    both = workshop.outcomes([job(2), job(1)], "trials")
    assert executor.started == ["1", "2"]
    assert [outcome.job.name for outcome in both] == ["2", "1"]
    assert [outcome.value["value"] for outcome in both] == [2, 1]
    for outcome in (first, both[1]):
        assert np.array_equal(outcome.value["row"], np.full(3, 1))


def test_what_breaks_is_kept_and_takes_nothing_with_it(workshop: Workshop, executor: Watched) -> None:
    for _ in range(2):
        broken, good = workshop.outcomes([job(1, operator.truediv, (1, 0)), job(2)], "trials")
        assert (broken.value, broken.failure) == (None, "raised ZeroDivisionError: division by zero")
        assert good.value["value"] == 2
    assert executor.started == ["1", "2"]


@pytest.mark.parametrize(
    ("function", "arguments", "failure"),
    [
        (time.sleep, (60,), "stopped at the time limit"),
        (operator.mul, ("x", 2**62), "ran out of memory"),
        (__import__, ("no_such_library",), "raised ModuleNotFoundError"),
        (signal.raise_signal, (int(signal.SIGSEGV),), "killed by SIGSEGV"),
    ],
)
def test_what_the_machine_did_or_lacked_is_tried_again(tmp_path: Path, function: Any, arguments: tuple[Any, ...], failure: str) -> None:
    executor = Watched(Limits(seconds=0.3 if function is time.sleep else 60.0, memory=2**30))
    for _ in range(2):
        (outcome,) = Workshop(Store(tmp_path), executor).outcomes([job(1, function, arguments)], "trials")
        assert outcome.failure.startswith(failure)
    assert executor.started == ["1", "1"]


def test_what_cannot_be_stored_is_told_and_takes_nothing_with_it(workshop: Workshop) -> None:
    bad, good = workshop.outcomes([job(1, arguments=({"value": {1, 2}},), inputs="bad"), job(2)], "trials")
    assert good.value["value"] == 2
    assert bad.failure == "its result cannot be stored: Object of type set is not JSON serializable"


def test_equal_jobs_are_computed_once(workshop: Workshop, executor: Watched) -> None:
    outcomes = workshop.outcomes([job(number, inputs="the same") for number in (1, 2)], "trials")
    assert [outcome.value["value"] for outcome in outcomes] == [1, 1]
    assert [outcome.job.name for outcome in outcomes] == ["1", "2"]
    assert executor.started == ["1"]


def test_an_entry_that_was_made_of_something_else_is_computed_anew_with_a_notice(workshop: Workshop, executor: Watched) -> None:
    workshop.outcomes([job(1)], "trials")
    (file,) = workshop.store.folder.glob("*.result")
    workshop.store.put(file.stem, Record({"nothing": "of the kind"}))
    (outcome,) = workshop.outcomes([job(1)], "trials")
    assert outcome.value["value"] == 1
    assert executor.started == ["1", "1"]
    assert "it is computed anew" in workshop.store.notices[0]


SCENE = load_case("thesis-24").mechanism
#: The fake engine, whose method `WHERE` raises `ERROR` in the first call.
LACKING = """
class Lacking(FakeEngine):
    name = "lacking"
    calls = 0

    def prepare(self, *arguments):
        type(self).calls += 1
        if WHERE == "prepare" and self.calls == 1:
            ERROR
        simulation = super().prepare(*arguments)
        advance = simulation.advance

        def first(*arguments):
            if WHERE == "advance" and self.calls == 1:
                ERROR
            return advance(*arguments)

        simulation.advance = first
        return simulation
"""


def trajectory() -> Job[Any]:
    return TrajectoryRequest(scene=SCENE, duration=0.1, output_step=0.01, engine="lacking", estimate=False).job("lacking")


def run() -> Job[Any]:
    request = RunRequest(mechanism=SCENE, duration=1.0, engine="lacking", settings={"step": "0.1"}, estimated=False, turn=1)
    return Job("lacking", steady_state, (request,), "steady state", ("lacking",))


@pytest.mark.parametrize(
    ("asked", "where", "error"),
    [(trajectory, "prepare", "MemoryError"), (run, "advance", "OSError"), (run, "prepare", "import no_such_library")],
)
def test_the_next_attempt_begins_anew(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, asked: Callable[[], Job[Any]], where: str, error: str
) -> None:
    statement = error if error.startswith("import") else f"raise {error}('libGL.so.1 is missing')"
    module = f"lacking_{where}_{asked.__name__}_{error.replace(' ', '_')}"
    source = FAKE_ENGINE + LACKING.replace("WHERE", repr(where)).replace("ERROR", statement)
    install(tmp_path / "packages", "lacking", {module: source}, {"lacking": f"{module}:Lacking"})
    monkeypatch.syspath_prepend(tmp_path / "packages")
    workshop = Workshop(Store(tmp_path), ThisProcess())
    (first,) = workshop.outcomes([asked()], "attempts")
    assert first.failure.startswith("raised ")
    assert not [*tmp_path.glob("*.result")]
    (second,) = workshop.outcomes([asked()], "attempts")
    assert second.completed, second.explanation
