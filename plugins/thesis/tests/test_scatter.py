"""Unprinted quantities can be varied in every run, and a band compares the halves; no engine is asked."""

import numpy as np
import pytest

from quickreturn.cases.files.case_file import load_case
from quickreturn.cases.library.thesis.runs import RUNS
from quickreturn.plugins.studies.sweep.rows import MeasureRequest
from quickreturn.plugins.studies.uncertainty.propagation import Scatter, planned
from quickreturn.plugins.thesis.scatter import MEASURES, UNPRINTED, band

UNCERTAIN = {"slider.mass": "uniform 1 kg .. 3 kg", "tip.center_of_mass": "uniform 0 in .. 0.5 in"}


def test_what_the_thesis_does_not_print_can_be_varied_in_every_run() -> None:
    uncertain = {each.key: each.distribution for each in UNPRINTED}
    for run in RUNS:
        found = planned(load_case(f"thesis-{run:02d}"), uncertain, MeasureRequest(measures=MEASURES), 8, "thesis")
        assert found.inputs.shape == (8, len(UNPRINTED))


def test_a_band_compares_the_halves_where_both_are_resolved() -> None:
    found = planned(load_case("thesis-24"), UNCERTAIN, MeasureRequest(measures=MEASURES), 8, "thesis")
    values = np.tile([10.0, 10.0, 1e-4, 3e-4, 2e-4], (8, 1))
    values[0, 1], values[1, 1], values[2, 0] = 9.0, 10.1, np.nan
    statuses = ("settled",) * 7 + ("failed",)
    made = band(24, Scatter(found.case, found.distributions, MEASURES, found.inputs, values, np.full(values.shape, np.nan), statuses))
    assert (made.points, made.settled, made.compared, made.apart) == (8, 7, 6, 1)
    assert made.ratio == pytest.approx((0.9, 1.0, 1.01))
    assert made.strain == pytest.approx((3e-4,) * 3)
