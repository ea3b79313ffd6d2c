"""One quantity of a scene, or two, with which `reference` would give a recorded table: a lead where table and engines differ."""

import math
from dataclasses import dataclass, replace
from typing import Final

import numpy as np
from numpy.typing import NDArray

from quickreturn.cases.case import Case
from quickreturn.cases.errors import CaseError
from quickreturn.cases.recorded import RecordedTable
from quickreturn.cases.uncertainty.calibration import Free, Search
from quickreturn.cases.uncertainty.covariance import smooth_part
from quickreturn.cases.uncertainty.table_model import TableModel
from quickreturn.engines.base import EngineFailure, NoSteadyState, Refusal
from quickreturn.engines.relative import rms

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
#: RMS of what is left of the columns, over theirs, up to which quantities explain a table. Engines at their default settings leave as much.
EXPLAINED: Final = 0.01
#: Part of the difference up to which quantities explain most of it.
MOSTLY: Final = 0.15
#: Largest ratio of what a quantity leaves to what the best one leaves, for both to be told; two together leave as much less.
AS_GOOD: Final = 2.0
FITTED_ALONE: Final = 3  # quantities that are fitted alone: the best by a linear fit
BEGUN_FROM: Final = 2  # of these, the best by their fits, with which others are tried together
PARTNERS: Final = 3  # quantities that are tried with each
#: Changes of a coordinate from which a quantity is fitted to a steady state that a fit from the case's own values does not explain.
SCAN: Final = (-0.36, -0.3, -0.24, -0.18, -0.12, -0.06, 0.06, 0.12, 0.18, 0.24, 0.3, 0.36)
STEPS: Final = 5  # most Gauss-Newton steps for a stretch of the table
LONGEST_STEP: Final = 0.3  # of a coordinate: a third of a value
SHARES: Final = (1.0, 0.4, 0.15)  # of a step that are tried, until one lessens what is left
LEAST_GAIN: Final = 0.02  # of a step, over what is left, below which a fit ends
SAME: Final = 0.01  # relative change up to which a value counts as the case's own


@dataclass(frozen=True)
class Lead:
    """Quantities that would explain a table; values in SI."""

    keys: tuple[str, ...]
    given: tuple[float, ...]  # values of the case
    values: tuple[float, ...]  # that the table would have
    difference: float  # RMS of the columns' difference from the case, over their RMS
    left: float  # the same with the values, without the part that looks like noise

    @property
    def whole(self) -> bool:
        """Whether the values explain the whole difference, not only most of it."""
        return self.left <= EXPLAINED

    def told(self, case: Case, path: str) -> str:
        """A sentence, with the command that fits the quantities; `path`: of the table."""
        parts = list[str]()
        for key, given, value in zip(self.keys, self.given, self.values, strict=True):
            unit = case.units.of(Free.of_text(key, case).parameter.quantity.unit)
            parts.append(f"{key} of about {unit.text(value, '.3g')} in place of {unit.text(given, '.3g')}")
        what = "the difference" if self.whole else "most of the difference"
        size = f"it is {100.0 * self.difference:.2g} % of the columns and would be {100.0 * self.left:.1g} %"
        free = " ".join(f"--free {key}" for key in self.keys)
        return f"{' and '.join(parts)} would explain {what} ({size}): `quickreturn calibrate {case.name} {path} {free}` fits that"


def leads(case: Case, table: RecordedTable) -> tuple[Lead, ...]:
    """Leads to single quantities that would explain the table about equally well, or else one to two; none if no such quantities are known.

    The best quantities by a linear fit are fitted, so that the phases of table and simulation agree. If none of them explains the table, a
    second one is chosen by another linear fit from there, and both are fitted together.
    """
    try:
        return _Leads(case, TableModel(case, table)).found()
    except (CaseError, EngineFailure, Refusal, NoSteadyState):
        return ()


@dataclass(frozen=True)
class _Try:
    """Candidates, by their places, with fitted coordinates, and what they leave of the columns, without noise."""

    places: tuple[int, ...]
    at: Array
    left: float


def _left(tried: _Try) -> float:
    return tried.left


class _Leads:
    """The search for the quantities of a table."""

    def __init__(self, case: Case, model: TableModel) -> None:
        self.case, self.model = case, model
        self.frees = [free for key in CANDIDATES if (free := _free(key, case))]
        self.every = Search(case, model, self.frees)
        self.weights = 1.0 / model.sizes

    def found(self) -> tuple[Lead, ...]:
        begin, rows = np.array([free.first for free in self.frees]), self.model.rows
        difference = self._smooth(self._apart(self.every, begin, rows))
        if difference <= EXPLAINED:
            return ()
        enough = max(EXPLAINED, MOSTLY * difference)
        if (exchanged := self._exchanged()) and exchanged.left <= enough:
            return (replace(exchanged, difference=difference),)
        first_rows = self.model.stretches(self.case.mechanism)[0]
        alone = sorted((self._fitted((place,), begin) for place in self._best(begin, first_rows, ())[:FITTED_ALONE]), key=_left)
        if alone[0].left > enough and not self.model.begins:
            alone = sorted((self._fitted((place,), at) for place, at in self._scanned(begin)[:FITTED_ALONE]), key=_left)
        pairs = []
        for one in alone[:BEGUN_FROM] if self.model.begins and alone[0].left > EXPLAINED else ():
            at = begin.copy()
            at[list(one.places)] = one.at
            pairs += [self._fitted((*one.places, place), at) for place in self._best(at, rows, one.places)[:PARTNERS]]
        together = min(pairs, key=_left, default=None)
        if together and together.left <= min(EXPLAINED, alone[0].left / AS_GOOD):
            return (self._lead(together, difference),)
        if alone[0].left > enough:
            return ()
        return tuple(self._lead(each, difference) for each in alone if each.left <= min(enough, AS_GOOD * alone[0].left))

    def _scanned(self, begin: Array) -> list[tuple[int, Array]]:
        """Places of quantities with coordinates of all from which to fit them, the best first.

        In the steady state no stretch of a table is short enough for the phases to agree, as it is after the start.
        """
        found = list[tuple[float, int, Array]]()
        for place in range(len(begin)):
            search = Search(self.case, self.model, [self.frees[place]])
            tries = [self._tried(search, begin[[place]] + step, self.model.rows) for step in SCAN]
            if best := min((each for each in tries if each), key=lambda each: rms(each[1]), default=None):
                at = begin.copy()
                at[place] = best[0][0]
                found.append((rms(best[1]), place, at))
        return [(place, at) for _, place, at in sorted(found, key=lambda each: each[0])]

    def _exchanged(self) -> Lead | None:
        """Width and thickness of a rectangle exchanged; None: the section is another one, or cannot be simulated so."""
        section = [free for key in ("follower.thickness", "follower.width") if (free := _free(key, self.case))]
        search, sizes = Search(self.case, self.model, section), tuple(free.start for free in section)
        if len(sizes) < 2:
            return None
        try:
            left = self._apart(search, np.log(sizes[::-1]) - np.log(sizes), self.model.rows)
        except (EngineFailure, Refusal, NoSteadyState, CaseError):
            return None
        return Lead(tuple(free.parameter.key for free in section), sizes, sizes[::-1], 0.0, self._smooth(left))

    def _best(self, at: Array, rows: int, fitted: tuple[int, ...]) -> list[int]:
        """The other candidates, first that with which a linear fit at `at`, together with those that are `fitted`, leaves least."""
        left = self._apart(self.every, at, rows).ravel()
        slopes = (self.every.slopes(at, rows) * self.weights[:, None, None]).reshape(-1, len(at))

        def left_with(place: int) -> float:
            chosen = slopes[:, [*fitted, place]]
            return float(np.linalg.norm(left - chosen @ np.linalg.lstsq(chosen, left, rcond=1e-9)[0]))

        return sorted((place for place in range(len(at)) if place not in fitted), key=left_with)

    def _fitted(self, places: tuple[int, ...], begin: Array) -> _Try:
        """Candidates fitted to longer and longer stretches of the table by Gauss-Newton steps that lessen what is left."""
        search = Search(self.case, self.model, [self.frees[place] for place in places])
        at = begin[list(places)]
        for rows in self.model.stretches(self.case.mechanism):
            left = self._apart(search, at, rows)
            for _ in range(STEPS):
                slopes = search.slopes(at, rows) * self.weights[:, None, None]
                step = np.linalg.lstsq(slopes.reshape(-1, len(at)), left.ravel(), rcond=1e-9)[0]
                step *= min(1.0, LONGEST_STEP / max(float(np.max(np.abs(step))), 1e-12))
                tries = (self._tried(search, at + share * step, rows) for share in SHARES)
                closer = next((each for each in tries if each is not None and rms(each[1]) < rms(left)), None)
                if closer is None:
                    break
                gain = rms(left) - rms(closer[1])
                at, left = closer
                if gain < LEAST_GAIN * rms(left):
                    break
        return _Try(places, at, self._smooth(left))

    def _tried(self, search: Search, at: Array, rows: int) -> tuple[Array, Array] | None:
        """Coordinates within their bounds with what they leave; None: they cannot be simulated."""
        inside = np.clip(at, *search.bounds)
        try:
            return inside, self._apart(search, inside, rows)
        except (EngineFailure, Refusal, NoSteadyState, CaseError):
            return None

    def _apart(self, search: Search, at: Array, rows: int) -> Array:
        """What is left of the columns' first rows, over their RMS, shape (C, rows)."""
        return np.asarray((self.model.values[:, :rows] - search.simulated(at, search.usual, rows)) * self.weights[:, None])

    def _smooth(self, left: Array) -> float:
        """RMS of what is left without the part that looks like noise."""
        return math.sqrt(float(np.mean([smooth_part(column[None]) * rms(column) ** 2 for column in left])))

    def _lead(self, found: _Try, difference: float) -> Lead:
        frees = [self.frees[place] for place in found.places]
        values = [free.value(float(coordinate)) for free, coordinate in zip(frees, found.at, strict=True)]
        others = [(free, value) for free, value in zip(frees, values, strict=True) if abs(value / free.start - 1.0) > SAME]
        keys, given = tuple(free.parameter.key for free, _ in others), tuple(free.start for free, _ in others)
        return Lead(keys, given, tuple(value for _, value in others), difference, found.left)


def _free(key: str, case: Case) -> Free | None:
    try:
        return Free.of_text(key, case)
    except CaseError:  # the scene has no value there
        return None
