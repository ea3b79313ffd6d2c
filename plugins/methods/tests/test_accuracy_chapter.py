"""Accuracy and cost: the errors that the heading gives, and steady states that were found directly."""

import dataclasses
import math

import pytest

from quickreturn.plugins.methods.chapters.accuracy import (
    both_starts_words,
    confirming_words,
    finding,
    orbits,
    prescribed_words,
    saved_words,
)
from quickreturn.plugins.methods.tests.made_up_studies import made_up_both_starts, made_up_studies
from quickreturn.plugins.methods.tests.pages import finding_of, one_run, plain, text_of
from quickreturn.plugins.methods.trials.trial import Trial
from quickreturn.plugins.methods.trials.truth import Truth
from tests.reports.plotted_results import with_run
from tests.reports.reported_results import reported_result


def test_the_heading_gives_the_errors_or_else_the_work_of_the_search() -> None:
    errors = {"thesis": 0.123, "reference": 0.00042}
    assert plain(finding(errors, 12.0)) == "At default accuracy run 24’s tip deflection is off by 12 % (thesis), 0.042 % (reference)"
    assert finding({}, 12.34) == "The search for the steady state takes the work of 12.3 cycles"
    assert finding({}, None) == ""
    made_up = "At default accuracy run 24’s tip deflection is off by 0.1 % (thesis), 0.1 % (reference)"
    assert finding_of(one_run(studies=made_up_studies()), "accuracy") == made_up
    assert finding_of(one_run(), "accuracy") == "The search for the steady state takes the work of 12 cycles"


def test_a_second_engine_confirms_the_solution_or_does_not() -> None:
    converged, trial = Truth("reference", {}, {}), Trial(scene="thesis-24", engine="exudyn")
    for error, words in ((1e-4, "0.01 % in the tip deflection: they confirm"), (0.02, "2.0 % in the tip deflection: they do not confirm")):
        told = plain(confirming_words(converged, dataclasses.replace(trial, errors={"tip_deflection": error})))
        assert told == f"The converged solution of run 24 (reference) and that of exudyn differ by {words} each other to 0.02 %."
    assert "differ by an unknown error in" in confirming_words(converged, trial)


def test_the_errors_of_models_that_need_a_prescribed_speed_stand_apart() -> None:
    study = made_up_studies().prescribed
    assert study is not None
    speed = "A prescribed crank speed alone changes run 24’s tip deflection by 30 %."
    first = "moving-boundaries, which takes no driven crank, is off by 9.0 % at this speed, the error of its linear beam"
    estimate = ", and its integration by 0.09 %, as it estimates itself."
    second = "moving-boundaries with foreshortening is off by 2.0 % at this speed"
    assert plain(prescribed_words(study)) == f"{speed} {first}{estimate} {second}{estimate}"
    alone = dataclasses.replace(study, runs=[dataclasses.replace(study.runs[0], claim=None)])
    assert plain(prescribed_words(alone)) == f"{speed} {first}."


def test_what_the_search_saves_is_told_in_cycles() -> None:
    told = plain(saved_words({"work": 11.84, "runs": 24, "settled": 2.18, "gone": 12.2}))
    search = "The direct search for the steady state takes the work of 11.8 cycles in the median of 24 runs."
    assert told == f"{search} Marching to 0.001 takes 2.2 times as many, to 10⁻⁶ 12 times."
    assert " of 1 run. " in plain(saved_words({"work": 11.84, "runs": 1, "settled": 2.18, "gone": 12.2}))


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
    assert "every engine marched" in text_of(one_run(marched, studies=made_up_studies()))


@pytest.mark.parametrize(("difference", "words"), [(1.3e-3, "no more"), (1.5e-3, "more")])
def test_both_starts_are_held_against_what_both_runs_say_is_left(difference: float, words: str) -> None:
    size = f"{100.0 * difference:.2g} %"
    told = plain(both_starts_words([made_up_both_starts(difference)]))  # 5e-4 and 9e-4 are left
    assert told == f"exudyn in 4 and 25 cycles, {size} apart ({words} than the remaining change that both state)"
    assert both_starts_words([made_up_both_starts()] * 2).count("; ") == 1
    shown = text_of(one_run(studies=dataclasses.replace(made_up_studies(), both_starts=[made_up_both_starts(difference)])))
    assert f"the difference of the two last cycles: {told}." in shown
