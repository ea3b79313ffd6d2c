"""Runs of the thesis' model for the tests: scene in, states and observables out."""

import dataclasses
import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

from reference_model.integrate import REACHED_END
from reference_model.mechanism import Mechanism, TorqueDrive
from reference_model.shapes import hermite_elements, no_shapes
from reference_model.thesis.model import ThesisModel
from tests.engines.scenes import run_24

Array = NDArray[np.float64]


def thesis(mechanism: Mechanism, *, elements: int = 1, exact: bool = False) -> ThesisModel:
    return ThesisModel(mechanism, hermite_elements(mechanism.follower.length, elements), exact)


def rigid(mechanism: Mechanism) -> ThesisModel:
    return ThesisModel(mechanism, no_shapes(mechanism.follower.length), True)


def undriven(**changes: Any) -> Mechanism:
    """Run 24 without torque and damping, from its speed."""
    drive = TorqueDrive(torque=0.0, damping=0.0, initial_speed=run_24().crank.drive.initial_speed)
    still = run_24(crank={"drive": drive}, base={"damping": 0.0}, follower={"damping": 0.0})
    return dataclasses.replace(still, **changes)


def run(
    model: ThesisModel, duration: float, intervals: int, tolerance: float, *, state: Array | None = None
) -> tuple[Array, dict[str, Array]]:
    """States and observables on a uniform grid from the standard start or a given state."""
    assert isinstance(model.scene, Mechanism)
    crank = model.scene.crank
    y = model.initial_state(crank.initial_angle, crank.drive.initial_speed) if state is None else state
    result = model.integrate(y, duration / intervals, intervals, tolerance)
    assert result.status == REACHED_END
    return result.states, model.observe(result.states)


def period(mechanism: Mechanism) -> float:
    """Time of one turn at the initial speed, s."""
    return 2.0 * math.pi / mechanism.crank.drive.initial_speed


def error(found: Array, expected: Array) -> float:
    """RMS of the difference over the RMS of what is expected."""
    return float(np.sqrt(np.mean((found - expected) ** 2) / np.mean(expected**2)))
