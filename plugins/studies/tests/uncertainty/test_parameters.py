"""Keys of parameters, and distributions as text."""

import math

import numpy as np
import pytest

from quickreturn.cases.files.errors import CaseError
from quickreturn.cases.library import load_case
from quickreturn.plugins.studies.uncertainty.parameters import Parameter, changes, distribution

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
        ("about 3 kg", "is no distribution"),
        ("uniform 0 kg to 3 kg", "is no distribution"),
        ("uniform 3 kg .. 0 kg", "does not rise"),
        ("uniform 0 kg .. 3 m", "is a length (m), but a mass is needed"),
        ("uniform -1 kg .. 3 kg", "is negative"),
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
