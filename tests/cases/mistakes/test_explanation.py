"""A mistake is named only where it explains what is found, and clearly better than any other."""

from collections.abc import Callable

import numpy as np
import pytest
from numpy.typing import NDArray

from quickreturn.cases.mistakes.diagnosis import diagnose, lateness, share_of
from quickreturn.cases.mistakes.explanation import Explanation, Hypothesis, explain
from quickreturn.plugins.conform.bench import Motion, solution
from quickreturn.plugins.conform.scenes import BASE
from quickreturn.reference_model.scene_values import changed

X = np.linspace(0.0, 2.0 * np.pi, 201)
EXPECTED = np.sin(X)
TURNED = Hypothesis("turned", "turn it round", -EXPECTED)


def named(found: Explanation | None) -> str | None:
    return None if found is None else found.words


def test_the_mistake_that_makes_it_is_named() -> None:
    others = (TURNED, Hypothesis("twice", "halve it", 2.0 * EXPECTED))
    assert explain(-EXPECTED, EXPECTED, others) == Explanation("turned", "turn it round", 0.0)
    assert named(explain(2.0 * EXPECTED, EXPECTED, others)) == "twice"


def test_nothing_is_named_where_nothing_explains_it() -> None:
    assert explain(np.cos(X), EXPECTED, (TURNED,)) is None


@pytest.mark.parametrize(("more", "words"), [(0.5, "turned"), (0.25, None)])
def test_of_two_that_explain_it_about_as_well_none_is_named(more: float, words: str | None) -> None:
    """The first leaves a tenth of the difference; the other one a quarter, or hardly more than the first."""
    found = -EXPECTED + 0.2 * np.cos(X)
    other = Hypothesis("another", "", found + more * np.cos(2.0 * X))
    assert named(explain(found, EXPECTED, (TURNED, other))) == words


def test_two_that_are_alike_are_both_named() -> None:
    found = -EXPECTED + 0.02 * np.cos(X)
    other = Hypothesis("another", "", found + 0.02 * np.cos(2.0 * X))
    assert named(explain(found, EXPECTED, (TURNED, other))) == "turned, or another"


def test_noise_that_hides_the_difference_of_two_names_none() -> None:
    other = Hypothesis("another", "", -1.2 * EXPECTED)
    assert named(explain(-EXPECTED, EXPECTED, (TURNED, other))) == "turned"
    assert explain(-EXPECTED, EXPECTED, (TURNED, other), noise=0.8) is None


def test_of_two_that_are_the_same_the_first_is_named() -> None:
    assert named(explain(-EXPECTED, EXPECTED, (TURNED, Hypothesis("mirrored", "", -EXPECTED)))) == "turned"


def test_a_fitted_number_is_named_only_where_no_mistake_without_one_explains_it() -> None:
    fitted = Hypothesis("times -1", "", -EXPECTED, fitted=1)
    assert named(explain(-EXPECTED, EXPECTED, (fitted, TURNED))) == "turned"
    assert named(explain(-EXPECTED, EXPECTED, (fitted,))) == "times -1"


@pytest.mark.parametrize(("rows", "words"), [(1.0, "comes 1 row late"), (-2.0, "comes 2 rows early"), (0.4, "comes 0.4 rows late")])
def test_lateness_by_rows_and_by_a_part_of_one(rows: float, words: str) -> None:
    """Against the closed form: a sine of forty rows a period."""
    row = np.arange(200.0)
    late, expected = (np.sin(2.0 * np.pi * (row - lag) / 40.0) for lag in (rows, 0.0))
    assert named(explain(late, expected, lateness(late, expected))) == words


@pytest.mark.parametrize(
    ("share", "words"), [(0.0234, "2.3 %"), (1.234, "120 %"), (86.2, "86 times its size"), (8612.0, "8600 times its size")]
)
def test_shares_are_told_without_exponents(share: float, words: str) -> None:
    assert share_of(share) == words


@pytest.mark.parametrize(
    ("other", "words"),
    [
        (lambda force, rubs: np.maximum(force, 0.0), "is that of the plus roller alone"),
        (lambda force, rubs: np.minimum(force, 0.0), "is that of the minus roller alone"),
        (lambda force, rubs: rubs, "is the friction along the follower"),
        (lambda force, rubs: np.hypot(force, rubs), "is the size of normal force and friction together"),
    ],
)
def test_other_forces_of_the_slider(other: Callable[..., NDArray[np.float64]], words: str) -> None:
    """The speed of the slider is that of the crank tip along the straight line from P, as the follower hardly bends."""
    scene = changed(
        BASE, {"slider.joint_stiffness": 5e3, "slider.friction": 0.8, "slider.friction_force": 1.0, "slider.friction_speed": 0.1}
    )
    columns = solution(Motion(scene, 0.4))
    angle, d, length = columns["crank_angle"], scene.pivot_distance, scene.crank.length
    speed = d * length * np.sin(angle) * columns["crank_speed"] / np.sqrt(d**2 + length**2 - 2.0 * d * length * np.cos(angle))
    force = columns["slider_force"]
    found = other(force, (1.0 + 0.8 * np.abs(force)) * np.tanh(speed / 0.1))
    finding = diagnose("slider_force", found, force, 1e-3, columns, scene)
    assert finding is not None
    assert finding.cause == f"slider_force {words}"
