"""Headings of the page count what its tables have, and warnings name what did not go well."""

import dataclasses
import re

import pytest

from quickreturn.reports.chapters.provenance import engines, settings
from quickreturn.reports.chapters.provenance import finding as of_provenance
from quickreturn.reports.chapters.recorded import finding as of_tables
from quickreturn.reports.chapters.runs import finding as of_runs
from quickreturn.reports.chapters.runs import resolvable
from quickreturn.reports.chapters.runs import signals_finding as of_signals
from quickreturn.reports.page.chapters import catalogue, chapters_of, next_finding
from quickreturn.reports.tables.table import Table
from quickreturn.reports.verification import Verification
from tests.reports.pages import chapter_of, finding_of, one_run, plain, text_of
from tests.reports.plotted_results import with_table
from tests.reports.reported_results import agreeing, reported_result

TROUBLED = {"exudyn": "failed", "mujoco": "inaccurate"}


def numbers(text: str) -> list[int]:
    """The whole numbers in a text, in their order."""
    return [int(each) for each in re.findall(r"(?<![\d.-])\d+(?![\d.%-])", text)]


def test_files_are_counted_and_listed_with_rows_and_captions() -> None:
    others = [table for chapter in list(chapters_of(one_run()))[:-1] for table in chapter.tables]
    assert numbers(finding_of(one_run(), "files")) == [len(others)]
    table = Table("made_up", "A caption.", ("a",))
    table.add(a="x")
    (row,) = catalogue([table], {"date": "today"}).rows
    assert {key: cell.value for key, cell in row.items()} == {"file": "made_up.csv", "rows": 1, "what": "A caption.", "date": "today"}


@pytest.mark.parametrize(("failures", "departing", "word"), [(2, ["a"], "2 simulations"), (0, ["a", "b"], "a and b"), (0, [], "Change")])
def test_failures_come_before_departures_among_the_next_steps(failures: int, departing: list[str], word: str) -> None:
    assert word in plain(next_finding(failures, departing))


def test_the_next_steps_are_about_the_cases_of_the_page() -> None:
    failed = one_run(reported_result("example", {"exudyn": "failed", "mujoco": "not settled"}))
    assert numbers(finding_of(failed, "next")) == [2]
    assert finding_of(one_run(reported_result("example")), "next").endswith("example")  # made up: mujoco departs
    assert "example" not in finding_of(one_run(agreeing(reported_result("example"))), "next")
    assert 'quickreturn run example --set crank.length="90 mm"' in text_of(failed)
    assert "example, exudyn: failed at t = 0.25 s: the beam <snapped>; try another beam" in text_of(failed)


def test_a_section_of_a_run_has_the_notes_failures_and_departures_of_its_case() -> None:
    assert of_signals(1) != of_signals(2)
    result = reported_result("thesis-06", {"exudyn": "failed"})
    told = text_of(one_run(dataclasses.replace(result, case=dataclasses.replace(result.case, notes=("a note on it",)))))
    assert "A note on it." in told
    assert "exudyn: failed. failed at t = 0.25 s: the beam <snapped>" in told
    ((engine, other), checks), *_ = result.departures.items()
    assert f"{engine} and {other} differ by more than they claim in {len(checks)} number" in told


def test_provenance_counts_engines_and_runs_that_are_not_simply_settled() -> None:
    verified, absent = Verification(date="2026-01-02"), Verification(absent="It has not been run with this store.")
    assert "2026-01-02" in of_provenance(4, 0, verified)
    assert "2026" not in of_provenance(4, 0, absent)
    content = one_run(reported_result("thesis-24", TROUBLED), verification=absent)
    assert numbers(finding_of(content, "provenance")) == [4, 2]
    assert numbers(finding_of(one_run(verification=absent), "provenance")) == [4]
    assert "failed: " in text_of(content)  # what the status means


def test_tables_of_engines_and_settings_have_what_the_runs_have() -> None:
    """With the numbers of `reported_result`."""
    result = reported_result("thesis-24", {"exudyn": "failed"})
    for row in engines(one_run(result)).rows:
        assert (row["method"].value, row["accuracy"].value, row["runs"].value) == ("made up", 1e-3, 1)
    for row in settings([result]).rows:
        assert tuple(row[key].value for key in ("accuracy", "error_estimate", "cycles", "settling_error")) == (1e-3, 8e-4, 12, 5e-4)


def test_comparisons_with_recorded_tables_are_counted_as_in_the_table_of_tables() -> None:
    content = one_run(with_table(reported_result("thesis-24"), "tool.csv", ["strain_2", "tip_acceleration"], factor=1.5))
    table, _, departures = chapter_of(content, "recorded").tables
    (row,) = table.rows
    assert 0 < row["beyond"].value == len(departures.rows) < row["compared"].value  # type: ignore[operator]
    assert numbers(finding_of(content, "recorded")) == [row["beyond"].value, row["compared"].value]
    assert numbers(plain(of_tables(["a.csv"], 34, 0))) == [34]
    assert numbers(plain(of_tables(["a.csv", "b.csv"], 0, 0))) == [2]
    assert "recorded" not in [chapter.id for chapter in chapters_of(one_run())]


def test_half_cycles_of_usable_runs_that_resolve_the_first_mode_are_counted() -> None:
    results = [reported_result("thesis-24"), reported_result("thesis-06", TROUBLED)]
    found = {name: resolvable(results, name) for name in results[0].runs}
    # made-up inaccurate runs have no frequencies
    assert found == {"thesis": (4, 4), "reference": (4, 4), "exudyn": (2, 2), "mujoco": (2, 4)}
    assert numbers(finding_of(one_run(*results), "runs")) == [2, 4, 4, 4, 4, 2, 2, 2, 4]
    assert numbers(of_runs(0, {"a": (3, 4), "b": (0, 0)})) == [3, 4]
    assert numbers(of_runs(1, {"a": (0, 2)})) == [1]
    assert numbers(of_runs(0, {})) == []
    assert "Not simply settled: exudyn on run 6 (failed); mujoco on run 6 (inaccurate)." in text_of(one_run(*results))
    assert "Not simply settled" not in text_of(one_run())
