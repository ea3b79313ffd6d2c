"""Least and greatest value of a channel in a half cycle."""

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import CubicSpline

Array = NDArray[np.float64]

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
    spectrum = np.fft.rfft(CubicSpline(time, signal)(uniform))
    frequencies = np.fft.rfftfreq(steps, (time[-1] - time[0]) / steps)
    filtered = np.fft.irfft(spectrum / (1.0 + (frequencies / CUT_OFF) ** (2 * ORDER)), steps)
    whole = CubicSpline(np.append(uniform, time[-1]), np.append(filtered, filtered[0]), bc_type="periodic")
    return np.asarray(whole(time))


def extremes(time: Array, signal: Array, start: float, end: float) -> tuple[float, float]:
    """Minimum and maximum of the cubic spline through a signal between two instants (s), both included.

    Between the samples, too, and at the ends: where a half begins on a steep flank, the nearest samples of two engines lie a good
    percent of the peak apart.

    Args:
        time: s, increasing, shape (n,).
        signal: shape (n,).
        start: s, within the samples but for round-off.
        end: s, likewise.
    """
    curve = CubicSpline(time, signal)
    turning = curve.derivative().roots(extrapolate=False)
    inside = turning[(turning > start) & (turning < end)]  # NaN, which stands for a level stretch, is not
    values = np.concatenate([curve(np.clip([start, end], time[0], time[-1])), curve(inside)])
    return float(values.min()), float(values.max())
