"""How far engines lie apart, case by case and in short."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final, Literal

import numpy as np

from cases.measures import CHANNELS
from cases.runs.comparison import HALVES, REFERENCE, CaseResult, values
from cases.runs.estimates import EXTREMES

Kind = Literal["frequency", "channel frequency", "amplitude", "extreme"]

#: Kind -> quantities of a measure; "frequency" is the consensus of a half over its channels.
QUANTITIES: Final = {
    "frequency": ("consensus_frequency",),
    "channel frequency": ("first_mode_frequency",),
    "amplitude": ("first_mode_amplitude",),
    "extreme": EXTREMES,
}


@dataclass(frozen=True)
class Difference:
    """One number of two engines.

    Attributes:
        case: name of the case.
        quantity: a number of `cases.measures.Measure`, or "consensus_frequency".
        half: "pre" or "post".
        channel: trajectory column; None for the consensus.
        value: the engine's.
        other: the one it is held against.
        relative: (value - other) / |other|; for an extreme over the channel's largest magnitude in the other's cycle.
    """

    case: str
    quantity: str
    half: str
    channel: str | None
    value: float
    other: float
    relative: float

    @property
    def ratio(self) -> float:
        """The value over the other."""
        return self.value / self.other


@dataclass(frozen=True, kw_only=True)
class Summary:
    """A set of numbers in short."""

    median: float
    lowest: float
    highest: float
    count: int


@dataclass(frozen=True, kw_only=True)
class Spread(Summary):
    """A set of differences in short; all relative."""

    worst: Difference


def summary_of(values: Sequence[float]) -> Summary | None:
    """Numbers in short; None if there are none."""
    return Summary(median=float(np.median(values)), lowest=min(values), highest=max(values), count=len(values)) if values else None


def differences(
    results: Sequence[CaseResult], engine: str, kind: Kind, other: str = REFERENCE, half: str | None = None, channel: str | None = None
) -> list[Difference]:
    """All differences of a kind between two engines, where both have the number; in both halves and all channels unless one is given."""
    found = []
    for result in results:
        run, opposite = result.runs.get(engine), result.runs.get(other)
        if run is None or opposite is None or not (run.usable and opposite.usable):
            continue
        for where in HALVES if half is None else (half,):
            for column in (None,) if kind == "frequency" else (CHANNELS if channel is None else (channel,)):
                for quantity in QUANTITIES[kind]:
                    pair = values(run, opposite, quantity, where, column)
                    scale = opposite.peak(column) if kind == "extreme" and column else abs(pair[1]) if pair else 0.0
                    if pair is not None and scale > 0.0:
                        found.append(Difference(result.case.name, quantity, where, column, *pair, (pair[0] - pair[1]) / scale))
    return found


def spread(found: Sequence[Difference]) -> Spread | None:
    """Differences in short; None if there are none."""
    short = summary_of([difference.relative for difference in found])
    return Spread(**vars(short), worst=max(found, key=lambda difference: abs(difference.relative))) if short else None


def engines_of(results: Sequence[CaseResult]) -> list[str]:
    """Names of all engines in the order of the first case that has them."""
    return list(dict.fromkeys(name for result in results for name in result.runs))


def resolvable(results: Sequence[CaseResult], engine: str) -> tuple[int, int]:
    """In how many halves of settled cycles the consensus frequency is resolvable, and of how many."""
    usable = [result.runs[engine] for result in results if engine in result.runs and result.runs[engine].usable]
    found = [run.consensus_frequency(half) is not None for run in usable for half in HALVES]
    return sum(found), len(found)
