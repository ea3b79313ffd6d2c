"""Measures of a motion that repeats in statistics only: means over many cycles, and their uncertainty from the cycles' scatter."""

import math
from collections.abc import Sequence
from typing import Any, Final

import numpy as np

from quickreturn.cases.motion.cycle import ChannelMeasures, CycleMeasures, consensus_of

#: Number of cycles for means if no cycle repeats.
AVERAGED: Final = 30
#: Number of groups of successive cycles whose means give the standard error. After the five cycles of a group a quarter of a disturbance or
#: less remains in the thesis' runs. Motions that repeat after two, three or six turns fill whole groups or pairs of them.
GROUPS: Final = 6
#: Part of a mean extreme's uncertainty that is due to scatter, in standard errors: for an extreme it is a bound, for other measures a
#: standard deviation.
BOUND: Final = 2.0
#: Part of the cycles that must resolve a first or second mode, so that the mean is not biased by selection.
RESOLVED: Final = 0.5


def standard_error(values: Sequence[float]) -> float:
    """Standard error of a mean of successive, correlated values, from the scatter of the means of `GROUPS` groups; 0 of a single value.

    It is too small if values are correlated over more than a group: by a third with a correlation of 0.77 from one to the next.
    """
    groups = [group.mean() for group in np.array_split(np.asarray(values), GROUPS) if group.size]
    return float(np.std(groups, ddof=1)) / math.sqrt(len(groups)) if len(groups) > 1 else 0.0


def mean_measures(cycles: Sequence[CycleMeasures]) -> CycleMeasures:
    """Means of the measures of successive cycles; those of a single cycle are its own.

    The uncertainty of a frequency or amplitude is the mean of the cycles', which is mostly the method's and the same in each, and the
    standard error of the mean, in quadrature; that of an extreme is `BOUND` standard errors more than the cycles' mean. A mode that less
    than `RESOLVED` of the cycles resolve is not resolved.

    Args:
        cycles: at least one; of the same channels.
    """
    measures = tuple(_mean([cycle.measures[place] for cycle in cycles]) for place in range(len(cycles[0].measures)))
    halves = dict.fromkeys(measure.half for measure in measures)
    return CycleMeasures(measures, tuple(consensus_of(half, [each for each in measures if each.half == half]) for half in halves))


def _mean(measures: Sequence[ChannelMeasures]) -> ChannelMeasures:
    """Mean of the measures of one channel in one half of successive cycles."""
    numbers: dict[str, Any] = {"half": measures[0].half, "channel": measures[0].channel}
    for name in ("first_mode_frequency", "first_mode_amplitude", "second_mode_frequency", "minimum", "maximum"):
        rows = [measure for measure in measures if getattr(measure, name) is not None]
        values, uncertainties = ([float(getattr(row, key, 0.0)) for row in rows] for key in (name, f"{name}_uncertainty"))
        resolved = len(rows) >= RESOLVED * len(measures)
        numbers[name] = float(np.mean(values)) if resolved else None
        if name == "second_mode_frequency":
            continue
        error = standard_error(values)
        uncertainty = None if not resolved else float(np.mean(uncertainties))
        if uncertainty is not None:
            uncertainty = uncertainty + BOUND * error if name in ("minimum", "maximum") else math.hypot(uncertainty, error)
        numbers[f"{name}_uncertainty"] = uncertainty
    reasons = [measure.reason for measure in measures if measure.reason]
    unresolved = numbers["first_mode_frequency"] is None or numbers["first_mode_amplitude"] is None
    return ChannelMeasures(**numbers, reason=max(set(reasons), key=reasons.count) if unresolved else "")
