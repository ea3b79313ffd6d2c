"""Runs of the explicit model for the tests: scene in, states and observables out."""

import dataclasses
import math
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from reference_model.integrate import REACHED_END
from reference_model.mechanism import Mechanism, TorqueDrive
from reference_model.model import ExplicitModel
from reference_model.shapes import clamped_free_modes, hermite_elements, no_shapes
from tests.engines.scenes import run_24

Array = NDArray[np.float64]
Method = Literal["DOP853", "LSODA"]


def thesis(mechanism: Mechanism, *, exact: bool = False) -> ExplicitModel:
    return ExplicitModel(mechanism, hermite_elements(mechanism.follower.length, 1), exact, False)


def reference(mechanism: Mechanism, shapes: int, *, recover: bool = True) -> ExplicitModel:
    return ExplicitModel(mechanism, clamped_free_modes(mechanism.follower.length, shapes), True, recover)


def rigid(mechanism: Mechanism) -> ExplicitModel:
    return ExplicitModel(mechanism, no_shapes(mechanism.follower.length), True, False)


def undriven(**changes: Any) -> Mechanism:
    """Run 24 without torque and damping, from its speed."""
    drive = TorqueDrive(torque=0.0, damping=0.0, initial_speed=run_24().crank.drive.initial_speed)
    still = run_24(crank={"drive": drive}, base={"damping": 0.0}, follower={"damping": 0.0})
    return dataclasses.replace(still, **changes)


def run(
    model: ExplicitModel, duration: float, intervals: int, tolerance: float, *, method: Method = "DOP853", state: Array | None = None
) -> tuple[Array, dict[str, Array]]:
    """States and observables on a uniform grid from the standard start or a given state."""
    crank = model.mechanism.crank
    y = model.initial_state(crank.initial_angle, crank.drive.initial_speed) if state is None else state
    result = model.integrate(y, duration / intervals, intervals, tolerance, method=method)
    assert result.status == REACHED_END
    return result.states, model.observe(result.states)


def period(mechanism: Mechanism) -> float:
    """Time of one turn at the initial speed, s."""
    return 2.0 * math.pi / mechanism.crank.drive.initial_speed


def error(found: Array, expected: Array) -> float:
    """RMS of the difference over the RMS of what is expected."""
    return float(np.sqrt(np.mean((found - expected) ** 2) / np.mean(expected**2)))
