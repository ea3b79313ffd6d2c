"""The scatter of measures of the settled motion due to that of parameters: quantiles, and the share of each parameter.

The points are quasi-random (Sobol', scrambled: A. B. Owen, Journal of Complexity 14, 1998, 466). The error of a number from a finite number
of points is found by resampling the points (bootstrap). The simulation's error at a point is given separately.
"""

import math
from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import combinations_with_replacement
from typing import Any, ClassVar, Final

import numpy as np
from numpy.typing import NDArray
from scipy import stats

from quickreturn.cases.case import Case
from quickreturn.cases.displayed import Cell, Displayed, Rows
from quickreturn.cases.errors import CaseError
from quickreturn.cases.jobs.job import Job
from quickreturn.cases.jobs.workshop import Workshop
from quickreturn.cases.measures.catalogue import measure
from quickreturn.cases.runs.endings import Ending
from quickreturn.cases.sweep.grid import job
from quickreturn.cases.sweep.rows import MeasureRequest, Row
from quickreturn.cases.sweep.study import computed, joined
from quickreturn.cases.uncertainty.parameters import Distribution, Parameter, changes, distribution
from quickreturn.cases.units import shown_unit
from quickreturn.reference_model.witnesses import Witness, Witnesses

Array = NDArray[np.float64]

#: Number of points that are computed one after the other; each begins its search in the motion of the one before.
ROW: Final = 16
#: Least and largest number of points; a power of two keeps a Sobol' sequence balanced.
FEWEST: Final = 8
MOST: Final = 65536
SEED: Final = 1  # of the random numbers
DRAWN: Final = 200  # number of resamplings
PROBABILITIES: Final = (0.025, 0.5, 0.975)  # of the quantiles
HIGHEST_DEGREE: Final = 4  # of a surrogate
#: Least number of points for each coefficient of a surrogate.
PER_TERM: Final = 2.0
#: A surrogate that explains less than this part of the variance, cross-validated, gives no indices.
GOOD: Final = 0.8


@dataclass(frozen=True)
class Quantile:
    """A quantile of a measure, SI; `error`: standard error from the finite number of points."""

    probability: float
    value: float
    error: float

    witnesses: ClassVar[Witnesses] = dict.fromkeys(
        ("value", "error"),
        Witness(
            "the closed form of uniform numbers",
            0.15,
            "tests/cases/uncertainty/test_propagation.py::test_the_error_of_a_quantile_is_what_other_samples_show",
        ),
    )


@dataclass(frozen=True)
class Share:
    """Share of a parameter in a measure's variance: alone, and in total with its interactions; ± 95 %."""

    key: str
    first: float
    first_error: float
    total: float
    total_error: float

    witnesses: ClassVar[Witnesses] = dict.fromkeys(
        ("first", "first_error", "total", "total_error"),
        Witness(
            "the closed form of a polynomial",
            1e-9,
            "tests/cases/uncertainty/test_propagation.py::test_the_shares_of_a_polynomial_are_those_of_its_closed_form",
        ),
    )


@dataclass(frozen=True, eq=False, repr=False)
class Scatter(Displayed):
    """The measured points.

    Attributes:
        case: the case with all other values.
        distributions: of the parameters.
        measures: names of the measures.
        inputs: values of the parameters, SI, shape (n, p).
        values: of the measures, SI, nan where unavailable, shape (n, measures).
        errors: errors of the values by the simulation's own estimate, likewise; nan without one.
        statuses: status of each point.
    """

    case: Case
    distributions: Mapping[Parameter, Distribution]
    measures: tuple[str, ...]
    inputs: Array
    values: Array
    errors: Array
    statuses: tuple[str, ...]

    @property
    def counts(self) -> dict[str, int]:
        """Status -> points; those that did not settle are missing from all numbers, and not at random."""
        return dict(Counter(self.statuses).most_common())

    def of(self, measure: str) -> tuple[NDArray[np.bool_], Array]:
        """Mask of the points with a measure, shape (n,), and its values there."""
        column = self.values[:, self.measures.index(measure)]
        settled = np.isfinite(column) & (np.array(self.statuses) == Ending.SETTLED)
        return settled, column[settled]

    def quantiles(self, measure: str, probabilities: Sequence[float] = PROBABILITIES) -> list[Quantile]:
        """Quantiles of a measure; none where no point has it."""
        _, values = self.of(measure)
        return quantiles(values, probabilities)

    def simulation_error(self, measure: str) -> float:
        """Median over the points of a measure's error by the simulation's own estimate, SI; nan without one."""
        settled, _ = self.of(measure)
        errors = self.errors[settled, self.measures.index(measure)]
        return float(np.nanmedian(errors)) if np.any(np.isfinite(errors)) else math.nan

    def surrogate(self, measure: str) -> "Surrogate":
        """The polynomial in all parameters that predicts a measure best, by its cross-validated error."""
        settled, values = self.of(measure)
        return Surrogate.best(list(self.distributions.values()), self.inputs[settled], values)

    def shares(self, measure: str) -> list[Share]:
        """Sobol' indices of a measure, the largest first; none if the surrogate is worse than `GOOD`."""
        surrogate = self.surrogate(measure)
        if not surrogate.q2 >= GOOD:
            return []
        keys = [parameter.key for parameter in self.distributions]
        return sorted((Share(key, *numbers) for key, numbers in zip(keys, surrogate.shares(), strict=True)), key=lambda share: -share.total)

    def _parts(self) -> Iterator[Cell]:
        """Counts; quantiles with their error from the number of points, and the simulation's own error; shares of the variance."""
        counts = ", ".join(f"{count} {status}" for status, count in self.counts.items())
        yield f"{self.case.name}: {len(self.statuses)} points in {len(self.distributions)} parameters: {counts}"
        rows = []
        for name in self.measures:
            unit, size = shown_unit(measure(name).unit)
            texts = [f"{each.value / size:.5g} ± {each.error / size:.1g}" for each in self.quantiles(name)]
            rows.append((name, unit, *(texts or ["-"] * len(PROBABILITIES)), f"{self.simulation_error(name) / size:.1g}"))
        heads = [f"{100.0 * each:g} %" for each in PROBABILITIES]
        yield Rows(rows, ("measure", "unit", *heads, "simulation's error"))
        for name in self.measures:
            shares = [f"{each.key} {each.first:.2f} ± {each.first_error:.2f} (in all {each.total:.2f})" for each in self.shares(name)]
            q2 = self.surrogate(name).q2
            told = ", ".join(shares) or "no surrogate is good enough, or there are too few points"
            yield f"variance of {name}: {told}; Q2 {q2:.3f}"


@dataclass(frozen=True, eq=False)
class Points:
    """Quasi-random points to compute."""

    case: Case
    distributions: Mapping[Parameter, Distribution]
    asked: MeasureRequest
    inputs: Array

    @cached_property
    def jobs(self) -> list[Job[Row]]:
        """A job for each `ROW` points."""
        scene = self.case.mechanism
        points = [changes(scene, dict(zip(self.distributions, point, strict=True))) for point in self.inputs]
        return [job(self.case, points[first : first + ROW], self.asked) for first in range(0, len(points), ROW)]

    def scatter(self, workshop: Workshop) -> Scatter:
        """Compute the points that are not stored. KeyboardInterrupt: Ctrl-C; finished points are stored."""
        names, row = self.asked.measures, joined(computed(self.jobs, workshop))
        return Scatter(self.case, self.distributions, names, self.inputs, row.values, row.errors, row.statuses)


def planned(case: Case, uncertain: Mapping[str, Any], asked: MeasureRequest, samples: int, source: str) -> Points:
    """Quasi-random points, `samples` of them (a power of two), of distributions as texts by key (`uncertain`).

    CaseError, which names `source`: an unknown key or measure, an invalid distribution or number of points.
    """
    if not uncertain:
        raise CaseError(source, "uncertain", None, "names no parameter", 'write KEY = "uniform A .. B"')
    if samples & (samples - 1) or not FEWEST <= samples <= MOST:
        raise CaseError(source, "samples", str(samples), "is no power of two", f"from {FEWEST} to {MOST} are accepted, such as 256")
    for name in asked.measures:
        measure(name)
    given = {Parameter.of_key(key, source): text for key, text in uncertain.items()}
    distributions = {parameter: distribution(text, parameter, source) for parameter, text in given.items()}
    cube = stats.qmc.Sobol(len(distributions), rng=np.random.default_rng(SEED)).random(samples)
    inputs = np.column_stack([each.quantile(cube[:, place]) for place, each in enumerate(distributions.values())])
    return Points(case, distributions, asked, inputs)


def quantiles(values: Array, probabilities: Sequence[float] = PROBABILITIES) -> list[Quantile]:
    """Quantiles of values, shape (n,), with standard errors by bootstrap; none of no values."""
    if not len(values):
        return []
    drawn = np.random.default_rng(SEED).integers(len(values), size=(DRAWN, len(values)))
    errors = np.std(np.quantile(values[drawn], probabilities, axis=1), axis=1, ddof=1)
    best = np.quantile(values, probabilities)
    return [Quantile(*numbers) for numbers in zip(probabilities, best.tolist(), errors.tolist(), strict=True)]


def powers_up_to(degree: int, count: int) -> NDArray[np.int64]:
    """The powers of all monomials in `count` variables up to a total degree, shape (binomial(degree + count, count), count)."""
    chosen = (each for total in range(degree + 1) for each in combinations_with_replacement(range(count), total))
    return np.array([np.bincount(np.array(each, dtype=np.int64), minlength=count) for each in chosen])


@dataclass(frozen=True, eq=False)
class Surrogate:
    """A polynomial chaos: orthonormal polynomials of the parameters, fitted by least squares."""

    degree: int  # largest total degree
    powers: NDArray[np.int64]  # degree of each term in each parameter, shape (terms, p)
    matrix: Array  # terms at the points, shape (n, terms)
    values: Array  # at the points, shape (n,)
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
            return cls(degree, np.zeros((1, count), dtype=np.int64), np.ones((len(values), 1)), values, math.nan)
        powers = powers_up_to(degree, count)
        matrix = np.ones((len(values), len(powers)))
        for place, each in enumerate(distributions):
            matrix *= each.polynomials(inputs[:, place], degree)[:, powers[:, place]]
        leverage = np.sum(np.linalg.qr(matrix)[0] ** 2, axis=1)
        left = values - matrix @ np.linalg.lstsq(matrix, values, rcond=None)[0]
        alone = left / np.maximum(1.0 - leverage, 1e-9)  # error at each point of the fit to all others
        return cls(degree, powers, matrix, values, 1.0 - float(np.mean(alone**2) / np.var(values)))

    def shares(self) -> list[tuple[float, float, float, float]]:
        """First-order and total Sobol' index of each parameter, each followed by its 95 % half width (bootstrap)."""
        generator = np.random.default_rng(SEED)
        indices = self._indices(np.arange(len(self.values)))
        drawn = [self._indices(generator.integers(len(self.values), size=len(self.values))) for _ in range(DRAWN)]
        errors = stats.norm.ppf(0.975) * np.std(drawn, axis=0, ddof=1)
        return [(*indices[k, :1], *errors[k, :1], *indices[k, 1:], *errors[k, 1:]) for k in range(len(indices))]

    def _indices(self, points: NDArray[np.int64]) -> Array:
        """First-order and total indices by a fit to some of the points, shape (p, 2)."""
        squares = np.linalg.lstsq(self.matrix[points], self.values[points], rcond=None)[0] ** 2
        squares[np.sum(self.powers, axis=1) == 0] = 0.0
        parts = squares / np.sum(squares)
        alone = [parts[(self.powers[:, k] > 0) & (np.sum(self.powers > 0, axis=1) == 1)].sum() for k in range(self.powers.shape[1])]
        total = [parts[self.powers[:, k] > 0].sum() for k in range(self.powers.shape[1])]
        return np.column_stack([alone, total])
