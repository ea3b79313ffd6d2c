"""The base of engines that model a clamped rod: a rod that curls into circles, whose curvature and acceleration are known."""

from typing import Any

import numpy as np
import pytest

from quickreturn.engines.base import SPIN_UP, EngineFailure, Refusal
from quickreturn.engines.one_run import run_once
from quickreturn.engines.rod import Rod, RodEngine, RodSettings
from quickreturn.engines.settings import SettingError
from quickreturn.plugins.conform.scenes import BASE
from quickreturn.plugins.conform.scenes import CLAMPED as SCENE
from quickreturn.reference_model.mechanism import FollowerAlone
from quickreturn.reference_model.scene_values import changed

LENGTH = SCENE.follower.length
RATE = 20.0  # of the curvature, 1/(m s): the end turns by a radian


class Circle(Rod):
    """Its curvature grows in time; `behind`: part of a piece that its clamp holds."""

    behind = 0.0

    def __init__(self, scene: FollowerAlone, pieces: int) -> None:
        self.time, h = 0.0, scene.follower.length / (pieces - self.behind)
        self.places, self.state = h * (np.arange(pieces + 1) - self.behind), np.zeros((3, pieces + 1))
        self.advance(0.0)

    def advance(self, duration: float) -> None:
        self.time += duration
        curvature = max(RATE * self.time, 1e-12)
        s = self.places
        self.state[:2] = np.sin(curvature * s) / curvature, (1.0 - np.cos(curvature * s)) / curvature
        self.state[0, s < 0.0], self.state[1, s < 0.0] = s[s < 0.0], 0.0

    def points(self) -> Any:
        return self.state[:2].T  # a view, as libraries return

    def acceleration(self) -> Any:
        end = RATE * self.time * LENGTH
        return 3.0 * -np.sin(end), 3.0 * np.cos(end)


class CircleEngine(RodEngine):
    name, method, library, rod = "circle", "known", "numpy", Circle
    errors, order = {4: 0.06, 8: 0.015, 16: 0.004}, 2.0
    quantities = ("mechanism.gravity",)


def engine_of(**members: Any) -> RodEngine:
    return type("Other", (CircleEngine,), {"rod": type("OtherCircle", (Circle,), members)})()


def advanced(engine: RodEngine, pieces: int = 40) -> Any:
    return run_once(engine, SCENE, None, 0.1, 1e-3, RodSettings(resolution=pieces)).trajectory


@pytest.mark.parametrize("behind", [0.0, 0.5])
def test_a_row_follows_from_points_and_acceleration(behind: float) -> None:
    run = advanced(engine_of(behind=behind))
    curvature = RATE * run["time"]
    assert run["tip_deflection"][-1] == pytest.approx((1.0 - np.cos(curvature[-1] * LENGTH)) / curvature[-1], rel=1e-9)
    assert run["tip_x"][0] == pytest.approx(LENGTH)
    for k in (1, 2, 3):
        assert run[f"strain_{k}"] == pytest.approx(SCENE.follower.extreme_fibre * curvature, rel=1e-3, abs=1e-12)
    # the last piece points where the tangent of its middle does
    assert run["tip_acceleration"] == pytest.approx(3.0, rel=1e-3)


def test_pieces_of_a_run_continue_on_the_grid() -> None:
    simulation = CircleEngine().prepare(SCENE, None, RodSettings(resolution=8))
    first, second = simulation.advance(0.1, 1e-3), simulation.advance(0.05, 5e-4)
    assert second["time"] == pytest.approx(0.1 + 5e-4 * np.arange(101), abs=1e-15)
    assert {name: first[name][-1] for name in first.columns} == {name: second[name][0] for name in second.columns}


@pytest.mark.parametrize(
    ("members", "words"),
    [
        ({"points": lambda self: self.state}, r"points\(\) of OtherCircle has the shape \(3, 41\); \(n, 2\) is needed"),
        ({"points": lambda self: self.state[1::-1].T}, "does not begin as a straight line along n1"),
        ({"points": lambda self: self.state[:2, ::-1].T}, "does not begin as a straight line along n1"),
        ({"points": lambda self: self.state[:2, : 41 if self.time < 0.01 else 40].T}, r"has the shape \(40, 2\); \(41, 2\) is needed"),
        ({"acceleration": lambda self: np.zeros(3)}, r"acceleration\(\) of OtherCircle has the shape \(3,\); \(2,\) is needed"),
        ({"acceleration": lambda self: (0.0, np.nan)}, "tip_acceleration is no longer a finite number"),
    ],
)
def test_what_a_rod_returns_is_checked(members: dict[str, Any], words: str) -> None:
    with pytest.raises(EngineFailure, match=words):
        advanced(engine_of(**members))


@pytest.mark.parametrize("scene", [BASE, changed(SCENE, {"base.spin_up_speed": 3.0})], ids=["mechanism", "spin-up"])
def test_other_scenes_are_refused(scene: Any) -> None:
    with pytest.raises(Refusal, match="engine circle models a clamped rod; accepted: a scene without"):
        CircleEngine().check(scene)


def test_settings_estimate_and_description_follow_from_errors_and_order() -> None:
    engine = CircleEngine()
    assert SPIN_UP in engine.quantities
    assert engine.settings_for(0.02, SCENE) == RodSettings(resolution=8)
    (pair,) = engine.comparisons(RodSettings(resolution=8), SCENE, 1e-3)
    assert (pair.other, pair.factor) == (RodSettings(resolution=12), pytest.approx((8 / 12) ** 2))
    assert engine.finer(RodSettings(resolution=8), {"resolution": 2.0}, 1e-3) == RodSettings(resolution=16)
    assert engine.finer(RodSettings(resolution=16), {}, 1e-3) is None
    assert engine.describe(SCENE, RodSettings(resolution=8)).degrees_of_freedom == 8
    with pytest.raises(SettingError, match="engine circle begins with 4"):
        advanced(engine, 3)
    with pytest.raises(Refusal, match=r"mechanism\.gravity: .* is not modelled by engine circle"):
        type("Weightless", (CircleEngine,), {"quantities": ()})().check(SCENE)
    with pytest.raises(TypeError, match="class Lacking lacks library, errors, order"):
        type("Lacking", (RodEngine,), {"name": "lacking", "method": "none", "rod": Circle})()
