"""Provenance: engines, versions, machine, settings, statuses, assumptions, verification."""

from collections.abc import Mapping, Sequence
from typing import Any

from quickreturn.cases.comparison.engines import CaseResult
from quickreturn.cases.motion.endings import Ending
from quickreturn.cases.motion.request import Run
from quickreturn.engines.error_parts import TIP
from quickreturn.engines.registry import own_engines
from quickreturn.reports.engine_differences import engines_of
from quickreturn.reports.page.chapter import Chapter
from quickreturn.reports.page.content import Content, Verification
from quickreturn.reports.page.part import parts
from quickreturn.reports.tables import CASE, Cell, Column, ColumnList, Table
from quickreturn.reports.words import counted, settings_words


def provenance(content: Content) -> Chapter:
    """The chapter."""
    runs = [run for result in content.results for run in result.runs.values()]
    engine_table = engines(content)
    facts = {
        "meanings": {ending.value: ending.sentence for ending in Ending if ending in {run.status for _, run in content.troubles}},
        "settled": Ending.SETTLED.sentence,
        "of_integration": list(dict.fromkeys(run.engine for run in runs if run.usable and run.estimate_of == "integration")),
        "notices": content.notices,
        "assumed": content.assumed,
        "date": content.facts.get("date", ""),
        "verification": content.verification,
        "failures": troubles(content.troubles),
        "engines": engine_table,
        "machine": machine({**content.facts, "code": content.code}),
        "settings": settings(content.results),
        "verified": [_verified(index, part) for index, part in enumerate(content.verification.chapters, start=1)],
    }
    return Chapter("provenance", "Provenance", finding(len(engine_table.rows), len(content.troubles), content.verification), facts)


def finding(engines: int, troubles: int, verification: Verification) -> str:
    """The number of engines, and of runs that are not simply settled, and whether there is a long verification."""
    unsettled = f"; {counted(troubles, 'run')} not simply settled" if troubles else ""
    verified = "no long verification" if verification.absent else f"verified on {verification.date}"
    return f"{counted(engines, 'engine')}, versions, machine, settings{unsettled}; {verified}"


def engines(content: Content) -> Table:
    """One row per engine and recorded table: origin, version, method, default accuracy, status of its runs, and what plugins say of it."""
    results, of_engines = content.results, {name: content.of(say) for part in parts() for name, say in part.of_engines.items()}
    columns: ColumnList = (
        "engine",
        Column("origin", "from"),
        "version",
        *of_engines,
        "method",
        Column("accuracy", "accuracy asked", "%", ".2g"),
        Column("runs", form="d"),
        Column("settled", form="d"),
    )
    table = Table("engines", "Engines, the libraries behind them, recorded tables, and how their runs ended.", columns)
    for name in engines_of([result.with_tables for result in results]):
        runs = [run for result in results if (run := result.with_tables.runs.get(name)) is not None]
        first = runs[0]
        table.add(
            first.flat,
            engine=name,
            origin="a file" if first.recording else "this project" if name in own_engines() else "another package",
            version=next((run.version for run in runs if run.version), None) or _no_version(first),
            runs=len(runs),
            settled=sum(run.status == Ending.SETTLED for run in runs),
            **{heading: None if first.recording else said.get(name) for heading, said in of_engines.items()},
        )
    return table


def _no_version(run: Run) -> Cell:
    if run.recording:
        return Cell(None)
    return Cell(None, "not available" if run.status == Ending.UNAVAILABLE else "unknown", run.remark, "failed")


def machine(facts: Mapping[str, str]) -> Table:
    """Facts about the computer on which the page was made."""
    table = Table("machine", "Machine, software and time of this page.", ("what", "value"))
    for what, value in facts.items():
        table.add(what=what, value=value)
    return table


def troubles(runs: Sequence[tuple[str, Run]]) -> Table:
    """Every run that is not simply settled, with the name of its case."""
    columns = (CASE, "engine", "status", Column("remark", "in the engine's words"))
    table = Table("failures", "Every run whose status is not “settled”.", columns)
    for case, run in runs:
        table.add(run.flat, case=case, status=Cell(run.status, mark="failed" if run.ending.incomplete else "open"))
    return table


def settings(results: Sequence[CaseResult]) -> Table:
    """Settings of each engine on each case."""
    columns: ColumnList = (
        *(CASE, "engine"),
        Column("accuracy", "asked", "%", ".2g"),
        Column("error_estimate", "estimate", "%", ".2g"),
        Column("degrees_of_freedom", form="d"),
        Column("start", "marched from"),
        Column("cycles", form="d", meaning="until settled"),
        Column("settling_error", "distance from steady", "%", ".2g", meaning="estimated, of the last cycle"),
        "settings",
    )
    table = Table(
        "settings",
        """Settings per run and engine. They follow from the accuracy asked. The estimate is the engine's own, for the tip deflection: over
        two cycles if it marched from the periodic state, otherwise over the case's duration from the standard start. The estimate of thesis
        covers only the integration of its own equations. Marched from: the state in which the cycles began; the reference finds its steady
        state without marching.""",
        columns,
    )
    for result in results:
        for run in result.runs.values():
            text = settings_words(run.computation.settings or {}) or "none: the run ended before"
            estimate = Cell(run.computation.error_estimate, note="; ".join(map(str, run.computation.error_parts.get(TIP, ()))))
            start = run.approach.start or Cell(None, note=run.status)
            table.add(run.flat, case=result.case.name, error_estimate=estimate, start=start, settings=text)
    return table


def _verified(number: int, part: dict[str, Any]) -> Table:
    """The table of a chapter of the verification."""
    heads, rows = part["columns"], part["rows"]
    forms = [".4g" if any(isinstance(row[i], float) for row in rows) else "" for i in range(len(heads))]
    columns = [Column(f"column_{i}", str(head), form=form) for i, (head, form) in enumerate(zip(heads, forms, strict=True))]
    table = Table(f"verification_{number}", part["title"], columns)
    for row in rows:
        table.add(**{column.key: value for column, value in zip(columns, row, strict=True)})
    return table
