"""Names the mistake that makes what is found, out of many that could: one rule for columns, scenes, starts and frequencies."""

from collections.abc import Iterable
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from quickreturn.engines.relative import rms

Array = NDArray[np.float64]

#: The largest part of a difference that a mistake may leave unexplained: where the engine's own error is small or given as noise, and
#: where it is in the difference as well and nobody knows its size.
EXPLAINED: Final = 0.15
COARSELY: Final = 0.4
#: By how many times more than the best any other mistake must leave unexplained for the best to be named.
_CLEARLY: Final = 2.0
#: Part of a difference, and part of the noise, below which what is left says nothing about which mistake is the right one. The noise is a
#: bound that errors reach a third of.
_UNTOLD: Final = 1e-3
_OF_NOISE: Final = 1.0 / 3.0
#: Predictions that differ by less than this part of the difference are one and the same: the first is named.
_SAME: Final = 1e-6
#: Predictions that differ by less than this part of it are alike: all are named.
_ALIKE: Final = 0.05


@dataclass(frozen=True)
class Hypothesis:
    """A mistake, and what would be found if it was made."""

    words: str  # what is wrong
    advice: str  # what to do
    values: Array  # what would be found, shape (n,)
    fitted: bool = False  # whether a number in it was chosen to fit: it is tried only where no other mistake explains what is found
    gross: bool = True  # whether a coarse engine without any mistake cannot come out like that


@dataclass(frozen=True)
class Explanation:
    """The mistake that explains what is found, how much of the difference it leaves (in its unit), and whether it was fitted."""

    words: str
    advice: str
    left: float
    fitted: bool = False


def explain(
    found: Array, expected: Array, hypotheses: Iterable[Hypothesis], noise: float = 0.0, coarse: bool = False
) -> Explanation | None:
    """The mistake that explains a difference, or several that are alike; None where there is none, or where others explain it as well.

    Args:
        found: what is there, shape (n,).
        expected: what should be there.
        hypotheses: mistakes that could have been made; of those that predict the same the first is named.
        noise: by how much `found` may be off (RMS) without any mistake.
        coarse: whether `found` may be off by more than that.
    """
    off = rms(found - expected)
    if off == 0.0:
        return None
    allowed = max((COARSELY if coarse else EXPLAINED) * off, min(noise, 0.5 * off))
    left = [(rms(found - each.values), each) for each in hypotheses]
    for fitted in (False, True):
        tried = [(rest, each) for rest, each in left if each.fitted is fitted and np.isfinite(rest)]
        if not tried:
            continue
        least, best = min(tried, key=lambda pair: pair[0])
        if least > allowed:
            continue
        clear = _CLEARLY * max(least, _UNTOLD * off, _OF_NOISE * min(noise, off))
        rivals = [each for rest, each in tried if rest < clear or each is best]
        alike = [each for each in rivals if rms(each.values - best.values) <= _ALIKE * off]
        if len(alike) < len(rivals):
            return None
        told = [each for n, each in enumerate(alike) if all(rms(each.values - other.values) > _SAME * off for other in alike[:n])]
        return Explanation(", or ".join(each.words for each in told), told[0].advice, least, fitted)
    return None
