"""A campaign continues where it stopped: what was computed is not computed again, what was stopped from outside is.

The work is done by functions of the standard library, so that every worker can import them.
"""

import copy
import operator
import os
import signal
import time
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import cases.stored_jobs
from cases.store import Store
from cases.stored_jobs import Campaign, Result, Work, results, stored
from cases.workers import Job, Limits

CAMPAIGN = Campaign("trial", ())


def work(number: int, function: Any = copy.copy, arguments: tuple[Any, ...] | None = None) -> Work:
    return Work(("trial", f"{number}"), ("reference",), function, arguments or (({"value": number}, {"row": np.full(3, number)}),))


def found(store: Store, *wanted: Work, campaign: Campaign = CAMPAIGN) -> dict[str, Result]:
    return {name[1]: result for name, result in results(wanted, campaign, store, jobs=2).items()}


@pytest.fixture
def started(monkeypatch: pytest.MonkeyPatch) -> list[str]:
    """Names of the functions that workers were started for."""
    names: list[str] = []
    run_jobs = cases.stored_jobs.run_jobs

    def watched(jobs: list[Any], *arguments: Any, **options: Any) -> Any:
        names.extend(job.function.__name__ for job in jobs)
        return run_jobs(jobs, *arguments, **options)

    monkeypatch.setattr(cases.stored_jobs, "run_jobs", watched)
    return names


def test_only_what_is_missing_is_computed(tmp_path: Path, started: list[str]) -> None:
    store = Store(tmp_path)
    assert found(store, work(1))["1"][0] == {"value": 1}
    both = found(store, work(1), work(2))
    assert started == ["copy", "copy"]
    assert [both[name][0]["value"] for name in ("1", "2")] == [1, 2]
    assert np.array_equal(both["1"][1]["row"], np.full(3, 1))


def test_another_kind_of_campaign_shares_nothing(tmp_path: Path, started: list[str]) -> None:
    store = Store(tmp_path)
    found(store, work(1))
    found(store, work(1), campaign=Campaign("other", ()))
    found(store, work(1), campaign=Campaign("trial", ("cases.progress",)))
    assert len(started) == 3


def test_what_breaks_is_kept_and_takes_nothing_with_it(tmp_path: Path, started: list[str]) -> None:
    store = Store(tmp_path)
    for _ in range(2):
        result = found(store, work(1, operator.truediv, (1, 0)), work(2))
        assert result["1"] == ({"failure": "raised ZeroDivisionError: division by zero"}, {})
        assert result["2"][0] == {"value": 2}
    assert started == ["truediv", "copy"]


def test_what_was_stopped_from_outside_is_tried_again(tmp_path: Path, started: list[str], monkeypatch: pytest.MonkeyPatch) -> None:
    store = Store(tmp_path)
    monkeypatch.setattr(cases.stored_jobs, "default_limits", lambda: Limits(seconds=0.1))
    for _ in range(2):
        ((document, _),) = found(store, work(1, time.sleep, (60,))).values()
        assert document["failure"].startswith("stopped at the time limit")
    assert started == ["sleep", "sleep"]


@pytest.mark.parametrize(
    ("function", "arguments", "failure"),
    [
        (operator.mul, ("x", 2**62), "ran out of memory"),
        (os.rmdir, ("/nowhere",), "raised FileNotFoundError"),
        (os._exit, (7,), "ended without a result"),
        (signal.raise_signal, (int(signal.SIGSEGV),), "killed by SIGSEGV"),
    ],
)
def test_what_the_machine_lacked_or_what_died_is_tried_again(
    tmp_path: Path, started: list[str], function: Any, arguments: tuple[Any, ...], failure: str
) -> None:
    store = Store(tmp_path)
    for _ in range(2):
        ((document, _),) = found(store, work(1, function, arguments)).values()
        assert document["failure"].startswith(failure)
    assert len(started) == 2


def test_a_name_given_twice_is_refused(tmp_path: Path) -> None:
    with pytest.raises(ValueError, match="two results have one name"):
        results([work(1), work(1)], CAMPAIGN, Store(tmp_path), jobs=2)


def test_nothing_is_computed_unless_asked(tmp_path: Path, started: list[str]) -> None:
    assert results([work(1)], CAMPAIGN, Store(tmp_path), jobs=2, compute=False) == {}
    assert started == []


def test_what_cannot_be_stored_is_told_and_takes_nothing_with_it(tmp_path: Path) -> None:
    jobs = [Job("bad", copy.copy, (({"value": {1, 2}}, {}),)), Job("good", copy.copy, (({"value": 1}, {}),))]
    entries, others = stored(jobs, Store(tmp_path), "trials")
    assert [entry.document for entry in entries.values()] == [{"value": 1}]
    assert others["bad"].failure == "its result cannot be stored: Object of type set is not JSON serializable"


def test_equal_keys_are_computed_once_and_what_is_not_to_be_kept_is_not(tmp_path: Path, started: list[str]) -> None:
    jobs = [Job("same", copy.copy, (({"value": number}, {}),)) for number in (1, 2)]
    for _ in range(2):
        entries, others = stored(jobs, Store(tmp_path), "trials", keep=lambda _: None)
        assert entries == {}
        assert others["same"].value[0] == {"value": 1}
    assert started == ["copy", "copy"]
