"""The chapter on constructions by other programs' means: its sentences, on made-up rows and on the record."""

from dataclasses import replace

import pytest

from quickreturn.plugins.as_built import chapter as chapter
from quickreturn.plugins.as_built.chapter import close_words, cure_words, finding, lost_words, narrow_words, price_words
from quickreturn.plugins.as_built.constructions import Construction, built
from tests.reports import pages
from tests.reports.pages import plain

GOOD = Construction("slot, contact 2 steps", "MuJoCo 4.0", 2.0, 0.033, -0.016, -2e-4, 0.0064, 1.3e-5, 0.2)
FINE = replace(GOOD, name="slot, contact 2 steps, 26 links, 0.025 ms", error=0.0085, gap=2e-6, seconds=1.7)
RUBBED = replace(GOOD, name="slot, contact 2 steps, default friction", error=1.06, gap=8e-5)
DAMPED = replace(GOOD, name="slot, contact 2 steps, discrete, 0.1 ms", error=0.14, gap=4e-4)
LOST = Construction("slot, 1 ms", "Drake 1.5", 0.016)
ROWS = (GOOD, FINE, RUBBED, DAMPED, LOST)


def test_the_heading_counts_what_is_right_lost_and_only_looks_right() -> None:
    of = "2 of 5 constructions with the means of MuJoCo and Drake are within 5 % in run 24"
    assert plain(finding(ROWS)) == f"{of}; 1 lost the motion and 2 only looked right"
    assert plain(finding([GOOD])) == "1 of 1 construction with the means of MuJoCo is within 5 % in run 24"
    assert plain(finding([GOOD, LOST])) == (
        "1 of 2 constructions with the means of MuJoCo and Drake is within 5 % in run 24; 1 lost the motion"
    )


def test_what_diverges_is_named_with_its_time() -> None:
    assert plain(lost_words(ROWS)).startswith("What diverges: Drake 1.5 (slot, 1 ms) after 16 ms. ")
    assert lost_words([GOOD]) == ""


def test_a_small_gap_and_a_right_frequency_are_told_apart() -> None:
    assert plain(narrow_words(ROWS)) == (
        "A gap below 0.1 mm proves nothing: 1 construction with it is 106 % off (worst: slot, contact 2 steps, default friction)."
    )
    assert plain(close_words(ROWS)) == (
        "A first frequency that is right to 0.3 % proves nothing: 2 constructions with it are 14 to 106 % off"
        " (worst: slot, contact 2 steps, default friction)."
    )
    assert narrow_words([GOOD]) == close_words([replace(RUBBED, frequency=-0.1)]) == ""


def test_a_cure_is_told_where_both_of_its_constructions_were_measured_and_it_helps() -> None:
    told = plain(cure_words(ROWS))
    assert told == (
        "What cures a chain of MuJoCo: no friction in place of the default (106 % to 3.3 %), the integrator implicitfast in place of"
        " discrete (14 % to 3.3 %) and 26 links in place of 13 (3.3 % to 0.85 %)."
    )
    assert cure_words([GOOD, replace(RUBBED, error=0.02)]) == ""


def test_the_price_is_that_of_the_fastest_within_one_per_cent_or_of_the_most_accurate() -> None:
    drake = Construction("slot, 0.2 ms", "Drake 1.5", 2.0, 0.031, 0.0, 0.0, 0.0064, 3e-5, 1.6)
    assert plain(price_words([*ROWS, replace(FINE, error=0.002, seconds=3.0), drake])) == (
        "What it costs: MuJoCo 4.0 is within 1 % in 1.7 s (slot, contact 2 steps, 26 links, 0.025 ms: 0.85 %)"
        " and Drake 1.5 was not tried finer than 3.1 %, in 1.6 s (slot, 0.2 ms)."
    )
    assert price_words([LOST]) == ""


def test_the_chapter_shows_every_construction_and_marks_what_was_lost() -> None:
    page = pages.read(pages.one_run(data={chapter.recorded: ROWS}))
    assert "lost after 16 ms" in plain(page.text)
    (found,) = pages.chapter_of(pages.one_run(data={chapter.recorded: ROWS}), "as_built").tables
    assert [row["error"].mark for row in found.rows] == ["good", "good", "missed", "missed", "failed"]
    assert "as_built" not in pages.read(pages.one_run()).anchors


def test_the_record_tells_all_five_sentences() -> None:
    rows = built()
    assert len({row.name for row in rows}) == len(rows)
    assert all(sentence(rows) for sentence in chapter.SENTENCES)


@pytest.mark.parametrize("program", ["MuJoCo", "Exudyn", "Drake"])
def test_the_record_has_every_program(program: str) -> None:
    assert any(row.program.startswith(f"{program} ") for row in built())
