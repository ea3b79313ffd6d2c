"""The largest magnitude of a signal: its value, place, crank angle and error."""

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from quickreturn.cases.measures.extremes import extremes

Array = NDArray[np.float64]

#: Error of a column at a crank angle (rad), in its unit, by the engine's own estimate; None if it has none.
ErrorAt = Callable[[str, float], float | None]


@dataclass(frozen=True)
class Peak:
    """A largest magnitude, in SI units."""

    value: float  # not negative
    crank_angle: float | None  # where it is reached, rad, from 0 to a turn; None without a crank
    time: float  # likewise, s
    uncertainty: float  # uncertainty from the spacing of the rows and places that an engine gives
    estimate: float | None  # the engine's own error estimate; None if there is none
    place: float | None = None  # arc length from P at which it is reached, m; None if it is not a quantity of the arm

    @property
    def error(self) -> float | None:
        """Its total error; None if the engine gives no estimate."""
        return None if self.estimate is None else self.uncertainty + self.estimate

    def times(self, factor: float) -> "Peak":
        """The peak times a factor: in another unit, or of a quantity proportional to it."""
        estimate = None if self.estimate is None else factor * self.estimate
        return replace(self, value=factor * self.value, uncertainty=factor * self.uncertainty, estimate=estimate)


def peak_of(signal: Array, columns: Mapping[str, Array], claim: Callable[[float], float | None], place: float | None = None) -> Peak:
    """Peak of the magnitude of a signal given at the rows of `columns`.

    Args:
        signal: shape (rows,).
        columns: of a trajectory; its time, and crank angle if there is a crank.
        claim: crank angle (rad, continuous; 0 without a crank) -> error of the signal by the engine's own estimate; None if it has none.
        place: arc length at which the signal is taken, m; None if it is no quantity of the arm.
    """
    time = columns["time"]
    largest = max(extremes(time, signal, time[0], time[-1]), key=lambda extreme: abs(extreme.value))
    angle = float(np.interp(largest.time, time, columns["crank_angle"])) if "crank_angle" in columns else None
    turned = None if angle is None else angle % (2.0 * math.pi)
    return Peak(abs(largest.value), turned, largest.time, largest.uncertainty, claim(angle or 0.0), place)


def of_column(name: str, columns: Mapping[str, Array], claim: ErrorAt) -> Peak | None:
    """Peak of a column; None where the engine does not give it."""
    return peak_of(columns[name], columns, lambda angle: claim(name, angle)) if name in columns else None


def of_vector(name: str, columns: Mapping[str, Array], claim: ErrorAt) -> Peak | None:
    """Peak of the length of a vector whose parts are the columns `name`_x and `name`_y."""
    parts = f"{name}_x", f"{name}_y"
    if not set(parts) <= set(columns):
        return None

    def both(angle: float) -> float | None:
        errors = [error for part in parts if (error := claim(part, angle)) is not None]
        return math.hypot(*errors) if len(errors) == len(parts) else None

    return peak_of(np.hypot(*(columns[part] for part in parts)), columns, both)
