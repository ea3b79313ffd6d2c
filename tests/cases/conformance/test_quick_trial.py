"""A trial of limited time compares the motion first and says what it leaves out."""

import time

import pytest

from quickreturn.cases import conformance
from quickreturn.cases.conformance import conform, trial
from quickreturn.engines.own.reference import ReferenceEngine
from tests.cases.conformance.third_mutants import Slow

#: Time of a quick trial in which the slow engine makes a few runs, and what may be compiled or loaded besides, s.
SHORT = 4.0
TO_COMPILE = 60.0


def test_an_exception_in_the_first_check_is_told() -> None:
    (check,) = trial("motion", ("motion",), type("Raising", (ReferenceEngine,), {"check": lambda self, mechanism: 1 / 0})())["motion"]
    assert check.status == "failed"
    assert "ZeroDivisionError" in check.cause


@pytest.mark.verify
def test_a_quick_trial_says_what_it_left_out(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(conformance, "QUICK", SHORT)
    began = time.monotonic()
    found = conform(Slow(), groups=("motion", "quantities"), quick=True, quiet=True)
    assert time.monotonic() - began < 3.0 * SHORT + TO_COMPILE
    assert {check.status for check in found.checks} <= {"passed", "not judged"}
    assert found.left_out
    assert f"{len(found.left_out)} checks are left out" in found.verdict
    assert all(check.cause and check.advice for check in found.checks if check.left_out)


def test_a_quick_trial_compares_the_motion_first(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(conformance, "QUICK", 300.0)
    found = conform(ReferenceEngine(), groups=("motion", "resolution"), quick=True, quiet=True)
    assert found.conforms
    assert found.left_out == ("resolution",)
    names = [check.check for check in found.checks]
    assert names[0].startswith("column ")
    assert names.index("column tip_deflection") < names.index("pieces continue") < names.index("the same with another output step")


def test_a_quick_trial_without_time_for_the_motion_is_not_judged(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(conformance, "QUICK", 1e-3)
    assert conform(Slow(), groups=("motion", "resolution"), quick=True, quiet=True).conforms is None
