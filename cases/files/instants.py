"""Rows of a recorded table: instants that stand in several rows, gaps between rows, and their noise.

Programs that simulate events write the row before and the row after an event at the same time. At the event itself places and angles do not
jump, while accelerations and forces may. The motion goes on from the last of such rows, which is kept.
"""

import math
from collections.abc import Callable, Mapping
from typing import Final

import numpy as np

from quickreturn.cases.files.errors import CaseError
from quickreturn.reference_model.arrays import Array

#: Columns that do not jump at an event.
_PLACES: Final = ("crank_angle", "follower_angle", "slider_position", "tip_x", "tip_y", "tip_deflection")
#: Rounding, as a part of a column's largest magnitude: numbers of a table are assumed to have five digits.
ROUNDING: Final = 1e-5
#: Largest part of the rows that stand at the time of another row and differ from it: where there are more, the time has too few digits.
_MOST_EVENTS: Final = 0.1
#: Least ratio of a gap to the usual step ...
_GAP: Final = 1.5
#: ... and least part of the steps that are usual, within a hundredth of them, for a table to be evenly sampled.
_EVEN: Final = 0.8
#: Uncertainty of an extreme, in standard deviations of a row's noise: one row in 15,000 departs further.
DEVIATIONS: Final = 4.0
TOO_FEW_DIGITS: Final = "sort the rows, drop doubles, or write the time with more digits"


def single_instants(columns: Mapping[str, Array], refusal: Callable[[int, str], CaseError]) -> tuple[dict[str, Array], tuple[str, ...]]:
    """The columns with one row for each instant, and clauses on the rows left out.

    Args:
        columns: by name, with "time", SI, each of shape (n,); the time does not fall.
        refusal: the error for a row whose time does not rise, with what to do.

    Raises:
        CaseError: rows at the same time differ in a place or an angle, or there are too many that differ.
    """
    doubled = np.flatnonzero(np.diff(columns["time"]) == 0.0)  # the earlier row of each pair
    if not doubled.size:
        return dict(columns), ()
    differs = {name: np.abs(values[doubled + 1] - values[doubled]) > ROUNDING * np.max(np.abs(values)) for name, values in columns.items()}
    moved = np.any([differs[name] for name in _PLACES if name in differs] or [np.zeros(doubled.size, bool)], axis=0)
    jumps = np.any([*differs.values()], axis=0)
    if np.any(moved) or np.count_nonzero(jumps) > _MOST_EVENTS * len(columns["time"]):
        raise refusal(int(doubled[np.argmax(moved if np.any(moved) else jumps)]) + 1, TOO_FEW_DIGITS)
    told = list[str]()
    if same := int(np.count_nonzero(~jumps)):
        told.append(f"{same} doubled row{'s' * (same > 1)} left out")
    if count := int(np.count_nonzero(jumps)):
        at, others = float(columns["time"][doubled[np.argmax(jumps)]]), f" and at {count - 1} others" * (count > 1)
        told.append(f"a jump at {at:.6g} s{others}: of the rows at this time the last is kept")
    return {name: np.delete(values, doubled) for name, values in columns.items()}, tuple(told)


def gaps(time: Array) -> str:
    """A clause on the gaps between the evenly sampled rows of a table, whose time (s, shape (n,)) rises; "" if there are none."""
    steps = np.diff(time)
    if steps.size < 2:
        return ""
    usual = float(np.median(steps))
    missing = np.flatnonzero(steps > _GAP * usual)
    if not missing.size or np.count_nonzero(np.abs(steps - usual) <= 0.01 * usual) < _EVEN * steps.size:
        return ""
    largest = missing[np.argmax(steps[missing])]
    clause = f"{steps[largest]:.3g} s without a row after {time[largest]:.6g} s"
    return f"a gap: {clause}" if missing.size == 1 else f"{missing.size} gaps, the largest {clause}"


def noise_of(time: Array, values: Array) -> float:
    """Departure of rows from a smooth course: by their scatter, and by rounding."""
    return scatter(time, values) + ROUNDING * float(np.max(np.abs(values)))


def scatter(time: Array, values: Array) -> float:
    """Departure of rows from a smooth course, from the difference of each from the cubic through its four neighbours."""
    if len(time) < 5:
        return math.inf
    near = [slice(shift, len(time) - 4 + shift) for shift in (0, 1, 3, 4)]
    here = time[2:-2]
    weights = [np.prod([(here - time[other]) / (time[one] - time[other]) for other in near if other is not one], axis=0) for one in near]
    differences = values[2:-2] - sum(weight * values[one] for weight, one in zip(weights, near, strict=True))
    spread = np.sqrt(1.0 + sum(weight**2 for weight in weights))
    return DEVIATIONS * float(np.sqrt(np.mean((differences / spread) ** 2)))
