"""The smallest error that the comparison of engines would find: errors are planted in the measured numbers, which are judged anew.

A planted error scales one number of one engine by the same factor in every case, as in an engine that is wrong by a factor. The claims of
both engines stay the same. `cases.runs.comparison.Difference.passed` judges.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from quickreturn.cases.runs.comparison import KINDS, CaseResult, Difference, Kind


@dataclass(frozen=True)
class Sharpness:
    """Errors that the comparisons of one kind between two engines can find; errors and tolerances are relative."""

    engine: str  # errors are planted in its numbers
    other: str  # the engine that it is compared with
    kind: Kind  # of numbers
    compared: int  # how many
    tolerance: float  # median of the tolerances, over the number itself; of an extreme over the channel's largest magnitude
    used: float  # largest ratio of a measured difference to its tolerance
    found_somewhere: float  # smallest planted error, of either sign, that at least one comparison finds
    found_mostly: float  # smallest planted error, of either sign, that at least half of the comparisons find


def sharpness(results: Sequence[CaseResult]) -> list[Sharpness]:
    """The sharpness of every compared pair of engines and every kind of numbers."""
    groups: dict[tuple[str, str, Kind], list[Difference]] = {}
    kinds = {quantity: kind for kind, quantities in KINDS.items() for quantity in quantities}
    for check in (check for result in results for check in result.checks if check.quantity in kinds):
        groups.setdefault((check.engine, check.other, kinds[check.quantity]), []).append(check)
    pairs = dict.fromkeys((engine, other) for engine, other, _ in groups)
    return [_of(*pair, kind, groups[*pair, kind]) for pair in pairs for kind in KINDS if (*pair, kind) in groups]


def smallest_found(check: Difference, sign: int) -> float:
    """The smallest relative error of one sign (1 or -1) in the engine's number that the comparison finds; infinite if it finds none."""
    change = sign * check.number.value
    if not check.passed:
        return 0.0
    return (check.tolerance - math.copysign(1.0, change) * check.difference) / abs(change) if change != 0.0 else math.inf


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
