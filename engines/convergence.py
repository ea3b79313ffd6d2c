"""How far a model has converged: error over its settings."""

from collections.abc import Sequence
from typing import Final

import numpy as np
import pandas as pd

from engines.base import AnyEngine
from engines.settings import Settings
from engines.start import standard_start
from engines.trajectory import Trajectory
from reference_model.mechanism import Mechanism

#: Channels of the table, in its order.
CHANNELS: Final = ("tip_deflection", "tip_acceleration", "strain_1", "strain_2", "strain_3", "slider_force")


def convergence_table(
    engine: AnyEngine,
    mechanism: Mechanism,
    ladder: Sequence[Settings],
    duration: float,
    output_step: float,
    truth: Trajectory | None = None,
) -> pd.DataFrame:
    """Errors of an engine for every one of several settings, from the standard start.

    The error of a channel is RMS(y - y_ref) / RMS(y_ref) over the output grid. Without a `truth` y_ref is the last of the ladder,
    marked `is_reference`; its own error is not known from this table, only bounded by how the errors fall towards it.

    Args:
        engine: the engine.
        mechanism: the scene; its follower must be flexible.
        ladder: settings, coarse to fine.
        duration: s, a multiple of `output_step`.
        output_step: s.
        truth: a solution to measure against, on the same grid.

    Returns:
        One row per settings: the settings by name, `degrees_of_freedom`, one error per name in `CHANNELS`, `solve_seconds`,
        `right_hand_side_calls` (NaN where an engine counts none), `is_reference`.

    Raises:
        EngineFailure: a run broke down.
        Refusal: a feature of the scene that the engine cannot model.
    """
    engine.check(mechanism)
    start = standard_start(mechanism)

    def run(settings: Settings, span: float) -> Trajectory:
        return engine.prepare(mechanism, start, settings).advance(span, output_step)

    if engine.compiles:
        run(ladder[0], output_step)  # so that the times below do not count it
    runs = [run(settings, duration) for settings in ladder]
    reference = truth if truth is not None else runs[-1]
    rows = []
    for settings, trajectory in zip(ladder, runs, strict=True):
        errors = {name: _error(trajectory, reference, name) for name in CHANNELS}
        cost = {
            "solve_seconds": trajectory.solve_seconds,
            "right_hand_side_calls": trajectory.statistics.get("right_hand_side_calls", np.nan),
            "is_reference": trajectory is reference,
        }
        free = engine.describe(mechanism, settings).degrees_of_freedom
        rows.append(settings.as_dict() | {"degrees_of_freedom": free} | errors | cost)
    return pd.DataFrame(rows)


def _error(trajectory: Trajectory, reference: Trajectory, name: str) -> float:
    difference = trajectory[name] - reference[name]
    return float(np.sqrt(np.mean(difference**2) / np.mean(reference[name] ** 2)))
