"""Least and greatest value of a channel in each half of a cycle; and the largest magnitude of a signal, with place, angle and error."""

import itertools
import math
from collections.abc import Callable, Mapping
from dataclasses import replace

import numpy as np
import scipy  # whose parts are imported when they are used

from quickreturn.cases.motion.number import Number
from quickreturn.reference_model.arrays import Array
from quickreturn.reference_model.interpolation import CubicSpline

#: Largest ratio of a spline's error at a corner between two samples to the error of a spline through every other sample at the nearest
#: four: the corner is then symmetric and lies midway. For a smooth signal the ratio is 1/16, so this overestimates a tiny error.
CORNER = 1.6

CUT_OFF = 200.0  # Hz, of the low-pass for measured signals
ORDER = 4  # the filter's gain is 1/(1 + (f/CUT_OFF)^(2 ORDER)): a Butterworth filter run forwards and backwards


def low_pass(time: Array, signal: Array) -> Array:
    """Zero-phase periodic low-pass at 200 Hz over one period.

    Args:
        time: s, increasing, shape (n,), from the start of a period to its end.
        signal: shape (n,).

    Returns:
        The filtered signal at the same instants, shape (n,).
    """
    steps = 2 * time.size  # dense enough to keep everything that uneven samples hold
    uniform = np.linspace(time[0], time[-1], steps, endpoint=False)
    spectrum = np.fft.rfft(scipy.interpolate.CubicSpline(time, signal)(uniform))
    frequencies = np.fft.rfftfreq(steps, (time[-1] - time[0]) / steps)
    filtered = np.fft.irfft(spectrum / (1.0 + (frequencies / CUT_OFF) ** (2 * ORDER)), steps)
    periodic = scipy.interpolate.CubicSpline(np.append(uniform, time[-1]), np.append(filtered, filtered[0]), bc_type="periodic")
    return np.asarray(periodic(time))


def extremes(time: Array, signal: Array, boundaries: Array | None = None) -> list[tuple[Number, Number]]:
    """Minimum and maximum of the cubic spline through a signal between any two neighbouring boundaries, without an engine's estimate.

    The spline is evaluated between the samples and at the boundaries: if a half begins on a steep flank, the nearest samples of two engines
    differ by a good percent of the peak.

    Args:
        time: s, increasing, shape (n,).
        signal: shape (n,).
        boundaries: s, increasing, within the samples but for round-off; None: the first and the last sample.
    """
    curve, left_out = CubicSpline(time, signal), _left_out(time, signal)
    turning = curve.turning_points()

    def between(start: float, end: float) -> tuple[Number, Number]:
        inside = turning[(turning > start) & (turning < end)]
        instants = np.concatenate([np.clip([start, end], time[0], time[-1]), inside])
        values = curve(instants)

        def extreme(at: int) -> Number:
            before = int(np.searchsorted(time, instants[at]))
            near = left_out[max(before - 2, 0) : before + 2]
            return Number(float(values[at]), measurement=CORNER * float(near.max()), time=float(instants[at]))

        return extreme(int(values.argmin())), extreme(int(values.argmax()))

    return [between(*pair) for pair in itertools.pairwise(time[[0, -1]] if boundaries is None else boundaries)]


def _left_out(time: Array, signal: Array) -> Array:
    """Error at each sample of a spline through every other sample and both ends, which leaves it out; shape (n,), zero at the ends."""
    missed = np.zeros(time.size)
    for first in (1, 2):
        between = np.arange(first, time.size - 1, 2)
        kept = np.delete(np.arange(time.size), between)
        missed[between] = np.abs(signal[between] - CubicSpline(time[kept], signal[kept])(time[between]))
    return missed


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
