"""One first-mode frequency per half cycle from the channels that resolve it."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

LEAST_UNCERTAINTY = 0.005  # of the frequency


@dataclass(frozen=True)
class Consensus:
    """First-mode frequency of a half cycle over all channels; None where no channel resolves it.

    Attributes:
        half: "pre" or "post".
        first_mode_frequency: Hz.
        uncertainty: Hz, one standard deviation.
    """

    half: str
    first_mode_frequency: float | None
    uncertainty: float | None


def consensus(half: str, frequencies: Sequence[float], uncertainties: Sequence[float]) -> Consensus:
    """Mean of the resolvable channels' frequencies (Hz), weighted with their uncertainties (Hz)."""
    if not frequencies:
        return Consensus(half, None, None)
    values, weights = np.array(frequencies), np.array(uncertainties) ** -2.0
    mean = float(weights @ values / weights.sum())
    scatter = float(np.std(values, ddof=1) / np.sqrt(values.size)) if values.size > 1 else 0.0
    return Consensus(half, mean, max(float(weights.sum() ** -0.5), scatter, LEAST_UNCERTAINTY * mean))
