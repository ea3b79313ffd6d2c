"""Size of a signal, and its distance from another."""

import math
from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray

from quickreturn.reference_model.columns import AXIAL, BENDING, ENDS


def rms(values: NDArray[np.float64]) -> float:
    """Root mean square; 0 for an empty array."""
    return float(np.sqrt(np.mean(np.square(values)))) if values.size else 0.0


def scale(name: str, columns: Mapping[str, NDArray[np.float64]]) -> float:
    """Size that the error of a column is relative to, in its unit: its RMS.

    A moment at an end is tiny where the body there is light: its scale is the largest RMS of the moments along the arm; likewise for the
    normal forces in the arm. A gap at the slider is zero but for errors: its scale is the slider's distance from the pivot.
    """
    family = BENDING if name in ENDS else AXIAL if name in AXIAL else ("slider_position",) if name == "constraint_gap" else (name,)
    return max(rms(columns[each]) for each in (family if columns.keys() & {*family} else (name,)) if each in columns)


def relative_error(values: NDArray[np.float64], truth: NDArray[np.float64]) -> float:
    """RMS of the difference over the RMS of the truth, both of shape (n,); infinite where the truth is zero throughout."""
    size = rms(truth)
    return rms(values - truth) / size if size > 0.0 else math.inf
