"""Accuracy and cost: the errors that the heading gives, warnings, and steady states that were found directly."""

import dataclasses
import math

import pytest

from quickreturn.plugins.methods.chapters.accuracy import finding, orbits
from quickreturn.plugins.methods.tests.made_up_studies import made_up_studies
from quickreturn.plugins.methods.tests.pages import finding_of, one_run, plain, text_of
from tests.reports.plotted_results import with_run
from tests.reports.reported_results import reported_result


def test_the_heading_gives_the_errors_or_else_the_work_of_the_search() -> None:
    assert plain(finding({"thesis": 0.123, "reference": 0.00042}, 12.0)).endswith(" 12 % (thesis), 0.042 % (reference)")
    assert finding({}, None) == ""
    assert finding_of(one_run(studies=made_up_studies()), "accuracy").endswith(" 0.1 % (thesis), 0.1 % (reference)")
    assert finding_of(one_run(), "accuracy").endswith(" 12 cycles")


def test_a_solution_that_no_second_engine_confirms_is_a_warning() -> None:
    known = made_up_studies()
    close, off = ([dataclasses.replace(run, errors={"tip_deflection": error}) for run in known.confirming] for error in (1e-4, 0.02))
    for confirming, warned in ((close, (False, False)), (off, (True, False)), ([], (False, True))):
        told = text_of(one_run(studies=dataclasses.replace(known, confirming=confirming)))
        assert ("do not confirm each other" in told, "No second engine confirms" in told) == warned


def test_marching_follows_from_the_largest_multiplier() -> None:
    table = orbits([reported_result("thesis-24"), reported_result("thesis-06")], ["exudyn"])
    values = {key: cell.value for key, cell in table.rows[0].items()}
    modulus = math.hypot(0.6, 0.48)
    assert values["multiplier"] == pytest.approx(modulus)
    assert modulus ** float(str(values["cycles_to_settled"])) == pytest.approx(1e-3)
    assert modulus ** float(str(values["cycles_to_gone"])) == pytest.approx(1e-6)
    assert values["cycles_of_work"] == 12
    assert values["exudyn_cycles"] == 12
    assert len(table.rows) == 2
    marched = with_run(reported_result("thesis-24"), "reference", periodic_orbit=None)
    assert "every engine marched" in text_of(one_run(marched, studies=made_up_studies()))
