"""Differences between engines from results whose answer is known beforehand."""

import pytest

from quickreturn.reports.engine_differences import differences, spread
from tests.reports.reported_results import ALIKE, with_frequencies


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
