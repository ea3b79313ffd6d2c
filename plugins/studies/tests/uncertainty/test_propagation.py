"""Keys and distributions as text; quantiles and shares of variance against closed forms; the engines are not asked."""

import dataclasses
import math
from itertools import product

import numpy as np
import pytest
from scipy import stats

from quickreturn.cases.files.errors import CaseError
from quickreturn.cases.library import load_case
from quickreturn.plugins.studies.sweep.rows import MeasureRequest
from quickreturn.plugins.studies.uncertainty.chaos import powers_up_to
from quickreturn.plugins.studies.uncertainty.parameters import Parameter, changes, distribution
from quickreturn.plugins.studies.uncertainty.scatter import Scatter, quantiles
from quickreturn.plugins.studies.uncertainty.study import Points, planned

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


@pytest.mark.parametrize(("degree", "count"), [(1, 1), (4, 1), (2, 3), (4, 4)])
def test_the_terms_of_a_surrogate_are_all_monomials_up_to_its_degree(degree: int, count: int) -> None:
    expected = {each for each in product(range(degree + 1), repeat=count) if sum(each) <= degree}
    terms = [tuple(each) for each in powers_up_to(degree, count).tolist()]
    assert len(terms) == len(expected)
    assert set(terms) == expected


def test_numbers_that_do_not_depend_on_the_parameters_give_no_shares() -> None:
    scatter = scattered(points(), np.random.default_rng(1).standard_normal(64))
    assert scatter.surrogate("peak.strain_2").q2 < 0.5
    assert scatter.shares("peak.strain_2") == []


def test_the_error_of_a_quantile_is_what_other_samples_show() -> None:
    """Of n uniform numbers the median has the standard error 0.5 / sqrt(n) over their range."""
    generator = np.random.default_rng(2)
    errors = [quantiles(generator.random(400), (0.5,))[0].error for _ in range(20)]
    assert np.mean(errors) == pytest.approx(0.5 / 20.0, rel=0.15)  # each scatters by a quarter, the mean of 20 by 6 %


def ended(scatter: Scatter, endings: list[str]) -> Scatter:
    """The points with other endings, the first of them."""
    more = {"statuses": (*endings, *scatter.statuses[len(endings) :]), "sentences": ("because",) * len(scatter.statuses)}
    return dataclasses.replace(scatter, **more)  # type: ignore[arg-type]


def test_points_that_did_not_settle_count_in_no_number() -> None:
    found = points(32)
    values = np.array([1e9, *np.random.default_rng(3).random(31)])  # no surrogate fits
    unstable = ended(scattered(found, values), ["unstable: fold"])
    assert unstable.counts == {"settled": 31, "unstable: fold": 1}
    assert unstable.lacking("peak.strain_2").startswith("no surrogate is good enough")
    assert unstable.mean("peak.strain_2").value == pytest.approx(np.mean(values[1:]))
    assert [each.value < 1.0 for each in unstable.quantiles("peak.strain_2")] == [True] * 3
    more = ended(scattered(points(64), np.array([1e9, 1e9, *np.linspace(0.0, 1.0, 62)])), ["unstable: fold", "not converged"])
    assert more.lacking("peak.strain_2") == ""
    assert [each.value for each in more.quantiles("peak.strain_2")] == pytest.approx([0.05, 0.5, 0.95])


def test_two_of_eight_points_are_no_band() -> None:
    scatter = ended(scattered(points(8), np.arange(8.0)), ["slider left"] * 5 + ["not converged"])
    assert scatter.lacking("peak.strain_2") == "2 of 8 points settled"
    assert scatter.quantiles("peak.strain_2") == []
    (document,) = scatter.document()["measures"]
    assert document["no_band"] == "2 of 8 points settled"
    assert {"mean", "quantiles", "band", "shares"}.isdisjoint(document)
    assert [failure.partition(",")[0] for failure in scatter.failures] == ["5 slider left", "1 not converged"]
    assert "±" not in repr(scatter)


def test_quantiles_of_a_linear_measure_are_those_of_its_distribution() -> None:
    """Y = 3 + 2 a with a uniform on -1 .. 1: uniform on 1 .. 5, mean 3, standard deviation 2 / sqrt(3)."""
    found = points(16)
    scatter = scattered(found, 3.0 + 2.0 * (found.inputs[:, 0] - 2.0))
    for each in scatter.quantiles("peak.strain_2"):
        exact = 1.0 + 4.0 * each.probability
        assert abs(each.value - exact) <= max(each.half_width, 1e-9)
        assert each.half_width < 0.01
    mean, deviation = scatter.mean("peak.strain_2"), scatter.deviation("peak.strain_2")
    assert (mean.value, deviation.value) == pytest.approx((3.0, 2.0 / math.sqrt(3.0)), abs=1e-9)
    assert max(mean.half_width, deviation.half_width) < 1e-9
    low, high = scatter.band("peak.strain_2")
    assert low == pytest.approx(1.2 - 0.01, abs=0.01)  # the claims are 0.01
    assert high == pytest.approx(4.8 + 0.01, abs=0.01)


def test_errors_of_the_simulation_move_every_number_by_as_much() -> None:
    scatter = scattered(points(32), np.linspace(0.0, 1.0, 32) ** 2)
    for each in (scatter.mean("peak.strain_2"), scatter.deviation("peak.strain_2"), *scatter.quantiles("peak.strain_2")):
        assert each.simulation == pytest.approx(0.01, rel=1e-12)


CHEAP = {
    "exponential": lambda a, b: np.exp(0.7 * a + 0.4 * b),
    "resonance": lambda a, b: 1.0 / np.hypot(1.0 - (0.9 + 0.05 * a) ** 2, 0.05 + 0.01 * b),
    "wave without a surrogate": lambda a, b: a + 0.3 * np.sin(9.0 * a + 4.0 * b),
}


@pytest.mark.parametrize("cheap", CHEAP)
@pytest.mark.parametrize("samples", [32, *(pytest.param(count, marks=pytest.mark.verify) for count in (16, 64))])
def test_intervals_of_forty_small_studies_contain_the_quantiles(cheap: str, samples: int) -> None:
    """The fewest of 40 that a share of 95 % gives in 97.5 % of the cases is 35 (binomial)."""
    found, function = points(8), CHEAP[cheap]
    middles = (np.arange(1000) + 0.5) / 500.0 - 1.0
    exact = np.quantile(function(*np.meshgrid(middles, middles)), (0.05, 0.5, 0.95))
    within, told = np.zeros(3), np.zeros(3)
    for seed in range(40):
        cube = stats.qmc.Sobol(2, rng=np.random.default_rng(100 + seed)).random(samples)
        inputs = np.column_stack([each.quantile(cube[:, place]) for place, each in enumerate(found.distributions.values())])
        values = function(*(2.0 * cube.T - 1.0))
        scatter = scattered(dataclasses.replace(found, inputs=inputs), values)
        for place, each in enumerate(scatter.quantiles("peak.strain_2")):
            told[place] += math.isfinite(each.error)
            within[place] += abs(each.value - exact[place]) <= each.half_width
    assert np.all(within >= 35), within
    if samples > 16 or not cheap.startswith("wave"):
        assert np.all(told == 40), "an interval without an end is no interval"


CASE = load_case("thesis-24")
MASS = Parameter.of_key("slider.mass", "test")


def test_the_units_of_a_distribution_are_read() -> None:
    stiffness = distribution("normal 2128.22 lbf*in^2 +- 4 %", Parameter.of_key("follower.bending_stiffness", "test"), "test")
    assert stiffness.first == pytest.approx(CASE.mechanism.follower.bending_stiffness, rel=1e-12)
    assert stiffness.second == pytest.approx(0.04 * stiffness.first, rel=1e-12)
    # 97.5 % of a normal distribution lie below 1.959964 standard deviations (any table of it)
    assert stiffness.quantile(np.array([0.975]))[0] == pytest.approx(stiffness.first + 1.959964 * stiffness.second, rel=1e-7)
    length = distribution("normal 2 in +- 0.1 in", Parameter.of_key("crank.length", "test"), "test")
    assert (length.first, length.second) == pytest.approx((0.0508, 0.00254))
    assert distribution("uniform 0 kg .. 0.3 kg", MASS, "test").quantile(np.array([0.0, 0.5, 1.0])) == pytest.approx([0.0, 0.15, 0.3])
    assert distribution("log-uniform 1 g .. 100 g", MASS, "test").quantile(np.array([0.5]))[0] == pytest.approx(0.01)


@pytest.mark.parametrize("text", ["uniform 1 kg .. 3 kg", "log-uniform 1 kg .. 4 kg", "normal 2 kg +- 10 %"])
def test_the_polynomials_are_orthonormal(text: str) -> None:
    found = distribution(text, MASS, "test")
    middles = (np.arange(200_000) + 0.5) / 200_000
    table = found.polynomials(found.quantile(middles), 3)
    # the rule of middle points leaves out the tails of a normal distribution: some 1e-3 of the sixth moment
    assert np.allclose(table.T @ table / len(middles), np.eye(4), atol=3e-3)


@pytest.mark.parametrize(
    ("text", "told"),
    [
        (0.3, "0.3 is no distribution"),
        ("uniform 3 kg .. 0 kg", "does not rise"),
        ("log-uniform 0 kg .. 3 kg", "and no logarithm"),
        ("normal 2 kg +- 0 %", "has no positive standard deviation"),
    ],
)
def test_what_is_no_distribution_gets_one_sentence(text: object, told: str) -> None:
    with pytest.raises(CaseError) as wrong:
        distribution(text, MASS, "study.toml")
    assert str(wrong.value).startswith("study.toml: slider.mass: ")
    assert told in str(wrong.value)


def test_one_place_of_a_list_changes_and_the_others_stay() -> None:
    along, across = (Parameter.of_key(f"mechanism.gravity[{place}]", "test") for place in (1, 2))
    scene = CASE.with_({"mechanism.gravity": '["1 m/s^2", "2 m/s^2"]'}).mechanism
    one = CASE.mechanism_with(changes(scene, {across: 3.0}))
    assert one.gravity == (1.0, 3.0)
    both = CASE.mechanism_with(changes(scene, {along: 4.0, across: 3.0, MASS: 0.1}))
    assert (both.gravity, both.slider.mass) == ((4.0, 3.0), 0.1)
    assert math.isclose(across.of(scene), 2.0)
