"""How far the converged model has converged: error over the number of shapes and the integration tolerance."""

from collections.abc import Sequence
from typing import Final

import numpy as np
import pandas as pd

from engines.pseudo_coordinate.engine import ReferenceEngine, ReferenceSettings
from engines.start import standard_start
from engines.trajectory import Trajectory
from reference_model.mechanism import Mechanism

#: Channels of the table, in its order.
CHANNELS: Final = ("tip_deflection", "tip_acceleration", "strain_1", "strain_2", "strain_3", "slider_force")


def convergence_table(
    mechanism: Mechanism,
    shape_counts: Sequence[int],
    tolerances: Sequence[float],
    duration: float,
    output_step: float,
    *,
    family: str = "clamped-free",
) -> pd.DataFrame:
    """Errors of the engine `reference` for every number of shapes and every tolerance, from the standard start.

    The error of a channel is RMS(y - y_ref) / RMS(y_ref) over the output grid. y_ref is the row with most shapes and the smallest
    tolerance, marked `is_reference`; its own error is not known from this table, only bounded by how the errors fall towards it.

    Args:
        mechanism: the scene; its follower must be flexible.
        shape_counts: numbers of shapes.
        tolerances: local errors of the integration.
        duration: s, a multiple of `output_step`.
        output_step: s.
        family: "clamped-free" or "hermite", as the setting `family` of the engine.

    Returns:
        One row per pair, shapes ascending and tolerances descending within: `shapes`, `tolerance`, one error per name in `CHANNELS`,
        `solve_seconds`, `right_hand_side_calls`, `is_reference`.

    Raises:
        EngineFailure: a run broke down.
        Refusal: a feature of the scene that the engine cannot model.
    """
    engine, start = ReferenceEngine(), standard_start(mechanism)
    engine.check(mechanism)
    pairs = [(shapes, tolerance) for shapes in sorted(shape_counts) for tolerance in sorted(tolerances, reverse=True)]

    def run(shapes: int, tolerance: float) -> Trajectory:
        settings = ReferenceSettings(shapes=shapes, family=family, tolerance=tolerance)
        return engine.prepare(mechanism, start, settings).advance(duration, output_step)

    run(*pairs[0])  # compiles, so that the times below do not count it
    runs = [run(*pair) for pair in pairs]
    rows = []
    for (shapes, tolerance), trajectory in zip(pairs, runs, strict=True):
        errors = {name: _error(trajectory, runs[-1], name) for name in CHANNELS}
        cost = {"solve_seconds": trajectory.solve_seconds, "right_hand_side_calls": int(trajectory.statistics["right_hand_side_calls"])}
        rows.append({"shapes": shapes, "tolerance": tolerance} | errors | cost | {"is_reference": trajectory is runs[-1]})
    return pd.DataFrame(rows)


def _error(trajectory: Trajectory, reference: Trajectory, name: str) -> float:
    difference = trajectory[name] - reference[name]
    return float(np.sqrt(np.mean(difference**2) / np.mean(reference[name] ** 2)))
