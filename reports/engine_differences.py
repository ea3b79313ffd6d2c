"""Differences between engines: case by case, and summarised."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from quickreturn.cases.comparison.engines import REFERENCE, CaseResult
from quickreturn.cases.comparison.pair import WAVEFORM, Difference, Kind
from quickreturn.cases.motion.cycle import HALVES
from quickreturn.cases.motion.marching import channels_of
from quickreturn.cases.motion.settling import GRID, on_common_grid
from quickreturn.reference_model.arrays import Array


@dataclass(frozen=True, kw_only=True)
class Summary:
    """Summary of a set of numbers."""

    median: float
    lowest: float
    highest: float
    count: int


@dataclass(frozen=True, kw_only=True)
class Spread(Summary):
    """Summary of a set of relative differences."""

    worst: Difference


def summary_of(values: Sequence[float]) -> Summary | None:
    """The summary of some numbers; None if there are none."""
    return Summary(median=float(np.median(values)), lowest=min(values), highest=max(values), count=len(values)) if values else None


def differences(
    results: Sequence[CaseResult], name: str, kind: Kind, other: str = REFERENCE, half: str | None = None, channel: str | None = None
) -> list[Difference]:
    """The differences of all cases; see `CaseResult.differences`."""
    return [difference for result in results for difference in result.differences(name, kind, other, half, channel)]


def used_along(result: CaseResult, name: str) -> Array | None:
    """The largest difference of an engine's channels from those it is held against, over the tolerance, at even crank angles, shape (720,).

    None if its waveforms are not judged.
    """
    checks = [check for check in result.checks if check.engine == name and check.quantity == WAVEFORM[1] and check.tolerance > 0.0]
    if not checks:
        return None
    one, other = (on_common_grid(channels_of(result.runs[each].cycle)) for each in (name, checks[0].other))
    used = np.zeros((len(HALVES), GRID // len(HALVES)))
    for check in checks:
        half, channel = HALVES.index(check.half), str(check.channel)
        used[half] = np.maximum(used[half], np.abs(one[channel] - other[channel]).reshape(used.shape)[half] / check.tolerance)
    return used.ravel()


def outward(quantity: str, difference: float) -> float:
    """A difference (engine minus other) with the sign that a reader expects: positive where the engine's number is larger.

    A minimum counts as larger where it is lower, because the signal then swings further; every other number where it is higher.
    """
    return -difference if quantity == "minimum" else difference


def spread(compared: Sequence[Difference]) -> Spread | None:
    """The summary of some differences; None if there are none."""
    short = summary_of([difference.relative for difference in compared])
    return Spread(**vars(short), worst=max(compared, key=lambda difference: abs(difference.relative))) if short else None


def engines_of(results: Sequence[CaseResult]) -> list[str]:
    """Names of all engines in the order of the first case that has them."""
    return list(dict.fromkeys(name for result in results for name in result.runs))
