"""Frequency of the second mode in a half cycle, for the few halves that clearly show one."""

import numpy as np
from numpy.typing import NDArray

from quickreturn.cases.motion.drifting_fit import Fit, Waves, left_by, orthonormal, without
from quickreturn.cases.motion.half_cycle import ChannelHalf, polynomials

Array = NDArray[np.float64]

DEGREE = 9  # of the polynomial that is the slow part
SCAN = np.linspace(0.80, 1.50, 71)  # tried factors on the mechanism's own second frequency
NEEDED_FALL = 2.0  # least ratio of the residual sums of squares without and with the second mode
NEEDED_LEAD = 1.4  # least ratio of the second best minimum of this sum, or of its ends, to the best
AGREEMENT = 0.06  # largest relative difference of two channels' frequencies that agree


def second_mode_frequency(channel: ChannelHalf, first_mode: Fit) -> float | None:
    """Time mean of the second mode's frequency in Hz, None where it does not stand out in this channel alone.

    Slow part and first mode are fitted with more freedom than in the first mode's own fit, so that neither is taken for a second mode: the
    first mode keeps its phase but its envelope may bend, each of its two components by itself.
    """
    waves = Waves.of(channel)
    sigma = waves.sigma[:, None]
    alpha, beta, kappa, _, _ = first_mode.parameters
    oscillation = waves.first_mode(alpha, beta, kappa)
    basis = orthonormal(np.hstack([polynomials(DEGREE), oscillation, oscillation * sigma, oscillation * sigma**2]))
    signal = without(basis, channel.signal[:, None])[:, 0]
    residuals = left_by(without(basis, waves.second_mode(SCAN)), signal)

    best = int(np.argmin(residuals))
    if best in (0, SCAN.size - 1) or not np.sum(signal**2) > NEEDED_FALL * residuals[best]:
        return None
    minima = np.flatnonzero((residuals[1:-1] < residuals[:-2]) & (residuals[1:-1] <= residuals[2:])) + 1
    rivals = np.concatenate([residuals[minima[minima != best]], residuals[[0, -1]]])
    if not rivals.min() > NEEDED_LEAD * residuals[best]:
        return None
    return float(_vertex(SCAN[best - 1 : best + 2], residuals[best - 1 : best + 2]) * channel.half.mean_frequencies[1])


def agreeing(frequencies: list[float | None]) -> list[float | None]:
    """Keep the frequencies (Hz, one per channel) that at least one other channel confirms."""
    return [
        value
        if value is not None
        and any(other is not None and abs(other - value) <= AGREEMENT * value for j, other in enumerate(frequencies) if j != i)
        else None
        for i, value in enumerate(frequencies)
    ]


def _vertex(x: Array, y: Array) -> float:
    """Abscissa of the vertex of the parabola through three equidistant points, the middle one lowest."""
    return float(x[1] + (x[1] - x[0]) * (y[0] - y[2]) / (2.0 * (y[0] - 2.0 * y[1] + y[2])))
