"""Runs of the thesis' model for the tests: scene in, states and observables out."""

import dataclasses
import math
from typing import Any

import numpy as np

from quickreturn.reference_model.arrays import Array
from quickreturn.reference_model.mechanism import Mechanism, TorqueDrive
from quickreturn.reference_model.shapes import hermite_elements, no_shapes
from quickreturn.reference_model.thesis.model import ThesisModel
from tests.engines.scenes import run_24


def thesis(mechanism: Mechanism, *, elements: int = 1, exact: bool = False) -> ThesisModel:
    return ThesisModel(mechanism, hermite_elements(mechanism.follower.length, elements), exact)


def rigid(mechanism: Mechanism) -> ThesisModel:
    return ThesisModel(mechanism, no_shapes(mechanism.follower.length), True)


def undriven(**changes: Any) -> Mechanism:
    """Run 24 without torque and damping, from its speed."""
    drive = TorqueDrive(torque=0.0, damping=0.0, initial_speed=run_24().crank.drive.initial_speed)
    still = run_24(crank={"drive": drive}, base={"damping": 0.0}, follower={"damping": 0.0})
    return dataclasses.replace(still, **changes)


def period(mechanism: Mechanism) -> float:
    """Time of one turn at the initial speed, s."""
    return 2.0 * math.pi / mechanism.crank.drive.initial_speed


def error(found: Array, expected: Array) -> float:
    """RMS of the difference over the RMS of what is expected."""
    return float(np.sqrt(np.mean((found - expected) ** 2) / np.mean(expected**2)))
