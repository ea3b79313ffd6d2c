"""Natural frequencies with the crank held, of every engine alike, and the motion in a natural mode in closed form."""

import math
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import pytest

from quickreturn.engines.base import EngineFailure
from quickreturn.engines.one_run import natural_frequencies
from quickreturn.engines.own.reference import ReferenceEngine
from quickreturn.engines.registry import MAIN, engine
from quickreturn.engines.settings import Settings
from quickreturn.engines.start import Start
from quickreturn.reference_model.arrays import Array
from quickreturn.reference_model.mechanism import Mechanism, PrescribedSpeed
from quickreturn.reference_model.natural_modes import FrozenModes, frozen_crank_modes
from quickreturn.reference_model.rigid import follower_inertia, rigid_motion
from tests.engines.scenes import run_24

#: Of run 24 at crank angles, Hz, from converged models of other kinds.
CONVERGED = {180: (20.354, 62.287, 112.95, 212.94), 90: (17.779, 45.604, 135.26, 263.37), 0: (10.925, 63.787, 123.83, 230.04)}


def settings_of(name: str, **texts: str) -> Settings:
    return engine(name).settings_for(engine(name).default_accuracy, run_24()).with_texts(texts)


@pytest.mark.parametrize("degrees", CONVERGED)
@pytest.mark.parametrize(
    ("name", "size", "tolerance"),
    [
        ("reference", {"modes": "1"}, 5e-5),  # half a unit of the last digit, whatever the number of modes
        ("reference", {"modes": "5"}, 5e-5),
        ("fixed-shapes", {}, 5e-5),
        ("exudyn", {}, 5e-4),
        ("mujoco", {}, 5e-3),  # the fourth mode is the worst: 0.4 % with twelve links
        ("mujoco", {"links": "60"}, 2e-4),  # 1.2e-4
    ],
)
def test_frequencies_of_run_24(name: str, size: dict[str, str], tolerance: float, degrees: int) -> None:
    found = engine(name).natural_frequencies(run_24(), math.radians(degrees), 4, settings_of(name, **size))
    np.testing.assert_allclose(found, CONVERGED[degrees], rtol=tolerance)


@pytest.mark.parametrize("name", MAIN)
def test_a_rigid_follower_has_no_natural_frequency(name: str) -> None:
    rigid = run_24(follower={"bending_stiffness": math.inf})
    assert engine(name).natural_frequencies(rigid, 1.0, 4, settings_of(name)).shape == (0,)


@pytest.mark.parametrize("name", ["reference", "exudyn", "mujoco", "stiff-spring"])
def test_a_rigid_follower_swings_on_a_soft_joint(name: str) -> None:
    """One pendulum: stiffness k s^2 against its moment of inertia about P."""
    scene = run_24(follower={"bending_stiffness": math.inf}, slider={"joint_stiffness": 1e4})
    expected = math.sqrt(1e4 / follower_inertia(scene)[0]) * float(rigid_motion(scene, np.array(1.0), 0.0).slider_position)
    chosen = engine(name)
    found = chosen.natural_frequencies(scene, 1.0, 4, chosen.settings_for(chosen.default_accuracy, scene))
    np.testing.assert_allclose(found, [expected / (2.0 * math.pi)], rtol=1e-9)


class Answers(ReferenceEngine):
    """Gives a made-up answer."""

    def __init__(self, answer: Any) -> None:
        self.answer = answer

    def natural_frequencies(self, *_: Any) -> Any:
        return self.answer


@pytest.mark.parametrize(
    ("answer", "wrong"),
    [
        ([10.0, math.nan], r"that are not finite: \[10.0, nan\]"),
        ([10.0, math.inf], "that are not finite"),
        ([-1.0, 10.0], "below zero"),
        ([20.0, 10.0], "that do not ascend"),
        (["10", "20"], "that are no list of numbers"),
        ([10.0 + 1.0j], "that are no list of numbers"),
        ([[10.0, 20.0]], "that are no list of numbers"),
        ([[10.0], [20.0, 30.0]], "that are no list of numbers"),
        (None, "that are no list of numbers: None"),
    ],
)
def test_frequencies_that_cannot_be_are_the_engines_failure(answer: Any, wrong: str) -> None:
    with pytest.raises(EngineFailure, match=f"the engine returned natural frequencies {wrong}"):
        natural_frequencies(Answers(answer), run_24(), 0.0, 2, settings_of("reference"))


#: Tip deflection at the start, m. Small: stiffness changes by the square of the slope, 1e-6 here.
AMPLITUDE = 3e-4
DURATION = 0.1  # s, two periods of the first mode

#: Engine -> its settings, and what the tip may be off by, in amplitudes, at worst.
ENGINES = {
    # tables of the shapes, and the square of the slope over four turns of phase
    "reference": ({"modes": "3", "tolerance": "1e-9"}, 1e-4),
    "fixed-shapes": ({"shapes": "12", "tolerance": "1e-9"}, 2e-3),
    "multiplier": ({"shapes": "12", "tolerance": "1e-9"}, 2e-3),
    "exudyn": ({"elements": "16", "step": "1e-4"}, 5e-3),
    "mujoco": ({"links": "32"}, 5e-3),
}


@dataclass(frozen=True)
class _Bent:
    """The first mode seen from the base's tangent."""

    modes: FrozenModes
    size: float

    def __call__(self, x: Array, nu: int = 0, /) -> Array:
        turned = self.modes.deflection(np.zeros(1), 1)[0, 0]
        line = {0: turned * x, 1: turned * np.ones_like(x)}.get(nu, np.zeros_like(x))
        return np.asarray(self.size * (self.modes.deflection(x, nu)[0] - line))


def held(degrees: float) -> tuple[Mechanism, Start, float]:
    """Run 24 without dampers and with its crank held, bent as in its first mode; and the mode's frequency, Hz."""
    angle = np.radians(degrees)
    scene = run_24(base={"damping": 0.0}, follower={"damping": 0.0})
    scene = replace(scene, crank=replace(scene.crank, drive=PrescribedSpeed(speed=0.0), initial_angle=angle))
    modes = frozen_crank_modes(scene, angle, 1)
    shape = _Bent(modes, 1.0)
    size = AMPLITUDE / float(shape(np.array([scene.follower.length]))[0])
    return scene, Start(angle, 0.0, _Bent(modes, size)), float(modes.frequencies[0])


@pytest.mark.parametrize("degrees", [180.0, 60.0])
@pytest.mark.parametrize("name", list(ENGINES))
def test_the_follower_swings_in_its_first_mode(name: str, degrees: float) -> None:
    texts, tolerance = ENGINES[name]
    scene, start, frequency = held(degrees)
    chosen = engine(name)
    settings = chosen.settings_for(1e-3, scene).with_texts(texts)
    found = chosen.prepare(scene, start, settings).advance(DURATION, 1e-3)
    exact = AMPLITUDE * np.cos(2.0 * np.pi * frequency * found["time"])
    np.testing.assert_allclose(found["tip_deflection"], exact, rtol=0.0, atol=tolerance * AMPLITUDE)
    np.testing.assert_allclose(found["crank_angle"], start.crank_angle, rtol=0.0, atol=1e-12)
    np.testing.assert_allclose(found["crank_speed"], 0.0, atol=1e-12)
    np.testing.assert_allclose(found["drive_work"], 0.0, atol=1e-15)
