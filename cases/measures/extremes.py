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
    """Minimum and maximum of the samples between two instants (s), both included."""
    slack = 1e-6 * (end - start)  # a sample at an end counts, whatever the round-off
    here = signal[(time >= start - slack) & (time <= end + slack)]
    return float(here.min()), float(here.max())
