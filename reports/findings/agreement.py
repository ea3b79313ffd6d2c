"""Differences between engines, case by case and summarised."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from quickreturn.cases.measures.cycle import HALVES
from quickreturn.cases.runs.comparison import REFERENCE, CaseResult, Difference, Kind


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


def resolvable(results: Sequence[CaseResult], engine: str) -> tuple[int, int]:
    """Of an engine's usable runs: the number of half cycles with a resolvable consensus frequency, and of all half cycles."""
    usable = [result.runs[engine] for result in results if engine in result.runs and result.runs[engine].usable]
    resolved = [run.consensus_frequency(half) is not None for run in usable for half in HALVES]
    return sum(resolved), len(resolved)
