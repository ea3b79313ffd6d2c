"""The page of the hard scenes, on made-up answers."""

from quickreturn.cases.library.hard import IMPOSSIBLE
from quickreturn.plugins.methods.chapters.hard import finding
from quickreturn.plugins.methods.row import MEANINGS, Row
from quickreturn.plugins.methods.tests import pages
from quickreturn.plugins.methods.tests.made_up_races import made_up_hard_scenes
from quickreturn.plugins.methods.tests.pages import plain
from tests.reports.reported_results import PageReader


def rows_of(wrong: bool = False) -> list[Row]:
    return [row for race in made_up_hard_scenes(wrong).races for row in race.rows]


def read(wrong: bool = False) -> PageReader:
    return pages.read(pages.one_run(hard_scenes=made_up_hard_scenes(wrong)))


def test_the_heading_counts_each_status_and_the_claims() -> None:
    assert plain(finding(rows_of())) == "Of 4 answers 1 ended, 1 own equations, 1 failed, 1 refused; none silently wrong of 2 claims"
    assert plain(finding(rows_of(wrong=True))).endswith("; 1 silently wrong of 3 claims")


def test_a_claim_that_does_not_hold_is_shouted() -> None:
    assert "Claims that did not hold: reference in hard-speed-x2" in read(wrong=True).text
    assert "Claims that did not hold" not in read().text


def test_the_page_explains_what_occurs() -> None:
    text = read().text
    assert all((meaning in text) == any(row.status == status for row in rows_of()) for status, meaning in MEANINGS.items())
    assert all(sentence in text for sentence in IMPOSSIBLE.values())


def test_without_results_there_is_no_chapter() -> None:
    assert "hard" not in pages.read(pages.one_run()).anchors
