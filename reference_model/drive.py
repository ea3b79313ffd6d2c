"""What follows from tables of the crank's drive: the speed to which a motor leads, and speeds over time as such over the angle."""

import math
from functools import lru_cache
from itertools import pairwise
from typing import Final

import numpy as np

from quickreturn.reference_model.arrays import Array
from quickreturn.reference_model.table import Table, hermite

#: Points of a piece of a speed over time between which the speed over the angle is a cubic.
_OF_PIECE: Final = 64
#: Width beside a motor's curve, over its own, in which a speed without torque is looked for.
_BESIDE: Final = 1e3


@lru_cache(maxsize=64)
def balanced_speed(table: Table) -> float:
    """The least speed (rad/s) at which a motor's torque falls through zero; infinite, with the sign of the torque at rest, if none."""
    points = np.array(table.points)
    beside = _BESIDE * (points[-1] - points[0])
    ends = np.concatenate([[points[0] - beside], points, [points[-1] + beside]])
    torque = table.at(ends)
    for at in np.flatnonzero((torque[:-1] > 0.0) & (torque[1:] <= 0.0)).tolist():
        low, high = ends[at], ends[at + 1]
        while low < (middle := 0.5 * (low + high)) < high:
            low, high = (middle, high) if table.at(middle) > 0.0 else (low, middle)
        return float(high)
    return math.copysign(math.inf, float(table.at(np.array(0.0))))


@lru_cache(maxsize=64)
def over_angle(table: Table) -> Array:
    """Rows of `pieces` for a table of speeds over time as one over the angle turned since time 0, in either direction."""
    times = np.unique([0.0, *(time for a, b in pairwise(table.points) for time in np.linspace(a, b, _OF_PIECE + 1))])
    times = np.append(times[times >= 0.0], times[-1] + 1.0)
    speed, step = table.at(times), np.diff(times)
    turned = step / 6.0 * np.abs(speed[:-1] + 4.0 * table.at(times[:-1] + 0.5 * step) + speed[1:])  # exact for a cubic
    turned = np.append(0.0, np.cumsum(turned))
    return hermite(turned, speed, table.at(times, slope=True) / np.abs(speed), np.diff(turned))
