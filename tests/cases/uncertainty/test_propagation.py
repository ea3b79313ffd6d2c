"""Quantiles and shares of variance against closed forms; the engines are not asked."""

import numpy as np
import pytest

from quickreturn.cases.case_file import load_case
from quickreturn.cases.errors import CaseError
from quickreturn.cases.library.thesis import RUNS
from quickreturn.cases.sweep.rows import Asked
from quickreturn.cases.uncertainty.propagation import Points, Scatter, planned, quantiles
from quickreturn.cases.uncertainty.thesis import MEASURES, UNPRINTED, band

ASKED = Asked(measures=("peak.strain_2",), claims=False)
UNCERTAIN = {"slider.mass": "uniform 1 kg .. 3 kg", "tip.center_of_mass": "uniform 0 in .. 0.5 in"}


def points(samples: int = 64) -> Points:
    return planned(load_case("thesis-24"), UNCERTAIN, ASKED, samples, "study")


def scattered(found: Points, values: np.ndarray) -> Scatter:
    errors = np.full((len(values), 1), 0.01)
    return Scatter(found.case, found.distributions, ASKED.measures, found.inputs, values[:, None], errors, ("settled",) * len(values))


def test_the_shares_of_a_polynomial_are_those_of_its_closed_form() -> None:
    """Y = 2 a + b + a b with a, b uniform on -1 .. 1: variances 4/3, 1/3 and 1/9 of the three parts, 16/9 in all."""
    found = points()
    a, b = found.inputs[:, 0] - 2.0, found.inputs[:, 1] / 0.00635 - 1.0
    scatter = scattered(found, 2.0 * a + b + a * b)
    assert scatter.surrogate("peak.strain_2").q2 == pytest.approx(1.0, abs=1e-9)
    one, other = scatter.shares("peak.strain_2")
    assert (one.key, other.key) == ("slider.mass", "tip.center_of_mass")
    assert (one.first, one.total) == pytest.approx((12.0 / 16.0, 13.0 / 16.0), abs=1e-9)
    assert (other.first, other.total) == pytest.approx((3.0 / 16.0, 4.0 / 16.0), abs=1e-9)
    assert scatter.simulation_error("peak.strain_2") == 0.01


def test_numbers_that_do_not_depend_on_the_parameters_give_no_shares() -> None:
    scatter = scattered(points(), np.random.default_rng(1).standard_normal(64))
    assert scatter.surrogate("peak.strain_2").q2 < 0.5
    assert scatter.shares("peak.strain_2") == []


def test_the_error_of_a_quantile_is_what_other_samples_show() -> None:
    """Of n uniform numbers the median has the standard error 0.5 / sqrt(n) over their range."""
    generator = np.random.default_rng(2)
    errors = [quantiles(generator.random(400), (0.5,))[0].error for _ in range(20)]
    assert np.mean(errors) == pytest.approx(0.5 / 20.0, rel=0.15)  # each scatters by a quarter, the mean of 20 by 6 %


def test_points_that_did_not_settle_count_in_no_number() -> None:
    found = points(8)
    scatter = scattered(found, np.arange(8.0))
    unstable = Scatter(**{**vars(scatter), "statuses": ("unstable: fold", *scatter.statuses[1:])})
    assert unstable.counts == {"settled": 7, "unstable: fold": 1}
    assert unstable.quantiles("peak.strain_2", (0.0,))[0].value == 1.0


@pytest.mark.parametrize(
    ("uncertain", "samples", "told"),
    [
        ({}, 64, "names no parameter"),
        (UNCERTAIN, 100, "is no power of two"),
        (UNCERTAIN, 4, "from 8 to"),
        ({"slider.mas": "uniform 0 kg .. 1 kg"}, 64, "the nearest known one is slider.mass"),
    ],
)
def test_bad_studies_get_one_sentence(uncertain: dict[str, str], samples: int, told: str) -> None:
    with pytest.raises(CaseError, match=told):
        planned(load_case("thesis-24"), uncertain, ASKED, samples, "study")


def test_what_the_thesis_does_not_print_can_be_varied_in_every_run() -> None:
    uncertain = {each.key: each.distribution for each in UNPRINTED}
    for run in RUNS:
        found = planned(load_case(f"thesis-{run:02d}"), uncertain, Asked(measures=MEASURES), 8, "thesis")
        assert found.inputs.shape == (8, len(UNPRINTED))


def test_a_band_compares_the_halves_where_both_are_resolved() -> None:
    found = planned(load_case("thesis-24"), UNCERTAIN, Asked(measures=MEASURES), 8, "thesis")
    values = np.tile([10.0, 10.0, 1e-4, 3e-4, 2e-4], (8, 1))
    values[0, 1], values[1, 1], values[2, 0] = 9.0, 10.1, np.nan
    statuses = ("settled",) * 7 + ("failed",)
    made = band(24, Scatter(found.case, found.distributions, MEASURES, found.inputs, values, np.full(values.shape, np.nan), statuses))
    assert (made.points, made.settled, made.compared, made.apart) == (8, 7, 6, 1)
    assert made.ratio == pytest.approx((0.9, 1.0, 1.01))
    assert made.strain == pytest.approx((3e-4,) * 3)
