"""Loads on the parts of a machine: stress along the arm, forces in joints and bearings, torque, and the distance to resonance."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

import numpy as np
from numpy.typing import NDArray

from quickreturn.cases.loads.axial import axial_stress
from quickreturn.cases.loads.peak import ErrorAt, of_column, of_vector
from quickreturn.cases.loads.resonance import HARDLY, Resonance, ordinal, resonance, share_of, share_words, shift_of_motion
from quickreturn.cases.loads.stress import ArmStress, Factor, arm_stress, safety
from quickreturn.cases.motion.number import Number
from quickreturn.reference_model.mechanism import Mechanism, Scene

if TYPE_CHECKING:
    from quickreturn.cases.motion.request import Run

__all__ = [
    "HARDLY",
    "ErrorAt",
    "Factor",
    "Loads",
    "Resonance",
    "loads_of",
    "loads_of_run",
    "ordinal",
    "resonance",
    "share_of",
    "share_words",
    "shift_of_motion",
]

Array = NDArray[np.float64]

#: Quantities besides the stress -> SI unit.
UNITS: Final = {"pivot_force": "N", "crank_force": "N", "slider_force": "N", "crank_torque": "N m", "tip_deflection": "m"}


@dataclass(frozen=True)
class Loads:
    """Loads on the parts by an engine; None if it does not give the necessary columns."""

    stress: ArmStress | None  # along the arm
    modulus: float  # of the arm's material, Pa; infinite for a rigid one
    # of each quantity in `UNITS`: forces in the bearings P and O and at the slider, the drive's torque, the tip's deflection
    peaks: Mapping[str, Number | None]
    axial_stress: Number | None  # largest magnitude of the stress by the normal force alone, along the arm, Pa
    yield_factor: Factor | None  # yield strength over the largest stress
    fatigue_factor: Factor | None  # fatigue strength over the equivalent amplitude (`fatigue`); None for a trajectory that is no cycle
    notch_factors: tuple[Factor | None, ...] = ()  # the same at each notch

    @property
    def factors(self) -> list[tuple[str, Factor]]:
        """The known safety factors, each with what it is against, the least first."""
        both = (("yielding", self.yield_factor), ("fatigue", self.fatigue_factor))
        return sorted(((against, factor) for against, factor in both if factor), key=lambda each: each[1].value)

    @property
    def strain(self) -> Number | None:
        """Largest surface strain along the arm."""
        return None if self.stress is None else self.stress.largest.times(1.0 / self.modulus)


def loads_of(scene: Scene, columns: Mapping[str, Array], claim: ErrorAt, *, cyclic: bool = True) -> Loads:
    """Loads on the parts in a cycle or a trajectory.

    Args:
        scene: the mechanism, or a follower alone.
        columns: of the cycle or trajectory, SI, each of shape (rows,).
        claim: error of a column at a crank angle, by the engine's own estimate.
        cyclic: whether the motion repeats, so that fatigue can be judged.
    """
    follower, stress = scene.follower, arm_stress(scene, columns, claim)
    peaks = {name: of_vector(name, columns, claim) or of_column(name, columns, claim) for name in UNITS}
    return Loads(
        stress,
        follower.elastic_modulus,
        peaks,
        axial_stress(scene, columns, claim),
        None if stress is None else safety(follower.yield_strength, stress.largest),
        safety(follower.fatigue_strength, stress.fatigue.equivalent) if stress and cyclic else None,
        tuple(safety(follower.fatigue_strength, notch.equivalent) for notch in stress.notches) if stress and cyclic else (),
    )


def loads_of_run(mechanism: Mechanism, run: "Run") -> Loads | None:
    """Loads on the parts in the cycle of a run; None if it has no usable cycle."""
    return loads_of(mechanism, run.cycle, Claimed(run)) if run.usable else None


@dataclass(frozen=True)
class Claimed:
    """A run's claim for a column in the half cycle of a crank angle: its error estimate and its distance from the steady state."""

    run: "Run"

    def __call__(self, column: str, angle: float) -> float | None:
        begin, end = self.run.cycle["crank_angle"][[0, -1]]
        half = "pre" if 2.0 * abs(angle - begin) <= abs(end - begin) else "post"
        estimate = self.run.measured.extreme_estimates.get(column, {}).get(half)
        if estimate is None:
            return None
        return estimate + self.run.approach.distance(column, float(np.ptp(self.run.cycle[column])))
