"""Finds parameters of a scene from a recorded table by least squares, and says how well the table determines them.

The intervals contain three errors. Noise shows in the residuals. The simulation's own error is estimated by finer settings. The table's
numbers have an error of their own, too. Most of it may look like the effect of a parameter, as an error of the frequency looks like another
stiffness, and then residuals hardly show it. So it is taken to be as large as `Search._table_error` says, with any course in time: more
rows do not average it. If another value of a parameter compensates for a mistake of the model, no interval contains this mistake.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np
from scipy import stats
from scipy.optimize import least_squares

from quickreturn import descriptions
from quickreturn.arguments import AnyCase, one_case
from quickreturn.cases.files.case import Case
from quickreturn.cases.files.errors import Argument, CaseError, as_written, texts_given
from quickreturn.cases.files.keys import si_text, unit_given
from quickreturn.cases.files.recorded import RecordedTable
from quickreturn.cases.running.job import Job, Limits
from quickreturn.engines.base import EngineFailure, NoSteadyState, Refusal
from quickreturn.engines.error_parts import comparison_by, counted
from quickreturn.engines.own.reference import ReferenceSettings
from quickreturn.engines.trajectory import rms
from quickreturn.plugins.studies.uncertainty.fit import (
    LOOSE,
    PROBABILITY,
    Fit,
    FittedParameter,
    best_step,
    covariance,
    reach,
    smooth_part,
    undetermined,
)
from quickreturn.plugins.studies.uncertainty.parameters import Parameter, changes, distribution
from quickreturn.plugins.studies.uncertainty.table_model import TableModel
from quickreturn.reference_model.arrays import Array
from quickreturn.table_comparison import AnyTable, as_table

FREE: Final = Argument("free")
#: Accuracy of the final simulations. The search and the derivatives use the engine's default.
ACCURACY: Final = 1e-4
#: Step of the differences, in a parameter's logarithm or in parts of its range: the integration's noise is a hundredth of their effect.
DIFFERENCE: Final = 1e-3
#: Strength of the prior that holds a parameter at the start of a fit if a stretch of the table does not determine it; 1: as strong as the
#: effect of a parameter that changes the table by all of its size. Each fit begins where the last one ended: it does not bias the result.
HOLD: Final = 1e-2
#: Largest change of the logarithm of a parameter without a range.
FARTHEST: Final = 3.0
#: Error of a table's column, as a part of its RMS, that residuals need not show. Measured with 80 tables that `mujoco` and `exudyn` make at
#: their default settings of machines near four of the thesis (`tests/uncertainty/test_calibration.py`): of the intervals for the 35 tables
#: with noise 60 of 60 contain the truth, and with 1.5e-3 57 of 65; of those for the 45 without noise 78 of 78 with 1.5e-3.
TABLE_ERROR: Final = 3e-3
#: RMS of the residuals of a column, as a part of its own, up to which model and table need not lack anything: the largest error that a main
#: engine claims at its default settings.
DEFAULT_ERROR: Final = 7e-3
#: Largest error of a column, as a multiple of the residuals' RMS. In these tables the part that looks like parameters is up to 3.3
#: (`reference`), 5.4 (`exudyn`) and 0.8 times (`mujoco`) as large as the residuals in 95 % of the fits.
HIDDEN: Final = 8.0
#: Smooth part of a column's squared residuals above which all of them count as an error of the table. Noise in which a row contains 0.8 of
#: the row before has 0.87, residuals of `mujoco` tables have at least 0.99.
ALL_SMOOTH: Final = 0.95
MOST_EVALUATIONS: Final = 30  # of the residuals in a fit
FITS: Final = 2  # number of fits to the whole table: weighted by the columns' sizes, then by their residuals
CORRECTIONS: Final = 2  # number of Gauss-Newton steps with the finer simulation and the derivatives of the usual one
ENOUGH: Final = 1e-4  # relative change of the sum of squares at which a fit ends; the corrections follow
FAILED: Final = 1e3  # residual in place of a failed simulation, as a multiple of the table's size


@dataclass(frozen=True)
class Free:
    """A parameter to fit. Its coordinate is the logarithm of its value over the start, or its place in a range from 0 to 1."""

    parameter: Parameter
    start: float  # SI
    ends: tuple[float, float] | None  # of the range, SI; None: there is no range
    unit: str  # in which the range is given; without one that of the case, see `Case.units`

    @classmethod
    def of_text(cls, text: str, case: Case) -> "Free":
        """The parameter of `KEY` or `KEY = A .. B`. CaseError: no such parameter, or one without a scale and without a range."""
        key, sign, range_ = (part.strip() for part in text.partition("="))
        parameter = Parameter.of_key(key, FREE)
        start = parameter.of(case.mechanism)
        if sign:
            given = distribution(f"uniform {range_}", parameter, FREE)
            low, high = given.first, given.second
            unit, _ = unit_given(parameter.path, range_.split(".."))
            return cls(parameter, start if low < start < high else 0.5 * (low + high), (low, high), unit)
        if not math.isfinite(start) or start == 0.0:
            ends = (si_text(parameter.path, end) for end in (0.1 if parameter.quantity.sign == "positive" else 0.0, 1.0))
            accepted = f'give a range, such as "{key} = {" .. ".join(ends)}"'
            raise CaseError(FREE, key, f"{start:g} {parameter.quantity.unit}", "is no value to begin from", accepted)
        return cls(parameter, start, None, case.units.of(parameter.quantity.unit).name)

    @property
    def first(self) -> float:
        """The coordinate of the start."""
        return 0.0 if self.ends is None else (self.start - self.ends[0]) / (self.ends[1] - self.ends[0])

    @property
    def bounds(self) -> tuple[float, float]:
        """Limits of the coordinate."""
        return (-FARTHEST, FARTHEST) if self.ends is None else (0.0, 1.0)

    def value(self, coordinate: float) -> float:
        """The value of the parameter at a coordinate, SI."""
        return self.start * math.exp(coordinate) if self.ends is None else self.ends[0] + coordinate * (self.ends[1] - self.ends[0])

    def slope(self, coordinate: float) -> float:
        """Derivative of the value by the coordinate, SI."""
        return self.value(coordinate) if self.ends is None else self.ends[1] - self.ends[0]


def calibrated(case: Case, table: RecordedTable, free: Sequence[str]) -> Fit:
    """The parameters with which `reference` is closest to a table from the standard start, or of the steady state.

    `free`: keys, each alone or with a range ("tip.center_of_mass = 0 in .. 0.5 in").

    Raises:
        CaseError: invalid keys or table.
        EngineFailure, Refusal: the case cannot be simulated where the search begins.
    """
    return Search(case, TableModel(case, table), frees_of(free, case)).fit(table.name)


def frees_of(texts: Sequence[str], case: Case) -> list[Free]:
    """The parameters of some texts. CaseError: as for `Free.of_text`; or one is given twice, or none."""
    frees = [Free.of_text(text, case) for text in texts]
    keys = [free.parameter.key for free in frees]
    if not frees or len({*keys}) < len(keys):
        raise CaseError(FREE, None, None, f"{as_written(keys)} are no different parameters", "give each key once")
    return frees


class Search:
    """Fits the coordinates `at` of the free parameters, shape (p,), to longer and longer stretches of a table.

    Weights, shape (C,), multiply the columns' residuals.
    """

    def __init__(self, case: Case, model: TableModel, frees: Sequence[Free]) -> None:
        self.case, self.model, self.frees = case, model, frees
        self.bounds = tuple(np.transpose([each.bounds for each in frees]))
        self.simulations = 0
        engine, scene = model.engine, case.mechanism
        self.usual, self.fine = (engine.settings_for(accuracy, scene) for accuracy in (engine.default_accuracy, ACCURACY))

    def fit(self, table: str) -> Fit:
        """The fit to the whole table, whose name is `table`. EngineFailure: it cannot be simulated where the search begins."""
        model, at = self.model, np.array([each.first for each in self.frees])
        try:
            self.simulated(at, self.usual, model.rows)
        except NoSteadyState as reason:
            raise EngineFailure(0.0, f"no steady state was found where the search begins: {reason}", "begin from other values") from reason
        weights = 1.0 / model.sizes
        for rows in model.stretches(self.case.mechanism)[:-1]:
            at = self.fitted(at, rows, weights)
        for _ in range(FITS):
            at = self.fitted(at, model.rows, weights)
            residuals = model.values - self.simulated(at, self.usual, model.rows)
            weights = 1.0 / np.maximum([rms(column) for column in residuals], TABLE_ERROR * model.sizes)
        slopes = self.slopes(at, model.rows)
        for _ in range(CORRECTIONS):
            residuals = model.values - self.simulated(at, self.fine, model.rows)
            at = np.clip(at + best_step(slopes, residuals, weights), *self.bounds)
        residuals = model.values - self.simulated(at, self.fine, model.rows)
        return self._fit_of(table, at, residuals, slopes, weights)

    def simulated(self, at: Array, settings: ReferenceSettings, rows: int) -> Array:
        """The columns in the first rows, see `TableModel.simulated`."""
        self.simulations += 1
        values = {each.parameter: each.value(float(coordinate)) for each, coordinate in zip(self.frees, at, strict=True)}
        scene = self.case.mechanism_with(changes(self.case.mechanism, values))
        return self.model.simulated(scene, settings, rows)

    def fitted(self, begin: Array, rows: int, weights: Array) -> Array:
        """The coordinates that are closest to the first rows."""
        scaled = (weights / math.sqrt(rows * len(weights)))[:, None]
        table = self.model.values[:, :rows]
        hold = HOLD * float(np.mean(weights * self.model.sizes))

        def residual(at: Array) -> Array:
            try:
                apart = (self.simulated(at, self.usual, rows) - table) * scaled
            except (EngineFailure, Refusal, NoSteadyState, CaseError):
                apart = np.full(table.shape, FAILED * float(np.max(scaled * self.model.sizes[:, None])))
            return np.concatenate([apart.ravel(), hold * (at - begin)])

        def jacobian(at: Array) -> Array:
            slopes = self.slopes(at, rows) * scaled[:, :, None]
            return np.vstack([slopes.reshape(-1, len(at)), hold * np.eye(len(at))])

        inside = np.clip(begin, self.bounds[0] + 1e-6, self.bounds[1] - 1e-6)
        solution = least_squares(residual, inside, jacobian, self.bounds, ftol=ENOUGH, xtol=None, gtol=None, max_nfev=MOST_EVALUATIONS)
        return np.asarray(solution.x)

    def slopes(self, at: Array, rows: int) -> Array:
        """Derivatives of the columns by the coordinates, shape (C, rows, p), by central differences within the bounds."""
        columns = []
        for number, each in enumerate(self.frees):
            ends = np.clip(at[number] + np.array([-DIFFERENCE, DIFFERENCE]), *each.bounds)
            both = [self.simulated(np.where(np.arange(len(at)) == number, end, at), self.usual, rows) for end in ends]
            columns.append((both[1] - both[0]) / (ends[1] - ends[0]))
        return np.stack(columns, axis=-1)

    def _fit_of(self, table: str, at: Array, residuals: Array, slopes: Array, weights: Array) -> Fit:
        model = self.model
        weighted, effects, error = residuals * weights[:, None], slopes * weights[:, None, None], self._error(at)
        noise, independent = covariance(weighted, effects)
        moved = best_step(slopes, error, weights)
        of_table = reach(effects, weights * self._table_error(residuals))
        normal = float(stats.norm.ppf(0.5 + 0.5 * PROBABILITY))
        spread = noise + (of_table + np.outer(moved, moved)) / normal**2  # the ends of these two count as ends of the interval
        sensitivities = slopes / model.sizes[:, None, None]
        directions = undetermined(sensitivities, spread)
        loose = {number for direction in directions for number in np.flatnonzero(np.abs(direction) > LOOSE * np.max(np.abs(direction)))}
        sizes = np.sqrt(np.diag(spread))
        divisors = np.where(sizes > 0.0, sizes, 1.0)  # the covariance of a parameter without any effect is zero
        per = np.array([each.slope(float(coordinate)) for each, coordinate in zip(self.frees, at, strict=True)])
        half, alone, alike = normal * sizes, np.diag(noise), np.diag(independent)
        fitted = []
        for k, each in enumerate(self.frees):
            ends = [each.value(float(np.clip(at[k] + sign * half[k], -99.0, 99.0))) for sign in (-1.0, 1.0)]
            fitted.append(
                FittedParameter(
                    key=each.parameter.key,
                    unit=each.parameter.quantity.unit,
                    given_in=each.unit,
                    start=each.start,
                    value=each.value(float(at[k])),
                    low=min(ends),
                    high=max(ends),
                    simulation_error=float(abs(moved[k] * per[k])),
                    table_error=float(math.sqrt(of_table[k, k]) * abs(per[k])),
                    determined=k not in loose and bool(np.any(sensitivities[:, :, k])),
                    at_end=bool(np.min(np.abs(at[k] - np.array(each.bounds))) < 1e-3),
                )
            )
        return Fit(
            case=self.case,
            table=table,
            begins=model.begins,
            rows=model.rows,
            found=tuple(fitted),
            covariance=tuple(map(tuple, (spread * np.outer(per, per)).tolist())),
            correlation=tuple(map(tuple, (spread / np.outer(divisors, divisors)).tolist())),
            cannot_tell=tuple(self._words(direction, per, sensitivities) for direction in directions),
            left={name: rms(column) / float(size) for name, column, size in zip(model.names, residuals, model.sizes, strict=True)},
            claimed={
                name: DEFAULT_ERROR + rms(column) / float(size) for name, column, size in zip(model.names, error, model.sizes, strict=True)
            },
            smooth=smooth_part(weighted),
            widened=float(np.exp(0.5 * np.mean(np.log(np.divide(alone, alike, out=np.ones_like(alone), where=alike > 0.0))))),
            simulations=self.simulations,
        )

    def _table_error(self, residuals: Array) -> Array:
        """RMS of each column's own error in the table, shape (C,), by the residuals (C, N).

        It is `TABLE_ERROR` of the column, but at most `HIDDEN` times the residuals, and at least the residuals if they are no noise.
        """
        left = np.array([rms(column) for column in residuals])
        smooth = np.array([smooth_part(column[None]) > ALL_SMOOTH for column in residuals])
        return np.maximum(np.minimum(TABLE_ERROR * self.model.sizes, HIDDEN * left), left * smooth)

    def _error(self, at: Array) -> Array:
        """Error of the finer simulation, shape (C, N), by a still finer one."""
        pair = comparison_by(self.model.engine.comparisons(self.fine, self.case.mechanism, 0.0), "modes")
        assert isinstance(pair.other, ReferenceSettings)
        finer, fine = (self.simulated(at, settings, self.model.rows) for settings in (pair.other, self.fine))
        return counted(pair.factor) * (finer - fine)

    def _words(self, direction: Array, per: Array, sensitivities: Array) -> str:
        """A change of parameters that the table does not show, in words; the largest part of it is a tenth."""
        step = LOOSE * direction / np.max(np.abs(direction))
        parts = []
        for each, part, slope in zip(self.frees, step, per, strict=True):
            _, size = unit_given(each.parameter.path, [f"1 {each.unit}"])
            change = f"{100.0 * math.expm1(part):+.3g} %" if each.ends is None else f"{part * slope / size:+.3g} {each.unit}"
            parts += [f"{each.parameter.key} {change}"] if abs(part) >= 0.05 * LOOSE else []
        shown = float(np.sqrt(np.mean((sensitivities @ step) ** 2)))
        return f"{' with '.join(parts)} (changes the columns by {100.0 * shown:.2g} % of their RMS)"


def calibrate(case: AnyCase, table: AnyTable, free: str | Sequence[str], *, limits: "Limits | None" = None, quiet: bool = False) -> Fit:
    """Find the parameters with which `reference` is closest to a recorded table, and how well the table determines them.

    Args:
        case: a name, a path or a `Case`, for all other values and for the first values of the search.
        table: a path, a DataFrame or a dictionary of arrays with units in the headings, or what `simulate` or `read_table` returns;
            it begins in the standard start or shows the steady state.
        free: keys of a case file, each alone, or with a range in which it lies: "tip.center_of_mass = 0 in .. 0.5 in".
        limits: time and memory limits of the process that computes; None: the default ones.
        quiet: whether progress on standard error is left out.

    Raises:
        CaseError: an invalid case, table or key.
        EngineFailure, Refusal: the case cannot be simulated where the search begins.
    """
    chosen, recorded, keys = one_case(case), as_table(table), texts_given(free, "free", "tip.mass")
    frees_of(keys, chosen)
    TableModel(chosen, recorded)
    job = Job("calibration", calibrated, (chosen, recorded, keys))
    return descriptions.value_of(descriptions.outcomes([job], "calibration", limits, quiet)[0])
