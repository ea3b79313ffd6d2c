"""Loads on the parts of a machine: stress along the arm, forces in joints and bearings, and torque."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

from quickreturn.cases.motion.extremes import ErrorAt, of_column, of_vector
from quickreturn.cases.motion.number import Number
from quickreturn.cases.motion.solving import TrajectoryRequest, kept
from quickreturn.cases.running.job import Job
from quickreturn.engines.accurate import Result
from quickreturn.engines.trajectory import Columns
from quickreturn.plugins.strength.stress import ArmStress, Factor, arm_stress, axial_stress, safety
from quickreturn.reference_model.arrays import Array
from quickreturn.reference_model.mechanism import Mechanism, Scene
from quickreturn.reference_model.scene_values import what_moves_nothing

if TYPE_CHECKING:  # a trajectory needs none of these, and they take long to load
    from quickreturn.cases.motion.measure import SettledMotion
    from quickreturn.cases.motion.request import Run

#: Quantities apart from the stress -> SI unit.
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
    fatigue_factor: Factor | None  # fatigue strength over the equivalent amplitude; None for a trajectory that is no cycle
    notch_factors: tuple[Factor | None, ...] = ()  # the same at each notch

    @property
    def factors(self) -> dict[str, Factor]:
        """The known safety factors by what they are against, the least first."""
        both = (("yielding", self.yield_factor), ("fatigue", self.fatigue_factor))
        return dict(sorted(((against, factor) for against, factor in both if factor), key=lambda each: each[1].value))

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
    fatigue = [stress.fatigue, *stress.notches] if stress and cyclic else []
    against_fatigue = [safety(follower.fatigue_strength, each.equivalent) for each in fatigue]
    return Loads(
        stress,
        follower.elastic_modulus,
        {name: of_vector(name, columns, claim) or of_column(name, columns, claim) for name in UNITS},
        axial_stress(scene, columns, claim),
        None if stress is None else safety(follower.yield_strength, stress.largest),
        against_fatigue[0] if against_fatigue else None,
        tuple(against_fatigue[1:]),
    )


def loads_in(motion: "SettledMotion") -> Loads:
    """Loads on the parts in a settled motion."""
    return loads_of(motion.mechanism, motion.cycle, motion.claim)


def loads_of_run(mechanism: Mechanism, run: "Run") -> Loads | None:
    """Loads on the parts in the cycle of a run; None if it has no usable cycle."""
    from quickreturn.cases.motion.measure import SettledMotion

    return loads_in(SettledMotion(mechanism, run)) if run.usable else None


def loads_job(request: TrajectoryRequest, result: Result) -> Job[Loads]:
    """The loads on the parts in a trajectory, as a job; estimates are the columns' largest errors at any instant.

    What a time limit cut short has other estimates, or other settings: its loads are not those of the full answer.
    """
    arguments = request.scene, result.trajectory.columns, result.largest_errors
    inputs = request, what_moves_nothing(request.scene), result.settings, result.largest_errors
    return Job("loads", _of_trajectory, arguments, "loads of a trajectory", inputs=inputs, **kept(request.engine))


def _of_trajectory(scene: Scene, columns: Columns, largest_errors: Mapping[str, float]) -> Loads:
    """Loads with the largest errors of the columns: a peak may err by more than the column does in the mean.

    A trajectory contains the transient of its start, and so says nothing on fatigue.
    """
    return loads_of(scene, columns, lambda name, _: largest_errors.get(name), cyclic=False)
