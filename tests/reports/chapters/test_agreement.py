"""Who agrees with whom: the numbers of the heading and tables; and chapters count what their tables have."""

import dataclasses
import re

import pytest

from quickreturn.cases.comparison.engines import agreement as verdicts
from quickreturn.reports.chapters.agreement import departures, run_map, summary
from quickreturn.reports.chapters.provenance import engines, settings
from quickreturn.reports.chapters.runs import resolvable
from quickreturn.reports.engine_differences import differences, outward
from tests.reports.pages import chapter_of, finding_of, one_run, text_of
from tests.reports.plotted_results import ENGINES, with_run, with_table
from tests.reports.reported_results import agreeing, departing, reported_result


def test_the_heading_counts_the_comparisons_of_the_page() -> None:
    content = one_run(agreeing(reported_result("thesis-24")), reported_result("thesis-06", seed=5))
    (table,) = (table for table in chapter_of(content, "agreement").tables if table.name == "compared")
    compared, beyond, silent = (sum(int(str(row[key].value)) for row in table.rows) for key in ("compared", "beyond", "say_nothing"))
    assert 0 < beyond < compared
    assert silent == 0
    assert f"{beyond} of {compared} comparisons" in finding_of(content, "agreement")
    alike = one_run(agreeing(reported_result("thesis-24")))
    checks = [check for result in alike.results for check in result.checks]
    assert verdicts(checks) == {"agree": len(checks), "disagree": 0, "says_nothing": 0}
    assert f"all {len(checks)} comparisons" in finding_of(alike, "agreement")
    nothing = one_run(reported_result("example", dict.fromkeys(ENGINES, "failed")))
    assert finding_of(nothing, "agreement") == "Nothing could be judged"


@pytest.mark.parametrize("factor", [0.9, 1.1])
def test_a_difference_of_peaks_tells_which_engine_swings_further(factor: float) -> None:
    result = reported_result("thesis-24")
    smaller = [
        dataclasses.replace(each, minimum=factor * each.minimum, maximum=factor * each.maximum)
        for each in result.runs["reference"].measured.measures
    ]
    result = with_run(result, "exudyn", measures=tuple(smaller))
    signed = [outward(each.quantity, each.relative) for each in differences([result], "exudyn", "extreme")]
    # minima are negative and maxima positive in these made-up signals; both are about as large as the peak, which is 1.01 of the signal's
    assert signed == pytest.approx([factor - 1.0] * len(signed), rel=0.05)
    (row,) = run_map([result]).rows
    assert row["exudyn_extreme_difference"].value == max(signed, key=abs)


def test_a_departure_is_told_with_what_both_claim() -> None:
    result, check = departing(reported_result("thesis-24"))
    assert check in result.missed
    wanted = {"engine": "exudyn", "quantity": "maximum", "half": "pre", "channel": "strain_3"}
    (numbers,) = (row for row in departures([result]).rows if all(row[key].value == value for key, value in wanted.items()))
    # made up: estimates of 1 % of the peak, settling errors of 5e-4 of it
    assert numbers["claim"].value == pytest.approx(0.01 + 5e-4)
    assert numbers["tolerance"].value == pytest.approx(2.0 * (0.01 + 5e-4))
    assert numbers["difference"].value == pytest.approx(3.0 * numbers["tolerance"].value)  # type: ignore[operator]
    beyond = {(row["engine"].value, row["other"].value, row["quantity"].value): row["beyond"].value for row in summary([result]).rows}
    assert beyond["exudyn", "reference", "maximum"] == sum(c.engine == "exudyn" and c.quantity == "maximum" for c in result.missed) >= 1


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
