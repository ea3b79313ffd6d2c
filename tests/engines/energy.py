"""Energy balance of a trajectory: stored = at the start + work of the drive - dissipated; and engines beside what they claim."""

import numpy as np

from quickreturn.engines.accurate import Result
from quickreturn.engines.trajectory import Trajectory, rms, scale
from quickreturn.reference_model.arrays import Array


def from_nowhere(trajectory: Trajectory) -> Array:
    """Energy that came from nowhere since the start, J, shape (rows,)."""
    stored = trajectory["kinetic_energy"] + trajectory["strain_energy"] + trajectory["gravity_energy"]
    total = stored + trajectory["dissipated_energy"] - trajectory["drive_work"]
    return np.asarray(total - total[0])


def imbalance(trajectory: Trajectory) -> float:
    """The largest of it over the largest strain energy."""
    return float(np.abs(from_nowhere(trajectory)).max() / trajectory["strain_energy"].max())


def assert_agree(ours: Result, theirs: Result) -> None:
    """Every column differs by no more than both estimates."""
    for column, estimate in theirs.error_estimates.items():
        own = ours.error_estimates[column]
        difference = rms(theirs.trajectory[column] - ours.trajectory[column])
        assert difference <= (estimate + own) * scale(column, ours.trajectory.columns), column
