"""`quickreturn conform`."""

import json

from cases.conformance import job
from cases.jobs.store import Store
from cases.jobs.workshop import Workshop
from tests.quickreturn.conftest import Call


def test_an_engine_whose_motion_is_made_up_does_not_conform(call: Call) -> None:
    answer = call("conform", "fake", "--json")
    assert answer.code == 1
    document = json.loads(answer.output)
    assert document["engine"] == "fake"
    assert document["conforms"] is False
    assert {"check", "status", "cause", "advice"} == set(document["checks"][0])
    failed = {check["check"] for check in document["checks"] if check["status"] == "failed"}
    assert any("tip_deflection" in check for check in failed)
    kept = Workshop(Store()).stored(job("fake"))  # where the report finds it
    assert kept is not None
    assert kept.value is not None
    assert kept.value.verdict == f"does not conform: {len(failed)} checks failed"


def test_an_engine_that_is_not_there_is_bad_input(call: Call) -> None:
    answer = call("conform", "refrence")
    assert answer.code == 2
    assert "refrence" in answer.errors
    assert "reference" in answer.errors
