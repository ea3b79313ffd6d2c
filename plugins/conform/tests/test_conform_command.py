"""`quickreturn conform`."""

import json
from pathlib import Path

import pytest

from quickreturn.cases.running.store import Store
from quickreturn.cases.running.workshop import Workshop
from quickreturn.plugins.conform.contract import job
from tests.engines.fake_package import FAKE_ENGINE, install
from tests.quickreturn.conftest import Call

#: The fake engine without a trajectory; to say that one's motion is made up takes twenty seconds.
BROKEN = (
    FAKE_ENGINE
    + """

class BrokenEngine(FakeEngine):
    name = "broken"

    def prepare(self, mechanism, start, settings):
        raise EngineFailure(0.0, "the licence server does not answer", "ask again tomorrow")
"""
)


@pytest.mark.parametrize("quick", [True, pytest.param(False, marks=pytest.mark.verify)])
def test_an_engine_without_a_trajectory_does_not_conform(call: Call, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, quick: bool) -> None:
    """The report finds the outcome, but for that of a quick trial."""
    install(tmp_path / "more", "breaks", {"broken_engine": BROKEN}, {"broken": "broken_engine:BrokenEngine"})
    monkeypatch.syspath_prepend(tmp_path / "more")
    answer = call("conform", "broken", "--json", *(["--quick"] if quick else []))
    assert answer.code == 1
    document = json.loads(answer.output)
    assert (document["engine"], document["conforms"]) == ("broken", False)
    assert {"check", "status", "cause", "advice"} == set(document["checks"][0])
    assert "ask again tomorrow" in {check["advice"] for check in document["checks"]}
    failed = {check["check"]: check["cause"] for check in document["checks"] if check["status"] == "failed"}
    assert "the licence server does not answer" in failed["a trajectory"]
    kept = Workshop(Store()).stored(job("broken"))
    assert (kept is None) is quick
    if kept is not None:
        assert kept.value is not None
        assert kept.value.verdict == f"does not conform: {len(failed)} checks failed"


@pytest.mark.verify
def test_an_engine_whose_motion_is_made_up_does_not_conform(call: Call) -> None:
    answer = call("conform", "fake", "--json")
    assert answer.code == 1
    failed = {check["check"] for check in json.loads(answer.output)["checks"] if check["status"] == "failed"}
    assert {"columns together", "frequencies"} <= failed


def test_an_engine_that_is_not_there_is_bad_input(call: Call) -> None:
    answer = call("conform", "refrence")
    assert answer.code == 2
    assert "refrence" in answer.errors
    assert "reference" in answer.errors
