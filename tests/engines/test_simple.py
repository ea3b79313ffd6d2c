"""The base of usual engines, with a toy: a crank that turns steadily and a tip that swings as x'' = -w^2 x."""

import dataclasses
import math
from collections.abc import Iterator
from typing import Any

import numpy as np
import pytest

from quickreturn.engines.base import SPIN_UP, EngineFailure, Refusal
from quickreturn.engines.one_run import run_once
from quickreturn.engines.settings import SettingError
from quickreturn.engines.simple import Model, SimpleEngine, SimpleSettings
from quickreturn.engines.start import Start, standard_start
from quickreturn.engines.trajectory import REQUIRED
from quickreturn.plugins.conform.scenes import ALONE, BASE, changed
from quickreturn.reference_model.arrays import Array
from quickreturn.reference_model.mechanism import Mechanism
from quickreturn.reference_model.scene_values import NAMED
from quickreturn.reference_model.table import Table

W = 70.0  # rad/s
AMPLITUDE = 0.01  # m
SETTINGS = SimpleSettings(tolerance=1e-9)


class Toy(Model):
    w = W

    def __init__(self, mechanism: Mechanism, start: Start, resolution: int) -> None:
        self.calls, self.held = 0, mechanism.crank.inertia > 1.0
        self.state = np.array([start.crank_angle, AMPLITUDE, start.crank_speed, 0.0])

    def accelerations(self, time: float, coordinates: Array, speeds: Array) -> Any:
        self.calls += 1
        return np.array([0.0, -(self.w**2) * (coordinates[1] - (0.0 if self.held else AMPLITUDE / 2.0))])

    def row(self, time: float, coordinates: Array, speeds: Array) -> dict[str, Any]:
        known = {"crank_angle": coordinates[0], "crank_speed": speeds[0], "tip_deflection": coordinates[1]}
        return dict.fromkeys((name for name in REQUIRED if name != "time"), 0.1) | known


class ToyEngine(SimpleEngine):
    name, method, library, model = "toy", "closed form", "numpy", Toy
    errors, order = {4: 0.1, 8: 0.025, 16: 0.006}, 2.0
    quantities = ("crank.torque", "slider.mass")


def engine_of(**members: Any) -> SimpleEngine:
    """The engine whose model has other members."""
    return type("Other", (ToyEngine,), {"model": type("OtherToy", (Toy,), members)})()


def advanced(engine: SimpleEngine, duration: float = 0.1, settings: SimpleSettings = SETTINGS) -> Any:
    return run_once(engine, BASE, standard_start(BASE), duration, 1e-3, settings).trajectory


def failure_of(engine: SimpleEngine) -> EngineFailure:
    with pytest.raises(EngineFailure) as caught:
        advanced(engine)
    return caught.value


def test_the_accelerations_are_integrated_onto_the_grid() -> None:
    run = advanced(ToyEngine())
    assert np.allclose(run["time"], 1e-3 * np.arange(101))
    assert np.allclose(run["tip_deflection"], AMPLITUDE / 2.0 * (1.0 + np.cos(W * run["time"])), atol=1e-6 * AMPLITUDE)


def test_pieces_go_on_where_the_one_before_ended() -> None:
    simulation = ToyEngine().prepare(BASE, standard_start(BASE), SETTINGS)
    first, second = simulation.advance(0.05, 1e-3), simulation.advance(0.05, 1e-3)
    assert simulation.time == pytest.approx(0.1)
    assert {name: values[-1] for name, values in first.columns.items()} == {name: values[0] for name, values in second.columns.items()}
    assert np.allclose(second["tip_deflection"], advanced(ToyEngine())["tip_deflection"][50:], atol=1e-6 * AMPLITUDE)


def test_a_vibration_that_is_not_excited_costs_no_steps() -> None:
    """At a million rad/s an explicit method would take some hundred thousand evaluations."""
    stiff = engine_of(w=1e6).prepare(BASE, standard_start(BASE), SimpleSettings())
    stiff.state = np.array([0.0, AMPLITUDE / 2.0, 1.0, 0.0])  # type: ignore[attr-defined]
    stiff.advance(0.1, 1e-3)
    assert stiff.model.calls < 500  # type: ignore[attr-defined]


def test_a_tool_may_step_by_itself() -> None:
    def states(self: Toy, times: Any, state: Any, tolerance: float) -> Iterator[Any]:
        for time in times:
            yield np.array([time, 2.0 * time, 1.0, 2.0])

    assert np.allclose(advanced(engine_of(states=states))["tip_deflection"], 2e-3 * np.arange(101))


@pytest.mark.parametrize("name", sorted(NAMED))
def test_what_the_model_has_not_is_refused_by_key_and_value(name: str) -> None:
    values: dict[str, tuple[Any, str]] = {
        "mechanism.gravity": ((0.0, 9.81), "9.81"),
        "crank.prescribed_speed": (7.5, "7.5"),
        SPIN_UP: (6.5, "6.5"),
        "crank.torque": (0.7, "0.7"),
        "crank.torque_table": (Table(("crank_speed", "crank_torque"), (0.0, 9.0), ((1.0, 0.0),)), "of 2 points"),
        "crank.speed_table": (Table(("time", "crank_speed"), (0.0, 9.0), ((1.0, 3.0),)), "of 2 points"),
        "tip.force": ((1.5, 0.0), "1.5"),
        "slider.joint_stiffness": (5e3, "5000"),
    }
    value, shown = values.get(name, (0.75, "0.75"))
    gives_way = {"slider.joint_stiffness_plus": 2e4} if "damping" in name or name == "slider.preload" else {}
    if name.startswith("spring."):
        gives_way = {"spring.anchor": (0.0, -0.4), "spring.preload_length": 0.3, "spring.stiffness": 0.0}
        gives_way |= {"spring.longest": 0.5} if name == "spring.stop_stiffness" else {}
    scene = changed(ALONE if name == SPIN_UP else BASE, gives_way | {name: value})
    others = tuple(each for each in NAMED if each != name)
    with pytest.raises(Refusal, match=name) as refused:
        type("Lacking", (ToyEngine,), {"quantities": others})().check(scene)
    assert shown in str(refused.value)
    assert "accepted" in str(refused.value)
    type("Full", (ToyEngine,), {"quantities": tuple(NAMED)})().check(scene)


def test_a_rigid_follower_is_refused() -> None:
    with pytest.raises(Refusal, match="bending_stiffness"):
        ToyEngine().check(changed(BASE, {"follower.bending_stiffness": math.inf}))


def test_a_quantity_that_there_is_not_is_told_to_the_author() -> None:
    with pytest.raises(TypeError, match=r"gravitation.*mechanism\.gravity"):
        type("Misspelt", (ToyEngine,), {"quantities": ("gravitation",)})


def test_the_ladder_follows_the_measured_errors() -> None:
    engine = ToyEngine()
    assert [engine.settings_for(accuracy, BASE).resolution for accuracy in (0.2, 0.05, 0.01, 1e-4)] == [4, 8, 16, 16]
    (pair,) = engine.comparisons(SimpleSettings(resolution=8), BASE, 1e-3)
    assert (pair.other.resolution, pair.factor) == (12, pytest.approx((8 / 12) ** 2))  # type: ignore[attr-defined]
    assert pair.other.tolerance < pair.run.tolerance  # type: ignore[attr-defined]
    finer = engine.finer(engine.settings_for(0.2, BASE), {"resolution": 4.0}, 1e-3)
    assert finer.resolution == 8
    assert engine.finer(SimpleSettings(resolution=16), {"resolution": 2.0}, 1e-3) is None


def test_frequencies_come_from_the_accelerations_with_the_crank_held() -> None:
    scene = changed(BASE, {"follower.damping": 0.0})
    assert ToyEngine().natural_frequencies(scene, 0.3, 4, SETTINGS) == pytest.approx([W / (2.0 * math.pi)], rel=1e-6)


def test_the_slider_that_leaves_ends_the_run() -> None:
    def row(self: Toy, time: float, coordinates: Any, speeds: Any) -> dict[str, Any]:
        return Toy.row(self, time, coordinates, speeds) | {"slider_position": 0.5 + 2.0 * time}

    failure = failure_of(engine_of(row=row))
    assert "left the follower" in failure.cause
    assert failure.time == pytest.approx(0.05, abs=1.01e-3)
    assert failure.partial["slider_position"].max() <= BASE.follower.length


@pytest.mark.parametrize(("place", "cause"), [(0.1, "does not get on"), (0.599, "left the follower")])
def test_where_there_are_no_accelerations_the_run_ends(place: float, cause: str) -> None:
    def accelerations(self: Toy, time: float, coordinates: Any, speeds: Any) -> Any:
        return np.full(2, np.nan) if time > 0.05 else np.zeros(2)

    def row(self: Toy, time: float, coordinates: Any, speeds: Any) -> dict[str, Any]:
        return Toy.row(self, time, coordinates, speeds) | {"slider_position": place}

    failure = failure_of(engine_of(accelerations=accelerations, row=row))
    assert cause in failure.cause
    assert 0.04 < failure.time <= 0.05
    assert failure.partial is not None


def test_a_motion_that_explodes_is_told() -> None:
    def states(self: Toy, times: Any, state: Any, tolerance: float) -> Iterator[Any]:
        for time in times:
            yield np.array([time, math.inf if time > 0.0305 else time, 1.0, 0.0])

    failure = failure_of(engine_of(states=states))
    assert "explodes" in failure.cause
    assert "tip_deflection" in failure.cause
    assert failure.time == pytest.approx(0.03)


def test_mistakes_of_the_author_are_named() -> None:
    def spoiled(**changes: Any) -> EngineFailure:
        def row(self: Toy, time: float, coordinates: Any, speeds: Any) -> dict[str, Any]:
            made = Toy.row(self, time, coordinates, speeds) | changes
            return {name: value for name, value in made.items() if value is not None}

        return failure_of(engine_of(row=row))

    assert "strain_2" in spoiled(strain_2=None).cause
    assert "tip_defletion" in spoiled(tip_defletion=0.0).cause
    assert "array" in spoiled(tip_x=np.array([0.1])).cause
    short = failure_of(engine_of(accelerations=lambda self, time, coordinates, speeds: np.zeros(3)))
    assert "accelerations" in short.cause
    assert "(3,)" in short.cause
    wrong = failure_of(engine_of(accelerations=lambda self, time, coordinates, speeds: np.linalg.solve(np.eye(3), speeds)))
    assert "test_simple.py" in wrong.cause  # where the author called, not where numpy raised
    time = failure_of(engine_of(row=lambda self, time, coordinates, speeds: None + time))
    assert "TypeError at test_simple.py" in time.cause


def test_a_resolution_that_was_not_measured_is_not_tried() -> None:
    with pytest.raises(SettingError, match=r"resolution: 3 .* 4"):
        advanced(ToyEngine(), settings=SimpleSettings(resolution=3))


def test_version_and_library() -> None:
    assert ToyEngine().version() == f"numpy {np.__version__}"
    assert ToyEngine().unavailable() is None
    missing = type("Missing", (ToyEngine,), {"library": "no-such-distribution"})()
    assert "no-such-distribution" in str(missing.unavailable())


def test_what_is_built_is_told() -> None:
    described = ToyEngine().describe(BASE, SETTINGS)
    assert described.degrees_of_freedom == 2
    assert "tip body" in described.bodies
    assert "tip body" not in ToyEngine().describe(dataclasses.replace(BASE, tip=None), SETTINGS).bodies
