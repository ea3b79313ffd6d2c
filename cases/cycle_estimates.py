"""How far the engine's own settings leave each measure of the settled cycle uncertain: its error estimate, measure by measure.

The same measures are taken of the same cycle in the runs that the engine compares (`engines.base.Comparison`); what their differences
show of the error is added up as for a trajectory (`engines.accurate`). Two extremes can be alike by accident, where the one run is
higher before the peak and the other behind it; they differ by at most the signals' largest difference in the half cycle, and that
bound is what an extreme is taken to be off by. In run 16 it covered all sixteen extremes of a chain of 12 links, their own differences
twelve.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from cases.marching import Columns, channels_of
from cases.measures import CHANNELS, CycleMeasures, on_common_grid
from engines.accurate import LEAST_FACTOR, Compared

Array = NDArray[np.float64]

#: Numbers of a measure that have an estimate under their name and "_estimate".
VIBRATION: Final = ("first_mode_frequency", "first_mode_amplitude")
EXTREMES: Final = ("minimum", "maximum")


@dataclass(frozen=True)
class MeasuredCycle:
    """A cycle's measures, and its signals by half and channel at even crank angles, each of shape (360,)."""

    measures: CycleMeasures
    signals: Mapping[tuple[str, str], Array]

    @classmethod
    def of(cls, cycle: Columns, measures: CycleMeasures) -> "MeasuredCycle":
        """A cycle from farthest to farthest, and what was measured of it."""
        whole = on_common_grid(channels_of(cycle))
        half = len(whole[CHANNELS[0]]) // 2
        halves = {"pre": slice(0, half), "post": slice(half, None)}
        return cls(measures, {(half, channel): whole[channel][part] for half, part in halves.items() for channel in CHANNELS})


def with_estimates(found: CycleMeasures, compared: Sequence[Compared[MeasuredCycle]]) -> dict[str, list[dict[str, Any]]]:
    """Measures and consensus as plain values, with their estimates, in the same units.

    Args:
        found: of the delivered run.
        compared: empty where nothing can be estimated; every estimate is then None.

    Returns:
        "measures" and "consensus": what `found` holds, and "first_mode_frequency_estimate", "first_mode_amplitude_estimate",
        "minimum_estimate" and "maximum_estimate" of each measure, "first_mode_frequency_estimate" of each consensus. None where one
        run resolves the first mode and another does not. Of a consensus it is the mean of those of its channels that have one, with
        the weights that their frequencies have in it.
    """
    measures = []
    for place, measure in enumerate(found.measures):
        of_extremes = sum(runs.part(_largest_difference(measure.half, measure.channel)) for runs in compared) if compared else None
        numbers = {name: _of_vibration(compared, place, name, getattr(measure, name)) for name in VIBRATION}
        numbers |= dict.fromkeys(EXTREMES, of_extremes)
        measures.append(vars(measure) | {f"{name}_estimate": value for name, value in numbers.items()})
    consensus = [vars(agreed) | {"first_mode_frequency_estimate": mean_estimate(measures, agreed.half)} for agreed in found.consensus]
    return {"measures": measures, "consensus": consensus}


def mean_estimate(measures: Sequence[Mapping[str, Any]], half: str, channels: Sequence[str] = CHANNELS) -> float | None:
    """Estimate of the weighted mean of some channels' frequencies: at most the mean of theirs; None where no channel has one."""
    known = [m for m in measures if m["half"] == half and m["channel"] in channels and m["first_mode_frequency_estimate"] is not None]
    if not known:
        return None
    weights = np.array([measure["first_mode_frequency_uncertainty"] ** -2.0 for measure in known])
    return float(weights @ [measure["first_mode_frequency_estimate"] for measure in known] / weights.sum())


def _largest_difference(half: str, channel: str) -> Callable[[MeasuredCycle, MeasuredCycle], float]:
    return lambda one, other: float(np.max(np.abs(one.signals[half, channel] - other.signals[half, channel])))


def _of_vibration(compared: Sequence[Compared[MeasuredCycle]], place: int, name: str, value: float | None) -> float | None:
    """Estimate of a number that not every run resolves; `place` is that of the measure among those of a cycle."""

    def of(run: MeasuredCycle) -> float | None:
        found: float | None = getattr(run.measures.measures[place], name)
        return found

    if not compared or value is None or any(of(run) is None for runs in compared for run in (runs.run, runs.other)):
        return None
    total = 0.0
    for runs in compared:
        if runs.before and of(runs.before[0]) is None:  # nothing shows the factor
            runs = replace(runs, factor=min(runs.factor, LEAST_FACTOR), before=None)
        total += runs.part(lambda one, other: abs(of(one) - of(other)))  # type: ignore[operator]
    return total
