"""Whether and how fast the rivals converge to the common solution: error over degrees of freedom, with the observed order.

The tables of `reference_model/RIVALS.md`, section 1, come from here; the commands stand there.
"""

import math
from collections.abc import Iterator, Sequence
from typing import Final

import numpy as np
import pandas as pd

from quickreturn.engines.base import Engine, EngineFailure
from quickreturn.engines.error_parts import ESTIMATED
from quickreturn.engines.own.reference import ReferenceEngine, ReferenceSettings
from quickreturn.engines.settings import Settings
from quickreturn.engines.start import standard_start
from quickreturn.engines.trajectory import Trajectory, relative_error
from quickreturn.plugins.methods.rivals import multiplier, nodal_load, stiff_spring
from quickreturn.plugins.methods.rivals.multiplier import MultiplierSettings
from quickreturn.plugins.methods.rivals.nodal_load import NodalLoadSettings
from quickreturn.plugins.methods.rivals.stiff_spring import StiffSpringSettings
from quickreturn.reference_model.mechanism import Mechanism

TOLERANCE: Final = 1e-8
#: The solution that errors are measured against.
TRUTH: Final = ReferenceSettings(modes=9, tolerance=1e-9)


def series(shapes: tuple[int, ...], elements: tuple[int, ...]) -> Iterator[tuple[str, Engine, Sequence[Settings]]]:
    """Name, engine and settings of each row group: what changes within one is the number of shapes, elements, or the stiffness."""
    yield "multiplier, modes", multiplier.ENGINE, [MultiplierSettings(shapes=n, tolerance=TOLERANCE) for n in shapes]
    hermite = [MultiplierSettings(shapes=2 * n, family="hermite", tolerance=TOLERANCE) for n in elements]
    yield "multiplier, elements", multiplier.ENGINE, hermite
    for distribution in ("lever", "consistent", "both linear"):
        settings = [NodalLoadSettings(elements=n, distribution=distribution, tolerance=TOLERANCE) for n in elements]
        yield f"nodal-load, {distribution}", nodal_load.ENGINE, settings
    yield "stiff-spring, 1e6 N/m", stiff_spring.ENGINE, [StiffSpringSettings(shapes=n, tolerance=TOLERANCE) for n in shapes]


def rival_table(
    mechanism: Mechanism,
    duration: float = 2.0,
    output_step: float = 1e-3,
    shapes: tuple[int, ...] = (4, 6, 8, 12, 16),
    elements: tuple[int, ...] = (2, 3, 4, 6, 8, 12),
) -> pd.DataFrame:
    """Errors against `reference` with 9 modes from the standard start.

    Args:
        mechanism: the scene; a flexible follower and a rigid slider joint.
        duration: s, a multiple of `output_step`.
        output_step: s.
        shapes: numbers of clamped-free modes.
        elements: numbers of Hermite elements.

    Returns:
        One row per method and settings: `method`, `flexible` (number of flexible coordinates), one error per name in `ESTIMATED`
        (RMS of the difference over RMS; NaN where the run failed), `order` (observed, of the tip deflection, between this row and the one
        before), `spurious` (work of the joint regardless of sign over the drive's work, NaN where the joint is ideal), `largest_gap` (m),
        `calls`, `solve_seconds`, `failure`.
    """
    start = standard_start(mechanism)
    for compiling in (ReferenceEngine(), multiplier.ENGINE):  # so that no time below counts it
        compiling.prepare(mechanism, start, compiling.settings_type()).advance(output_step, output_step)
    truth = ReferenceEngine().prepare(mechanism, start, TRUTH).advance(duration, output_step)
    rows: list[dict[str, object]] = []
    for name, engine, ladder in series(shapes, elements):
        for settings in ladder:
            row = _row(name, engine, settings, mechanism, truth, duration, output_step)
            if rows and rows[-1]["method"] == name:
                row["order"] = _order(rows[-1], row)
            rows.append(row)
    return pd.DataFrame(rows)


def stiffness_table(
    mechanism: Mechanism, stiffnesses: tuple[float, ...], shapes: int = 12, duration: float = 2.0, output_step: float = 1e-3
) -> pd.DataFrame:
    """What the spring alone does: difference of `stiff-spring` from `multiplier` with the same shapes, over the stiffness.

    Args:
        mechanism: the scene; a flexible follower and a rigid slider joint.
        stiffnesses: N/m, ascending; the damping is that of the time constant of the default settings.
        shapes: number of clamped-free modes of both.
        duration: s, a multiple of `output_step`.
        output_step: s.

    Returns:
        One row per stiffness: `stiffness`, one difference per name in `ESTIMATED`, `order` of the tip deflection, `calls`.
    """
    start = standard_start(mechanism)
    rigid = multiplier.ENGINE.prepare(mechanism, start, MultiplierSettings(shapes=shapes, tolerance=TOLERANCE))
    truth = rigid.advance(duration, output_step)
    default = StiffSpringSettings()
    rows: list[dict[str, object]] = []
    for stiffness in stiffnesses:
        damping = default.damping / default.stiffness * stiffness
        settings = StiffSpringSettings(shapes=shapes, stiffness=stiffness, damping=damping, tolerance=TOLERANCE)
        row = _row("stiff-spring", stiff_spring.ENGINE, settings, mechanism, truth, duration, output_step) | {"flexible": stiffness}
        if rows:
            row["order"] = _order(rows[-1], row)
        rows.append(row)
    return pd.DataFrame(rows).rename(columns={"flexible": "stiffness"}).drop(columns=["method", "spurious", "failure"])


def _row(
    name: str, engine: Engine, settings: Settings, mechanism: Mechanism, truth: Trajectory, duration: float, output_step: float
) -> dict[str, object]:
    free = engine.describe(mechanism, settings).degrees_of_freedom - (2 if mechanism.crank_is_free else 1)
    row: dict[str, object] = {"method": name, "flexible": free} | dict.fromkeys((*ESTIMATED, "order", "spurious"), math.nan)
    simulation = engine.prepare(mechanism, standard_start(mechanism), settings)
    try:
        trajectory = simulation.advance(duration, output_step)
    except EngineFailure as failure:
        return row | {"largest_gap": math.nan, "calls": math.nan, "solve_seconds": math.nan, "failure": str(failure)}
    errors = {channel: relative_error(trajectory[channel], truth[channel]) for channel in ESTIMATED}
    moved = trajectory.statistics.get("spurious_energy_moved", math.nan)
    return row | {
        **errors,
        "spurious": moved / abs(float(trajectory["drive_work"][-1])),
        "largest_gap": float(np.max(trajectory["constraint_gap"])),
        "calls": trajectory.statistics["right_hand_side_calls"],
        "solve_seconds": trajectory.solve_seconds,
        "failure": "",
    }


def _order(before: dict[str, object], now: dict[str, object]) -> float:
    """-d log(error) / d log(number) between two rows."""
    errors = np.array([before["tip_deflection"], now["tip_deflection"]], dtype=float)
    numbers = np.array([before["flexible"], now["flexible"]], dtype=float)
    return float(-np.diff(np.log(errors))[0] / np.diff(np.log(numbers))[0])
