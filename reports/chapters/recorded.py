"""Recorded tables: results of other tools, of earlier versions and of measurements, compared with the engines."""

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

from quickreturn.cases.comparison.engines import CaseResult
from quickreturn.cases.files.shown import Unit
from quickreturn.cases.motion.cycle import EXTREMES
from quickreturn.cases.motion.request import Run
from quickreturn.reference_model.columns import COLUMNS
from quickreturn.reports.engine_differences import engines_of
from quickreturn.reports.page.chapter import Chapter
from quickreturn.reports.page.content import Content, MeasuredHalf
from quickreturn.reports.tables import CASE, CHANNEL, COMPARISON, HALF_COLUMN, UNRESOLVABLE, Cell, Column, ColumnList, Table, compared
from quickreturn.reports.words import channel_name, counted, listed, quantity


def recorded(content: Content) -> Chapter | None:
    """The chapter; None if no recorded table was given."""
    runs = [run for result in content.results for run in result.recorded.values()]
    if not runs:
        return None
    names, checks = [run.engine for run in runs], [check for result in content.results for check in result.table_checks]
    facts = {
        "synthetic": [run.engine for run in runs if run.recording and run.recording.declared.get("origin") == "synthetic"],
        "tables": recorded_tables(content.results),
        "comparison": curve_comparison(content.comparisons, engines_of(content.results)),
        "departures": table_departures(content.results),
    }
    return Chapter("recorded", "Recorded tables", finding(names, len(checks), sum(not check.passed for check in checks)), facts)


def finding(names: Sequence[str], checks: int, beyond: int) -> str:
    """Whether the tables agree with the engines: the number of comparisons, and of those beyond what is claimed."""
    if not checks:
        return f"{counted(len(names), 'table')}; nothing could be judged"
    if beyond:
        return f"{listed(names)}: beyond what is claimed in {beyond} of {counted(checks, 'comparison')}"
    return f"{listed(names)}: within what is claimed in {'all ' if checks > 1 else ''}{counted(checks, 'comparison')}"


def recorded_tables(results: Sequence[CaseResult]) -> Table:
    """The recorded tables with their declarations, and how many of their numbers were compared and depart from an engine's."""
    counts = Column("compared", form="d"), Column("beyond", form="d")
    columns = (CASE, "table", "version", "origin", "status", Column("rows", form="d"), "columns", *counts, "source", "remark")
    table = Table(
        "recorded",
        "Recorded tables: results of other tools, earlier versions and measurements, with the declarations in their files.",
        columns,
    )
    for result in results:
        for run in result.recorded.values():
            checks = [check for check in result.table_checks if check.engine == run.engine]
            beyond = sum(not check.passed for check in checks)
            table.add(
                run.flat,
                compared=len(checks),
                beyond=Cell(beyond, mark="missed" if beyond else ""),
                case=result.case.name,
                table=run.engine,
                origin=_origin(run),
                status=Cell(run.status, mark="" if run.usable else "failed"),
                rows=0 if run.recording is None else run.recording.rows,
                columns=", ".join(channel_name(name) for name in run.cycle if name not in ("time", "crank_angle")),
                source=run.method,
            )
    return table


def _shown(value: float, unit: Unit | None) -> Cell:
    """A number in SI, which the page shows with its unit, if one is given."""
    return Cell(value, quantity(value, unit) if unit else "")


def _origin(run: Run) -> Cell:
    origin = run.recording.declared.get("origin", "") if run.recording else ""
    return Cell(origin or None, mark="open" if origin == "synthetic" else "")


def curve_comparison(halves: Sequence[MeasuredHalf], engines: Sequence[str]) -> Table:
    """First-mode frequency and amplitude of each engine over the recorded table's, per half cycle and channel."""

    def over_table(quantity: str) -> list[Column]:
        group, meaning = f"first-mode {quantity}", "engine / table"
        return [Column(f"{quantity}_{name}", name, "1", ".3f", group=group, meaning=meaning) for name in engines]

    columns: ColumnList = (
        *(CASE, "table", CHANNEL, "origin", HALF_COLUMN),
        Column("frequency", "table", "Hz", ".2f", uncertainty="frequency_uncertainty", group="first-mode frequency"),
        Column("frequency_uncertainty", unit="Hz", in_page=False),
        *over_table("frequency"),
        Column("amplitude", "table", "[SI]", ".3g", group="first-mode amplitude"),
        *over_table("amplitude"),
        Column("minimum", unit="[SI]", form=".3g", group="extremes of the table"),
        Column("maximum", unit="[SI]", form=".3g", group="extremes of the table"),
    )
    table = Table(
        "curve_comparison",
        """Engines over recorded tables: first-mode frequency and amplitude of the table, measured as in an engine's cycle, and the ratio of
        each engine's number to the table's. Extremes of measured or digitised tables are taken after a zero-phase low-pass at 200 Hz.""",
        columns,
    )
    for half in halves:
        unit = half.case.units.column(COLUMNS[half.measure.channel].unit)
        cells: dict[str, Any] = {"frequency_uncertainty": half.measure.first_mode_frequency_uncertainty}
        cells |= {name: _shown(getattr(half.measure, name), unit) for name in EXTREMES}
        for short in ("frequency", "amplitude"):
            value = getattr(half.measure, f"first_mode_{short}")
            shown = unit if short == "amplitude" else None
            cells[short] = Cell(None, UNRESOLVABLE, half.measure.reason, "open") if value is None else _shown(value, shown)
            for engine in engines:
                of_engine = getattr(half.engines.get(engine), f"first_mode_{short}", None)
                cells[f"{short}_{engine}"] = of_engine / value if of_engine is not None and value else None
        table.add(half.measure, case=half.case.name, table=half.table.engine, origin=_origin(half.table), **cells)
    return table


def table_departures(results: Sequence[CaseResult]) -> Table:
    """One row per number of a recorded table that differs from an engine's by more than claim and uncertainty of the measures."""
    of_tables = {"engine": Column("table"), "channel": replace(CHANNEL, head="column")}
    of_tables["other_value"] = Column("other_value", "engine's value", "[SI]", ".4g")
    table = Table(
        "table_departures",
        """Every number in which a recorded table and an engine differ by more than the uncertainty of the measures and the engine's own
        estimate together. Differences are relative to the engine's value; for an extreme they are relative to the column's largest
        magnitude in the turn. They are positive if the table's number is larger; for a minimum, if it is lower.""",
        [of_tables.get(column.key, column) for column in COMPARISON],
    )
    for result in results:
        for check in (check for check in result.table_checks if not check.passed):
            table.add(check, table=check.engine, **compared(result, check))
    return table
