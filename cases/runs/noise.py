"""Noise: the departure of a table's rows from a smooth course."""

import math
from typing import Final

import numpy as np
from numpy.typing import NDArray

from quickreturn.cases.instants import ROUNDING

Array = NDArray[np.float64]

#: Uncertainty of an extreme, in standard deviations of a row's noise: one row in 15,000 departs further.
DEVIATIONS: Final = 4.0


def noise_of(time: Array, values: Array) -> float:
    """Departure of rows from a smooth course: by their scatter, and by rounding."""
    return scatter(time, values) + ROUNDING * float(np.max(np.abs(values)))


def scatter(time: Array, values: Array) -> float:
    """Departure of rows from a smooth course, from the difference of each from the cubic through its four neighbours."""
    if len(time) < 5:
        return math.inf
    near = [slice(shift, len(time) - 4 + shift) for shift in (0, 1, 3, 4)]
    here = time[2:-2]
    weights = [np.prod([(here - time[other]) / (time[one] - time[other]) for other in near if other is not one], axis=0) for one in near]
    differences = values[2:-2] - sum(weight * values[one] for weight, one in zip(weights, near, strict=True))
    spread = np.sqrt(1.0 + sum(weight**2 for weight in weights))
    return DEVIATIONS * float(np.sqrt(np.mean((differences / spread) ** 2)))
