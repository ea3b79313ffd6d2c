"""Where two runs differ, column by column, and the mistake that would explain it."""

from typing import Final

import numpy as np
from numpy.typing import NDArray

from cases.measures import on_common_grid
from cases.measures.steady_state import GRID
from cases.mistakes import diagnose
from cases.runs.marching import channels_of
from cases.runs.recorded import GROWING, TELLING
from cases.runs.request import NOTHING, Run
from engines.relative import relative_error, rms
from reference_model.columns import COLUMNS
from reference_model.mechanism import Mechanism

Array = NDArray[np.float64]

#: Columns that differ by a smaller part are not explained.
NEAR: Final = 0.02
#: Lateness explains a column's difference if it leaves less than this part of the column, and less than a third of the difference.
ALIKE: Final = 0.1


def column_differences(run: Run, other: Run) -> dict[str, float]:
    """RMS difference of each column that both have, over its RMS in the other, at equal crank angles of the turn that was measured."""
    return {name: relative_error(mine, its) for name, (mine, its) in _on_grid(run, other).items()}


def mistakes(run: Run, other: Run, mechanism: Mechanism) -> dict[str, str]:
    """Columns in which a mistake explains most of the difference, each with a sentence that names it and what to do.

    Where all that vibrates is equally late it is the crank angle that is off.
    """
    grids, right = _on_grid(run, other), on_common_grid(channels_of(other.cycle, COLUMNS.keys() & other.cycle.keys()))
    found, late = dict[str, str](), dict[str, int]()
    for name, (mine, its) in grids.items():
        finding = diagnose(name, mine, its, NEAR * rms(its), right, mechanism)
        if finding is None:
            continue
        lag = _lag(mine, its)
        left = rms(np.roll(mine, -lag) - its)
        if left < min(ALIKE * rms(its), rms(mine - its) / 3.0) and (finding.left is None or left < finding.left):
            late[name], found[name] = lag, f"{name} is about {_degrees(abs(lag)):.3g} deg of the crank {_when(lag)}"
        elif finding.explained:
            found[name] = f"{finding.cause}; {finding.advice}"
    vibrating = [name for name in grids if name in TELLING]
    if len(vibrating) > 1 and late.keys() >= set(vibrating) and max(late.values()) - min(late.values()) <= 1:
        lag = late[vibrating[0]]
        off = f"{_degrees(abs(lag)):.3g} deg too {'large' if lag > 0 else 'small'}"
        ahead = f"crank_angle is about {off}, or all columns are {_when(lag)}"
        return {"crank_angle": ahead} | {name: told for name, told in found.items() if name not in late}
    return found


def _lag(mine: Array, its: Array) -> int:
    """By how many places of the grid a column is late, less than half a turn; negative if it is early."""
    lag = int(np.argmax(np.fft.irfft(np.fft.rfft(mine) * np.conj(np.fft.rfft(its)), GRID)))
    return lag if lag <= GRID // 2 else lag - GRID


def _degrees(places: int) -> float:
    return 360.0 * places / GRID


def _when(lag: int) -> str:
    return "late" if lag > 0 else "early"


def _on_grid(run: Run, other: Run) -> dict[str, tuple[Array, Array]]:
    """Columns that both have and that are not zero in the other, at even crank angles of the turn."""
    names = [name for name in run.cycle if name in other.cycle and name not in GROWING and other.peak(name) > NOTHING]
    mine, its = (on_common_grid(channels_of(each.cycle, names)) for each in (run, other))
    return {name: (mine[name], its[name]) for name in names}
