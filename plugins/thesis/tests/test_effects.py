"""What the chapter on the thesis says of the effects that were tried."""

import dataclasses
from typing import Any

from quickreturn.plugins.thesis.effects import odd_words, ring_words, set_words, tightened_words
from quickreturn.plugins.thesis.finding.study import Row
from quickreturn.plugins.thesis.records import finding
from quickreturn.plugins.thesis.sufficiency import trials
from quickreturn.plugins.thesis.tests.made_up_finding import made_up_finding
from tests.reports.pages import plain


def moved(rows: list[Row], effect: str) -> list[Row]:
    """The same rows, an effect of which moves the halves far apart."""
    changed: dict[str, Any] = {"pre_frequency": (0,) * 24, "post_frequency": (900,) * 24}
    return [dataclasses.replace(row, **changed) if row.effect == effect and row.engine == "reference" else row for row in rows]


def test_symmetric_effects_that_split_the_halves_are_not_denied() -> None:
    study = made_up_finding()
    none = "None of these moves the halves apart by more than the measurement leaves open."
    assert none in odd_words(study)
    assert none not in odd_words(moved(study, "linear"))
    assert plain(odd_words(moved(study, "friction"))).endswith(": +9.0 %.")


def test_sets_their_choices_and_the_best_are_told() -> None:
    sets = trials(made_up_finding())
    choices = sorted(len(each.choices) for each in sets)
    best = max(sum(each.shown.values()) for each in sets)
    tried = f" {len(sets)} sets were tried; none of their {choices[0]} to {choices[-1]} choices is published"
    assert f"{tried}, and the best shows {best} of the 11 statements that a joint can bear on (" in set_words(sets)


def test_frequencies_at_the_return_tell_clearance_from_a_soft_roller() -> None:
    study = made_up_finding()
    told = plain(ring_words(trials(study), study, []))
    assert told.endswith("clearance rings at 134 Hz, a soft roller at 60 to 80 Hz (strongest from 60 to 200 Hz); section 3.4 read 132 Hz.")
    silent = [dataclasses.replace(row, example=()) for row in study]
    assert ring_words(trials(silent), silent, []) == ""


def test_what_the_thesis_says_against_a_soft_roller_is_told_with_what_a_preload_leaves() -> None:
    """Section 3.2 has the rollers tightened; the recorded study has a preload of 6 N, which leaves less than the 2 % that the words ask."""
    told = plain(tightened_words(finding()))
    assert told.startswith("section 3.2 says that the rollers were tightened, and a preload of 6 N leaves −1.")
    assert told.endswith(" between the halves, less than the words ask (−2.0 %)")
    assert tightened_words([]) == ""
