"""A crank held still by a prescribed speed of zero: the follower swings in a natural mode, in closed form, and no work is done."""

from dataclasses import dataclass, replace

import numpy as np
import pytest
from numpy.typing import NDArray

from quickreturn.engines.registry import engine
from quickreturn.engines.start import Start
from quickreturn.reference_model.mechanism import Mechanism, PrescribedSpeed
from quickreturn.reference_model.natural_modes import FrozenModes, frozen_crank_modes
from tests.engines.scenes import run_24

Array = NDArray[np.float64]
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
