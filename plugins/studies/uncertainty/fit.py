"""Parameters of a scene, fitted to a recorded table, and the covariance of a least-squares fit with correlated residuals.

The residuals of a real table are not independent: noise is coloured, and errors of the model are smooth. So the covariance comes
from the residuals' own spectra (the sandwich estimate: W. K. Newey, K. D. West, Econometrica 55, 1987, 703; here in the frequency domain
and for all columns together).
"""

import math
from collections.abc import Iterator
from dataclasses import dataclass, fields
from typing import Any, Final

import numpy as np

from quickreturn.cases.files.case import Case
from quickreturn.cases.files.document import LONGEST_NAME
from quickreturn.cases.files.keys import text_of, unit_given
from quickreturn.cases.files.shown import Cell, Printable, Rows
from quickreturn.plugins.studies.uncertainty.parameters import Parameter, changes
from quickreturn.reference_model.arrays import Array

PROBABILITY: Final = 0.95
#: Smooth part of the squared residuals above which a note is printed.
NOTED_SHARE: Final = 0.3


@dataclass(frozen=True, kw_only=True)
class FittedParameter:
    """A parameter fitted to a table; numbers in SI."""

    key: str  # of the parameter
    unit: str  # SI
    given_in: str  # unit of the range of the search, or else of the case, in which the numbers are shown
    start: float  # value with which the search began
    value: float  # the best value
    low: float  # lower end of the 95 % interval: noise, the simulation's error and the table's own
    high: float  # upper end
    simulation_error: float  # change of the value by the simulation's own error
    table_error: float  # largest change of the value by the error that the table's numbers are taken to have
    determined: bool  # whether the table determines it
    at_end: bool  # whether it lies at the end of its range

    @property
    def shown(self) -> tuple[str, ...]:
        """The parameter as a row of a printed table."""
        _, size = unit_given(self.key.partition("[")[0], [f"1 {self.given_in}"])
        interval = f"{self.low / size:.6g} .. {self.high / size:.6g}" if self.determined else "not determined by this table"
        end = " (at an end of its range)" if self.at_end else ""
        return (
            self.key,
            f"{self.value / size:.6g}{end}",
            self.given_in,
            interval,
            f"{self.simulation_error / size:.1e}",
            f"{self.table_error / size:.1e}",
            f"{self.start / size:.6g}",
        )


@dataclass(frozen=True, kw_only=True, repr=False)
class Fit(Printable):
    """Parameters fitted to a table, their intervals, and the residuals.

    Attributes:
        case: the case with whose values the search began.
        table: name of the table.
        begins: whether the table begins in the standard start, like its simulation; otherwise the steady state was fitted.
        rows: number of rows of the table.
        found: the fitted parameters.
        covariance: of the parameters, SI, as nested tuples, (p, p), with all three errors.
        correlation: likewise, without unit.
        cannot_tell: directions that the table does not determine, as clauses.
        left: column -> RMS of the residual over RMS of the column.
        claimed: column -> RMS of the errors that table and simulation are taken to have at least, over RMS of the column.
        smooth: part of the squared residuals that is smooth from row to row: it is due to model, sensors or numerical errors, not to noise.
        widened: ratio of the widths of the intervals' noise to those for independent residuals, geometric mean.
        simulations: number of simulations.
    """

    case: Case
    table: str
    begins: bool
    rows: int
    found: tuple[FittedParameter, ...]
    covariance: tuple[tuple[float, ...], ...]
    correlation: tuple[tuple[float, ...], ...]
    cannot_tell: tuple[str, ...]
    left: dict[str, float]
    claimed: dict[str, float]
    smooth: float
    widened: float
    simulations: int

    @property
    def exceeding(self) -> tuple[str, ...]:
        """The columns whose residuals exceed the errors that table and simulation are taken to have at least."""
        return tuple(name for name, share in self.left.items() if share > self.claimed[name])

    @property
    def fitted(self) -> Case:
        """The case with the fitted values."""
        values = {Parameter.of_key(each.key, self.case.name): each.value for each in self.found}
        texts = {path: text_of(path, value) for path, value in changes(self.case.mechanism, values).items()}
        suffix = "-fitted"
        return self.case.with_(texts, name=self.case.name[: LONGEST_NAME - len(suffix)] + suffix)

    def as_document(self) -> dict[str, Any]:
        """The fit as a JSON document."""
        return {**{each.name: getattr(self, each.name) for each in fields(self)}, "case": self.case.name, "found": [*map(vars, self.found)]}

    def _parts(self) -> Iterator[Cell]:
        of = "from the standard start" if self.begins else "of the steady state"
        yield f"{self.case.name} fitted to {self.table}: {self.rows} rows {of}, {self.simulations} simulations"
        yield Rows(
            [each.shown for each in self.found],
            ("parameter", "value", "unit", "95 % interval", "simulation's error", "table's error", "begun from"),
        )
        if len(self.found) > 1:
            named = zip(self.found, self.correlation, strict=True)
            rows = [(each.key, *(f"{value:+.2f}" for value in line)) for each, line in named]
            yield Rows(rows, ("correlation", *(each.key for each in self.found)))
        yield from (f"this table cannot tell: {direction}" for direction in self.cannot_tell)
        yield f"left, RMS over the column's: {', '.join(f'{name} {100.0 * share:.2g} %' for name, share in self.left.items())}"
        if not self.exceeding:
            claims = ", ".join(f"{100.0 * share:.2g} %" for share in self.claimed.values())
            yield f"that is within the errors that table and simulation are taken to have: {claims}"
        elif self.smooth > NOTED_SHARE:
            columns = ", ".join(self.exceeding)
            yield (
                f"note: {100.0 * self.smooth:.0f} % of the squared residuals are smooth from row to row, and those of {columns} exceed"
                " the errors of table and simulation: the model or the table lacks something, or the noise is coloured; the intervals"
                " allow for it only as far as no parameter makes up for it"
            )


#: A direction counts as not determined if its standard error is larger than this part of the parameters or of their ranges ...
LOOSE: Final = 0.1
#: ... or if a change by that part changes the table by less than this part, which is about the simulation's accuracy.
LEAST_CHANGE: Final = 2e-4


def best_step(slopes: Array, residuals: Array, weights: Array) -> Array:
    """Change of the coordinates, (p,), that most reduces the residuals, (C, N), weighted by (C,); `slopes`: its effect, (C, N, p)."""
    matrix = (slopes * weights[:, None, None]).reshape(-1, slopes.shape[2])
    return np.asarray(np.linalg.lstsq(matrix, (residuals * weights[:, None]).ravel(), rcond=LEAST_CHANGE)[0])


def covariance(residuals: Array, slopes: Array) -> tuple[Array, Array]:
    """Covariance of a least-squares estimate with correlated residuals, and that with independent ones.

    Spectra and cross-spectra are averaged over 2 sqrt(N) + 1 of 2 N frequencies, so correlations over up to sqrt(N) rows count.

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
    correlated = bread @ np.real(filling + filling.conj().T) @ bread * 0.5 * freedom / scale
    variances = np.diag(correlated)  # the scatter of the spectra must not make them smaller than for independent residuals
    wider = np.sqrt(np.maximum(1.0, np.diag(independent) / np.where(variances > 0.0, variances, math.inf)))
    return correlated * np.outer(wider, wider), independent


def reach(slopes: Array, levels: Array) -> Array:
    """Bound of what errors of known size do to a least-squares estimate, whatever their course in time, shape (p, p).

    Errors e_c of the columns with RMS up to t_c move the estimate by b = sum_c P_c e_c, where P is the pseudo-inverse of the slopes. With
    M = sqrt(C N) [t_1 P_1, ..., t_C P_C] this is b = M u with |u| <= 1, so that b lies in the ellipsoid of M M^T, which is returned. More
    rows do not make it smaller: such an error is no noise, and may look like the effect of a parameter throughout.

    Args:
        slopes: weighted, shape (C, N, p).
        levels: weighted RMS of the errors, shape (C,).
    """
    channels, rows, count = slopes.shape
    matrix = slopes.reshape(-1, count)
    sizes = np.linalg.norm(matrix, axis=0)
    sizes[sizes == 0.0] = 1.0
    bread = np.linalg.pinv((matrix / sizes).T @ (matrix / sizes), rcond=1e-14, hermitian=True)
    moved = (slopes / sizes) @ bread / sizes * levels[:, None, None]  # of each coordinate by an error of `levels` in one row
    return np.asarray(channels * rows * np.einsum("cnk,cnl->kl", moved, moved))


def smooth_part(residuals: Array) -> float:
    """Part of the squared residuals, shape (C, N), that is smooth from row to row: 0 for independent noise.

    Third differences of independent numbers of variance v have the variance 20 v; those of a smooth course are small.
    """
    noise = float(np.mean(np.diff(residuals, 3, axis=1) ** 2)) / 20.0
    square = float(np.mean(residuals**2))
    return max(0.0, 1.0 - noise / square) if square > 0.0 else 0.0


def undetermined(sensitivities: Array, spread: Array) -> list[Array]:
    """Unit vectors of coordinates that a table does not determine, shape (p,) each.

    Args:
        sensitivities: relative change of each column by each coordinate, shape (C, N, p).
        spread: covariance of the coordinates, shape (p, p).
    """
    matrix = sensitivities.reshape(-1, len(spread))
    _, values, vectors = np.linalg.svd(matrix / math.sqrt(len(matrix)), full_matrices=False)
    errors = np.sqrt(np.maximum(np.einsum("ki,ij,kj->k", vectors, spread, vectors), 0.0))
    return [vector for vector, value, error in zip(vectors, values, errors, strict=True) if LOOSE * value < LEAST_CHANGE or error > LOOSE]
