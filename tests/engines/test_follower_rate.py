"""The follower's angular velocity and acceleration: the derivatives of its angle, and the closed form of a rigid follower."""

import math
from typing import Any

import numpy as np
import pytest

from quickreturn.cases.library import library_case
from quickreturn.engines.one_run import run_once
from quickreturn.engines.registry import usable_engine
from quickreturn.engines.start import standard_start
from quickreturn.engines.trajectory import Columns
from quickreturn.reference_model.mechanism import Scene, base_motion
from tests.engines.scenes import run_24

MAIN = ("reference", "thesis", "exudyn", "mujoco")
STEP = 2e-5  # s
#: A base that is heavy enough to stand still while the arm's fast vibrations pass.
HEAVY_BASE: dict[str, Any] = {"inertia": 2e-3, "damping": 0.02}


def columns(engine: str, scene: Scene, accuracy: float = 1e-3, duration: float = 0.04, step: float = STEP) -> Columns:
    solver = usable_engine(engine)
    settings = solver.settings_for(max(accuracy, 3e-3) if engine == "exudyn" else accuracy, scene)
    return run_once(solver, scene, standard_start(scene), duration, step, settings).trajectory.columns


def part(found: Any, right: Any) -> float:
    """RMS of the difference over the RMS."""
    return float(np.sqrt(np.mean((found - right) ** 2) / np.mean(right**2)))


@pytest.mark.parametrize("engine", MAIN)
def test_rate_and_acceleration_are_the_derivatives_of_the_angle(engine: str) -> None:
    """`reference` recovers the angle from equilibrium, the rate is that of its modes: its own error parts them.

    MuJoCo's acceleration is that of the base block, which differs a little from the tangent's as the chain's fastest vibrations pass.
    The accelerations of Exudyn ring from step to step, so that they are held against those of other engines (`test_end_moments.py`).
    """
    found = columns(engine, run_24(base=HEAVY_BASE), 1e-4, 0.02)
    inner, angle, rate = slice(2, -2), found["follower_angle"], found["follower_rate"]

    def derivative(values: Any) -> Any:
        return (values[:-4] - 8.0 * values[1:-3] + 8.0 * values[3:-1] - values[4:]) / (12.0 * STEP)

    of_angle, of_rate = {"reference": (5e-5, 2e-4), "thesis": (1e-8, 1e-6), "mujoco": (1e-6, 3e-2), "exudyn": (4e-6, math.inf)}[engine]
    assert part(derivative(angle), rate[inner]) < of_angle
    assert part(derivative(rate), found["follower_acceleration"][inner]) < of_rate


@pytest.mark.parametrize("engine", ["reference", pytest.param("thesis", marks=pytest.mark.verify), "exudyn", "mujoco"])
def test_rate_and_acceleration_of_a_base_that_turns_as_prescribed(engine: str) -> None:
    scene = library_case("spin-up").scene
    found = columns(engine, scene, 1e-2, 15.0, 0.01)
    right = np.array([base_motion(scene.spin_up.speed, scene.spin_up.time, t) for t in found["time"]]).T
    # MuJoCo prescribes the first link, from which the beam's tangent at the base differs as the arm bends
    rate, acceleration = (2e-5, 1e-4) if engine == "mujoco" else (2e-7, 2e-6)
    assert part(found["follower_rate"], right[1]) < rate
    assert part(found["follower_acceleration"], right[2]) < acceleration
