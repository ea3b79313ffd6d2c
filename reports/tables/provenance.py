"""Engines, versions, machine, statuses, and the list of all tables."""

from collections.abc import Mapping, Sequence
from typing import Any

from cases.runs.comparison import CaseResult
from cases.runs.request import SETTLED
from engines.registry import engine
from reports.findings.agreement import engines_of
from reports.findings.failures import Trouble
from reports.tables.table import Cell, Column, Table, TableBuilder
from reports.words import case_label


def engines(results: Sequence[CaseResult]) -> Table:
    """One row per engine: method, version, default accuracy, how its runs ended."""
    builder = TableBuilder(
        "engines",
        "Engines, the libraries behind them, and how their runs ended.",
        (
            Column("engine", "engine"),
            Column("version", "version"),
            Column("method", "method"),
            Column("accuracy", "accuracy asked", "1", ".2g", "%", 100.0),
            Column("runs", "runs", form="d"),
            Column("settled", "settled", form="d"),
        ),
    )
    for name in engines_of(results):
        chosen = engine(name)
        reason = chosen.unavailable()
        runs = [result.runs[name] for result in results if name in result.runs]
        asked = sorted({run.accuracy or chosen.default_accuracy for run in runs})
        builder.add(
            engine=name,
            version=chosen.version() if reason is None else Cell(None, "not available", reason, "failed"),
            method=chosen.method,
            accuracy=asked[0],
            runs=len(runs),
            settled=sum(run.status == SETTLED for run in runs),
        )
    return builder.table()


def machine(facts: Mapping[str, str]) -> Table:
    """The machine on which the page was made."""
    builder = TableBuilder("machine", "Machine, software and time of this page.", (Column("what", "what"), Column("value", "value")))
    for what, value in facts.items():
        builder.add(what=what, value=value)
    return builder.table()


def troubles(found: Sequence[Trouble]) -> Table:
    """Every run that is not simply settled."""
    builder = TableBuilder(
        "failures",
        "Every run that did not simply settle.",
        (Column("case", "run"), Column("engine", "engine"), Column("status", "status"), Column("remark", "in the engine's words")),
    )
    for trouble in found:
        builder.add(
            case=Cell(trouble.case, case_label(trouble.case)),
            engine=trouble.engine,
            status=Cell(trouble.status, mark="failed" if trouble.is_failure else "open"),
            remark=trouble.remark,
        )
    return builder.table()


def catalogue(tables: Sequence[Table], about: Mapping[str, Any]) -> Table:
    """All CSV files beside the page."""
    builder = TableBuilder(
        "tables",
        "Every table of this report as a CSV file beside this page, in full precision and SI units.",
        (
            Column("file", "file"),
            Column("rows", "rows", form="d"),
            Column("what", "what"),
            *(Column(key, key, in_page=False) for key in about),
        ),
    )
    for table in tables:
        builder.add(file=table.file, rows=len(table.rows), what=table.caption, **about)
    return builder.table()
