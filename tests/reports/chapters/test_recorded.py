"""Recorded tables beside the engines."""

from quickreturn.reports.chapters.recorded import finding
from quickreturn.reports.page.chapters import chapters_of
from tests.reports.pages import chapter_of, finding_of, one_run, plain
from tests.reports.plotted_results import with_table
from tests.reports.reported_results import reported_result


def test_the_heading_says_in_how_many_comparisons_the_tables_agree() -> None:
    assert plain(finding(["a.csv"], 34, 0)) == "a.csv: within what is claimed in all 34 comparisons"
    assert plain(finding(["a.csv"], 1, 0)) == "a.csv: within what is claimed in 1 comparison"
    assert plain(finding(["a.csv", "b.csv"], 34, 2)) == "a.csv and b.csv: beyond what is claimed in 2 of 34 comparisons"
    assert plain(finding(["a.csv"], 1, 1)) == "a.csv: beyond what is claimed in 1 of 1 comparison"
    assert plain(finding(["a.csv", "b.csv"], 0, 0)) == "2 tables; nothing could be judged"
    assert plain(finding(["a.csv"], 0, 0)) == "1 table; nothing could be judged"


def test_the_heading_counts_what_the_table_of_tables_counts() -> None:
    content = one_run(with_table(reported_result("thesis-24"), "tool.csv", ["strain_2", "tip_acceleration"], factor=1.5))
    chapter = chapter_of(content, "recorded")
    table, _, departures = chapter.tables
    (row,) = table.rows
    assert 0 < row["beyond"].value == len(departures.rows) < row["compared"].value  # type: ignore[operator]
    told = f"tool.csv: beyond what is claimed in {row['beyond'].value} of {row['compared'].value} comparisons"
    assert finding_of(content, "recorded") == told


def test_without_a_table_there_is_no_chapter() -> None:
    assert "recorded" not in [chapter.id for chapter in chapters_of(one_run())]
