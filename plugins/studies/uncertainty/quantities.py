"""The quantities of a scene with which `reference` would give a recorded table: leads where table and engines differ."""

import math
from collections.abc import Sequence
from itertools import combinations
from typing import Final, NamedTuple

import numpy as np

from quickreturn.cases.comparison.causes import LEAST_DIFFERENCE, Explanation
from quickreturn.cases.files.case import Case
from quickreturn.cases.files.errors import CaseError
from quickreturn.cases.files.recorded import RecordedTable
from quickreturn.engines.base import EngineFailure, NoSteadyState, Refusal
from quickreturn.engines.trajectory import rms
from quickreturn.plugins.studies.uncertainty.calibration import Free, Search
from quickreturn.plugins.studies.uncertainty.fit import smooth_part
from quickreturn.plugins.studies.uncertainty.table_model import TableModel
from quickreturn.reference_model.arrays import Array

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
FITTED: Final = 3  # quantities, and pairs of them, that are fitted: the best by a linear fit
#: Changes of a coordinate from which a quantity is fitted to a steady state that a fit from the case's own value does not explain. In the
#: steady state no stretch of a table is short enough for the phases to agree, as it is after the start.
SCAN: Final = (-0.36, -0.3, -0.24, -0.18, -0.12, -0.06, 0.06, 0.12, 0.18, 0.24, 0.3, 0.36)


def explanations(case: Case, table: RecordedTable) -> tuple[Explanation, ...]:
    """What one quantity, or two, would leave of a table's difference, of those that a linear fit finds best. None: there is no difference.

    They are fitted, so that the phases of table and simulation agree. Pairs are fitted where no single quantity explains the table.
    """
    try:
        model = TableModel(case, table)
        every = Search(case, model, [free for key in CANDIDATES if (free := _free(key, case))])
        begin = np.array([free.first for free in every.frees])
        if _smooth(_apart(every, begin, model.rows)) <= LEAST_DIFFERENCE:
            return ()
        effects = _effects(every, begin)
        tries = [_fitted(case, model, every, places, begin) for places in _best(*effects, 1)]
        if min(map(_left, tries)) > LEAST_DIFFERENCE and not model.begins:
            scanned = sorted((_scanned(case, model, free, at) for free, at in zip(every.frees, begin, strict=True)), key=_left)
            tries = [_fitted(case, model, Search(case, model, each.frees), (0,), each.at) for each in scanned[:FITTED]]
        if min(map(_left, tries)) > LEAST_DIFFERENCE:
            tries += [_fitted(case, model, every, places, begin) for places in _best(*effects, 2)]
    except (CaseError, EngineFailure, Refusal, NoSteadyState):
        return ()
    return tuple(_explanation(each, case, table) for each in tries)


def _explanation(tried: "_Try", case: Case, table: RecordedTable) -> Explanation:
    keys = [free.parameter.key for free in tried.frees]
    changes = []
    for free, at in zip(tried.frees, tried.at, strict=True):
        unit = case.units.of(free.parameter.quantity.unit)
        changes.append(f"{free.parameter.key} of about {unit.text(free.value(at), '.3g')} in place of {unit.text(free.start, '.3g')}")
    options = " ".join(f"--free {key}" for key in keys)
    words = f"{' and '.join(changes)} would explain it: `quickreturn calibrate {case.name} {table.shown} {options}` fits that"
    return Explanation(f"another {' and '.join(keys)}", words, tried.left, len(keys))


class _Try(NamedTuple):
    """Quantities at coordinates, shape (p,), and what they leave of the columns, over their RMS; infinite if it cannot be simulated."""

    frees: Sequence[Free]
    at: Array
    left: float


def _left(tried: _Try) -> float:
    return tried.left


def _effects(every: Search, begin: Array) -> tuple[Array, Array]:
    """What is left of the first stretch of the table, and its slopes by the quantities, shapes (n,) and (n, p), over the columns' RMS."""
    rows = every.model.stretches(every.case.mechanism)[0]
    slopes = every.slopes(begin, rows) / every.model.sizes[:, None, None]
    return _apart(every, begin, rows).ravel(), slopes.reshape(-1, len(begin))


def _best(left: Array, slopes: Array, count: int) -> list[tuple[int, ...]]:
    """The places of single quantities, or of pairs, with which a linear fit to `_effects` leaves least."""

    def rest(places: tuple[int, ...]) -> float:
        return rms(left - slopes[:, places] @ np.linalg.lstsq(slopes[:, places], left)[0])

    return sorted(combinations(range(slopes.shape[1]), count), key=rest)[:FITTED]


def _fitted(case: Case, model: TableModel, every: Search, places: tuple[int, ...], begin: Array) -> _Try:
    """Some quantities of a search fitted to longer and longer stretches of the table."""
    search, at = Search(case, model, [every.frees[place] for place in places]), begin[[*places]]
    for rows in model.stretches(case.mechanism):
        at = search.fitted(at, rows, 1.0 / model.sizes)
    return _tried(search, at)


def _scanned(case: Case, model: TableModel, free: Free, at: float) -> _Try:
    """A quantity at the best of several values."""
    search = Search(case, model, [free])
    return min((_tried(search, np.clip([at + step], *search.bounds)) for step in SCAN), key=_left)


def _tried(search: Search, at: Array) -> _Try:
    try:
        return _Try(search.frees, at, _smooth(_apart(search, at, search.model.rows)))
    except (EngineFailure, Refusal, NoSteadyState, CaseError):
        return _Try(search.frees, at, math.inf)


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
