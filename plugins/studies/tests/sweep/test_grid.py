"""Axes as they are written, and the scenes of their grid."""

import math

import pytest

from quickreturn.cases.files.errors import CaseError
from quickreturn.cases.files.reading import changes_of
from quickreturn.cases.library import library_case
from quickreturn.cases.motion.endings import Ending
from quickreturn.plugins.studies.sweep.grid import Grid, axis, scenes_of
from quickreturn.plugins.studies.sweep.rows import OPEN, Impossible

RPM = math.pi / 30.0


def test_a_range_is_even_in_its_own_unit() -> None:
    found = axis("crank.prescribed_speed = 60 rpm .. 300 rpm : 5")
    assert found.texts == ("60 rpm", "120 rpm", "180 rpm", "240 rpm", "300 rpm")
    assert found.values == pytest.approx([60 * RPM, 120 * RPM, 180 * RPM, 240 * RPM, 300 * RPM], rel=1e-12)
    assert found.unit == "rad/s"


def test_a_logarithmic_range_has_equal_ratios() -> None:
    assert axis("slider.joint_stiffness = log 1 N/mm .. 100 N/mm : 3").values == pytest.approx((1e3, 1e4, 1e5), rel=1e-12)


def test_a_list_keeps_its_order_and_infinity() -> None:
    assert axis("follower.bending_stiffness = 2 N*m^2; inf; 1 N*m^2").values == (2.0, math.inf, 1.0)


def test_vectors_are_listed_as_texts() -> None:
    found = axis('mechanism.gravity = ["0 m/s^2", "0 m/s^2"]; ["0 m/s^2", "-9.81 m/s^2"]')
    upright, level = scenes_of(library_case("thesis-24"), [{found.key: vector} for vector in found.numbers])
    assert not isinstance(upright, Impossible)
    assert not isinstance(level, Impossible)
    assert (upright.gravity, level.gravity) == ((0.0, 0.0), (0.0, -9.81))


@pytest.mark.parametrize(
    ("text", "told"),
    [
        ("tip.mass", "is no axis"),
        ('mechanism.gravity = ["0 m/s^2", "-9.8 m/s^2 +- 1 %"]; ["0 m/s^2", "0 m/s^2"]', "has a tolerance; give single values"),
        ("tip.mas = 0 g; 1 g", "tip.mass"),
        ("tip.mass = 0 g .. 60 g", "is no range"),
        ("tip.mass = 1 g; 0.001 kg", "twice"),
        ("slider.joint_stiffness = log 0 N/m .. 1 N/m : 3", "not positive"),
        ("simulation.duration = 1 s; 2 s", "changes no steady motion"),
        ("engine = referense", "reference"),
    ],
)
def test_a_mistake_is_told(text: str, told: str) -> None:
    with pytest.raises(CaseError, match=told):
        axis(text)


def test_a_grid_too_large_or_with_a_key_twice_is_refused() -> None:
    case = library_case("thesis-24")
    with pytest.raises(CaseError, match="1000000000 points"):
        Grid(case, tuple(axis(f"{key} = 0 g .. 1 g : 1000".replace("0 g .. 1 g", ends)) for key, ends in HUGE.items()))
    with pytest.raises(CaseError, match="varies twice"):
        Grid(case, (axis("tip.mass = 0 g; 1 g"), axis("tip.mass = 2 g; 3 g")))


HUGE = {"tip.mass": "0 g .. 1 g", "crank.prescribed_speed": "1 rpm .. 2 rpm", "follower.damping": "0 N*s/m^2 .. 1 N*s/m^2"}


def test_rows_run_along_the_axis_that_keeps_the_shapes() -> None:
    grid = Grid(library_case("thesis-24"), (axis("tip.mass = 0 g .. 9 g : 10"), axis("crank.prescribed_speed = 1 rpm; 2 rpm; 3 rpm")))
    assert grid.along == 1
    assert list(grid.rows()) == [(number, 0) for number in range(10)]
    assert grid.changes((2, 1)) == pytest.approx({"tip.mass": 2e-3, "crank.prescribed_speed": 2.0 * RPM}, rel=1e-15)


def test_what_cannot_be_becomes_a_point_with_its_sentence() -> None:
    long, negative = scenes_of(library_case("thesis-24"), [changes_of({"crank.length": "20 in"}, "test"), {"tip.mass": -1e-3}])
    assert isinstance(long, Impossible)
    assert long.status == OPEN
    assert long.sentence.startswith('crank.length: "20 in" cannot be')
    assert isinstance(negative, Impossible)
    assert negative.status == Ending.REFUSED
    assert negative.sentence.startswith('tip.mass: "-0.001 kg" is negative')
