"""Differences of two trajectories, column by column."""

import math
import os
from collections.abc import Iterator, Mapping
from typing import Any, Final

import numpy as np
from numpy.typing import ArrayLike, NDArray

from quickreturn.cases.errors import CaseError
from quickreturn.cases.recorded import RecordedTable, read_table, table_of
from quickreturn.cases.shown import Cell, Rows, Shown
from quickreturn.engines.relative import rms
from quickreturn.engines.trajectory import Trajectory
from quickreturn.reference_model.columns import COLUMNS
from quickreturn.solution import Solution

Array = NDArray[np.float64]
Places = NDArray[np.intp]
#: A table: a path, a DataFrame or a dictionary of arrays with units in the headings, or a result of `simulate`.
AnyTable = str | os.PathLike[str] | Mapping[str, ArrayLike] | Solution | Trajectory | Any

#: Largest distance, over the smaller time step, of instants that count as the same. Times written with five digits are rounded by less.
_SAME_INSTANT: Final = 1e-2


class Differences(Shown, Mapping[str, float]):
    """RMS(ours - theirs) / RMS(theirs) by column, over the rows that both have.

    Attributes:
        absolute: column -> RMS of the difference, in the column's SI unit.
        rows: number of rows that both have.
        step: median time between two of these, s.
    """

    def __init__(self, relative: Mapping[str, float], absolute: Mapping[str, float], rows: int, step: float) -> None:
        self._relative, self.absolute, self.rows, self.step = dict(relative), dict(absolute), rows, step

    def __getitem__(self, column: str) -> float:
        return self._relative[column]

    def __iter__(self) -> Iterator[str]:
        return iter(self._relative)

    def __len__(self) -> int:
        return len(self._relative)

    def _parts(self) -> Iterator[Cell]:
        rows = [(name, f"{share:.2e}", f"{self.absolute[name]:.2e}", COLUMNS[name].unit) for name, share in self.items()]
        yield f"{self.rows} rows, {self.step:.4g} s apart"
        yield Rows(rows, ("column", "relative", "RMS", "unit"))


def difference(ours: AnyTable, theirs: AnyTable) -> Differences:
    """The relative RMS difference of each column that both have, over the rows at the same instants. Nothing is interpolated.

    Args:
        ours: a result of `simulate`, the path of a table, a DataFrame or a dictionary of arrays; units stand in the headings.
        theirs: likewise; the differences are relative to it. A column that is zero throughout in `theirs` gives infinity, or 0 if it is
            zero in both.

    Raises:
        CaseError: a table cannot be read; the tables have no column in common, or rows at different instants. One table may have more rows
            than the other, between its rows and beyond them.
    """
    our_columns, their_columns = as_table(ours, "ours").columns, as_table(theirs, "theirs").columns
    names = [name for name in COLUMNS if name in our_columns and name in their_columns and name != "time"]
    if not names:
        columns = f"ours holds {', '.join(our_columns)}, theirs {', '.join(their_columns)}"
        raise CaseError("difference", None, None, "the two tables have no column in common but the time", columns)
    rows, other_rows = _common_rows(our_columns["time"], their_columns["time"])
    absolute = {name: rms(our_columns[name][rows] - their_columns[name][other_rows]) for name in names}
    relative = {name: _over(absolute[name], rms(their_columns[name][other_rows])) for name in names}
    return Differences(relative, absolute, len(rows), float(np.median(np.diff(their_columns["time"][other_rows]))))


def as_table(given: AnyTable, name: str = "table") -> RecordedTable:
    """Any kind of table as a recorded table, which declares its case if that is known; `name` is given to a table without a file.

    Raises:
        CaseError: it cannot be read, or is not a table.
    """
    if isinstance(given, Solution):
        return table_of(given.trajectory.columns, name, given.case.name)
    if isinstance(given, Trajectory):
        return table_of(given.columns, name)
    if isinstance(given, (str, os.PathLike)):
        return read_table(os.fspath(given))
    if hasattr(given, "keys") and hasattr(given, "__getitem__"):
        case = getattr(given, "attrs", {}).get("case")
        return table_of({heading: given[heading] for heading in given.keys()}, name, case if isinstance(case, str) else None)  # noqa: SIM118
    raise CaseError(
        name, None, None, f"{type(given).__name__} is no table", "give a path, a DataFrame, a dictionary of arrays or a solution"
    )


def _common_rows(our_times: Array, their_times: Array) -> tuple[Places, Places]:
    """Indices of the rows at the same instants, as many in each. CaseError: where both have rows, neither has all instants of the other."""
    overlap = max(our_times[0], their_times[0]), min(our_times[-1], their_times[-1])
    near = _SAME_INSTANT * min(float(np.min(np.diff(times), initial=np.inf)) for times in (our_times, their_times))
    rows, other_rows = (np.flatnonzero((times >= overlap[0] - near) & (times <= overlap[1] + near)) for times in (our_times, their_times))
    if min(len(rows), len(other_rows)) < 2:
        ranges = f"ours goes from {our_times[0]:g} to {our_times[-1]:g} s, theirs from {their_times[0]:g} to {their_times[-1]:g} s"
        raise CaseError("difference", "time", None, "the two tables have fewer than two rows in common", ranges)
    if len(rows) <= len(other_rows):
        return rows, other_rows[_nearest(our_times[rows], their_times[other_rows], near)]
    return rows[_nearest(their_times[other_rows], our_times[rows], near)], other_rows


def _nearest(times: Array, others: Array, near: float) -> Places:
    """The index of each instant among the others. CaseError: one is missing."""
    after = np.clip(np.searchsorted(others, times), 1, len(others) - 1)
    places = np.where(times - others[after - 1] < others[after] - times, after - 1, after)
    alone = np.abs(others[places] - times) > near
    if np.any(alone):
        problem = f"one table has a row at {times[np.argmax(alone)]:.6g} s, the other has none"
        raise CaseError("difference", "time", None, problem, "give both the same output step, or one a multiple of the other's")
    return places


def _over(size: float, reference: float) -> float:
    return size / reference if reference > 0.0 else 0.0 if size == 0.0 else math.inf
