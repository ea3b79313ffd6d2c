"""A recorded table compared with engines: departures, their size, and their cause."""

from collections.abc import Iterable, Mapping, Sequence
from functools import cached_property
from typing import TYPE_CHECKING, Any

from quickreturn.accuracy import checked
from quickreturn.cases.errors import CaseError
from quickreturn.cases.measures.number import SAYS_NOTHING
from quickreturn.cases.recorded import RecordedTable
from quickreturn.cases.runs.campaign import hold_against_engines
from quickreturn.cases.runs.comparison import CaseResult, Difference, agreement
from quickreturn.cases.runs.differences import column_differences, explanations
from quickreturn.cases.runs.request import Run
from quickreturn.cases.shown import Cell, Rows, Shown
from quickreturn.catalogue import AnyCase, one_case
from quickreturn.cross_validation import given_settings, opened
from quickreturn.differences import AnyTable, as_table
from quickreturn.engine_choice import AnyEngineOrTable, prepared
from quickreturn.engines.registry import MAIN
from quickreturn.verdict_text import parts_of

if TYPE_CHECKING:
    import pandas as pd


class TableComparison(Shown):
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
            told = f"; {count} of them say nothing, for more is claimed than {SAYS_NOTHING}" if count else ""
            return f"{self.name} is within what is claimed of {others} in all {len(self.rows)} comparisons{told}"
        return f"{self.name} departs from {others} by more than is claimed in {len(self.missed)} of {len(self.rows)} comparisons"

    @cached_property
    def differences(self) -> dict[str, dict[str, float]]:
        """Engine -> column -> RMS difference over the engine's RMS, at equal crank angles of the turn that is compared."""
        return {other.engine: column_differences(self.run, other) for other in self._comparable}

    @cached_property
    def explanations(self) -> dict[str, str]:
        """Column -> the mistake that explains its difference, or noise, and what to do; "case" -> why it is a table of another case."""
        return next((explanations(self.run, other, self.result.case) for other in self._comparable), {})

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
        return parts_of_tables(self.result, [self])


def compare(
    case: AnyCase,
    table: AnyTable,
    engines: "AnyEngineOrTable | Iterable[AnyEngineOrTable]" = MAIN,
    *,
    accuracy: float | None = None,
    settings: Mapping[str, Mapping[str, Any]] | None = None,
    jobs: int | None = None,
    quiet: bool = False,
) -> TableComparison:
    """Compare a table with engines in the turn of the crank or the steady state that it shows. Each result is stored at once.

    Args:
        case: a name, a path or a `Case`.
        table: a path, a DataFrame or a dictionary of arrays whose headings have units ("tip_deflection [mm]"; none: SI), or a result of
            `simulate`: `time` and any columns of a trajectory.
        engines: names, or engines that are installed, one or several; default: the four main ones.
        accuracy: relative error of the tip deflection asked of every engine; None: each engine's default.
        settings: settings by engine: {"mujoco": {"links": 16}}.
        jobs: how many processes at a time; None: one per core.
        quiet: whether progress on standard error is left out.

    Raises:
        CaseError: no such case; the table cannot be read, declares another case, or has no whole turn of the crank.
        UnknownEngine, Refusal, SettingError, StoreError, KeyboardInterrupt: as of `run`.
    """
    scene, texts = one_case(case), given_settings(settings)
    names, of_engines, others = prepared([scene], engines, texts)
    tables = [as_table(table), *others.get(scene.name, ())]
    refuse_same_names(names, tables)
    results = hold_against_engines(scene, tables, opened(jobs, quiet), names, checked(accuracy), of_engines)
    return next(comparison for result in results for comparison in tables_in(result) if comparison.name == tables[0].name)


def tables_in(result: CaseResult) -> list[TableComparison]:
    """All tables of a result."""
    return [TableComparison(result, name) for name in result.recorded]


def refuse_same_names(engines: Sequence[str], tables: Sequence[RecordedTable]) -> None:
    """Raise CaseError if two tables, or a table and an engine, have the same name."""
    called = [*engines, *(table.name for table in tables)]
    for name in called:
        if called.count(name) > 1:
            raise CaseError(name, None, None, "two tables or engines have this name", "give each file a name of its own")


def parts_of_tables(result: CaseResult, tables: Sequence[TableComparison]) -> list[Cell]:
    """The text on the tables of a result: measures and verdicts, differences by column, and their explanations."""
    parts = parts_of(result)
    differences = {(table, engine): shares for table in tables for engine, shares in table.differences.items()}
    if columns := dict.fromkeys(column for shares in differences.values() for column in shares):
        heads = [engine if len(tables) == 1 else f"{table.name} - {engine}" for table, engine in differences]
        rows = [[f"  {column}", *(f"{each[column]:.1e}" if column in each else "-" for each in differences.values())] for column in columns]
        parts += ["  RMS difference in this turn, over the engine's RMS:", Rows(rows, ("", *heads))]
    return [*parts, *(f"  {table.name}: {sentence}" for table in tables for sentence in table.explanations.values())]
