"""Runs of the one beam, with its own tables or with finer ones."""

from functools import cache

import numpy as np

from quickreturn.plugins.methods.moving_boundaries.model import MovingBoundariesModel
from quickreturn.reference_model.arrays import Array
from quickreturn.reference_model.beam.modes import ModeFamily, mode_family
from quickreturn.reference_model.beam.tables import slider_range, span_tables
from quickreturn.reference_model.integrate import REACHED_END
from quickreturn.reference_model.joint import CLOSED, SliderConstraint
from quickreturn.reference_model.mechanism import Mechanism
from quickreturn.reference_model.model import BeamModel
from quickreturn.reference_model.motion.parameters import parameters
from quickreturn.reference_model.shapes import clamped_free_modes
from quickreturn.reference_model.thesis.model import ThesisModel


def places_of(mechanism: Mechanism) -> tuple[float, float]:
    """Nearest and farthest place of the rigid mechanism's slider, m."""
    return mechanism.pivot_distance - mechanism.crank.length, mechanism.pivot_distance + mechanism.crank.length


@cache
def fine_family(mechanism: Mechanism, modes: int) -> ModeFamily:
    """Shapes around the places that the slider visits: 120 terms leave 1e-9 of psi and 1e-6 of its second derivative in five modes."""
    nearest, farthest = places_of(mechanism)
    return mode_family(mechanism, modes, 0.98 * nearest, min(1.02 * farthest, slider_range(mechanism).high), 120)


def with_fine_tables(
    mechanism: Mechanism, modes: int, *, points: int = 11, intervals: int = 400, constraint: SliderConstraint = CLOSED
) -> BeamModel:
    """Shapes that follow the slider, in tables whose errors are 1e-8 and less: what is left is the equations' own."""
    family = fine_family(mechanism, modes)
    constants = parameters(mechanism, modes, span_tables(family, points, intervals), family.high, constraint)
    return BeamModel(mechanism, constants, family.angles)


def run(
    model: BeamModel | ThesisModel | MovingBoundariesModel, duration: float, intervals: int, tolerance: float, state: Array | None = None
) -> tuple[Array, dict[str, Array]]:
    """States and observables on a uniform grid, from the standard start or a given state."""
    crank, begin = model.scene.crank, model.initial_state if isinstance(model, ThesisModel) else model.straight_state
    y = begin(crank.initial_angle, crank.drive.initial_speed) if state is None else state
    result = model.integrate(y, duration / intervals, intervals, tolerance)
    assert result.status == REACHED_END
    return result.states, model.observe(result.states)


def balance(columns: dict[str, Array]) -> Array:
    """Stored energy and what was dissipated, less the work of the drive, J: constant but for the work that the lever rule does."""
    stored = columns["kinetic_energy"] + columns["strain_energy"] + columns["gravity_energy"]
    return np.asarray(stored + columns["dissipated_energy"] - columns["drive_work"], dtype=np.float64)


def follower_energy(model: BeamModel | ThesisModel, columns: dict[str, Array]) -> float:
    """Largest kinetic energy of all but the crank, plus strain energy, J: the flywheel's would hide any drift."""
    crank = 0.5 * model.parameters.crank_inertia * columns["crank_speed"] ** 2
    return float(np.max(columns["kinetic_energy"] - crank + columns["strain_energy"]))


def staying(mechanism: Mechanism, shapes: int) -> BeamModel:
    """Clamped-free modes that stay where they are."""
    return BeamModel.staying(mechanism, clamped_free_modes(mechanism.follower.length, shapes))
