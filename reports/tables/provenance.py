"""Engines, versions, machine, statuses, and the list of all tables."""

from collections.abc import Mapping, Sequence
from typing import Any

from cases.runs.comparison import CaseResult
from cases.runs.request import SETTLED, UNAVAILABLE, Run
from engines.registry import OWN
from reports.findings.agreement import engines_of
from reports.findings.failures import Trouble
from reports.tables.table import CASE, Cell, Column, Table, TableBuilder


def engines(results: Sequence[CaseResult], conformance: Mapping[str, str]) -> Table:
    """One row per engine and recorded table: whose it is, version, conformance, method, default accuracy, how its runs ended."""
    builder = TableBuilder(
        "engines",
        "Engines, the libraries behind them, recorded tables, and how their runs ended.",
        (
            Column("engine", "engine"),
            Column("origin", "from"),
            Column("version", "version"),
            Column("conformance", "does what it says", meaning="`quickreturn conform ENGINE` with this version"),
            Column("method", "method"),
            Column("accuracy", "accuracy asked", "1", ".2g", "%", 100.0),
            Column("runs", "runs", form="d"),
            Column("settled", "settled", form="d"),
        ),
    )
    for name in engines_of([result.whole for result in results]):
        runs = [run for result in results if (run := result.whole.runs.get(name)) is not None]
        first = runs[0]
        builder.add(
            engine=name,
            origin="a file" if first.recording else "this project" if name in OWN else "another package",
            version=next((run.version for run in runs if run.version), None) or _no_version(first),
            conformance=None if first.recording else conformance.get(name, f"not tested: run quickreturn conform {name}"),
            method=first.method,
            accuracy=first.accuracy,
            runs=len(runs),
            settled=sum(run.status == SETTLED for run in runs),
        )
    return builder.table()


def _no_version(run: Run) -> Cell:
    return Cell(None) if run.recording else Cell(None, "not available" if run.status == UNAVAILABLE else "unknown", run.remark, "failed")


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
        (CASE, Column("engine", "engine"), Column("status", "status"), Column("remark", "in the engine's words")),
    )
    for trouble in found:
        builder.add(trouble, status=Cell(trouble.status, mark="failed" if trouble.is_failure else "open"))
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
