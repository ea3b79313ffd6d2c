"""The ledger of the long tests notices a change of what a test imports, and of nothing else."""

import dataclasses
import os
import subprocess
import sys
from pathlib import Path
from typing import Literal

import pytest

from quickreturn.cases.running.store import VARIABLE
from tests.ledger import FILE, ROOT, Entry, Ledger, code_of, read, status, write
from tests.slices import UNREACHED

FILES = {
    "tests/__init__.py": "",
    "tests/test_value.py": "from tests.helper import value\ndef test_value(): assert value() == 1\n",
    "tests/helper.py": "def value():\n    from tests.constants import ONE\n    return ONE\n",
    "tests/constants.py": "ONE = 1\n",
    "tests/other.py": "",
}
TEST = "tests/test_value.py::test_value"
Outcome = Literal["passed", "failed", "skipped"]
GOOD = Entry(TEST, "abc", "1", 60.0, "passed")


@pytest.fixture
def checkout(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    for name, text in FILES.items():
        (tmp_path / name).parent.mkdir(exist_ok=True)
        (tmp_path / name).write_text(text)
    monkeypatch.setenv(VARIABLE, str(tmp_path / "store"))
    return tmp_path


def test_a_change_of_what_a_test_imports_is_noticed_and_no_other(checkout: Path) -> None:
    def code() -> str:
        return code_of("tests/test_value.py", checkout)

    first = code()
    (checkout / "tests/other.py").write_text("TWO = 2\n")
    assert code() == first
    for name in ("tests/constants.py", "tests/helper.py", "tests/test_value.py"):
        before = code()
        (checkout / name).write_text((checkout / name).read_text() + "# changed\n")
        assert code() != before


def test_what_should_run_again_is_listed_with_the_reason() -> None:
    outcomes = {"a::one": GOOD, "a::two": GOOD, "b::one": GOOD, "c::one": dataclasses.replace(GOOD, outcome="failed")}
    assert status(outcomes, [*outcomes, "b::two", "b::three"], lambda file: "2" if file == "b" else "1") == [
        "b: 1 ran at abc, with other code; 2 never ran",
        "c: 1 failed at abc",
        "2 of 6 long tests passed with the code as it is",
    ]


def reported(ledger: Ledger, when: Literal["setup", "call", "teardown"], outcome: Outcome, why: str = "") -> None:
    ledger.pytest_runtest_logreport(pytest.TestReport(TEST, ("", 0, ""), {}, outcome, why or None, when, duration=1.5))


@pytest.mark.parametrize(
    ("setup", "call", "teardown", "outcome"),
    [
        ("passed", "passed", "passed", "passed"),
        ("passed", "failed", "passed", "failed"),
        ("passed", "passed", "failed", "failed"),
        ("skipped", None, "passed", "skipped"),
        ("failed", None, "passed", "failed"),
    ],
)
def test_a_test_that_ran_is_entered_beside_those_that_ran_before(
    checkout: Path, setup: Outcome, call: Outcome | None, teardown: Outcome, outcome: str
) -> None:
    place = checkout / "store" / FILE
    place.parent.mkdir()
    write([GOOD, dataclasses.replace(GOOD, test="tests/test_other.py::test")], place)
    ledger = Ledger(UNREACHED, checkout)
    reported(ledger, "setup", setup)
    if call:
        reported(ledger, "call", call)
    before = code_of("tests/test_value.py", checkout)
    (checkout / "tests/constants.py").write_text("ONE = 2\n")
    reported(ledger, "teardown", teardown)
    ledger.pytest_sessionfinish()
    entries = read(place)
    assert set(entries) == {TEST, "tests/test_other.py::test"}
    assert entries[TEST] == Entry(TEST, "", before, 4.5 if call else 3.0, outcome), "with the code that it began with"


def test_a_test_that_was_not_begun_is_not_entered(checkout: Path) -> None:
    ledger = Ledger(UNREACHED, checkout)
    reported(ledger, "setup", "skipped", f"Skipped: {UNREACHED}")
    ledger.pytest_sessionfinish()
    assert not (checkout / "store" / FILE).exists()


@pytest.mark.verify
def test_long_tests_are_entered_and_their_status_is_told(tmp_path: Path) -> None:
    def told(*options: str) -> str:
        command = [sys.executable, "-m", "pytest", "-p", "no:cacheprovider", "-q", "-m", "verify", "tests/test_slices.py", *options]
        environment = os.environ | {VARIABLE: str(tmp_path)}
        return subprocess.run(command, cwd=ROOT, env=environment, capture_output=True, text=True, check=True).stdout

    assert "tests/test_slices.py: 2 never ran\n0 of 2 long tests" in told("--ledger-status")
    told()
    assert "2 of 2 long tests passed with the code as it is" in told("--ledger-status")
