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
#: Largest part of the values that a mistake may leave in a coarse engine; otherwise it is `UNEXPLAINED`. A table that is too small differs
#: from the right one by nearly all of it, so that any factor below one would leave a small part of the difference.
LEFT_COARSELY: Final = 0.6
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
    fitted: int = 0  # how many numbers in it were fitted: it is tried only if no mistake with fewer explains the finding
    gross: bool = True  # whether a coarse engine without a mistake cannot give such values
    # RMS of the values as the mistake gives them, without a constant that it adds: what is left when the mistake is undone counts in parts
    # of it. None: only the part of the difference counts
    size: float | None = None


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

    A mistake is accepted if it leaves a small part of the difference and, when it is undone, a small part of the values. The one with the
    fewest fitted numbers is named, unless it leaves more than noise and another of known size leaves clearly less.

    Args:
        found: values with the mistake, shape (n,).
        expected: the right values.
        hypotheses: possible mistakes; if several predict the same, the first is named.
        noise: bound of the RMS error of `found` without any mistake.
        coarse: whether `found` may have an error of unknown size besides.
    """
    difference, size = rms(found - expected), rms(expected)
    if difference == 0.0:
        return None
    share = noise / max(size, rms(found))  # engines state their errors in the unit, right or wrong, in which they give the column
    judged = [_judged(mistake, found, difference, noise, share) for mistake in hypotheses]
    allowed = max((UNEXPLAINED_COARSELY if coarse else UNEXPLAINED) * difference, min(noise, 0.5 * difference))
    of_values = LEFT_COARSELY if coarse else max(UNEXPLAINED, share)
    tried = [each for each in judged if each.mistake.size is None or each.left <= of_values * each.mistake.size]
    tried = [each for each in tried if np.isfinite(each.left)]
    for fitted in sorted({each.mistake.fitted for each in tried}):
        level = [each for each in tried if each.mistake.fitted == fitted]
        best = min(level, key=lambda each: each.left)
        if best.left > allowed or (best.left > best.noise and _beaten(best, tried)):
            continue
        clear = _CLEARLY * max(best.left, _LEAST_REMAINDER * best.extent, _LEAST_OF_NOISE * min(best.noise, best.extent))
        rivals = [each.mistake for each in level if each.left < clear or each is best]
        alike = [mistake for mistake in rivals if rms(mistake.prediction - best.mistake.prediction) <= _ALIKE * best.extent]
        if len(alike) < len(rivals):
            return None
        same = [
            [rms(mistake.prediction - other.prediction) <= _SAME * best.extent for other in alike[:n]] for n, mistake in enumerate(alike)
        ]
        named = [mistake for mistake, earlier in zip(alike, same, strict=True) if not any(earlier)]
        return Explanation(", or ".join(mistake.words for mistake in named), named[0].advice, best.left, bool(fitted))
    return None


@dataclass(frozen=True)
class _Judged:
    """A mistake held against what is found."""

    mistake: Hypothesis
    left: float  # RMS of the difference that it leaves
    noise: float  # bound of the RMS error that the values with this mistake have besides
    extent: float  # RMS of the difference, or of the values as the mistake gives them, whichever is less


def _judged(mistake: Hypothesis, found: Array, difference: float, noise: float, share: float) -> _Judged:
    """A mistake held against what is found; `share`: the noise over the size of the values."""
    left = rms(found - mistake.prediction)
    if mistake.size is None:
        return _Judged(mistake, left, noise, difference)
    return _Judged(mistake, left, share * mistake.size, min(difference, mistake.size or difference))


def _beaten(best: _Judged, tried: Iterable[_Judged]) -> bool:
    """Whether a mistake of known size with more fitted numbers leaves clearly less than one of known size."""
    if best.mistake.size is None:
        return False
    return any(
        _CLEARLY * each.left < best.left for each in tried if each.mistake.size is not None and each.mistake.fitted > best.mistake.fitted
    )
