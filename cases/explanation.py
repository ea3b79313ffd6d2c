"""Names the mistake that explains a finding, among many hypotheses: one rule for columns, scenes, starts and frequencies."""

from collections.abc import Iterable
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from quickreturn.engines.relative import rms

Array = NDArray[np.float64]

#: Largest part of a difference that a mistake may leave unexplained: if the engine's own error is small or given as noise ...
UNEXPLAINED: Final = 0.15
#: ... and if the difference also contains an error of the engine of unknown size.
UNEXPLAINED_COARSELY: Final = 0.4
#: Least ratio of the remainder with any other mistake to that with the best, for the best to be named.
_CLEARLY: Final = 2.0
#: Smaller remainders than this part of a difference do not distinguish mistakes ...
_LEAST_REMAINDER: Final = 1e-3
#: ... nor do those below this part of the noise, which is a bound: errors reach a third of it.
_LEAST_OF_NOISE: Final = 1.0 / 3.0
#: Predictions that differ by less than this part of the difference count as the same: the first is named.
_SAME: Final = 1e-6
#: Predictions that differ by less than this part of the difference are alike: all are named.
_ALIKE: Final = 0.05


@dataclass(frozen=True)
class Hypothesis:
    """A mistake and its prediction."""

    words: str  # what is wrong
    advice: str  # what to do
    prediction: Array  # values that the mistake would give, shape (n,)
    fitted: bool = False  # whether a number in it was fitted: it is tried only if no other mistake explains the finding
    gross: bool = True  # whether a coarse engine without a mistake cannot give such values


@dataclass(frozen=True)
class Explanation:
    """The mistake that explains a difference."""

    words: str
    advice: str
    remainder: float  # RMS of the difference that it leaves, in the unit of the values
    fitted: bool = False  # whether a number in it was fitted


def explain(
    found: Array, expected: Array, hypotheses: Iterable[Hypothesis], noise: float = 0.0, coarse: bool = False
) -> Explanation | None:
    """The mistake that explains a difference, or several that are alike; None if there is none, or if others explain it as well.

    Args:
        found: values with the mistake, shape (n,).
        expected: the right values.
        hypotheses: possible mistakes; if several predict the same, the first is named.
        noise: bound of the RMS error of `found` without any mistake.
        coarse: whether `found` may have an error of unknown size besides.
    """
    difference = rms(found - expected)
    if difference == 0.0:
        return None
    allowed = max((UNEXPLAINED_COARSELY if coarse else UNEXPLAINED) * difference, min(noise, 0.5 * difference))
    remainders = [(rms(found - mistake.prediction), mistake) for mistake in hypotheses]
    for fitted in (False, True):
        tried = [(remainder, mistake) for remainder, mistake in remainders if mistake.fitted is fitted and np.isfinite(remainder)]
        least, best = min(tried, key=lambda pair: pair[0], default=(np.inf, None))
        if best is None or least > allowed:
            continue
        clear = _CLEARLY * max(least, _LEAST_REMAINDER * difference, _LEAST_OF_NOISE * min(noise, difference))
        rivals = [mistake for remainder, mistake in tried if remainder < clear or mistake is best]
        alike = [mistake for mistake in rivals if rms(mistake.prediction - best.prediction) <= _ALIKE * difference]
        if len(alike) < len(rivals):
            return None
        same = [
            [rms(mistake.prediction - other.prediction) <= _SAME * difference for other in alike[:n]] for n, mistake in enumerate(alike)
        ]
        named = [mistake for mistake, earlier in zip(alike, same, strict=True) if not any(earlier)]
        return Explanation(", or ".join(mistake.words for mistake in named), named[0].advice, least, fitted)
    return None
