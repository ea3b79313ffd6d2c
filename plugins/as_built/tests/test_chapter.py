"""The chapter on constructions by other programs' means: on made-up rows and on the record."""

from dataclasses import replace

import pytest

from quickreturn.plugins.as_built import chapter as chapter
from quickreturn.plugins.as_built.chapter import Construction, built, finding
from tests.reports import pages
from tests.reports.pages import plain

GOOD = Construction("slot, contact 2 steps", "MuJoCo 4.0", 2.0, 0.033, -0.016, -2e-4, 0.0064, 1.3e-5, 0.2)
FINE = replace(GOOD, name="slot, contact 2 steps, 26 links, 0.025 ms", error=0.0085, gap=2e-6, seconds=1.7)
RUBBED = replace(GOOD, name="slot, contact 2 steps, default friction", error=1.06, gap=8e-5)
DAMPED = replace(GOOD, name="slot, contact 2 steps, discrete, 0.1 ms", error=0.14, gap=4e-4)
LOST = Construction("slot, 1 ms", "Exudyn 1.5", 0.016)
ROWS = (GOOD, FINE, RUBBED, DAMPED, LOST)


def test_the_heading_counts_what_is_right_lost_and_only_looks_right() -> None:
    told = plain(finding(ROWS))
    assert all(each in told for each in ("2 of 5", "MuJoCo and Exudyn", "1 lost", "2 only looked right"))
    assert "lost" not in plain(finding([GOOD]))


def test_the_chapter_shows_every_construction_and_marks_what_was_lost() -> None:
    page = pages.read(pages.one_run(data={chapter.recorded: ROWS}))
    assert "lost after 16 ms" in plain(page.text)
    (found,) = pages.chapter_of(pages.one_run(data={chapter.recorded: ROWS}), "as_built").tables
    assert [row["error"].mark for row in found.rows] == ["good", "good", "missed", "missed", "failed"]
    assert "as_built" not in pages.read(pages.one_run()).anchors


@pytest.mark.parametrize("program", ["MuJoCo", "Exudyn"])
def test_the_record_has_every_program(program: str) -> None:
    assert any(row.program.startswith(f"{program} ") for row in built())
