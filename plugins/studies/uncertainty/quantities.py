"""The quantity of a scene with which `reference` would give a recorded table: a lead where table and engines differ."""

import math
from dataclasses import dataclass
from typing import Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from quickreturn.cases.comparison.column_differences import LEAST_DIFFERENCE
from quickreturn.cases.files.case import Case
from quickreturn.cases.files.errors import CaseError
from quickreturn.cases.files.recorded import RecordedTable
from quickreturn.engines.base import EngineFailure, NoSteadyState, Refusal
from quickreturn.engines.relative import rms
from quickreturn.plugins.studies.uncertainty.calibration import Free, Search
from quickreturn.plugins.studies.uncertainty.covariance import smooth_part
from quickreturn.plugins.studies.uncertainty.table_model import TableModel

Array = NDArray[np.float64]

#: Keys that are tried, if the scene has a value there.
CANDIDATES: Final = (
    "follower.bending_stiffness",
    "follower.mass_per_length",
    "follower.damping",
    "follower.length",
    "tip.mass",
    "base.inertia",
    "base.damping",
    "crank.length",
    "crank.torque",
    "crank.damping",
    "crank.inertia",
    "crank.prescribed_speed",
    "mechanism.pivot_distance",
)
#: RMS of what is left of the columns, over theirs, up to which a quantity explains a table: that which needs no explanation itself.
EXPLAINED: Final = LEAST_DIFFERENCE
#: Largest ratio of what a quantity leaves to what the best one leaves, for both to be named.
AS_GOOD: Final = 2.0
FITTED: Final = 3  # quantities that are fitted: the best by a linear fit
#: Changes of a coordinate from which a quantity is fitted to a steady state that a fit from the case's own value does not explain. In the
#: steady state no stretch of a table is short enough for the phases to agree, as it is after the start.
SCAN: Final = (-0.36, -0.3, -0.24, -0.18, -0.12, -0.06, 0.06, 0.12, 0.18, 0.24, 0.3, 0.36)


@dataclass(frozen=True)
class Lead:
    """A quantity that would explain a table; values in SI."""

    key: str
    given: float  # value of the case
    value: float  # that the table would have
    difference: float  # RMS of the columns' difference from the case, over their RMS
    left: float  # the same with the value, without the part that looks like noise

    def told(self, case: Case, path: str) -> str:
        """A sentence, with the command that fits the quantity; `path`: of the table."""
        unit = case.units.of(Free.of_text(self.key, case).parameter.quantity.unit)
        place = f"{self.key} of about {unit.text(self.value, '.3g')} in place of {unit.text(self.given, '.3g')}"
        size = f"it is {100.0 * self.difference:.2g} % of the columns and would be {100.0 * self.left:.2g} %"
        return f"{place} would explain the difference ({size}): `quickreturn calibrate {case.name} {path} --free {self.key}` fits that"


def leads(case: Case, table: RecordedTable) -> tuple[Lead, ...]:
    """The quantities each of which would explain the table alone, about equally well; none if there is none.

    The best by a linear fit are fitted, so that the phases of table and simulation agree.
    """
    try:
        model = TableModel(case, table)
        every = Search(case, model, [free for key in CANDIDATES if (free := _free(key, case))])
        begin = np.array([free.first for free in every.frees])
        difference = _smooth(_apart(every, begin, model.rows))
        if difference <= EXPLAINED:
            return ()
        tries = [_fitted(case, model, every.frees[place], begin[place]) for place in _best(every, begin)[:FITTED]]
        if min(map(_left, tries)) > EXPLAINED and not model.begins:
            scanned = sorted((_scanned(case, model, free, at) for free, at in zip(every.frees, begin, strict=True)), key=_left)
            tries = [_fitted(case, model, each.free, each.at) for each in scanned[:FITTED]]
    except (CaseError, EngineFailure, Refusal, NoSteadyState):
        return ()
    enough = min(EXPLAINED, AS_GOOD * min(map(_left, tries)))
    return tuple(
        Lead(each.free.parameter.key, each.free.start, each.free.value(each.at), difference, each.left)
        for each in sorted(tries, key=_left)
        if each.left <= enough
    )


class _Try(NamedTuple):
    """A quantity at a coordinate, and what it leaves of the columns, over their RMS; infinite if it cannot be simulated."""

    free: Free
    at: float
    left: float


def _left(tried: _Try) -> float:
    return tried.left


def _best(every: Search, begin: Array) -> list[int]:
    """The places of the quantities, first that with which a linear fit to the first stretch of the table leaves least."""
    rows = every.model.stretches(every.case.mechanism)[0]
    left = _apart(every, begin, rows).ravel()
    slopes = (every.slopes(begin, rows) / every.model.sizes[:, None, None]).reshape(-1, len(begin))
    sizes = np.linalg.norm(slopes, axis=0)
    gains = np.abs(left @ slopes) / np.where(sizes > 0.0, sizes, math.inf)
    return [int(place) for place in np.argsort(-gains)]


def _fitted(case: Case, model: TableModel, free: Free, at: float) -> _Try:
    """A quantity fitted to longer and longer stretches of the table."""
    search, coordinate = Search(case, model, [free]), np.array([at])
    for rows in model.stretches(case.mechanism):
        coordinate = search.fitted(coordinate, rows, 1.0 / model.sizes)
    return _tried(search, float(coordinate[0]))


def _scanned(case: Case, model: TableModel, free: Free, at: float) -> _Try:
    """A quantity at the best of several values."""
    search = Search(case, model, [free])
    low, high = (float(bound[0]) for bound in search.bounds)
    return min((_tried(search, float(np.clip(at + step, low, high))) for step in SCAN), key=_left)


def _tried(search: Search, at: float) -> _Try:
    (free,) = search.frees
    try:
        return _Try(free, at, _smooth(_apart(search, np.array([at]), search.model.rows)))
    except (EngineFailure, Refusal, NoSteadyState, CaseError):
        return _Try(free, at, math.inf)


def _apart(search: Search, at: Array, rows: int) -> Array:
    """What is left of the columns' first rows, over their RMS, shape (C, rows)."""
    model = search.model
    return np.asarray((model.values[:, :rows] - search.simulated(at, search.usual, rows)) / model.sizes[:, None])


def _smooth(left: Array) -> float:
    """RMS of what is left without the part that looks like noise."""
    return math.sqrt(float(np.mean([smooth_part(column[None]) * rms(column) ** 2 for column in left])))


def _free(key: str, case: Case) -> Free | None:
    try:
        return Free.of_text(key, case)
    except CaseError:  # the scene has no value there
        return None
