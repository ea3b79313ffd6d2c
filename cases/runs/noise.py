"""Noise: white noise in the difference of two signals, and the departure of a table's rows from a smooth course."""

import math
from typing import Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from quickreturn.cases.instants import ROUNDING

Array = NDArray[np.float64]

#: Least number of rows for a spectrum that can show noise.
FEWEST_ROWS: Final = 64
#: Least part of a difference's mean square that white noise makes up for the difference to be called noise.
LEAST_SHARE: Final = 0.5
#: Largest ratio of a band's mean power to the level of the noise, or of the level to it, besides `_ERRORS` standard errors of that mean.
_LARGEST_RATIO: Final = 1.5
_ERRORS: Final = 3.0


#: Uncertainty of an extreme, in standard deviations of a row's noise: one row in 15,000 departs further.
DEVIATIONS: Final = 4.0


class Noise(NamedTuple):
    """White noise: its RMS, in the signal's unit, and the frequency (Hz) above which the signal is nothing else."""

    rms: float
    above: float


def white_noise(time: Array, difference: Array) -> Noise | None:
    """The noise that makes up most of a difference, or None.

    The power of white noise is the same at all frequencies. Its level is taken from the upper half of the spectrum. Bands below
    follow, each down to half the frequency of the last, as long as they keep to that level.

    Args:
        time: s, shape (n,); noise is found only in evenly spaced rows.
        difference: of a signal from its right values, shape (n,).
    """
    steps, n = np.diff(time), len(time)
    if n < FEWEST_ROWS or np.max(steps) > 1.01 * np.min(steps):
        return None
    mean_square = float(np.mean(difference**2))
    power = 2.0 * np.abs(np.fft.rfft(difference)[1 : (n + 1) // 2]) ** 2 / n**2  # of each frequency in the mean square
    lowest = len(power) // 2
    level = float(np.mean(power[lowest:]))
    if level == 0.0 or not _is_flat(power[lowest : 3 * lowest // 2], level) or len(power) * level < LEAST_SHARE * mean_square:
        return None
    while lowest and _is_flat(power[lowest // 2 : lowest], level):
        lowest //= 2
    return Noise(math.sqrt(len(power) * level), lowest / (n * float(np.mean(steps))))


def _is_flat(band: Array, level: float) -> bool:
    """Whether the mean power of a band is the level. Single powers of white noise scatter as much as they are large."""
    error = 1.0 + _ERRORS / math.sqrt(len(band))
    return level / (_LARGEST_RATIO * error) <= float(np.mean(band)) <= _LARGEST_RATIO * error * level


def noise_of(time: Array, values: Array) -> float:
    """Departure of rows from a smooth course: by their scatter, and by rounding."""
    return scatter(time, values) + ROUNDING * float(np.max(np.abs(values)))


def scatter(time: Array, values: Array) -> float:
    """Departure of rows from a smooth course, from the difference of each from the cubic through its four neighbours."""
    if len(time) < 5:
        return math.inf
    near = [slice(shift, len(time) - 4 + shift) for shift in (0, 1, 3, 4)]
    here = time[2:-2]
    weights = [np.prod([(here - time[other]) / (time[one] - time[other]) for other in near if other is not one], axis=0) for one in near]
    differences = values[2:-2] - sum(weight * values[one] for weight, one in zip(weights, near, strict=True))
    spread = np.sqrt(1.0 + sum(weight**2 for weight in weights))
    return DEVIATIONS * float(np.sqrt(np.mean((differences / spread) ** 2)))
