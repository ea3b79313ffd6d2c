"""Cost of a steady state: the work of the search, and what marching takes."""

import math

import pytest

from quickreturn.plugins.methods.chapters.accuracy import finding, orbits
from quickreturn.plugins.methods.tests.pages import finding_of, one_run, read
from tests.reports.plotted_results import with_run
from tests.reports.reported_results import reported_result


def test_the_heading_gives_the_work_of_the_search() -> None:
    assert finding(None) == ""
    assert finding_of(one_run(), "accuracy").endswith(" 12 cycles")


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
    assert "accuracy" not in read(one_run(marched)).anchors
