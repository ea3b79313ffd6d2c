"""One first-mode frequency per half cycle from the channels that resolve it."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from quickreturn.cases.motion.number import Number, or_nan

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
