"""Quantiles and shares of variance against closed forms; the engines are not asked."""

import math
from itertools import product

import numpy as np
import pytest

from quickreturn.cases.case_file import load_case
from quickreturn.cases.errors import CaseError
from quickreturn.cases.sweep.rows import MeasureRequest
from quickreturn.cases.uncertainty.propagation import Points, Scatter, planned, powers_up_to, quantiles

ASKED = MeasureRequest(measures=("peak.strain_2",), claims=False)
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


@pytest.mark.parametrize(("degree", "count"), [(1, 1), (4, 1), (2, 3), (4, 4)])
def test_the_terms_of_a_surrogate_are_all_monomials_up_to_its_degree(degree: int, count: int) -> None:
    expected = {each for each in product(range(degree + 1), repeat=count) if sum(each) <= degree}
    terms = [tuple(each) for each in powers_up_to(degree, count).tolist()]
    assert len(terms) == len(expected)
    assert set(terms) == expected


def test_forty_parameters_have_a_surrogate() -> None:
    """861 terms; a search among all 3^40 combinations would not end."""
    assert powers_up_to(2, 40).shape == (math.comb(42, 2), 40)


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
