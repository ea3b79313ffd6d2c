"""What the thesis saw: the heading's sentences, and those on plots and stiffness."""

import dataclasses

import pytest

from quickreturn.plugins.thesis.chapters.thesis import finding, model_error_words, stiffness_words
from quickreturn.plugins.thesis.conclusions import CANNOT_FOLLOW, HOLDS, IN_PART, NOT, UNCHECKABLE
from quickreturn.plugins.thesis.experiment.stiffness import StiffnessReading, stiffness_reading
from quickreturn.plugins.thesis.finding.effects import effects
from quickreturn.plugins.thesis.page_data import finding_of as of_finding
from quickreturn.plugins.thesis.sufficiency import Split, splits
from quickreturn.plugins.thesis.tests.made_up_finding import made_up_finding
from tests.reports.pages import finding_of, one_run, plain

OUTCOMES = [HOLDS, IN_PART, IN_PART, NOT, CANNOT_FOLLOW, *[UNCHECKABLE] * 8]
VERDICTS = "13 statements: 1 holds, 2 hold in part, 1 does not hold, 1 cannot follow from the model, 8 cannot be checked"
BY_ID = {effect.id: effect for effect in effects()}
SOFT, FRICTION = (Split(BY_ID[name], "20 kN/m", 0.002, -0.0204) for name in ("post-side", "friction"))


def test_the_heading_names_what_makes_the_halves_differ() -> None:
    changes = "at 20 kN/m by +0.2 % before and −2.0 % after the return (medians)"
    begin = "What made the halves differ is open. Of the effects tried one at a time, {} would: {}"
    soft = begin.format("a roller that is softer on one side", changes)
    alike = "no symmetric effect tried moves them apart by more than the measurement leaves open"
    assert plain(finding([SOFT], "", False, {}, OUTCOMES)) == f"{soft}; {alike}; {VERDICTS}"
    assert plain(finding([SOFT], "it was tightened", True, {}, OUTCOMES)) == f"{soft}; but it was tightened; {VERDICTS}"
    other = begin.format("one that is not symmetric", changes)
    assert plain(finding([SOFT, FRICTION], "", True, {}, OUTCOMES)) == f"{other}; {VERDICTS}"


@pytest.mark.parametrize(
    ("pre", "post", "words"),
    [
        ([1.12, 1.14], [1.13], "stiff before and after the return alike (1.13 and 1.13 times the converged frequency, medians of 2 and 1"),
        ([1.10], [1.15], "stiff before and after the return (1.10 and 1.15 times the converged frequency, medians of 1 and 1"),
        ([0.90], [0.95], "soft before and after the return (0.90 and 0.95 times the converged frequency, medians of 1 and 1"),
    ],
)
def test_the_heading_without_a_study_says_how_stiff_the_cubic_is(pre: list[float], post: list[float], words: str) -> None:
    told = plain(finding([], "", True, {"pre": pre, "post": post}, OUTCOMES))
    assert told == f"Its one cubic is too {words} runs that resolve it); {VERDICTS}"


def test_the_heading_counts_the_verdicts_alone_where_nothing_is_resolved() -> None:
    assert plain(finding([], "", True, {"pre": [1.1], "post": []}, OUTCOMES)) == f"Its statements, checked one by one; {VERDICTS}"
    told = plain(finding([], "", True, {"pre": [], "post": []}, [HOLDS, HOLDS, NOT, NOT]))
    assert told == "Its statements, checked one by one; 4 statements: 2 hold, 2 do not hold"
    assert plain(finding([], "", True, {"pre": [], "post": []}, [NOT])).endswith("; 1 statement: 1 does not hold")


def test_the_heading_is_about_the_study_that_is_recorded() -> None:
    study = made_up_finding()
    told, (soft, *_) = finding_of(one_run(data={of_finding: study}), "thesis"), splits(study)
    assert soft.strength == "20 kN/m"
    assert told.startswith(
        "What made the halves differ is open. Of the effects tried one at a time, a roller that is softer on one side would: at 20 kN/m by "
    )
    assert "no symmetric effect tried" in told
    assert finding_of(one_run(), "thesis").startswith("Its one cubic is too stiff before and after the return alike (1.13 and 1.1")


def test_whether_the_machine_moves_as_the_converged_model_is_open() -> None:
    assert model_error_words(False).endswith(" Whether it does is open.")
    fits = "the only contact with the measurement that is left, and there the cubic fits better (see The experiment)."
    assert model_error_words(True).endswith(fits)


def test_the_stiffness_is_told_beside_that_of_aluminium() -> None:
    reading = StiffnessReading("2128.22 lbf*in^2", 64.2e9, (0.07, 0.09), 0.2)
    begin = "EI = 2128.22 lbf in² over the nominal section means E = 64.2 GPa, 7 to 9 % below ordinary aluminium."
    lower = "to undo the single cubic’s median excess EI would have to be 20 % lower."
    told = plain(stiffness_words(reading))
    assert told.startswith(f"{begin} A frequency grows with the square root of EI: {lower} Inference: ")
    assert told.endswith("towards the measured frequencies, though not all the way.")
    assert plain(stiffness_words(dataclasses.replace(reading, needed=0.08))).endswith("towards the measured frequencies.")
    assert plain(stiffness_words(dataclasses.replace(reading, needed=None))) == begin
    assert stiffness_words(stiffness_reading([])).startswith("EI = ")
