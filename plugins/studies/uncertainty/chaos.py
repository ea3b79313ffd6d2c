"""A polynomial chaos: orthonormal polynomials of uncertain quantities, fitted to a measure by least squares.

Sobol' indices follow from its coefficients (B. Sudret, Reliability Engineering & System Safety 93, 2008, 964). Their errors, and those of
mean and scatter, are those of fits to resampled residuals, each taken as the error at a point of the fit to all others
(A. C. Davison, D. V. Hinkley, Bootstrap Methods and their Application, 1997, section 6.2).
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import combinations_with_replacement
from typing import Final

import numpy as np
from numpy.typing import NDArray
from scipy import stats

from quickreturn.plugins.studies.uncertainty.parameters import Distribution
from quickreturn.reference_model.arrays import Array

SEED: Final = 1  # of the random numbers
DRAWN: Final = 200  # number of resamplings
HIGHEST_DEGREE: Final = 4
#: Least number of points for each coefficient.
PER_TERM: Final = 2.0
#: A surrogate that explains less than this part of the variance, cross-validated, serves for nothing.
GOOD: Final = 0.8
#: Number of its values from which quantiles are read.
VALUES: Final = 16384
PARTS: Final = 4  # of these values; the spread of the parts' quantiles is more than the error of those of all
#: Standard errors in the half width of an interval of 95 %.
HALF_WIDTH: Final = 1.96
#: Half width of a quantile's interval over the largest error of the fit at a point left out. Five functions of one to three quantities
#: (product, exponential, two resonance curves, corner; 8 to 256 points, 60 studies each) lay within it in at least 93 % of the studies,
#: the corner of 8 points in 80 %; with 1 in place of 1.5 the median of the corner lay within it in 32 %.
BEYOND: Final = 1.5


def cube(count: int, points: int) -> Array:
    """Quasi-random points from 0 to 1 in `count` dimensions (scrambled Sobol'), a power of two, shape (points, count)."""
    return np.asarray(stats.qmc.Sobol(count, rng=np.random.default_rng(SEED)).random(points))


def powers_up_to(degree: int, count: int) -> NDArray[np.int64]:
    """The powers of all monomials in `count` variables up to a total degree, shape (binomial(degree + count, count), count)."""
    chosen = (each for total in range(degree + 1) for each in combinations_with_replacement(range(count), total))
    return np.array([np.bincount(np.array(each, dtype=np.int64), minlength=count) for each in chosen])


def least_points(count: int) -> int:
    """Least power of two that is enough points for a linear surrogate in `count` variables."""
    return 1 << math.ceil(math.log2(PER_TERM * (count + 1)))


@dataclass(frozen=True, eq=False)
class Surrogate:
    """Orthonormal polynomials of the parameters, fitted by least squares."""

    distributions: Sequence[Distribution]  # of the p parameters
    degree: int  # largest total degree
    powers: NDArray[np.int64]  # degree of each term in each parameter, shape (terms, p)
    matrix: Array  # terms at the points, shape (n, terms)
    values: Array  # at the points, shape (n,)
    alone: Array  # error at each point of the fit to all others, shape (n,)
    q2: float  # part of the variance that it predicts at points left out of its fit, one at a time; nan without enough points

    @classmethod
    def best(cls, distributions: Sequence[Distribution], inputs: Array, values: Array) -> "Surrogate":
        """The surrogate of the degree with the best `q2`, among degrees that have enough points."""
        candidates = [cls._of(degree, distributions, inputs, values) for degree in range(1, HIGHEST_DEGREE + 1)]
        return max(candidates, key=lambda surrogate: surrogate.q2 if math.isfinite(surrogate.q2) else -math.inf)

    @classmethod
    def _of(cls, degree: int, distributions: Sequence[Distribution], inputs: Array, values: Array) -> "Surrogate":
        count = len(distributions)
        if math.comb(degree + count, count) * PER_TERM > len(values) or not np.ptp(values) > 0.0:
            constant = np.zeros((1, count), dtype=np.int64)
            return cls(distributions, degree, constant, np.ones((len(values), 1)), values, values, math.nan)
        powers = powers_up_to(degree, count)
        matrix = _terms(distributions, inputs, powers)
        leverage = np.sum(np.linalg.qr(matrix)[0] ** 2, axis=1)
        left = values - matrix @ np.linalg.lstsq(matrix, values, rcond=None)[0]
        alone = left / np.maximum(1.0 - leverage, 1e-9)
        return cls(distributions, degree, powers, matrix, values, alone, 1.0 - float(np.mean(alone**2) / np.var(values)))

    @property
    def good(self) -> bool:
        """Whether it predicts enough."""
        return self.q2 >= GOOD

    @cached_property
    def coefficients(self) -> Array:
        """Of the fit, and of fits to resampled residuals, shape (terms, 1 + DRAWN)."""
        inverse, residuals = np.linalg.pinv(self.matrix), self.alone - np.mean(self.alone)
        drawn = np.random.default_rng(SEED).integers(len(residuals), size=(len(residuals), DRAWN))
        return np.asarray((inverse @ self.values)[:, None] + np.column_stack([np.zeros(len(inverse)), inverse @ residuals[drawn]]))

    def shares(self) -> list[tuple[float, float, float, float]]:
        """First-order and total Sobol' index of each parameter, each followed by its 95 % half width."""
        squares = np.where(np.any(self.powers > 0, axis=1)[:, None], self.coefficients**2, 0.0)
        parts = squares / np.sum(squares, axis=0)
        found = list[tuple[float, float, float, float]]()
        for place in range(self.powers.shape[1]):
            has = self.powers[:, place] > 0
            kinds = [parts[kind].sum(axis=0) for kind in (has & (np.sum(self.powers > 0, axis=1) == 1), has)]
            (first, total), errors = (kind[0] for kind in kinds), [HALF_WIDTH * np.std(kind[1:], ddof=1) for kind in kinds]
            found.append((float(first), float(errors[0]), float(total), float(errors[1])))
        return found

    def moments(self) -> tuple[tuple[float, float], tuple[float, float]]:
        """Mean and standard deviation of the measure, each with its standard error; the residuals belong to the deviation."""
        left = np.mean((self.values - self.matrix @ self.coefficients[:, 0]) ** 2)
        kinds = self.coefficients[0], np.sqrt(np.sum(self.coefficients[1:] ** 2, axis=0) + left)
        shifted = abs(float(np.mean(kinds[1][1:]) - kinds[1][0])) / HALF_WIDTH
        (mean, of_mean), (deviation, of_deviation) = ((float(kind[0]), float(np.std(kind[1:], ddof=1))) for kind in kinds)
        return (mean, of_mean), (deviation, of_deviation + shifted)

    def quantiles(self, probabilities: Sequence[float]) -> tuple[Array, Array]:
        """Quantiles of the surrogate, and standard errors: no quantile moves farther than all values do, see `BEYOND`."""
        points = cube(len(self.distributions), VALUES)
        inputs = np.column_stack([each.quantile(points[:, place]) for place, each in enumerate(self.distributions)])
        values = _terms(self.distributions, inputs, self.powers) @ self.coefficients[:, 0]
        best, of_parts = (np.quantile(some, probabilities, axis=-1) for some in (values, values.reshape(PARTS, -1)))
        of_number = np.max(np.abs(of_parts - best[:, None]), axis=-1)
        return best, (BEYOND * np.max(np.abs(self.alone)) + of_number) / HALF_WIDTH


def _terms(distributions: Sequence[Distribution], inputs: Array, powers: NDArray[np.int64]) -> Array:
    """The terms at some points, shape (points, terms)."""
    matrix = np.ones((len(inputs), len(powers)))
    for place, each in enumerate(distributions):
        matrix *= each.polynomials(inputs[:, place], int(powers.max()))[:, powers[:, place]]
    return matrix
