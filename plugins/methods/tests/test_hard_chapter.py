"""Answers in hard scenes in the chapter on methods, on made-up ones."""

from quickreturn.plugins.methods.chapters.methods import of_answers
from quickreturn.plugins.methods.row import MEANINGS, Row
from quickreturn.plugins.methods.tests.made_up_races import made_up_fronts, made_up_hard_scenes
from quickreturn.plugins.methods.tests.pages import one_run, plain, text_of


def rows_of(wrong: bool = False) -> list[Row]:
    return [row for race in made_up_hard_scenes(wrong)[0] for row in race.rows]


def text(wrong: bool = False) -> str:
    return text_of(one_run(fronts=made_up_fronts(), hard_scenes=made_up_hard_scenes(wrong)))


def test_a_sentence_counts_each_status_and_the_claims() -> None:
    told = "Of 4 answers 1 ended, 1 own equations, 1 failed, 1 refused; none silently wrong of 2 claims."
    assert plain(of_answers(rows_of())) == told
    assert plain(of_answers(rows_of(wrong=True))).endswith("; 1 silently wrong of 3 claims.")
    assert told in text()


def test_a_claim_that_does_not_hold_is_shouted() -> None:
    assert "Claims that did not hold: reference in hard-speed-x2" in text(wrong=True)
    assert "Claims that did not hold" not in text()


def test_the_page_explains_what_occurs() -> None:
    found, occurring = text(), {row.status for row in rows_of()} | {"reached"}
    assert all((meaning in found) == (status in occurring) for status, meaning in MEANINGS.items())
