"""Engines, versions, machine, statuses, and the list of all tables."""

from collections.abc import Mapping, Sequence
from typing import Any

from quickreturn.cases.runs.comparison import CaseResult
from quickreturn.cases.runs.endings import Ending
from quickreturn.cases.runs.request import Run
from quickreturn.engines.registry import OWN
from quickreturn.reports.findings.agreement import engines_of
from quickreturn.reports.tables.table import CASE, Cell, Column, Table


def engines(results: Sequence[CaseResult], conformance: Mapping[str, str]) -> Table:
    """One row per engine and recorded table: origin, version, conformance, method, default accuracy, status of its runs."""
    columns = (
        "engine",
        Column("origin", "from"),
        "version",
        Column("conformance", "does what it says", meaning="by quickreturn conform ENGINE, with this version"),
        "method",
        Column("accuracy", "accuracy asked", "%", ".2g"),
        Column("runs", form="d"),
        Column("settled", form="d"),
    )
    table = Table("engines", columns)
    for name in engines_of([result.with_tables for result in results]):
        runs = [run for result in results if (run := result.with_tables.runs.get(name)) is not None]
        first = runs[0]
        table.add(
            first,
            engine=name,
            origin="a file" if first.recording else "this project" if name in OWN else "another package",
            version=next((run.version for run in runs if run.version), None) or _no_version(first),
            conformance=None if first.recording else conformance.get(name, f"not tested: run quickreturn conform {name}"),
            runs=len(runs),
            settled=sum(run.status == Ending.SETTLED for run in runs),
        )
    return table


def _no_version(run: Run) -> Cell:
    if run.recording:
        return Cell(None)
    return Cell(None, "not available" if run.status == Ending.UNAVAILABLE else "unknown", run.remark, "failed")


def machine(facts: Mapping[str, str]) -> Table:
    """Facts about the computer on which the page was made."""
    table = Table("machine", ("what", "value"))
    for what, value in facts.items():
        table.add(what=what, value=value)
    return table


def troubles(runs: Sequence[tuple[str, Run]]) -> Table:
    """Every run that is not simply settled, with the name of its case."""
    table = Table("failures", (CASE, "engine", "status", Column("remark", "in the engine's words")))
    for case, run in runs:
        table.add(run, case=case, status=Cell(run.status, mark="failed" if run.ending.incomplete else "open"))
    return table


def catalogue(tables: Sequence[Table], about: Mapping[str, Any]) -> Table:
    """All CSV files beside the page."""
    catalogue_table = Table("tables", ("file", Column("rows", form="d"), "what", *(Column(key, in_page=False) for key in about)))
    for table in tables:
        catalogue_table.add(file=table.file, rows=len(table.rows), what=table.caption, **about)
    return catalogue_table
