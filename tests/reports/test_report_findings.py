"""What the report finds, from results whose answer is known beforehand."""

import dataclasses

import numpy as np
import pytest

from quickreturn.cases.runs.comparison import CaseResult, Difference, compare
from quickreturn.reports.findings.agreement import differences, outward, spread
from quickreturn.reports.page.content import Content
from quickreturn.reports.page.facts.agreement import run_map
from quickreturn.reports.tables.claims import KINK, MARGINAL, cause, classes, departures, summary
from tests.reports.plotted_results import with_run
from tests.reports.reported_results import ALIKE, reported_result, with_frequencies


def test_differences_are_relative_to_the_other_engine_and_extremes_to_its_peak() -> None:
    result = with_frequencies("thesis-24", ALIKE | {"exudyn": (1.01, 0.98)})
    found = spread(differences([result], "exudyn", "frequency"))
    assert found is not None
    assert found.lowest == pytest.approx(-0.02)
    assert found.highest == pytest.approx(0.01)
    assert found.worst.half == "post"
    reference, exudyn = result.runs["reference"], result.runs["exudyn"]
    extreme = next(d for d in differences([result], "exudyn", "extreme", half="pre", channel="strain_1") if d.quantity == "minimum")
    mine, other = exudyn.measure("pre", "strain_1"), reference.measure("pre", "strain_1")
    assert mine is not None
    assert other is not None
    assert extreme.relative == pytest.approx((mine.minimum - other.minimum) / reference.peak("strain_1"))


@pytest.mark.parametrize("factor", [0.9, 1.1])
def test_a_difference_of_peaks_tells_which_engine_swings_further(factor: float) -> None:
    result = reported_result("thesis-24")
    smaller = [
        dataclasses.replace(each, minimum=factor * each.minimum, maximum=factor * each.maximum)
        for each in result.runs["reference"].measures
    ]
    result = with_run(result, "exudyn", measures=tuple(smaller))
    signed = [outward(each.quantity, each.relative) for each in differences([result], "exudyn", "extreme")]
    # minima are negative and maxima positive in these made-up signals; both are about as large as the peak, which is 1.01 of the signal's
    assert signed == pytest.approx([factor - 1.0] * len(signed), rel=0.05)
    (row,) = run_map([result]).rows
    assert row["exudyn_extreme_difference"].value == max(signed, key=abs)


def test_a_status_is_a_failure_only_if_the_engine_did_not_complete() -> None:
    statuses = {"thesis": "inaccurate", "reference": "not settled", "exudyn": "failed", "mujoco": "refused"}
    found = {run.engine: run.ending.incomplete for _, run in Content(results=[reported_result("thesis-24", statuses)]).troubles}
    assert found == {"thesis": False, "reference": True, "exudyn": True, "mujoco": False}  # mujoco is there: it refuses the scene


def departing(result: CaseResult, excess: float = 3.0) -> tuple[CaseResult, Difference]:
    """The same with exudyn's maximum of strain 3 before the return off by so many times what both claim, and its check."""
    reference, exudyn = (result.runs[name].measure("pre", "strain_3") for name in ("reference", "exudyn"))
    assert reference is not None
    assert exudyn is not None
    wanted = ("exudyn", "maximum", "pre", "strain_3")

    def found(of: CaseResult) -> Difference:
        (check,) = (c for c in of.checks if (c.engine, c.quantity, c.half, c.channel) == wanted)
        return check

    off = reference.maximum + excess * found(result).tolerance
    measures = [dataclasses.replace(each, maximum=off) if each is exudyn else each for each in result.runs["exudyn"].measures]
    result = with_run(result, "exudyn", measures=tuple(measures))
    other = compare(result.case, result.runs)
    return other, found(other)


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


def test_a_departure_that_is_marginal_is_called_so() -> None:
    for excess, marginal in ((1.0 + 0.5 * MARGINAL, True), (1.0 + 2.0 * MARGINAL, False)):
        result, check = departing(reported_result("thesis-24"), excess)
        assert ("marginal" in cause(result, check)) is marginal


def test_a_departure_of_an_engine_that_misses_its_accuracy_says_so() -> None:
    result, check = departing(reported_result("thesis-24"))
    assert "accuracy asked" not in cause(result, check)
    result = with_run(result, "exudyn", reached=False)
    assert "exudyn does not reach the accuracy asked" in cause(result, check)


def test_a_strain_extreme_while_the_slider_is_at_the_gauge_is_told() -> None:
    result, check = departing(reported_result("thesis-24"))
    follower = result.case.mechanism.follower
    cycle, gauge = result.runs["reference"].cycle, follower.strain_gauges[2]
    half = cycle["crank_angle"] <= 2.0 * np.pi
    for distance, told in ((0.0, True), (10.0 * KINK * follower.length, False)):
        at_gauge = int(np.argmin(np.where(half, np.abs(cycle["slider_position"] - (gauge - distance)), np.inf)))
        cycle["strain_3"] = np.where(np.arange(half.size) == at_gauge, 1.0, 0.0)
        assert ("passes the gauge" in cause(result, check)) is told


def test_classes_count_runs() -> None:
    results = [reported_result("thesis-24"), reported_result("thesis-06", {"exudyn": "failed"}, seed=5)]
    rows = {row["engine"].value: [cell.value for key, cell in row.items() if key != "engine"] for row in classes(results).rows}
    assert {engine: sum(counts) for engine, counts in rows.items()} == dict.fromkeys(("thesis", "reference", "exudyn", "mujoco"), 2)  # type: ignore[arg-type]
    # the cubic is 13 % off in these made-up results, the reference claims 1 % of the peaks, and what failed has no class
    assert rows["thesis"][-2:] == [2, 0]
    assert rows["reference"] == [0, 0, 2, 0, 0, 0, 0]
    assert rows["exudyn"][-1] == 1
