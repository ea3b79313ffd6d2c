"""Differences between engines: case by case, summarised, and their likely causes."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from quickreturn.cases.comparison.engines import REFERENCE, CaseResult
from quickreturn.cases.comparison.pair import WAVEFORM, Difference, Kind
from quickreturn.cases.motion.cycle import EXTREMES, HALVES
from quickreturn.cases.motion.marching import channels_of
from quickreturn.cases.motion.settling import GRID, on_common_grid

#: Distance over the follower's length within which the slider counts as at a gauge: half of one of sixteen elements.
KINK: Final = 1.0 / 32.0
#: A difference is marginal if it exceeds its tolerance by less than this part of it.
MARGINAL: Final = 0.1


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


def used_along(result: CaseResult, name: str) -> NDArray[np.float64] | None:
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


def cause(result: CaseResult, check: Difference) -> str:
    """The likely causes of a departure, as far as the numbers at hand show them (clauses)."""
    causes = []
    if check.quantity in EXTREMES and _slider_at_gauge(result, check):
        causes.append("at this instant the slider passes the gauge, where the curvature has a kink that elements and links round off")
    missed = [name for name in (check.engine, check.other) if not result.runs[name].computation.reached]
    causes += [f"{name} does not reach the accuracy asked, by its own estimate" for name in missed]
    if abs(check.difference) < (1.0 + MARGINAL) * check.tolerance:
        causes.append(f"marginal: beyond the tolerance by less than {MARGINAL:.0%} of it")
    return "; ".join(causes) or "not explained by the numbers at hand"


def _slider_at_gauge(result: CaseResult, check: Difference) -> bool:
    """Whether the other engine's extreme of a strain happens while the slider is within `KINK` of the gauge."""
    follower = result.case.mechanism.follower
    if check.channel is None or not check.channel.startswith("strain_"):
        return False
    cycle = result.runs[check.other].cycle
    turned = np.abs(cycle["crank_angle"] - cycle["crank_angle"][0])
    here = turned <= np.pi if check.half == "pre" else turned >= np.pi
    signal = cycle[check.channel] if check.quantity == "maximum" else -cycle[check.channel]
    instant = int(np.argmax(np.where(here, signal, -np.inf)))
    gauge = follower.strain_gauges[int(check.channel[-1]) - 1]
    return bool(abs(cycle["slider_position"][instant] - gauge) <= KINK * follower.length)
