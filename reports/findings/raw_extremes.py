"""The frequency that a reader counts off a plot: half oscillations between the extremes that the eye sees.

This is not how anything is measured here. It is done because the thesis' frequencies were read from plots: where a slow part rises
and falls about the return, its hump is counted among the peaks, and what is counted differs from the first mode.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray
from scipy.signal import find_peaks

from cases.comparison import HALVES, REFERENCE, CaseResult
from cases.engine_run import EngineRun
from cases.measures import CHANNELS

Array = NDArray[np.float64]

#: Prominence that an extreme needs to be seen, as a part of the signal's range over the cycle.
VISIBLE: Final = 0.03


@dataclass(frozen=True)
class Excess:
    """By how much one engine's counted frequency exceeds another's in a half and channel: median, range and number of cases."""

    half: str
    channel: str
    median: float
    lowest: float
    highest: float
    count: int


def counted_frequency(run: EngineRun, half: str, channel: str) -> float | None:
    """Frequency counted off the plot of a half, Hz: half the number of intervals between its extremes over their time.

    None where fewer than three extremes are seen.
    """
    times = _extremes(run.cycle["time"], run.cycle[channel])
    turned = np.abs(run.cycle["crank_angle"] - run.cycle["crank_angle"][0])
    at_return = float(np.interp(np.pi, turned, run.cycle["time"]))
    here = times[times <= at_return] if half == "pre" else times[times > at_return]
    return (here.size - 1) / (2.0 * float(here[-1] - here[0])) if here.size >= 3 else None


def _extremes(time: Array, signal: Array) -> Array:
    """Instants of the visible peaks and troughs in order, s."""
    prominence = VISIBLE * float(np.ptp(signal))
    found = [find_peaks(sign * signal, prominence=prominence)[0] for sign in (1.0, -1.0)]
    return time[np.sort(np.concatenate(found))]


def counted_excess(results: Sequence[CaseResult], engine: str = "thesis", other: str = REFERENCE) -> list[Excess]:
    """Per half and channel the excess of `engine` over `other`, of the cases in which both can be counted."""
    found = []
    for half in HALVES:
        for channel in CHANNELS:
            ratios = []
            for result in results:
                runs = result.runs.get(engine), result.runs.get(other)
                if runs[0] is None or runs[1] is None or not (runs[0].usable and runs[1].usable):
                    continue
                pair = counted_frequency(runs[0], half, channel), counted_frequency(runs[1], half, channel)
                if pair[0] and pair[1]:
                    ratios.append(pair[0] / pair[1] - 1.0)
            if ratios:
                found.append(Excess(half, channel, float(np.median(ratios)), min(ratios), max(ratios), len(ratios)))
    return found
