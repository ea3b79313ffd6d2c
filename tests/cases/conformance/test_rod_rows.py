"""Rows of a clamped rod with one mistake each are named; the mistakes that authors of adapters make with sensors and signs."""

import re
from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from quickreturn.cases.conformance.bench import Bench, Motion
from quickreturn.cases.conformance.checks import Fault
from quickreturn.cases.conformance.rod_rows import acceleration, strains
from quickreturn.cases.conformance.rods import SCENE, motion_alone
from quickreturn.engines.base import Simulation
from quickreturn.engines.trajectory import Trajectory
from tests.cases.conformance.rod_engines import LinearMotion, LinearRod, Links

MOTION = Motion(SCENE, 0.66)
Change = Callable[[np.ndarray], np.ndarray]
#: Mistake -> the column, how it is changed, and what is said.
WRONG: dict[str, tuple[str, Change, str]] = {
    "an accelerometer's reading": ("tip_acceleration", lambda a: a + 9.81, r"tip_acceleration is 9\.8\d* m/s\^2 too large on average"),
    "acceleration with the wrong sign": ("tip_acceleration", lambda a: -a, r"tip_acceleration is -1 times the second derivative"),
    "acceleration in mm/s^2": ("tip_acceleration", lambda a: 1e3 * a, r"tip_acceleration is 1e\+03 times|too large on average"),
    "no acceleration": ("tip_acceleration", lambda a: 0.0 * a, r"tip_acceleration is 0 times the second derivative"),
    "an end that stands still": ("tip_deflection", lambda w: 0.0 * w, "tip_deflection does not change"),
    "strain with the wrong sign": ("strain_2", lambda e: -e, r"strain_2 comes to rest at -1\.\d* times the closed form"),
    "curvature for strain": ("strain_1", lambda e: e / SCENE.follower.extreme_fibre, r"strain_1 comes to rest at 669\.\d times"),
    "double thickness": ("strain_3", lambda e: 2.0 * e, r"strain_3 comes to rest at [12]\.\d* times"),
}


class Spoilt(LinearMotion):
    column, change = "", staticmethod(lambda values: values)

    def advance(self, duration: float, output_step: float) -> Any:
        run: Trajectory = super().advance(duration, output_step)
        return replace(run, columns=run.columns | {self.column: self.change(run[self.column])}) if self.column else run


def bench_of(column: str, change: Change) -> Bench:
    kind: Any = type("Kind", (Spoilt,), {"column": column, "change": staticmethod(change)})

    class SpoiltRod(LinearRod):
        def prepare(self, scene: Any, start: Any, settings: Links, /) -> Simulation:
            found: Simulation = kind(self, scene, settings.links)
            return found

    return Bench(SpoiltRod(), alone=motion_alone(SpoiltRod()))


@pytest.mark.parametrize("mistake", WRONG)
def test_a_wrong_column_is_named(mistake: str) -> None:
    column, change, words = WRONG[mistake]
    with pytest.raises(Fault) as found:
        (acceleration if column.startswith("tip_") else strains)(bench_of(column, change), MOTION)
    assert re.search(words, found.value.cause), found.value.cause
    assert found.value.advice
    assert ("accelerometer" in found.value.advice) == (mistake == "an accelerometer's reading")


def test_a_sound_rod_is_right() -> None:
    bench = bench_of("", lambda values: values)
    assert strains(bench, MOTION).startswith("off by")
    assert acceleration(bench, MOTION).startswith("its integral is 1 times")
