"""Continuation along a parameter: on maps whose branches are known in closed form, and on a machine against marching."""

import math
from collections.abc import Callable

import numpy as np
import pytest

from quickreturn.reference_model.arrays import Array
from quickreturn.reference_model.cycles.continuation import Branch, branch
from quickreturn.reference_model.cycles.cycle_family import CycleFamily
from quickreturn.reference_model.cycles.fixed_points import Image, Limits, NotConverged, first_point
from quickreturn.reference_model.cycles.poincare import CycleBroken
from quickreturn.reference_model.mechanism import Mechanism, PrescribedSpeed
from tests.engines.scenes import run_24


class Known:
    """A map given by a formula; its noise is round-off."""

    def __init__(self, formula: Callable[[Array, float], Array]) -> None:
        self.formula = formula

    def image(self, point: Array, parameter: float) -> Image:
        found = self.formula(point, parameter)
        return Image(found, np.ones(len(point)), np.full(len(point), 1e-16))


def special(found: Branch, kind: str) -> list[float]:
    return [each.parameter for each in found.points if each.special == kind]


def test_both_folds_of_a_cubic() -> None:
    """Of x -> x + 0.3 (a + x - x^3): fixed points a = x^3 - x, folds where 3 x^2 = 1, at a = +-2/(3 sqrt 3)."""
    found = branch(Known(lambda x, a: x + 0.3 * (a + x - x**3)), np.array([-1.25]), -0.9, -1.0, 1.0)
    assert special(found, "fold") == pytest.approx([2.0 / math.sqrt(27.0), -2.0 / math.sqrt(27.0)], abs=1e-10)
    assert found.endings == (None, None)
    assert [found.points[0].parameter, found.points[-1].parameter] == [-1.0, 1.0]
    for each in found.points:
        assert each.point[0] ** 3 - each.point[0] == pytest.approx(each.parameter, abs=1e-6)
        if not each.special:  # multiplier 1 + 0.3 (1 - 3 x^2), unstable between the folds
            assert each.multipliers[0].real == pytest.approx(1.3 - 0.9 * each.point[0] ** 2, abs=1e-3)
            assert each.instability == ("fold" if 3.0 * each.point[0] ** 2 < 1.0 else "")


def test_period_doubling_of_the_logistic_map() -> None:
    """Of x -> a x (1 - x): multiplier 2 - a at x = 1 - 1/a, minus one at a = 3. Derivatives are good to 1e-4, so is the place."""
    found = branch(Known(lambda x, a: a * x * (1.0 - x)), np.array([0.6]), 2.5, 2.2, 3.4)
    assert special(found, "period doubling") == pytest.approx([3.0], abs=4e-4)
    assert {each.instability for each in found.points if each.parameter > 3.001} == {"period doubling"}
    assert {each.instability for each in found.points if each.parameter < 2.999} == {""}


def test_torus_of_a_turning_map() -> None:
    """Of x -> a R x - x |x|^2 about x = 0, with R a turn by 1 rad: a pair of multipliers leaves the unit circle at a = 1."""
    turn = np.array([[math.cos(1.0), -math.sin(1.0)], [math.sin(1.0), math.cos(1.0)]])
    found = branch(Known(lambda x, a: a * turn @ x - x * (x @ x)), np.zeros(2), 0.6, 0.5, 1.5)
    assert special(found, "torus") == pytest.approx([1.0], abs=1e-5)
    assert found.points[-1].instability == "torus"


def test_a_closed_branch_is_gone_round_once() -> None:
    """Fixed points on the circle x^2 + a^2 = 1, with a fold at either end."""
    found = branch(Known(lambda x, a: x + 0.2 * (1.0 - a**2 - x**2)), np.array([1.0]), 0.0, -2.0, 2.0)
    assert sorted(special(found, "fold")) == pytest.approx([-1.0, 1.0], abs=1e-7)  # a correction leaves 1e-8 of the range's width


def test_a_branch_that_ends_says_why() -> None:
    """The map has no image beyond a = 1; the last step is halved until it changes a by 1e-4 of the range at most."""

    def formula(x: Array, a: float) -> Array:
        if a > 1.0:
            raise CycleBroken("it ended", left=True)
        return 0.5 * (x + a)

    found = branch(Known(formula), np.array([0.5]), 0.5, 0.0, 3.0)
    ending = found.endings[1]
    assert ending.left
    assert ending.parameter == pytest.approx(1.0, abs=1e-3)
    assert found.endings[0] is None


def test_no_fixed_point_is_an_answer() -> None:
    with pytest.raises(NotConverged, match="corrections"):
        first_point(Known(lambda x, a: x + 1.0 + x**2), np.array([0.7]), 0.0, Limits.of(-1.0, 1.0))


RPM = math.pi / 30.0


def at_speed(speed: float) -> Mechanism:
    return run_24(crank={"drive": PrescribedSpeed(speed=speed)})


@pytest.mark.verify
def test_marching_jumps_where_the_fold_is() -> None:
    """Run 24's machine in two modes: a march stays on the branch 0.4 rpm below its fold and leaves it 0.4 rpm above.

    The branch comes back below the fold, unstable. At 0.4 rpm from the fold the stable one has a multiplier below 0.8, so that 40 cycles
    leave 1e-4 of a disturbance.
    """
    low, high = 236.5 * RPM, 241.0 * RPM
    family = CycleFamily(at_speed, 2, 1e-8)
    found = branch(family, family.orbit(low), low, low, high)
    (fold,) = special(found, "fold")
    assert found.points[-1].parameter == low
    assert [each.instability for each in found.points if each.parameter == low] == ["", "fold"]
    for speed, stays in ((fold - 0.4 * RPM, True), (fold + 0.4 * RPM, False)):
        near = min((each for each in found.points if not each.instability), key=lambda each: abs(each.parameter - speed))
        point = near.point
        for _ in range(40):
            point = family.image(point, speed).point
        moved = np.max(np.abs(point - near.point) / near.sizes)
        assert bool(moved < 0.3) is stays, (speed / RPM, moved)
        assert (np.max(np.abs(family.image(point, speed).point - point) / near.sizes) < 1e-3) or not stays
