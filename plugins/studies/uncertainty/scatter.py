"""The scatter of measures of the settled motion due to that of parameters: mean, quantiles, band, and the share of each parameter.

Each number has two errors, which are kept
apart: that from the finite number of points, by the surrogate's errors (`uncertainty.chaos`) or, without a good surrogate, by
resampling the points (bootstrap); and the largest change by the simulation's own errors at the points.
"""

import math
from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, Any, Final

import numpy as np
from numpy.typing import NDArray

from quickreturn.cases.files.case import Case
from quickreturn.cases.files.shown import Cell, Printable, Rows
from quickreturn.cases.motion.catalogue import measure
from quickreturn.cases.motion.endings import Ending
from quickreturn.plugins.studies.uncertainty.chaos import DRAWN, HALF_WIDTH, SEED, Surrogate
from quickreturn.plugins.studies.uncertainty.parameters import Distribution, Parameter
from quickreturn.reference_model.arrays import Array

if TYPE_CHECKING:
    import pandas as pd

PROBABILITIES: Final = (0.05, 0.5, 0.95)  # of the quantiles
#: Largest part of the points that may lack a measure which has a band: they do not lack it at random, and might all lie beyond a quantile.
LACKING: Final = PROBABILITIES[0]
#: Least number of points beyond a quantile that is read off the points alone. Of two functions without a good surrogate (a narrow peak, a
#: fast wave; 60 studies of 32 to 256 points each) at least 90 % of the intervals of the outer quantiles contain them.
BEYOND: Final = 1.6
ENOUGH: Final = 32  # number of points with so many beyond the outer quantiles
#: Range of a measure over its size up to which it counts as constant, as it does within the simulation's errors: no tail lies far out then.
FLAT: Final = 1e-9


@dataclass(frozen=True, kw_only=True)
class Estimate:
    """A number of a measure's distribution, SI."""

    value: float  # the number
    error: float  # standard error from the finite number of points; infinite if these are too few to tell
    simulation: float = math.nan  # largest change by the simulation's own errors at the points; nan where these are unknown

    @property
    def half_width(self) -> float:
        """Of the 95 % interval from the finite number of points."""
        return HALF_WIDTH * self.error

    @property
    def whole(self) -> float:
        """Both errors together; the simulation's counts as nothing where it is unknown."""
        return self.half_width + (0.0 if math.isnan(self.simulation) else self.simulation)


@dataclass(frozen=True, kw_only=True)
class Quantile(Estimate):
    """A quantile of a measure."""

    probability: float


@dataclass(frozen=True)
class Share:
    """Share of a parameter in a measure's variance: alone, and in total with its interactions; ± 95 %."""

    key: str
    first: float
    first_error: float
    total: float
    total_error: float


@dataclass(frozen=True, eq=False, repr=False)
class Scatter(Printable):
    """The measured points.

    Attributes:
        case: the case with all other values.
        distributions: of the parameters.
        measures: names of the measures.
        inputs: values of the parameters, SI, shape (n, p).
        values: of the measures, SI, nan where unavailable, shape (n, measures).
        errors: errors of the values by the simulation's own estimate, likewise; nan without one.
        statuses: status of each point.
        sentences: reason of each status, "" if the point settled.
        engine: name of the engine.
    """

    case: Case
    distributions: Mapping[Parameter, Distribution]
    measures: tuple[str, ...]
    inputs: Array
    values: Array
    errors: Array
    statuses: tuple[str, ...]
    sentences: tuple[str, ...] = ()
    engine: str = "reference"

    @property
    def counts(self) -> dict[str, int]:
        """Status -> points; those that did not settle are missing from all numbers, and not at random."""
        return dict(Counter(self.statuses).most_common())

    @property
    def failures(self) -> list[str]:
        """For each status but `settled` a clause: how many points have it, where the first of them is, and why."""
        found = []
        for status, count in self.counts.items():
            if status != Ending.SETTLED:
                at = self.statuses.index(status)
                values = zip(self.distributions, self.inputs[at].tolist(), strict=True)
                place = ", ".join(f"{key.key} = {self.case.units.of(key.quantity.unit).text(value)}" for key, value in values)
                found.append(f"{count} {status}, such as at {place}" + (f": {self.sentences[at]}" if any(self.sentences) else ""))
        return found

    def of(self, measure: str) -> tuple[NDArray[np.bool_], Array]:
        """Mask of the points with a measure, shape (n,), and its values there."""
        column = self.values[:, self.measures.index(measure)]
        settled = np.isfinite(column) & (np.array(self.statuses) == Ending.SETTLED)
        return settled, column[settled]

    def lacking(self, measure: str) -> str:
        """Why the points give no band of a measure (a clause); "" if they do."""
        settled, total = self.counts.get(Ending.SETTLED, 0), len(self.statuses)
        known = len(self.of(measure)[1])
        if total - known <= LACKING * total:
            unknown = any(math.isinf(each.error) for each in self.quantiles(measure))
            return f"no surrogate is good enough, and {total} points are too few without one; try {ENOUGH}" if unknown else ""
        if known < settled:
            return f"{known} of {total} points have the measure, {settled} settled"
        return f"{settled} of {total} points settled"

    def mean(self, measure: str) -> Estimate:
        """Mean of a measure over its points."""
        return self._moments(measure)[0]

    def deviation(self, measure: str) -> Estimate:
        """Standard deviation of a measure."""
        return self._moments(measure)[1]

    def _claims(self, measure: str) -> Array:
        """The simulation's errors at the points with a measure, unknown ones as the largest; nan without any, shape (n,)."""
        claims = self.errors[self.of(measure)[0], self.measures.index(measure)]
        return np.where(
            np.isnan(claims), np.max(claims[np.isfinite(claims)], initial=-math.inf) if np.any(np.isfinite(claims)) else math.nan, claims
        )

    def _moments(self, measure: str) -> tuple[Estimate, Estimate]:
        surrogate, claims, (_, values) = self.surrogate(measure), self._claims(measure), self.of(measure)
        if surrogate.good:
            mean, deviation = surrogate.moments()
        else:
            mean, deviation = (_bootstrapped(values, kind) for kind in (np.mean, np.std))
        size = math.sqrt(float(np.mean(claims**2)))
        return Estimate(value=mean[0], error=mean[1], simulation=float(np.mean(claims))), Estimate(
            value=deviation[0], error=deviation[1], simulation=size
        )

    def quantiles(self, measure: str, probabilities: Sequence[float] = PROBABILITIES) -> list[Quantile]:
        """Quantiles of a measure, off the points or a good surrogate, whichever is surer; none if more points lack it than `LACKING`."""
        settled, values = self.of(measure)
        if len(values) < (1.0 - LACKING) * len(settled):
            return []
        claims, surrogate = self._claims(measure), self.surrogate(measure)
        at = surrogate.quantiles(probabilities) if surrogate.good else (values, np.full(len(probabilities), math.inf))
        spread = float(np.ptp(values))
        unknown = spread if spread <= max(FLAT * float(np.max(np.abs(values))), float(np.max(claims))) else math.inf
        found = []
        for place, plain in enumerate(quantiles(values, probabilities)):
            far = [abs(float(np.quantile(values + sign * claims, plain.probability)) - plain.value) for sign in (-1.0, 1.0)]
            outside = len(values) * min(plain.probability, 1.0 - plain.probability)
            best = min((plain.error if outside >= BEYOND else unknown, plain.value), (float(at[1][place]), float(at[0][place])))
            found.append(Quantile(probability=plain.probability, value=best[1], error=best[0], simulation=max(far)))
        return found

    def band(self, measure: str) -> tuple[float, float]:
        """Values between which nine of ten machines lie, SI: the outer quantiles, moved outwards by both errors."""
        first, *_, last = self.quantiles(measure)
        return first.value - first.whole, last.value + last.whole

    def surrogate(self, measure: str) -> Surrogate:
        """The polynomial in all parameters that predicts a measure best, by its cross-validated error."""
        if measure not in self._surrogates:
            settled, values = self.of(measure)
            self._surrogates[measure] = Surrogate.best(list(self.distributions.values()), self.inputs[settled], values)
        return self._surrogates[measure]

    @cached_property
    def _surrogates(self) -> dict[str, Surrogate]:
        return {}

    def shares(self, measure: str) -> list[Share]:
        """Sobol' indices of a measure, the largest first; none if the surrogate is not good enough."""
        surrogate = self.surrogate(measure)
        if not surrogate.good:
            return []
        keys = [parameter.key for parameter in self.distributions]
        return sorted((Share(key, *numbers) for key, numbers in zip(keys, surrogate.shares(), strict=True)), key=lambda share: -share.total)

    @property
    def frame(self) -> "pd.DataFrame":
        """A row for each point, SI: parameters, measures, their errors under the names with ".error", status and reason."""
        import pandas as pd

        columns: dict[str, Any] = {key.key: self.inputs[:, place] for place, key in enumerate(self.distributions)}
        units = {key.key: key.quantity.unit for key in self.distributions}
        for place, name in enumerate(self.measures):
            columns |= {name: self.values[:, place], f"{name}.error": self.errors[:, place]}
            units |= dict.fromkeys((name, f"{name}.error"), measure(name).unit)
        table = pd.DataFrame({**columns, "status": self.statuses, "sentence": self.sentences})
        table.attrs["units"] = units
        return table

    def document(self) -> dict[str, Any]:
        """The JSON document: parameters, counts, and for each measure its numbers with both errors, SI."""
        measures = []
        for name in self.measures:
            lacking, told = self.lacking(name), {"measure": name, "unit": measure(name).unit, "points": len(self.of(name)[1])}
            numbers: dict[str, Any] = {"no_band": lacking or None}
            if not lacking:
                numbers |= {kind: _plain(getattr(self, kind)(name)) for kind in ("mean", "deviation")}
                numbers["quantiles"] = [{"probability": each.probability, **_plain(each)} for each in self.quantiles(name)]
                numbers |= {"band": self.band(name), "shares": self.shares(name), "q2": self.surrogate(name).q2}
            measures.append(told | numbers)
        given = {parameter.key: each.told for parameter, each in self.distributions.items()}
        about = {"case": self.case.name, "engine": self.engine, "uncertain": given, "points": len(self.statuses)}
        return {**about, "statuses": self.counts, "failures": self.failures, "measures": measures}

    def _parts(self) -> Iterator[Cell]:
        """Counts, distributions and failures; numbers with both errors; bands; shares of the variance."""
        counts = ", ".join(f"{count} {status}" for status, count in self.counts.items())
        yield f"{self.case.name} by {self.engine}: {len(self.statuses)} points in {len(self.distributions)} parameters: {counts}"
        yield Rows([(f"  {parameter.key}", each.told) for parameter, each in self.distributions.items()])
        yield from (f"  {clause}" for clause in self.failures)
        told = [name for name in self.measures if not self.lacking(name)]
        yield from (f"{name}: no band: {self.lacking(name)}" for name in self.measures if name not in told)
        if not told:
            return
        rows, bands, shares = list[Sequence[Cell]](), list[str](), list[Sequence[Cell]]()
        for name in told:
            unit, size = (shown := self.case.units.of(measure(name).unit)).name, shown.size
            found = [self.mean(name), self.deviation(name), *self.quantiles(name)]
            rows += [
                (name, unit, *(f"{each.value / size:.5g}" for each in found)),
                ("", "± points, 95 %", *(_one_digit(each.half_width / size) for each in found)),
                ("", "± simulation", *(_one_digit(each.simulation / size) for each in found)),
            ]
            low, high = self.band(name)
            bands.append(
                f"{name}: nine of ten machines lie between {low / size:.5g} and {high / size:.5g} {unit}".removesuffix(" 1")
                + ", both errors included"
            )
            alone = [
                (f"{each.first:.2f} ± {each.first_error:.2f}", f"{each.total:.2f} ± {each.total_error:.2f}") for each in self.shares(name)
            ]
            shares += [(name, each.key, *texts) for each, texts in zip(self.shares(name), alone, strict=True)]
            if not alone:
                bands.append(f"{name}: no shares of the variance, for no surrogate is good enough (Q2 {self.surrogate(name).q2:.2f})")
        yield Rows(rows, ("measure", "unit", "mean", "scatter", *(f"{100.0 * each:g} %" for each in PROBABILITIES)))
        yield from bands
        if shares:
            yield Rows(shares, ("share of variance", "of", "alone", "in all"))


def _plain(number: Estimate) -> dict[str, float]:
    """A number for JSON, with the half width of its 95 % interval from the points, and its error from the simulation."""
    return {"value": number.value, "sampling_error": number.half_width, "simulation_error": number.simulation}


def _one_digit(error: float) -> str:
    """An error with one digit, large ones without an exponent; "-" for an unknown one."""
    return "-" if math.isnan(error) else f"{float(f'{error:.1g}'):.6g}"


def _bootstrapped(values: Array, kind: Any, *more: Any) -> tuple[Any, Any]:
    """A number of values, shape (n,), and its standard error: `kind(values, *more, axis=-1)`, or several at once, shape (m,)."""
    drawn = np.random.default_rng(SEED).integers(len(values), size=(DRAWN, len(values)))
    return kind(values, *more, axis=-1), np.std(kind(values[drawn], *more, axis=-1), axis=-1, ddof=1)


def quantiles(values: Array, probabilities: Sequence[float] = PROBABILITIES) -> list[Quantile]:
    """Quantiles of values, shape (n,), with standard errors by bootstrap; none of no values."""
    if not len(values):
        return []
    best, errors = _bootstrapped(values, np.quantile, probabilities)
    numbers = zip(probabilities, best.tolist(), errors.tolist(), strict=True)
    return [Quantile(probability=probability, value=value, error=error) for probability, value, error in numbers]
