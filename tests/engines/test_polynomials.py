"""A sound engine of another method conforms, and its errors are those that it states."""

import pytest

import quickreturn as qr
from tests.engines.polynomials import Ritz


@pytest.mark.verify
def test_the_errors_are_those_stated() -> None:
    known = qr.simulate("thesis-24", "reference", accuracy=1e-4)
    settings = ({"resolution": resolution, "tolerance": 1e-6} for resolution in Ritz.errors)
    measured = [qr.difference(qr.simulate("thesis-24", Ritz(), settings=each), known)["tip_deflection"] for each in settings]
    assert measured == pytest.approx(list(Ritz.errors.values()), rel=0.1)


@pytest.mark.verify
def test_it_conforms() -> None:
    outcome = qr.conform(Ritz())
    assert outcome.conforms, outcome.failed


@pytest.mark.verify
def test_it_agrees_with_reference() -> None:
    case = qr.case("thesis-24", duration=0.1)
    ours, known = qr.simulate(case, Ritz()), qr.simulate(case, "reference")
    assert qr.difference(ours, known)["tip_deflection"] < ours.estimates["tip_deflection"] + known.estimates["tip_deflection"]
