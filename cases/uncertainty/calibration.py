"""Finds parameters of a scene from a recorded table by least squares, and says how well the table determines them.

The residuals of a real table are no independent numbers: noise is coloured, and what the model lacks is smooth. So the covariance of the
estimate comes from the residuals' own spectra (the sandwich estimate with a smoothed spectrum: W. K. Newey, K. D. West, Econometrica
55, 1987, 703; here in the frequency domain and for all columns together). It is of what the residuals show. A mistake of the model that
another value of a parameter makes up for shows in no residual; the part of it that is the simulation's own error is estimated by finer
settings and told apart.
"""

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, fields
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray
from scipy import stats
from scipy.optimize import least_squares

from cases.case import Case
from cases.copies import LONGEST_NAME
from cases.copies import as_written as as_document
from cases.errors import CaseError, as_written
from cases.reading import case_of
from cases.recorded import RecordedTable
from cases.shown import Cell, Rows, Shown
from cases.uncertainty.parameters import Parameter, interval, overrides
from cases.uncertainty.table_model import TableModel
from engines.base import EngineFailure, NoSteadyState, Refusal
from engines.own.reference import ReferenceSettings
from engines.relative import rms
from reference_model.mechanism import Mechanism

Array = NDArray[np.float64]

#: Accuracy of the simulations that the result rests on. The way there, and the derivatives, take the engine's default.
ACCURACY: Final = 1e-4
#: Step of the differences, in a parameter's logarithm or in parts of its range: the integration's noise is a hundredth of what it shows.
DIFFERENCE: Final = 1e-3
#: How strongly a parameter is held where a fit begins, relative to one that changes the table by all of its size: what a stretch of the
#: table does not tell shall not run away. Each fit begins where the last one ended, so nothing of it is left in the end.
HOLD: Final = 1e-2
#: By how much a parameter without a range may change: its logarithm.
FARTHEST: Final = 3.0
#: A column is not weighted as if it were better known than this part of its size.
BEST_KNOWN: Final = 1e-4
#: A direction counts as not determined if its standard error reaches this part of the parameters or of their ranges ...
UNTOLD: Final = 0.1
#: ... or if such a change moves the table by less than this part, which is about the simulation's accuracy.
UNSEEN: Final = 2e-4
PROBABILITY: Final = 0.95
MOST_EVALUATIONS: Final = 30
FITS: Final = 2  # of the whole table: weighted by the columns' sizes, then by what was left of each
CORRECTIONS: Final = 2  # Gauss-Newton steps with the finer simulation and the derivatives of the usual one
ENOUGH: Final = 1e-4  # relative change of the squares at which a fit ends; the corrections do the rest
#: A smooth part of the squares left that is worth a word.
SMOOTH: Final = 0.3
FAILED: Final = 1e3  # residual in place of a simulation that broke down, relative to the table's size


@dataclass(frozen=True)
class Free:
    """A parameter to be found: in its logarithm from the case's value on, or between the ends of a range."""

    parameter: Parameter
    start: float
    ends: tuple[float, float] | None

    @classmethod
    def of_text(cls, text: str, case: Case, source: str) -> "Free":
        """From `KEY` or `KEY = A .. B`.

        Raises:
            CaseError: no such parameter, or one whose value gives no scale and that has no range.
        """
        key, sign, range_ = (part.strip() for part in text.partition("="))
        parameter = Parameter.of_key(key, source)
        start = parameter.of(case.mechanism)
        if sign:
            low, high = interval(range_, parameter, source)
            return cls(parameter, start if low < start < high else 0.5 * (low + high), (low, high))
        if not math.isfinite(start) or start == 0.0:
            accepted = f'give a range, such as "{key} = {parameter_example(parameter)}"'
            raise CaseError(source, key, f"{start:g} {parameter.quantity.unit}", "is no value to begin from", accepted)
        return cls(parameter, start, None)

    @property
    def first(self) -> float:
        """The coordinate of the start."""
        return 0.0 if self.ends is None else (self.start - self.ends[0]) / (self.ends[1] - self.ends[0])

    @property
    def bounds(self) -> tuple[float, float]:
        """Of the coordinate."""
        return (-FARTHEST, FARTHEST) if self.ends is None else (0.0, 1.0)

    def value(self, coordinate: float) -> float:
        """SI."""
        return self.start * math.exp(coordinate) if self.ends is None else self.ends[0] + coordinate * (self.ends[1] - self.ends[0])

    def slope(self, coordinate: float) -> float:
        """Change of the value by the coordinate."""
        return self.value(coordinate) if self.ends is None else self.ends[1] - self.ends[0]


def parameter_example(parameter: Parameter) -> str:
    """A range of a parameter as it is written."""
    return f"0 {parameter.quantity.unit} .. 1 {parameter.quantity.unit}"


@dataclass(frozen=True, kw_only=True)
class Found:
    """A parameter that was found, SI.

    Attributes:
        key: of the parameter.
        unit: SI.
        start: where the search began.
        value: the best one.
        low: lower end of the 95 % interval, by what the residuals show.
        high: upper end.
        simulation_error: by how much the simulation's own error may move the value; not part of the interval.
        determined: whether the table tells it at all.
        at_end: whether it lies at the end of its range.
    """

    key: str
    unit: str
    start: float
    value: float
    low: float
    high: float
    simulation_error: float
    determined: bool
    at_end: bool

    @property
    def shown(self) -> tuple[str, ...]:
        """A row for people."""
        interval_ = f"{self.low:.6g} .. {self.high:.6g}" if self.determined else "not determined by this table"
        end = " (at an end of its range)" if self.at_end else ""
        return self.key, f"{self.value:.6g}{end}", self.unit, interval_, f"{self.simulation_error:.1e}", f"{self.start:.6g}"


@dataclass(frozen=True, kw_only=True, repr=False)
class Fit(Shown):
    """What a table says of some parameters.

    Attributes:
        case: where the search began.
        table: name.
        begins: whether the simulation began in the standard start with the table; else the steady state was fitted.
        rows: of the table.
        found: the parameters.
        covariance: of the estimate, SI, as nested lists, (p, p).
        correlation: likewise.
        cannot_tell: directions that the table does not determine, as clauses.
        left: column -> RMS of what is left over RMS of the column.
        smooth: part of the squares left that is smooth from row to row: no measuring noise, but what the model or the sensors do.
        widened: how many times wider the intervals are than for independent residuals, geometric mean.
        simulations: how many were made.
    """

    case: Case
    table: str
    begins: bool
    rows: int
    found: tuple[Found, ...]
    covariance: tuple[tuple[float, ...], ...]
    correlation: tuple[tuple[float, ...], ...]
    cannot_tell: tuple[str, ...]
    left: dict[str, float]
    smooth: float
    widened: float
    simulations: int

    def holds(self, values: Sequence[float]) -> bool:
        """Whether values (SI, in the order of `found`) lie in the 95 % region of all parameters that are determined, together."""
        told = [place for place, each in enumerate(self.found) if each.determined]
        spread = np.array(self.covariance)[np.ix_(told, told)]
        sizes = np.sqrt(np.diag(spread))
        away = np.array([values[place] - self.found[place].value for place in told]) / sizes
        return bool(away @ np.linalg.solve(spread / np.outer(sizes, sizes), away) <= stats.chi2(len(told)).ppf(PROBABILITY))

    @property
    def fitted(self) -> Case:
        """The case with the values that were found."""
        values = {Parameter.of_key(each.key, self.case.name): each.value for each in self.found}
        return self.case.with_(overrides(self.case.mechanism, values), name=f"{self.case.name}-fitted"[-LONGEST_NAME:])

    def as_document(self) -> dict[str, Any]:
        """All of it as JSON has it."""
        return {**{each.name: getattr(self, each.name) for each in fields(self)}, "case": self.case.name, "found": [*map(vars, self.found)]}

    def _parts(self) -> Iterator[Cell]:
        of = "from the standard start" if self.begins else "of the steady state"
        yield f"{self.case.name} fitted to {self.table}: {self.rows} rows {of}, {self.simulations} simulations"
        yield Rows([each.shown for each in self.found], ("parameter", "value", "unit", "95 % interval", "simulation's error", "begun from"))
        if len(self.found) > 1:
            named = zip(self.found, self.correlation, strict=True)
            rows = [(each.key, *(f"{value:+.2f}" for value in line)) for each, line in named]
            yield Rows(rows, ("correlation", *(each.key for each in self.found)))
        yield from (f"this table cannot tell: {direction}" for direction in self.cannot_tell)
        yield f"left, RMS over the column's: {', '.join(f'{name} {100.0 * share:.2g} %' for name, share in self.left.items())}"
        if self.smooth > SMOOTH:
            yield (
                f"note: {100.0 * self.smooth:.0f} % of the squares left go on smoothly from row to row: the model lacks something,"
                " or the noise is coloured; the intervals allow for it only as far as no parameter makes up for it"
            )


def calibrate(case: Case, table: RecordedTable, free: Sequence[str], source: str = "--free") -> Fit:
    """Find the parameters with which `reference` comes closest to a table.

    Args:
        case: the scene to begin from.
        table: from the standard start, or of the steady state.
        free: keys, each alone or with a range: `"tip.center_of_mass = 0 in .. 0.5 in"`.
        source: named in what is wrong with `free`.

    Raises:
        CaseError: keys or table that cannot be.
        EngineFailure, Refusal: the case cannot be simulated where the search begins.
    """
    return _Search(case, TableModel(case, table), frees_of(free, case, source)).fit(table.name)


def frees_of(texts: Sequence[str], case: Case, source: str) -> list[Free]:
    """The parameters of some texts. CaseError: as of `Free.of_text`, or one is given twice, or none is."""
    found = [Free.of_text(text, case, source) for text in texts]
    keys = [each.parameter.key for each in found]
    if not found or len({*keys}) < len(keys):
        raise CaseError(source, None, None, f"{as_written(keys)} are no different parameters", "give each key once")
    return found


class _Search:
    """Fits stretch after stretch."""

    def __init__(self, case: Case, model: TableModel, frees: Sequence[Free]) -> None:
        self.case, self.model, self.frees, self.document = case, model, frees, as_document(case)
        self.simulations = 0
        engine, scene = model.engine, case.mechanism
        self.usual, self.fine = (engine.settings_for(accuracy, scene) for accuracy in (engine.default_accuracy, ACCURACY))

    def fit(self, table: str) -> Fit:
        model, at = self.model, np.array([each.first for each in self.frees])
        try:
            self._simulated(at, self.usual, model.rows)
        except NoSteadyState as reason:
            raise EngineFailure(0.0, f"no steady state was found where the search begins: {reason}", "begin from other values") from reason
        weights = 1.0 / model.sizes
        for rows in model.stretches(self.case.mechanism)[:-1]:
            at = self._fitted(at, self.usual, rows, weights)
        for _ in range(FITS):
            at = self._fitted(at, self.usual, model.rows, weights)
            left = model.values - self._simulated(at, self.usual, model.rows)
            weights = 1.0 / np.maximum([rms(column) for column in left], BEST_KNOWN * model.sizes)
        slopes = self._slopes(at, self.usual, model.rows)
        for _ in range(CORRECTIONS):
            left = model.values - self._simulated(at, self.fine, model.rows)
            at = np.clip(at + _best_step(slopes, left, weights), *np.transpose([each.bounds for each in self.frees]))
        left = model.values - self._simulated(at, self.fine, model.rows)
        return self._told(table, at, left, slopes, weights)

    def _scene(self, at: Array) -> Mechanism:
        values = {each.parameter: each.value(float(coordinate)) for each, coordinate in zip(self.frees, at, strict=True)}
        return case_of(self.document.overridden_by(overrides(self.case.mechanism, values))).mechanism

    def _simulated(self, at: Array, settings: ReferenceSettings, rows: int) -> Array:
        self.simulations += 1
        return self.model.simulated(self._scene(at), settings, rows)

    def _fitted(self, begin: Array, settings: ReferenceSettings, rows: int, weights: Array) -> Array:
        scaled = (weights / math.sqrt(rows * len(weights)))[:, None]
        table = self.model.values[:, :rows]
        hold = HOLD * float(np.mean(weights * self.model.sizes))

        def residual(at: Array) -> Array:
            try:
                apart = (self._simulated(at, settings, rows) - table) * scaled
            except (EngineFailure, Refusal, NoSteadyState, CaseError):
                apart = np.full(table.shape, FAILED * float(np.max(scaled * self.model.sizes[:, None])))
            return np.concatenate([apart.ravel(), hold * (at - begin)])

        def jacobian(at: Array) -> Array:
            slopes = self._slopes(at, settings, rows) * scaled[:, :, None]
            return np.vstack([slopes.reshape(-1, len(at)), hold * np.eye(len(at))])

        bounds = tuple(np.transpose([each.bounds for each in self.frees]))
        inside = np.clip(begin, bounds[0] + 1e-6, bounds[1] - 1e-6)
        return np.asarray(least_squares(residual, inside, jacobian, bounds, ftol=ENOUGH, xtol=None, gtol=None, max_nfev=MOST_EVALUATIONS).x)

    def _slopes(self, at: Array, settings: ReferenceSettings, rows: int) -> Array:
        """Derivatives of the columns by the coordinates, shape (C, rows, p), by central differences within the bounds."""
        columns = []
        for number, each in enumerate(self.frees):
            ends = np.clip(at[number] + np.array([-DIFFERENCE, DIFFERENCE]), *each.bounds)
            both = [self._simulated(np.where(np.arange(len(at)) == number, end, at), settings, rows) for end in ends]
            columns.append((both[1] - both[0]) / (ends[1] - ends[0]))
        return np.stack(columns, axis=-1)

    def _told(self, table: str, at: Array, left: Array, slopes: Array, weights: Array) -> Fit:
        model, rows = self.model, self.model.rows
        spread, alone = covariance(left * weights[:, None], slopes * weights[:, None, None])
        sensitivities = slopes / model.sizes[:, None, None]
        parts = np.sqrt(np.mean(sensitivities**2, axis=(0, 1)))  # relative change of the table by each coordinate
        directions = untold(sensitivities, spread)
        loose = {number for direction in directions for number in np.flatnonzero(np.abs(direction) > UNTOLD * np.max(np.abs(direction)))}
        finer = model.engine.comparisons(self.fine, self.case.mechanism, 0.0)[0]
        finer_settings = finer.other
        assert isinstance(finer_settings, ReferenceSettings)
        apart = (self._simulated(at, finer_settings, rows) - self._simulated(at, self.fine, rows)) / abs(1.0 - finer.factor)
        moved = np.abs(_best_step(slopes, apart, weights))
        sizes = np.sqrt(np.diag(spread))
        known = np.where(sizes > 0.0, sizes, 1.0)  # of a parameter without any effect all is zero
        per = np.array([each.slope(float(coordinate)) for each, coordinate in zip(self.frees, at, strict=True)])
        reach = stats.norm.ppf(0.5 + 0.5 * PROBABILITY) * sizes
        found = [
            Found(
                key=each.parameter.key,
                unit=each.parameter.quantity.unit,
                start=each.start,
                value=each.value(float(at[k])),
                low=min(ends := [each.value(float(np.clip(at[k] + sign * reach[k], -99.0, 99.0))) for sign in (-1.0, 1.0)]),
                high=max(ends),
                simulation_error=float(moved[k] * abs(per[k])),
                determined=k not in loose and bool(parts[k] > 0.0),
                at_end=bool(np.min(np.abs(at[k] - np.array(each.bounds))) < 1e-3),
            )
            for k, each in enumerate(self.frees)
        ]
        in_si = spread * np.outer(per, per)
        return Fit(
            case=self.case,
            table=table,
            begins=model.begins,
            rows=rows,
            found=tuple(found),
            covariance=tuple(map(tuple, in_si.tolist())),
            correlation=tuple(map(tuple, (spread / np.outer(known, known)).tolist())),
            cannot_tell=tuple(self._words(direction, at, sensitivities) for direction in directions),
            left={name: rms(column) / float(size) for name, column, size in zip(model.names, left, model.sizes, strict=True)},
            smooth=smooth_part(left * weights[:, None]),
            widened=float(np.exp(np.mean(np.log(known / np.sqrt(np.where(sizes > 0.0, np.diag(alone), 1.0)))))),
            simulations=self.simulations,
        )

    def _words(self, direction: Array, at: Array, sensitivities: Array) -> str:
        """A change of parameters, the largest by a tenth, that the table does not show."""
        step = UNTOLD * direction / np.max(np.abs(direction))
        parts = []
        for each, coordinate, part in zip(self.frees, at, step, strict=True):
            if abs(part) < 0.05 * UNTOLD:
                continue
            if each.ends is None:
                parts.append(f"{each.parameter.key} {100.0 * math.expm1(part):+.3g} %")
            else:
                parts.append(f"{each.parameter.key} {part * each.slope(float(coordinate)):+.3g} {each.parameter.quantity.unit}")
        shown = float(np.sqrt(np.mean((sensitivities @ step) ** 2)))
        return f"{' with '.join(parts)} (changes the columns by {100.0 * shown:.2g} % of their RMS)"


def _best_step(slopes: Array, left: Array, weights: Array) -> Array:
    """The change of the coordinates, shape (p,), that takes most of what is left, shape (C, N), with a change's effect (C, N, p)."""
    matrix = (slopes * weights[:, None, None]).reshape(-1, slopes.shape[2])
    return np.asarray(np.linalg.lstsq(matrix, (left * weights[:, None]).ravel(), rcond=UNSEEN)[0])


def covariance(residuals: Array, slopes: Array) -> tuple[Array, Array]:
    """Covariance of a least-squares estimate with residuals that depend on each other, and what independent ones would give.

    The residuals' spectra and cross-spectra are means over the square root of the number of frequencies, so that a correlation over up
    to so many rows counts.

    Args:
        residuals: weighted, shape (C, N).
        slopes: their derivatives by the parameters, shape (C, N, p).

    Returns:
        Both of shape (p, p).
    """
    channels, rows, count = slopes.shape
    matrix = slopes.reshape(-1, count)
    sizes = np.linalg.norm(matrix, axis=0)
    sizes[sizes == 0.0] = 1.0
    bread = np.linalg.pinv((matrix / sizes).T @ (matrix / sizes), rcond=1e-14, hermitian=True)
    spectra = np.fft.fft(residuals, 2 * rows, axis=1)
    of_slopes = np.fft.fft(slopes / sizes, 2 * rows, axis=1)
    width = 2 * math.isqrt(rows) + 1
    window = np.fft.fft(np.roll(np.pad(np.full(width, 1.0 / width), (0, 2 * rows - width)), -(width // 2)))
    filling = np.zeros((count, count), dtype=complex)
    for one in range(channels):
        for other in range(channels):
            smoothed = np.fft.ifft(np.fft.fft(spectra[one] * np.conj(spectra[other])) * window) / rows
            filling += np.einsum("fi,f,fj->ij", np.conj(of_slopes[one]), smoothed, of_slopes[other]) / (2 * rows)
    freedom = channels * rows / (channels * rows - count)
    scale = np.outer(sizes, sizes)
    independent = bread * float(np.mean(residuals**2)) * freedom / scale
    found = bread @ np.real(filling + filling.conj().T) @ bread * 0.5 * freedom / scale
    own = np.diag(found)  # which the scatter of the spectra shall not make narrower than for independent residuals
    wider = np.sqrt(np.maximum(1.0, np.diag(independent) / np.where(own > 0.0, own, math.inf)))
    return found * np.outer(wider, wider), independent


def smooth_part(residuals: Array) -> float:
    """Part of the squares of residuals, shape (C, N), that goes on smoothly from row to row: 0 of independent noise.

    Third differences of independent numbers of variance v have the variance 20 v; those of a smooth course are small.
    """
    noise = float(np.mean(np.diff(residuals, 3, axis=1) ** 2)) / 20.0
    return max(0.0, 1.0 - noise / float(np.mean(residuals**2)))


def untold(sensitivities: Array, spread: Array) -> list[Array]:
    """Unit vectors of coordinates that a table does not determine, shape (p,) each.

    Args:
        sensitivities: relative change of each column by each coordinate, shape (C, N, p).
        spread: covariance of the coordinates, shape (p, p).
    """
    matrix = sensitivities.reshape(-1, len(spread))
    _, values, vectors = np.linalg.svd(matrix / math.sqrt(len(matrix)), full_matrices=False)
    errors = np.sqrt(np.maximum(np.einsum("ki,ij,kj->k", vectors, spread, vectors), 0.0))
    return [vector for vector, value, error in zip(vectors, values, errors, strict=True) if UNTOLD * value < UNSEEN or error > UNTOLD]
