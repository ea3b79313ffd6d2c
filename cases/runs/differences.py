"""Where two runs differ, column by column, and the slip that would explain it."""

import math
from collections.abc import Mapping
from typing import Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from cases.measures import on_common_grid
from cases.measures.steady_state import GRID
from cases.runs.marching import channels_of
from cases.runs.recorded import GROWING, TELLING
from cases.runs.request import NOTHING, Run
from engines.relative import relative_error
from reference_model.columns import COLUMNS

Array = NDArray[np.float64]

#: A slip explains a column's difference if it leaves less than this part of the column, and less than a third of the difference.
ALIKE: Final = 0.1
#: Columns that differ by less are not explained; a factor so near to one of those below is that one.
NEAR: Final = 0.02
#: Factors that come of a unit or a convention, and what they tell.
_SLIPS: Final = (
    (1.0, ""),
    (1e3, "1000 times as large: is it in thousandths of the unit that its heading says"),
    (1e-3, "a thousandth: is it in thousands of the unit that its heading says"),
    (1e2, "100 times as large: is it in percent or centimetres"),
    (1e6, "a million times as large: is it in millionths"),
    (math.degrees(1.0), "57.3 times as large: is it in degrees"),
    (math.radians(1.0), "57.3 times too small: was it turned into radians twice"),
    (1.0 / 0.0254, "39.37 times as large: is it in inches"),
    (30.0 / math.pi, "9.55 times as large: is it in rpm"),
    (2.0 * math.pi, "2 pi times as large: are turns and radians mixed up"),
    (0.5 / math.pi, "2 pi times too small: are turns and radians mixed up"),
    (1.0 / 9.80665, "9.81 times too small: is it in g"),
    (2.0, "twice as large"),
    (0.5, "half as large"),
)


def column_differences(run: Run, other: Run) -> dict[str, float]:
    """RMS difference of each column that both have, over its RMS in the other, at equal crank angles of the turn that was measured."""
    return {name: relative_error(mine, its) for name, (mine, its) in _on_grid(run, other).items() if other.peak(name) > NOTHING}


def slips(run: Run, other: Run) -> dict[str, str]:
    """Columns that are another's multiple, lie beside it, are late or another column, each with a clause that names the slip.

    Where all that vibrates is equally late it is the crank angle that is off.
    """
    grids = {name: pair for name, pair in _on_grid(run, other).items() if other.peak(name) > NOTHING}
    found = {name: slip for name in grids if (slip := _slip(name, grids)) is not None}
    late = {name: slip.late for name, slip in found.items() if slip.late}
    vibrating = [name for name in grids if name in TELLING]
    if len(vibrating) > 1 and late.keys() >= set(vibrating) and max(late.values()) - min(late.values()) <= 1:
        off = _degrees(late[vibrating[0]])
        ahead = f"is about {abs(off):.3g} deg too {'large' if off > 0.0 else 'small'}, or all columns are {_when(off)}"
        return {"crank_angle": ahead} | {name: slip.told for name, slip in found.items() if name not in late}
    return {name: slip.told for name, slip in found.items()}


class _Slip(NamedTuple):
    """What would explain a column's difference: what is then left of it, relative; in words; by how many places of the grid it is late."""

    left: float
    told: str
    late: int = 0


def _slip(name: str, grids: Mapping[str, tuple[Array, Array]]) -> _Slip | None:
    """The slip that leaves least of a column's difference; None if none leaves little."""
    mine, its = grids[name]
    before = relative_error(mine, its)
    if before < NEAR:
        return None
    unit, offset = COLUMNS[name].unit, float(np.mean(mine - its))
    beside = f"lies {abs(offset):.4g}{'' if unit == '1' else f' {unit}'} {'above' if offset > 0.0 else 'below'}"
    if name == "follower_angle":
        beside += ": it lies within 90 deg of 180 deg at the start"
    late = int(np.argmax(np.fft.irfft(np.fft.rfft(mine) * np.conj(np.fft.rfft(its)), mine.size)))
    late -= mine.size if late > mine.size // 2 else 0
    alike = [other for other in grids if other != name and COLUMNS[other].unit == unit]
    slips = [
        _multiple(mine, its),
        _Slip(relative_error(mine - offset, its), beside),
        *(_Slip(relative_error(mine, grids[other][1]), f"is the engine's {other}: are columns exchanged") for other in alike),
        _Slip(relative_error(np.roll(mine, -late), its), f"is about {abs(_degrees(late)):.3g} deg of the crank {_when(late)}", late),
    ]
    best = min(slips, key=lambda slip: slip.left)
    return best if best.left < min(ALIKE, before / 3.0) else None


def _multiple(mine: Array, its: Array) -> _Slip:
    factor = float(mine @ its / (its @ its))
    known = next((words for size, words in _SLIPS if abs(abs(factor) / size - 1.0) < NEAR), f"{abs(factor):.4g} times as large")
    told = ", ".join(filter(None, ["of the opposite sign" if factor < 0.0 else "", known]))
    return _Slip(relative_error(factor * its, mine), told)


def _degrees(late: int) -> float:
    return 360.0 * late / GRID


def _when(late: float) -> str:
    return "late" if late > 0.0 else "early"


def _on_grid(run: Run, other: Run) -> dict[str, tuple[Array, Array]]:
    """Columns that both have, at even crank angles of the turn."""
    names = [name for name in run.cycle if name in other.cycle and name not in GROWING]
    mine, its = on_common_grid(channels_of(run.cycle, names)), on_common_grid(channels_of(other.cycle, names))
    return {name: (mine[name], its[name]) for name in names}
