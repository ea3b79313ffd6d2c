"""Steady states found directly, as the report shows them."""

import dataclasses
import math

import pytest

from quickreturn.reports.tables.orbits import orbits
from tests.reports.pages import one_run, text_of
from tests.reports.plotted_results import with_run
from tests.reports.reported_results import reported_result
from tests.reports.test_report import both_starts, studies


def test_marching_is_told_from_the_largest_multiplier() -> None:
    table = orbits([reported_result("thesis-24"), reported_result("thesis-06")], ["exudyn"])
    values = {key: cell.value for key, cell in table.rows[0].items()}
    modulus = math.hypot(0.6, 0.48)
    assert values["multiplier"] == pytest.approx(modulus)
    assert modulus ** float(str(values["cycles_to_settled"])) == pytest.approx(1e-3)
    assert modulus ** float(str(values["cycles_to_gone"])) == pytest.approx(1e-6)
    assert values["cycles_of_work"] == 12
    assert values["exudyn_cycles"] == 12
    assert len(table.rows) == 2


def test_the_chapter_says_how_much_is_saved_or_that_nothing_is() -> None:
    # ln 1e-3 / ln 0.768 = 26.2 cycles against 12
    assert "Marching to 0.001 takes 2.2 times as many, to 10⁻⁶ 4.4 times." in text_of(one_run())
    marched = with_run(reported_result("thesis-24"), "reference", periodic_orbit=None)
    assert "every engine marched" in text_of(one_run(marched, studies=studies()))


@pytest.mark.parametrize(
    ("difference", "words"),
    [(1.3e-3, "(no more than the remaining change that both state)"), (1.5e-3, "(more than the remaining change that both state)")],
)
def test_both_starts_are_held_against_what_both_runs_say_is_left(difference: float, words: str) -> None:
    told = text_of(one_run(studies=dataclasses.replace(studies(), both_starts=[both_starts(difference)])))
    assert "exudyn in 4 and 25 cycles" in told
    assert words in told
