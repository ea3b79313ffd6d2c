"""Chapters count what their tables have and name what did not go well."""

import dataclasses
import re

from quickreturn.reports.chapters.provenance import engines, settings
from quickreturn.reports.chapters.runs import resolvable
from tests.reports.pages import chapter_of, finding_of, one_run, text_of
from tests.reports.plotted_results import with_table
from tests.reports.reported_results import reported_result


def numbers(text: str) -> list[int]:
    """The whole numbers in a text, in their order."""
    return [int(each) for each in re.findall(r"(?<![\d.-])\d+(?![\d.%-])", text)]


def test_a_section_of_a_run_has_the_notes_failures_and_departures_of_its_case() -> None:
    result = reported_result("thesis-06", {"exudyn": "failed"})
    told = text_of(one_run(dataclasses.replace(result, case=dataclasses.replace(result.case, notes=("a note on it",)))))
    assert "A note on it." in told
    assert "exudyn: failed. failed at t = 0.25 s: the beam <snapped>" in told
    ((engine, other), checks), *_ = result.departures.items()
    assert f"{engine} and {other} differ by more than they claim in {len(checks)} number" in told


def test_tables_of_engines_and_settings_have_what_the_runs_have() -> None:
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


def test_half_cycles_of_usable_runs_that_resolve_the_first_mode_are_counted() -> None:
    results = [reported_result("thesis-24"), reported_result("thesis-06", {"exudyn": "failed", "mujoco": "inaccurate"})]
    found = {name: resolvable(results, name) for name in results[0].runs}
    # made-up inaccurate runs have no frequencies
    assert found == {"thesis": (4, 4), "reference": (4, 4), "exudyn": (2, 2), "mujoco": (2, 4)}
    assert numbers(finding_of(one_run(*results), "runs")) == [2, 4, 4, 4, 4, 2, 2, 2, 4]
    assert "Not simply settled: exudyn on run 6 (failed); mujoco on run 6 (inaccurate)." in text_of(one_run(*results))
