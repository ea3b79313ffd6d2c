"""The coefficients of DOP853: order 8, error formulas of orders 5 and 3, interpolation within a step.

Hairer, Norsett and Wanner, Solving Ordinary Differential Equations I, section II.5.
"""

from typing import Final

import numpy as np
from numpy.typing import NDArray
from scipy.integrate import DOP853  # takes 0.3 s to import: only the compiled loop imports this module

#: Weights of the stages before each stage, shape (13, 13): twelve of the step, and its end.
A: Final = np.vstack([np.pad(DOP853.A, ((0, 0), (0, 1))), np.append(DOP853.B, 0.0)])
#: Errors of orders 3 and 5: weights of the step's stages and its end, shape (13,).
E3: Final[NDArray[np.float64]] = DOP853.E3
E5: Final[NDArray[np.float64]] = DOP853.E5
#: Stages that the interpolation uses: those with a weight in the step, and the step's end.
INTERPOLATED: Final = (0, *range(5, 13))


def _interpolation() -> NDArray[np.float64]:
    """Weights of the `INTERPOLATED` stages at the fraction u of a step (equation 5.17), in powers of 2 u - 1, shape (9, 8)."""
    c = A.sum(axis=1)
    powers = np.vander(2.0 * c - 1.0, 7, increasing=True).T
    conditions = np.array([*powers, A @ A @ c**3 - c**5 / 20, A @ A @ A @ A @ c - c**5 / 120])[:, INTERPOLATED]
    integrals = np.zeros((len(INTERPOLATED), 8))  # of the powers from 0 to u; the last two conditions have the right side 0
    for k in range(7):
        integrals[k, k + 1], integrals[k, 0] = 0.5 / (k + 1), 0.5 * (-1) ** k / (k + 1)
    return np.linalg.solve(conditions, integrals)


INTERPOLATION: Final = _interpolation()
