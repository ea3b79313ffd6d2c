"""Tables compared: a recorded one with engines, with the size and place of departures; and two, column by column."""

import math
import os
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import replace
from functools import cached_property
from typing import TYPE_CHECKING, Any, Final

import numpy as np
from numpy.typing import ArrayLike, NDArray

from quickreturn.arguments import AnyCase, AnyEngineOrTable, given_settings, one_case, prepared
from quickreturn.cases.comparison.campaign import hold_against_engines
from quickreturn.cases.comparison.causes import Causes, causes, column_differences, places
from quickreturn.cases.comparison.engines import CaseResult, agreement
from quickreturn.cases.comparison.pair import Difference
from quickreturn.cases.files.case import Case
from quickreturn.cases.files.errors import CaseError
from quickreturn.cases.files.number_rows import PLAIN, Form
from quickreturn.cases.files.recorded import RecordedTable, read_table, table_of
from quickreturn.cases.files.shown import Cell, Printable, Rows
from quickreturn.cases.motion.number import SAYS_NOTHING
from quickreturn.cases.motion.request import NOTHING, Run
from quickreturn.cases.running.job import Job
from quickreturn.cases.running.workshop import Workshop
from quickreturn.computing import checked, workshop
from quickreturn.engines.plugins import found as found_at
from quickreturn.engines.plugins import places as of_plugins
from quickreturn.engines.registry import MAIN
from quickreturn.engines.trajectory import Trajectory, rms, scale
from quickreturn.reference_model.arrays import Array
from quickreturn.reference_model.columns import COLUMNS
from quickreturn.solution import Solution
from quickreturn.verdict_text import parts_of

if TYPE_CHECKING:
    import pandas as pd


Places = NDArray[np.intp]
#: A table: a path, a DataFrame a dictionary of arrays with units in the headings, or what `simulate` or `read_table` returns.
AnyTable = str | os.PathLike[str] | Mapping[str, ArrayLike] | Solution | Trajectory | RecordedTable | Any

#: Largest distance, over the smaller time step, of instants that count as the same. Times written with five digits are rounded by less.
_SAME_INSTANT: Final = 1e-2


class TableComparison(Printable):
    """The comparison of a table with engines, in the turn of the crank or the steady state that it shows.

    Attributes:
        result: runs of the engines and of the table, and all comparisons.
        name: name of the table.
    """

    def __init__(self, result: CaseResult, name: str) -> None:
        self.result, self.name = result, name

    @property
    def run(self) -> Run:
        """The table as a run: the turn that is compared, its measures and their uncertainties."""
        return self.result.recorded[self.name]

    @property
    def rows(self) -> tuple[Difference, ...]:
        """Every number of the table compared with an engine's: both values, difference, tolerance, and whether it passed."""
        return tuple(check for check in self.result.table_checks if check.engine == self.name)

    @property
    def missed(self) -> tuple[Difference, ...]:
        """The rows whose difference exceeds the engine's claim and the uncertainty of the table's measures."""
        return tuple(check for check in self.rows if not check.passed)

    @property
    def passed(self) -> bool | None:
        """Whether no row exceeds its tolerance; None if nothing could be judged, or every row says nothing (`Difference.verdict`)."""
        return None if all(row.verdict == "says nothing" for row in self.rows) else not self.missed

    @property
    def accuracy_class(self) -> str | None:
        """The least of 0.1, 0.3, 1, 3 and 10 % that covers its deviation from `reference`, or "worse"; None if `reference` did not run."""
        return self.result.with_tables.accuracy_class(self.name)

    @property
    def verdict(self) -> str:
        """The outcome as a sentence."""
        if self.passed is None:
            silent = f"all {len(self.rows)} comparisons say nothing: what is claimed is more than {SAYS_NOTHING}" if self.rows else ""
            return f"{self.name} could not be judged: {silent or self.run.remark or self.result.with_tables.reason}"
        others = " and ".join(dict.fromkeys(check.other for check in self.missed or self.rows))
        if not self.missed:
            count = agreement(self.rows)["says_nothing"]
            silent = f"; {count} of them say nothing, for more is claimed than {SAYS_NOTHING}" if count else ""
            return f"{self.name} is within what is claimed of {others} in all {len(self.rows)} comparisons{silent}"
        return f"{self.name} departs from {others} by more than is claimed in {len(self.missed)} of {len(self.rows)} comparisons"

    @cached_property
    def differences(self) -> dict[str, dict[str, float]]:
        """Engine -> column -> RMS difference over the engine's RMS, at equal crank angles of the turn that is compared."""
        return {other.engine: column_differences(self.run, other) for other in self._comparable}

    @cached_property
    def places(self) -> dict[str, dict[str, float]]:
        """Engine -> column -> crank angle, deg, at which the table differs most from the engine."""
        return {other.engine: places(self.run, other) for other in self._comparable}

    @cached_property
    def causes(self) -> Causes | None:
        """What explains the differences from the first engine; None if there is none to compare with."""
        return next((causes(self.run, other) for other in self._comparable), None)

    @property
    def explanations(self) -> dict[str, str]:
        """Column -> what in its measuring chain explains its difference, see `cases.comparison.causes`.

        "crank_angle" -> how late all columns are; "time" -> how much longer a turn takes; "quantities" -> with which other values of one or
        two quantities of the scene the case would give the table; "unexplained" -> the columns that nothing of this explains.
        """
        return self.causes.told(self.result.case.name, self.result.leads.get(self.name, ())) if self.causes else {}

    @property
    def frame(self) -> "pd.DataFrame":
        """The rows as a table."""
        import pandas as pd

        return pd.DataFrame([check.as_dict() for check in self.rows])

    @property
    def _comparable(self) -> list[Run]:
        """Runs of the engines with which the table can be compared."""
        return [other for other in self.result.runs.values() if self.run.usable and other.usable]

    def _parts(self) -> list[Cell]:
        form = self.run.recording.told if self.run.recording else ""
        return [*([f"{self.name}: {form}"] if form else []), *parts_of_tables(self.result, [self])]


def compare(
    case: AnyCase,
    table: AnyTable,
    engines: "AnyEngineOrTable | Iterable[AnyEngineOrTable]" = MAIN,
    *,
    accuracy: float | None = None,
    settings: Mapping[str, Mapping[str, Any]] | None = None,
    separator: str | None = None,
    decimal: str | None = None,
    skip: int = 0,
    jobs: int | None = None,
    quiet: bool = False,
) -> TableComparison:
    """Compare a table with engines in the turn of the crank or the steady state that it shows. Each result is stored at once.

    Args:
        case: a name, a path or a `Case`.
        table: a path, a DataFrame or a dictionary of arrays whose headings have units ("tip_deflection [mm]"; none: SI), or what `simulate`
            or `read_table` returns: `time` and any columns of a trajectory.
        engines: names, or engines that are installed, one or several; default: the four main ones.
        accuracy: relative error of the tip deflection asked of every engine; None: each engine's default.
        settings: settings by engine: {"mujoco": {"links": 16}}.
        separator: sign between the columns of a file; None: recognised.
        decimal: decimal sign of a file; None: recognised.
        skip: number of lines above the headings of a file.
        jobs: how many processes at a time; None: one per core.
        quiet: whether progress on standard error is left out.

    Raises:
        CaseError: no such case; the table cannot be read, declares another case, or has no whole turn of the crank.
        UnknownEngine, Refusal, SettingError, StoreError, KeyboardInterrupt: as of `run`.
    """
    recorded = as_table(table, form=Form(separator, decimal, skip))
    results = compared(case, [recorded], engines, accuracy=accuracy, settings=settings, jobs=jobs, quiet=quiet)
    return next(comparison for result in results for comparison in tables_in(result) if comparison.name == recorded.name)


def compared(
    case: AnyCase,
    tables: Iterable[RecordedTable],
    engines: "AnyEngineOrTable | Iterable[AnyEngineOrTable]",
    *,
    accuracy: float | None = None,
    settings: Mapping[str, Mapping[str, Any]] | None = None,
    jobs: int | None = None,
    quiet: bool = False,
) -> list[CaseResult]:
    """The results of `compare` for several tables; other arguments and errors as there."""
    chosen = one_case(case)
    names, texts, others = prepared([chosen], engines, given_settings(settings))
    recorded = [*others.get(chosen.name, ()), *tables]
    called = [*names, *(table.name for table in recorded)]
    for name in called:
        if called.count(name) > 1:
            raise CaseError(name, None, None, "two tables or engines have this name", "give each file a name of its own")
    with workshop(jobs, quiet, [chosen], names) as opened:
        results = hold_against_engines(chosen, recorded, opened, names, checked(accuracy), texts)
        return _led_on(chosen, results, {table.name: table for table in recorded}, opened)


def _led_on(case: Case, results: list[CaseResult], tables: Mapping[str, RecordedTable], workshop: Workshop) -> list[CaseResult]:
    """The results with the quantities of the scene that would explain tables."""
    names = [table.name for result in results for table in tables_in(result) if table.causes is not None and table.causes.open]
    leads = of_plugins("leads")
    jobs = [Job(f"quantities of {name}", found_at(lead), (case, tables[name]), lasts=None) for lead in leads for name in names]
    outcomes = workshop.outcomes(jobs, "quantities that would explain a table")
    found = {name: outcome.value or () for name, outcome in zip(names * len(leads), outcomes, strict=True)}
    return [replace(result, leads={name: found[name] for name in result.recorded if name in found}) for result in results]


def tables_in(result: CaseResult) -> list[TableComparison]:
    """All tables of a result."""
    return [TableComparison(result, name) for name in result.recorded]


def parts_of_tables(result: CaseResult, tables: Sequence[TableComparison]) -> list[Cell]:
    """The text on the tables of a result: measures and verdicts, differences by column, and their explanations."""
    parts = parts_of(result)
    differences = {(table, engine): shares for table in tables for engine, shares in table.differences.items()}
    if columns := dict.fromkeys(column for shares in differences.values() for column in shares):
        heads = [engine if len(tables) == 1 else f"{table.name} - {engine}" for table, engine in differences]
        at = [table.places[engine] for table, engine in differences]
        cells = [
            [f"{each[name]:.1e} {at[k][name]:.0f}°" if name in each else "-" for k, each in enumerate(differences.values())]
            for name in columns
        ]
        rows = [[f"  {name}", *row] for name, row in zip(columns, cells, strict=True)]
        what = "  RMS difference in this turn, over the engine's RMS, and the crank angle at which it is largest:"
        parts += [what, Rows(rows, ("", *heads))]
    return [*parts, *(f"  {table.name}: {sentence}" for table in tables for sentence in table.explanations.values())]


class Differences(Printable, Mapping[str, float]):
    """RMS(ours - theirs) over the `scale` of theirs by column, for most the column's RMS, over the rows that both have.

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
        theirs: likewise; the differences are relative to it, as error estimates are (`engines.trajectory.scale`). A column that is zero
            throughout in `theirs` gives infinity, or 0 if it is zero in both, or rounding.

    Raises:
        CaseError: a table cannot be read; the tables have no column in common, or rows at different instants. One table may have more rows
            than the other, between its rows and beyond them.
    """
    our_table, their_table = as_table(ours, "ours"), as_table(theirs, "theirs")
    our_columns, their_columns = our_table.columns, their_table.columns
    names = [name for name in COLUMNS if name in our_columns and name in their_columns and name != "time"]
    if not names:
        columns = f"{our_table.name} holds {', '.join(our_columns)}, {their_table.name} {', '.join(their_columns)}"
        raise CaseError("difference", None, None, "the two tables have no column in common but the time", columns)
    rows, other_rows = _common_rows(our_table, their_table)
    absolute = {name: rms(our_columns[name][rows] - their_columns[name][other_rows]) for name in names}
    compared = {name: values[other_rows] for name, values in their_columns.items()}
    relative = {name: _over(absolute[name], scale(name, compared)) for name in names}
    return Differences(relative, absolute, len(rows), float(np.median(np.diff(their_columns["time"][other_rows]))))


def as_table(given: AnyTable, name: str = "table", form: Form = PLAIN) -> RecordedTable:
    """Any kind of table as a recorded table, which declares its case if that is known.

    Args:
        given: the table.
        name: of a table without a file.
        form: how a file is written.

    Raises:
        CaseError: it cannot be read, or is not a table.
    """
    if isinstance(given, RecordedTable):
        return given
    if isinstance(given, Solution):
        return table_of(given.trajectory.columns, name, given.case.name)
    if isinstance(given, Trajectory):
        return table_of(given.columns, name)
    if isinstance(given, (str, os.PathLike)):
        return read_table(given, (), form.decimal, form.separator, form.skip)
    if hasattr(given, "keys") and hasattr(given, "__getitem__"):
        case = getattr(given, "attrs", {}).get("case")
        columns = {heading: given[heading] for heading in given.keys()}  # noqa: SIM118
        return table_of(_index_as_time(given) | columns, name, case if isinstance(case, str) else None)
    accepted = "give a path, a DataFrame, a dictionary of arrays or a solution"
    raise CaseError(name, None, None, f"{type(given).__name__} is no table", accepted)


def _index_as_time(given: Any) -> dict[str, Any]:
    """The column time that a DataFrame has as its index: one that is called so, or durations. Empty if it has none."""
    index: Any = getattr(given, "index", None)
    if any(_is_time(heading) for heading in given.keys()) or not hasattr(index, "name"):  # noqa: SIM118
        return {}
    if hasattr(index, "total_seconds"):
        return {"time": index.total_seconds()}
    return {index.name: index} if _is_time(index.name) else {}


def _is_time(heading: Any) -> bool:
    return str(heading).partition("[")[0].partition("(")[0].strip() == "time"


def _common_rows(ours: RecordedTable, theirs: RecordedTable) -> tuple[Places, Places]:
    """Indices of the rows at the same instants, as many in each. CaseError: where both have rows, neither has all instants of the other."""
    our_times, their_times = ours["time"], theirs["time"]
    if ours.begin is not None and theirs.begin is not None:
        our_times = our_times + (ours.begin - theirs.begin).total_seconds()
    overlap = max(our_times[0], their_times[0]), min(our_times[-1], their_times[-1])
    near = _SAME_INSTANT * min(float(np.min(np.diff(times), initial=np.inf)) for times in (our_times, their_times))
    rows, other_rows = (np.flatnonzero((times >= overlap[0] - near) & (times <= overlap[1] + near)) for times in (our_times, their_times))
    if min(len(rows), len(other_rows)) < 2:
        named = (ours.name, our_times), (theirs.name, their_times)
        ranges = (f"{name} goes from {times[0]:g} to {times[-1]:g} s" for name, times in named)
        raise CaseError("difference", "time", None, "the two tables have fewer than two rows in common", ", ".join(ranges))
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
    """A size over that to which it is relative; 0 where both are rounding."""
    return 0.0 if max(size, reference) <= NOTHING else size / reference if reference > 0.0 else math.inf
