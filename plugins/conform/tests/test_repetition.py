"""`conform` finds what an engine keeps of an earlier scene, and accuses no engine of the last digits."""

import dataclasses
from collections.abc import Callable
from typing import Any

import pytest

from quickreturn.engines.own.reference import ReferenceEngine
from quickreturn.plugins.conform.bench import Bench
from quickreturn.plugins.conform.contract import ALONE, IN_TURN, PARTS, Results, columns_of, conform, elsewhere, repetition
from quickreturn.plugins.conform.tests.keepers import BuiltForAFollower, Keeps, KeepsCrank, KeepsFollower, KeepsTip, Threaded

Elsewhere = tuple[Results, Results] | str


def failed(kind: type[Keeps] | type[BuiltForAFollower], other: Elsewhere) -> list[str]:
    return [check.check for check in repetition(Bench(kind()), other) if check.status == "failed"]


@pytest.mark.parametrize(("part", "status"), [(0.01, "passed"), (0.1, "failed")])
def test_last_digits_may_differ(part: float, status: str) -> None:
    """By a part of the engine's own error; here in the force, by some millionths of it."""
    bench = Bench(ReferenceEngine())
    errors, found = bench.estimates(dataclasses.replace(bench.mild, duration=0.1)), columns_of(bench.engine, IN_TURN)
    assert errors is not None
    other = dict(found["first"]) | {"slider_force": found["first"]["slider_force"] + part * errors["slider_force"]}
    checks = {check.check: check.status for check in repetition(bench, (found, {**found, "in another process": other}))}
    assert checks.pop("the same in another process") == status
    assert set(checks.values()) == {"passed"}


@pytest.mark.verify
def test_threads_may_add_in_another_order(monkeypatch: pytest.MonkeyPatch) -> None:
    """Compared are processes that have one thread each, not the caller, who may have many."""
    monkeypatch.delenv("OPENBLAS_NUM_THREADS")
    assert all(check.status == "passed" for check in repetition(Bench(Threaded()), elsewhere(Threaded())))


def in_this_process(kind: type[Keeps]) -> Elsewhere:
    """What `elsewhere` finds in other processes, each of which begins with nothing kept."""

    def begun_anew(name: str) -> Any:
        kind.kept.clear()
        return columns_of(kind(), (name,))[name]

    kind.kept.clear()
    in_turn = columns_of(kind(), IN_TURN)
    return in_turn, {name: begun_anew(name) for name in ALONE}


@pytest.mark.parametrize("results", [in_this_process, pytest.param(lambda kind: elsewhere(kind()), marks=pytest.mark.verify)])
@pytest.mark.parametrize(("kind", "part"), [(KeepsCrank, "crank"), (KeepsTip, "tip"), (KeepsFollower, "follower")])
def test_a_part_kept_of_an_earlier_scene_is_found(kind: type[Keeps], part: str, results: Callable[[type[Keeps]], Elsewhere]) -> None:
    assert failed(kind, results(kind)) == [f"nothing kept of an earlier {part}"]


@pytest.mark.verify
def test_a_model_that_is_kept_until_the_follower_is_another_one_is_found() -> None:
    found = failed(BuiltForAFollower, elsewhere(BuiltForAFollower()))
    assert found == [f"nothing kept of an earlier {part}" for part in PARTS if part != "follower"]


def test_a_class_that_no_other_process_can_import_is_not_accused() -> None:
    found = conform(type("Local", (ReferenceEngine,), {})(), groups=("repetition",))
    assert found.conforms
    (check,) = [check for check in found.checks if check.check == "the same in other processes"]
    assert check.status == "not judged"
    assert "entry point" in check.advice
