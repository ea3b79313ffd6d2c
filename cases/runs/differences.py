"""Where two runs differ, column by column, and the slip that would explain it."""

import math
from typing import Final

import numpy as np
from numpy.typing import NDArray

from cases.measures import on_common_grid
from cases.runs.marching import channels_of
from cases.runs.recorded import GROWING
from cases.runs.request import NOTHING, Run
from engines.relative import relative_error

Array = NDArray[np.float64]

#: A column is another's multiple if what is left is less than this part of it, and the factor one of those below if it is as near.
ALIKE: Final = 0.1
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
    """Columns that are another's multiple or lie a whole turn off, each with a clause that names the slip."""
    found = {}
    for name, (mine, its) in _on_grid(run, other).items():
        offset = round(float(np.mean(mine - its)) / (2.0 * math.pi))
        if name == "follower_angle" and offset:
            found[name] = (
                f"lies {abs(offset)} whole turn{'s' if abs(offset) > 1 else ''} off: it lies within 90 deg of 180 deg at the start"
            )
        elif other.peak(name) > NOTHING and (told := _multiple(mine, its)):
            found[name] = told
    return found


def _multiple(mine: Array, its: Array) -> str:
    factor = float(mine @ its / (its @ its))
    if relative_error(factor * its, mine) > ALIKE:
        return ""
    told = next((words for size, words in _SLIPS if abs(abs(factor) / size - 1.0) < NEAR), "")
    return ", ".join(filter(None, ["of the opposite sign" if factor < 0.0 else "", told]))


def _on_grid(run: Run, other: Run) -> dict[str, tuple[Array, Array]]:
    """Columns that both have, at even crank angles of the turn."""
    names = [name for name in run.cycle if name in other.cycle and name not in GROWING]
    mine, its = on_common_grid(channels_of(run.cycle, names)), on_common_grid(channels_of(other.cycle, names))
    return {name: (mine[name], its[name]) for name in names}
