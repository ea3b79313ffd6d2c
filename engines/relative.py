"""Size of a signal, and its distance from another."""

import math

import numpy as np
from numpy.typing import NDArray


def rms(values: NDArray[np.float64]) -> float:
    """Root mean square; 0 for an empty array."""
    return float(np.sqrt(np.mean(np.square(values)))) if values.size else 0.0


def relative_error(values: NDArray[np.float64], truth: NDArray[np.float64]) -> float:
    """RMS of the difference over the RMS of the truth, both of shape (n,); infinite where the truth is zero throughout."""
    size = rms(truth)
    return rms(values - truth) / size if size > 0.0 else math.inf
