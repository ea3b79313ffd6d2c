"""The frequency that a reader counts off a plot: half oscillations between visible extremes.

No result rests on this count. It is computed because it is the obvious way to take a frequency from a printed curve: where a slow part
rises and falls about the return, the count takes its hump for a peak, and the counted frequency differs from the first mode's. The
difference depends on the smallest extreme that is counted, so several thresholds are tried.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from quickreturn.cases.measures.cycle import HALVES
from quickreturn.cases.measures.time_scale import CHANNELS
from quickreturn.cases.runs.comparison import REFERENCE, CaseResult
from quickreturn.cases.runs.request import Run
from quickreturn.engines.registry import MODEL
from quickreturn.reports.results.differences import Summary, summary_of

Array = NDArray[np.float64]

#: Thresholds: least prominence of a counted extreme over the signal's range in the cycle, from a line's width to an obvious extreme.
VISIBLE: Final = (0.005, 0.01, 0.02, 0.03)


@dataclass(frozen=True, kw_only=True)
class Excess(Summary):
    """Excess of the counted frequency of one engine over another's in a half and channel, over the cases.

    `visible` is the least prominence of a counted extreme.
    """

    visible: float
    half: str
    channel: str


def counted_frequency(run: Run, half: str, channel: str, visible: float) -> float | None:
    """Frequency counted off the plot of a half, Hz: half the number of intervals between its extremes over their time.

    None if fewer than three extremes are visible.
    """
    times = _extremes(run.cycle["time"], run.cycle[channel], visible)
    turned = np.abs(run.cycle["crank_angle"] - run.cycle["crank_angle"][0])
    at_return = float(np.interp(np.pi, turned, run.cycle["time"]))
    here = times[times <= at_return] if half == "pre" else times[times > at_return]
    return (here.size - 1) / (2.0 * float(here[-1] - here[0])) if here.size >= 3 else None


def _extremes(time: Array, signal: Array, visible: float) -> Array:
    """Instants of the visible peaks and troughs in order, s."""
    from scipy.signal import find_peaks  # takes a second to import

    prominence = visible * float(np.ptp(signal))
    places = [find_peaks(sign * signal, prominence=prominence)[0] for sign in (1.0, -1.0)]
    return time[np.sort(np.concatenate(places))]


def counted_excess(results: Sequence[CaseResult]) -> list[Excess]:
    """Per threshold, half and channel the excess of the thesis' model over the reference, in halves where both resolve the first mode."""
    pairs = [(result.runs[MODEL], result.runs[REFERENCE]) for result in results if {MODEL, REFERENCE} <= set(result.runs)]
    excesses = []
    for visible in VISIBLE:
        for half in HALVES:
            resolved = [pair for pair in pairs if all(run.usable and run.consensus_frequency(half) for run in pair)]
            for channel in CHANNELS:
                counts = [tuple(counted_frequency(run, half, channel, visible) for run in pair) for pair in resolved]
                ratios = [mine / its - 1.0 for mine, its in counts if mine and its]
                if short := summary_of(ratios):
                    excesses.append(Excess(**vars(short), visible=visible, half=half, channel=channel))
    return excesses
