"""`conform` finds what an engine keeps of an earlier scene, and accuses no engine of the last digits."""

import dataclasses
from collections.abc import Callable
from typing import Any

import pytest

from quickreturn.cases.conformance import conform
from quickreturn.cases.conformance.bench import Bench
from quickreturn.cases.conformance.repetition import ALONE as SCENES_ALONE
from quickreturn.cases.conformance.repetition import IN_TURN, PARTS, OtherProcesses, columns_of, elsewhere, repetition
from quickreturn.engines.own.reference import ReferenceEngine
from tests.cases.conformance.third_mutants import BuiltForAFollower, Keeps, KeepsCrank, KeepsFollower, KeepsTip, Threaded


@pytest.mark.parametrize(("part", "status"), [(0.01, "passed"), (0.1, "failed")])
def test_last_digits_may_differ(part: float, status: str) -> None:
    """By a part of the engine's own error; here in the force, by some millionths of it."""
    bench = Bench(ReferenceEngine())
    errors, found = bench.estimates(dataclasses.replace(bench.mild, duration=0.1)), columns_of(bench.engine, IN_TURN)
    assert errors is not None
    first = found["the mild scene"]
    other = first | {"slider_force": first["slider_force"] + part * errors["slider_force"]}
    alone = {"the mild scene": first, "in another process": other} | {name: found[name] for name in PARTS}
    checks = {check.check: check.status for check in repetition(bench, OtherProcesses(found, alone))}
    assert checks.pop("the same from another process") == status
    assert set(checks.values()) == {"passed"}


@pytest.mark.verify
def test_threads_may_add_in_another_order(monkeypatch: pytest.MonkeyPatch) -> None:
    """Compared are processes that have one thread each, not the caller, who may have many."""
    monkeypatch.delenv("OPENBLAS_NUM_THREADS")
    other = elsewhere(Threaded())
    assert not other.reason
    assert all(check.status == "passed" for check in repetition(Bench(Threaded()), other))


def in_this_process(kind: type[Keeps]) -> OtherProcesses:
    """What `elsewhere` finds in other processes, each of which begins with nothing kept."""

    def begun_anew(name: str) -> dict[str, Any]:
        kind.kept.clear()
        return columns_of(kind(), (name,))[name]

    kind.kept.clear()
    in_turn = columns_of(kind(), IN_TURN)
    return OtherProcesses(in_turn, {name: begun_anew(name) for name in SCENES_ALONE})


@pytest.mark.parametrize("results", [in_this_process, pytest.param(lambda kind: elsewhere(kind()), marks=pytest.mark.verify)])
@pytest.mark.parametrize(("kind", "part"), [(KeepsCrank, "crank"), (KeepsTip, "tip"), (KeepsFollower, "follower")])
def test_a_part_kept_of_an_earlier_scene_is_named(kind: type[Keeps], part: str, results: Callable[[type[Keeps]], OtherProcesses]) -> None:
    failed = [check for check in repetition(Bench(kind()), results(kind)) if check.status == "failed"]
    assert [check.check for check in failed] == [f"nothing kept of an earlier {part}"]
    assert f"the {part} of an earlier scene is kept" in failed[0].cause


@pytest.mark.verify
def test_a_model_that_is_kept_until_the_follower_is_another_one_is_found() -> None:
    failed = [check for check in repetition(Bench(BuiltForAFollower()), elsewhere(BuiltForAFollower())) if check.status == "failed"]
    assert {check.check.rsplit(" ", 1)[1] for check in failed} == {"crank", "tip"}


def test_a_class_that_no_other_process_can_import_is_not_accused() -> None:
    found = conform(type("Local", (ReferenceEngine,), {})(), groups=("repetition",))
    assert found.conforms
    (check,) = [check for check in found.checks if check.check == "the same from another process"]
    assert check.status == "not judged"
    assert "entry point" in check.advice
