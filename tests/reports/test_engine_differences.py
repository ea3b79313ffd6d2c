"""Differences between engines and their causes, from results whose answer is known beforehand."""

import numpy as np
import pytest

from quickreturn.reports.engine_differences import KINK, MARGINAL, cause, differences, spread
from tests.reports.plotted_results import with_run
from tests.reports.reported_results import ALIKE, departing, reported_result, with_frequencies


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
