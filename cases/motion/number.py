"""A number with its claimed errors; and the consensus of channels on one, the first-mode frequency of a half cycle."""

import math
from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from typing import Final, Literal

import numpy as np

from quickreturn.engines.error_parts import ErrorPart

Verdict = Literal["agrees", "disagrees", "says nothing"]
VERDICTS: Final[tuple[Verdict, ...]] = ("agrees", "disagrees", "says nothing")
#: Largest tolerance, over the scale, of a comparison that says something where it is kept; a larger one of a frequency would hide what
#: the thesis found, frequencies that are some percent too high.
TELLING: Final = 0.1
TELLING_OF_AMPLITUDES: Final = 0.05
TELLING_OF_FREQUENCIES: Final = 0.01
SAYS_NOTHING: Final = (
    f"{100 * TELLING:g} % of the number, of an amplitude {100 * TELLING_OF_AMPLITUDES:g} %,"
    f" of a frequency {100 * TELLING_OF_FREQUENCIES:g} %"
)


@dataclass(frozen=True)
class Number:
    """A number, its claimed errors, and where it is reached; all in SI units.

    Attributes:
        value: the number; nan where there is none.
        estimate: the engine's estimate of its error; None if it has none.
        measurement: uncertainty of the measurement: one standard deviation of a frequency or amplitude; of an extreme, and of a
            function of a turn's columns, that from the spacing of rows and places.
        settling: what is left to the steady state.
        parts: parts of the estimate, with the runs that show them.
        time: when it is reached, s; nan where that means nothing.
        crank_angle: where it is reached, rad, from 0 to a turn; None where that means nothing.
        place: arc length from P at which it is reached, m; likewise.
    """

    value: float = math.nan
    estimate: float | None = None
    measurement: float = 0.0
    settling: float = 0.0
    parts: tuple[ErrorPart, ...] = field(default=(), compare=False)
    time: float = math.nan
    crank_angle: float | None = None
    place: float | None = None

    @property
    def uncertainty(self) -> float:
        """Error of the measurement, and what is left to the steady state."""
        return self.measurement + self.settling

    @property
    def error(self) -> float:
        """The total claimed error; nan if it is not known."""
        return math.nan if self.estimate is None else self.estimate + self.uncertainty

    def times(self, factor: float) -> "Number":
        """The number times a factor: in another unit, or of a quantity proportional to it."""
        names = ("value", "estimate", "measurement", "settling")
        numbers = {name: factor * number for name in names if (number := getattr(self, name)) is not None}
        return replace(self, **numbers, parts=tuple(replace(part, difference=factor * part.difference) for part in self.parts))


#: Where there is no number.
NO_NUMBER: Final = Number()


def or_nan(number: float | None) -> float:
    """A number, nan if there is none."""
    return math.nan if number is None else number


#: Correlation of the errors of two channels in a half: they share the path of the frequency and much of the slow part. Measured 0.66 in the
#: thesis' steady states, 0.4 in those of random scenes, 0.2 on synthetic halves whose path is the mechanism's own and 0.6 to 0.8 where it
#: drifts.
CORRELATION = 0.5


@dataclass(frozen=True)
class Consensus:
    """First-mode frequency of a half cycle over all channels; None where no channel resolves it."""

    half: str  # "pre" or "post"
    first_mode_frequency: float | None  # Hz
    uncertainty: float | None  # Hz, one standard deviation
    first_mode_frequency_estimate: float | None = None  # an engine's estimate of its error, Hz; None if there is none

    @property
    def number(self) -> Number | None:
        """The frequency with its claims; None where it is not resolvable."""
        frequency = self.first_mode_frequency
        return None if frequency is None else Number(frequency, self.first_mode_frequency_estimate, or_nan(self.uncertainty))


def consensus(half: str, frequencies: Sequence[float], uncertainties: Sequence[float]) -> Consensus:
    """Mean of the channels' frequencies (Hz), weighted with their uncertainties (Hz).

    The common error of channels does not average out: with weights w and correlation c the variance of the mean is
    (1 - c) sum of (w u)^2 + c (sum of w u)^2, at least that of their scatter.
    """
    if not frequencies:
        return Consensus(half, None, None)
    values, errors = np.array(frequencies), np.array(uncertainties)
    weights = errors**-2.0 / np.sum(errors**-2.0)
    mean, parts = float(weights @ values), weights * errors
    scatter = float(np.std(values, ddof=1) / np.sqrt(values.size)) if values.size > 1 else 0.0
    return Consensus(half, mean, max(float(np.sqrt((1.0 - CORRELATION) * parts @ parts + CORRELATION * parts.sum() ** 2)), scatter))
