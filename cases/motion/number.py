"""A number with its claimed errors."""

import math
from dataclasses import dataclass, field, replace
from typing import Final, Literal

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
