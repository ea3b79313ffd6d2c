"""How small an error the comparison of engines would have found: errors are planted in what was measured, and judged as before.

An error is planted by scaling a number of one engine, in every case alike, as an engine would show that is wrong by a factor. What both
engines claim stays as it is. The judgement is `cases.runs.comparison.Difference.passed`.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Final

import numpy as np

from quickreturn.cases.runs.comparison import KINDS, CaseResult, Difference, Kind

#: Relative errors between which the smallest that is found is searched, and the precision of the search.
SEARCHED: Final = (1e-9, 1e9)
PRECISION: Final = 1e-3


@dataclass(frozen=True)
class Sharpness:
    """What the comparisons of one kind between two engines can find; errors and tolerances are relative."""

    engine: str  # the one in whose numbers errors are planted
    other: str  # the one that it is held against
    kind: Kind  # of numbers
    compared: int  # how many
    tolerance: float  # median of the tolerances, over the number itself; of an extreme over the channel's largest magnitude
    used: float  # largest part of a tolerance that the difference, as measured, takes up
    found_somewhere: float  # smallest planted error, of either sign, that at least one comparison finds
    found_mostly: float  # smallest planted error, of either sign, that at least half of the comparisons find


def sharpness(results: Sequence[CaseResult]) -> list[Sharpness]:
    """Of every pair of engines that was compared, and every kind of numbers."""
    groups: dict[tuple[str, str, Kind], list[Difference]] = {}
    kinds = {quantity: kind for kind, quantities in KINDS.items() for quantity in quantities}
    for check in (check for result in results for check in result.checks if check.quantity in kinds):
        groups.setdefault((check.engine, check.other, kinds[check.quantity]), []).append(check)
    pairs = dict.fromkeys((engine, other) for engine, other, _ in groups)
    return [_of(*pair, kind, groups[*pair, kind]) for pair in pairs for kind in KINDS if (*pair, kind) in groups]


def smallest_found(check: Difference, sign: int) -> float:
    """The smallest relative error of one sign (1 or -1) in the engine's number that the comparison finds; infinite where it finds none."""

    def found(error: float) -> bool:
        return not replace(check, mine=replace(check.mine, value=(1.0 + sign * error) * check.mine.value)).passed

    low, high = SEARCHED
    if found(low):
        return low
    if not found(high):
        return float("inf")
    while high / low > 1.0 + PRECISION:
        middle = (low * high) ** 0.5
        low, high = (low, middle) if found(middle) else (middle, high)
    return high


def _of(engine: str, other: str, kind: Kind, checks: Sequence[Difference]) -> Sharpness:
    by_sign = [sorted(smallest_found(check, sign) for check in checks) for sign in (1, -1)]
    return Sharpness(
        engine,
        other,
        kind,
        len(checks),
        tolerance=float(np.median([check.tolerance / check.scale for check in checks])),
        used=max(abs(check.difference) / check.tolerance if check.tolerance > 0.0 else np.inf for check in checks),
        found_somewhere=max(errors[0] for errors in by_sign),
        found_mostly=max(errors[(len(checks) - 1) // 2] for errors in by_sign),
    )
