"""The largest magnitude of a signal: its value, place, crank angle and error."""

import math
from collections.abc import Callable, Mapping
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from quickreturn.cases.motion.extremes import extremes
from quickreturn.cases.motion.number import Number

Array = NDArray[np.float64]

#: Error of a column at a crank angle (rad), in its unit, by the engine's own estimate; None if it has none.
ErrorAt = Callable[[str, float], float | None]


def peak_of(signal: Array, columns: Mapping[str, Array], claim: Callable[[float], float | None], place: float | None = None) -> Number:
    """Peak of the magnitude of a signal given at the rows of `columns`.

    Args:
        signal: shape (rows,).
        columns: of a trajectory; its time, and crank angle if there is a crank.
        claim: crank angle (rad, continuous; 0 without a crank) -> error of the signal by the engine's own estimate; None if it has none.
        place: arc length at which the signal is taken, m; None if it is no quantity of the arm.
    """
    time = columns["time"]
    largest = max(extremes(time, signal)[0], key=lambda extreme: abs(extreme.value))
    angle = float(np.interp(largest.time, time, columns["crank_angle"])) if "crank_angle" in columns else None
    turned = None if angle is None else angle % (2.0 * math.pi)
    return replace(largest, value=abs(largest.value), estimate=claim(angle or 0.0), crank_angle=turned, place=place)


def of_column(name: str, columns: Mapping[str, Array], claim: ErrorAt) -> Number | None:
    """Peak of a column; None where the engine does not give it."""
    return peak_of(columns[name], columns, lambda angle: claim(name, angle)) if name in columns else None


def of_vector(name: str, columns: Mapping[str, Array], claim: ErrorAt) -> Number | None:
    """Peak of the length of a vector whose parts are the columns `name`_x and `name`_y."""
    parts = f"{name}_x", f"{name}_y"
    if not set(parts) <= set(columns):
        return None

    def both(angle: float) -> float | None:
        errors = [error for part in parts if (error := claim(part, angle)) is not None]
        return math.hypot(*errors) if len(errors) == len(parts) else None

    return peak_of(np.hypot(*(columns[part] for part in parts)), columns, both)
