"""How far the engine's own settings leave each measure of the settled cycle uncertain: its error estimate, measure by measure.

The same measures are taken of the same cycle in the runs that the engine compares (`engines.base.Comparison`); a part of the error of
a measure is their difference over |factor - 1|, and the parts' sizes are added, as for a trajectory (`engines.accurate`). Two extremes
can be alike by accident, where the one run is higher before the peak and the other behind it: no part of an extreme is taken for less
than the signals' RMS difference over the half cycle.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import CubicSpline

from cases.marching import Columns
from cases.measures import CHANNELS, CycleMeasures, Measure
from cases.steady_run import Pair

Array = NDArray[np.float64]

#: Numbers of a measure that have an estimate under their name and "_estimate".
VIBRATION: Final = ("first_mode_frequency", "first_mode_amplitude")
EXTREMES: Final = ("minimum", "maximum")
#: Crank angles of a cycle at which signals are compared.
GRID: Final = 720


@dataclass(frozen=True)
class MeasuredPair:
    """A pair of runs, the measures of both, and the RMS difference of their signals by half and channel."""

    run: CycleMeasures
    other: CycleMeasures
    factor: float
    differences: Mapping[tuple[str, str], float]


def measured_pair(pair: Pair, measured: Callable[[Columns], CycleMeasures]) -> MeasuredPair:
    """Take the measures of both runs by `measured`."""
    differences = {
        (half, channel): float(np.sqrt(np.mean((_on_grid(pair.run, channel) - _on_grid(pair.other, channel))[part] ** 2)))
        for half, part in (("pre", slice(0, GRID // 2)), ("post", slice(GRID // 2, None)))
        for channel in CHANNELS
    }
    return MeasuredPair(measured(pair.run), measured(pair.other), pair.factor, differences)


def with_estimates(found: CycleMeasures, pairs: Sequence[MeasuredPair]) -> dict[str, list[dict[str, Any]]]:
    """Measures and consensus as plain values, with their estimates, in the same units.

    Args:
        found: of the delivered run.
        pairs: empty where nothing can be estimated; every estimate is then None.

    Returns:
        "measures" and "consensus": what `found` holds, and "first_mode_frequency_estimate", "first_mode_amplitude_estimate",
        "minimum_estimate" and "maximum_estimate" of each measure, "first_mode_frequency_estimate" of each consensus. None where one
        run resolves the first mode and another does not. Of a consensus it is the mean of those of its channels that have one, with
        the weights that their frequencies have in it.
    """
    measures = []
    for place, measure in enumerate(found.measures):
        numbers = {name: _estimate(measure, pairs, place, name) for name in (*VIBRATION, *EXTREMES)}
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


def _estimate(measure: Measure, pairs: Sequence[MeasuredPair], place: int, name: str) -> float | None:
    if not pairs or getattr(measure, name) is None:
        return None
    total = 0.0
    for pair in pairs:
        one, other = getattr(pair.run.measures[place], name), getattr(pair.other.measures[place], name)
        if one is None or other is None:
            return None
        least = pair.differences[measure.half, measure.channel] if name in EXTREMES else 0.0
        total += max(abs(one - other), least) / abs(pair.factor - 1.0)
    return total


def _on_grid(cycle: Columns, channel: str) -> Array:
    """A channel over the angle turned since the cycle's beginning, at `GRID` even angles."""
    turned = np.abs(cycle["crank_angle"] - cycle["crank_angle"][0])
    return np.asarray(CubicSpline(turned, cycle[channel])(np.linspace(0.0, 2.0 * np.pi, GRID, endpoint=False)))
