"""What `run` says of engines that agree, depart, cannot be judged or refuse: exit codes, JSON and terminal.

The engines are made up (`tests.engines.faulty_engines`), so that what they are off by is known.
"""

import json
from pathlib import Path
from typing import Any

import pytest

from tests.engines.faulty_engines import install_faulty_engines
from tests.quickreturn.conftest import Answer, Call
from tests.quickreturn.scene_file import SCENE

HEAVY = ("--set", "slider.mass=1 kg")  # which the made-up engines refuse, all but one


@pytest.fixture(scope="module")
def store(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The same engines run in most of these tests: each once is enough."""
    return tmp_path_factory.mktemp("store")


@pytest.fixture(autouse=True)
def _place(tmp_path: Path, call: Call, store: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("QUICKRETURN_STORE", str(store))
    install_faulty_engines(tmp_path)
    (tmp_path / "small.toml").write_text(SCENE)


def run(call: Call, *names: str, more: tuple[str, ...] = ()) -> tuple[Answer, dict[str, Any]]:
    """The answer in words, and the case of the JSON document, which must go with the same exit code and messages."""
    arguments = ("run", "small.toml", *(word for name in names for word in ("--engine", name)), *more)
    answer, document = call(*arguments), call(*arguments, "--json")
    assert (answer.code, answer.errors) == (document.code, document.errors)
    (case,) = json.loads(document.output)["cases"]
    return answer, case


def test_engines_that_are_right_agree(call: Call) -> None:
    answer, case = run(call, "sound", "also-sound")
    assert (answer.code, case["passed"], case["reason"]) == (0, True, "")
    assert len(case["checks"]) >= 4
    assert case["agreement"] == {"agree": len(case["checks"]), "disagree": 0, "says_nothing": 0}
    assert "also-sound: within what is claimed of sound in all" in answer.output
    for engine in case["engines"]:
        assert (engine["start"], engine["accuracy_class"], engine["unestimated"]) == ("periodic orbit of reference", "0.1 %", "")


def test_an_engine_that_claims_too_much_departs(call: Call) -> None:
    answer, case = run(call, "sound", "overclaims")
    assert (answer.code, case["passed"]) == (1, False)
    assert case["reason"] == "overclaims and sound disagree by more than they claim"
    missed = [check for check in case["checks"] if not check["passed"]]
    assert {(check["engine"], check["other"], check["channel"]) for check in missed} == {("overclaims", "sound", "strain_1")}
    for check in missed:
        assert abs(check["difference"]) > check["tolerance"]
        parts = ("estimate", "other_estimate", "uncertainty", "other_uncertainty")
        assert check["tolerance"] == pytest.approx(sum(check[part] for part in parts))
    assert case["agreement"]["disagree"] == len(missed)
    # pair, quantity, by how much, and what both claim
    line = next(line for line in answer.output.splitlines() if "maximum, post-return, strain_1" in line)
    assert "differ by 5e-05" in line
    assert "overclaims and sound allow 8e-07" in line
    assert "      sound: 4.0e-7 by resolution: step 0.2 against 0.4 (0.333 times their difference of 1.2e-6)" in answer.output
    assert answer.errors == ""


@pytest.mark.parametrize(
    ("engines", "code", "passed", "words"),
    [
        (("sound",), 0, None, "one engine alone"),
        (("sound", "returns-nan"), 3, None, "returns-nan: failed"),
        (("sound", "returns-nan", "also-sound"), 3, False, "returns-nan did not deliver: failed"),
        pytest.param(("sound", "own-equations"), 0, None, "own-equations: its estimate covers the integration", marks=pytest.mark.verify),
    ],
)
def test_what_is_not_judged_is_no_success_and_says_why(
    call: Call, engines: tuple[str, ...], code: int, passed: bool | None, words: str
) -> None:
    answer, case = run(call, *engines)
    assert (answer.code, case["passed"]) == (code, passed)
    assert words in case["reason"]
    assert all(check["passed"] for check in case["checks"])
    assert (f"not judged: {case['reason']}" in answer.output) is (passed is None)
    for own in (engine for engine in case["engines"] if engine["engine"] == "own-equations"):
        assert (own["estimate_of"], own["accuracy_class"], own["unestimated"] != "") == ("integration", None, True)


def test_an_engine_asked_for_by_name_that_refuses_costs_the_others_nothing(call: Call) -> None:
    answer, case = run(call, "sound", "carries", more=HEAVY)
    assert answer.code == 2
    assert answer.errors == "quickreturn: small: engine sound: slider.mass: engine fake models a massless slider only\n"
    found = {engine["engine"]: engine for engine in case["engines"]}
    assert (found["sound"]["status"], found["sound"]["remark"]) == ("refused", "slider.mass: engine fake models a massless slider only")
    assert found["carries"]["status"] == "settled"
    assert len(found["carries"]["measures"]) == 8
    assert (case["passed"], "sound: refused" in case["reason"]) == (None, True)
