"""Tables of recorded tables, and of their comparison with the engines."""

from collections.abc import Sequence
from typing import Any

from quickreturn.cases.runs.comparison import CaseResult
from quickreturn.cases.runs.request import Run
from quickreturn.reports.findings.measured import MeasuredHalf
from quickreturn.reports.tables.table import CASE, CHANNEL, HALF_COLUMN, Cell, Column, ColumnList, Table
from quickreturn.reports.words import channel_name


def recorded(results: Sequence[CaseResult]) -> Table:
    """The recorded tables with their declarations, and how many of their numbers were compared and depart from an engine's."""
    counts = Column("compared", form="d"), Column("beyond", form="d")
    columns = (CASE, "table", "version", "origin", "status", Column("rows", form="d"), "columns", *counts, "source", "remark")
    table = Table("recorded", columns)
    for result in results:
        for run in result.recorded.values():
            checks = [check for check in result.table_checks if check.engine == run.engine]
            beyond = sum(not check.passed for check in checks)
            table.add(
                run,
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
        Column("amplitude", "table", "SI", ".3g", group="first-mode amplitude"),
        *over_table("amplitude"),
        Column("minimum", unit="SI", form=".3g", group="extremes of the table"),
        Column("maximum", unit="SI", form=".3g", group="extremes of the table"),
    )
    table = Table("curve_comparison", columns)
    for half in halves:
        cells: dict[str, Any] = {"frequency_uncertainty": half.measure.first_mode_frequency_uncertainty}
        for short in ("frequency", "amplitude"):
            value = getattr(half.measure, f"first_mode_{short}")
            cells[short] = Cell(None, "n. r.", half.measure.reason, "open") if value is None else value
            for engine in engines:
                of_engine = getattr(half.engines.get(engine), f"first_mode_{short}", None)
                cells[f"{short}_{engine}"] = of_engine / value if of_engine is not None and value else None
        table.add(half.measure, case=half.case.name, table=half.table.engine, origin=_origin(half.table), **cells)
    return table
