"""Who agrees with whom, and every run on every engine."""

from collections.abc import Sequence
from typing import Any

from cases.runs.comparison import HALVES, REFERENCE, CaseResult, not_judged
from reports.findings.agreement import differences, engines_of, resolvable
from reports.findings.verdicts import MODEL
from reports.page.answer import answer_of
from reports.page.content import Content
from reports.tables import claims, engines
from reports.tables.table import Cell, Column, Mark, Table, TableBuilder
from reports.words import case_label, percent


def agreement(content: Content) -> dict[str, Any] | None:
    """None where there is one engine alone."""
    results = content.results
    names = engines_of(results)
    if len(names) < 2:
        return None
    checks = [check for result in results for check in result.checks]
    judged = {check.engine for check in checks} | {check.other for check in checks}
    return {
        "answer": answer_of(content),
        "checks": len(checks),
        "missed": [check for check in checks if not check.passed],
        "cases": [result.case.name for result in results if result.missed],
        "reasons": list(dict.fromkeys(result.reason for result in results if result.reason)),
        "unjudged": {name: _why(results, name) for name in names if name not in judged},
        "model": MODEL,
        "map": run_map(results),
        "summary": claims.summary(results),
        "departures": claims.departures(results),
        "classes": claims.classes(results),
    }


def _why(results: Sequence[CaseResult], name: str) -> str:
    return next((why for result in results if name in result.runs and (why := not_judged(result.runs[name]))), "nothing to compare with")


def run_map(results: Sequence[CaseResult]) -> Table:
    """A row per case, a column per engine: how far its first-mode frequency is from the reference's, and whether it departs."""
    names = [name for name in engines_of(results) if name != REFERENCE]
    builder = TableBuilder(
        "map",
        f"Larger of the differences to {REFERENCE} in first-mode frequency (consensus of the channels) before and after the return, and in"
        " how many numbers the two differ by more than they claim. A cell opens its run.",
        (
            Column("case", "run"),
            *(
                column
                for name in names
                for column in (
                    Column(f"{name}_frequency_difference", name, "1", "+.2f", "%", 100.0),
                    Column(f"{name}_beyond", f"{name} beyond", form="d", in_page=False),
                )
            ),
        ),
    )
    for result in results:
        cells: dict[str, Any] = {"case": Cell(result.case.name, case_label(result.case.name), run=result.case.name)}
        for name in names:
            if name in result.runs:
                beyond = sum(not check.passed for check in result.checks if check.engine == name)
                cells[f"{name}_frequency_difference"] = _map_cell(result, name, beyond)
                cells[f"{name}_beyond"] = beyond
        builder.add(**cells)
    return builder.table()


def _map_cell(result: CaseResult, name: str, beyond: int) -> Cell:
    run = result.runs[name]
    if not run.usable:
        return Cell(None, run.status, run.remark, "failed", result.case.name)
    found = [found.relative for half in HALVES for found in differences([result], name, "frequency", half=half)]
    largest = max(found, key=abs, default=None)
    mark: Mark = "missed" if beyond else "open" if not_judged(run) else "good"
    text = "n. r." if largest is None else percent(largest, "+.2f")
    return Cell(largest, f"{text} ({beyond} beyond)" if beyond else text, not_judged(run), mark, result.case.name)


def runs(content: Content) -> dict[str, Any]:
    """All measures."""
    names = engines_of(content.results)
    return {
        "troubles": content.troubles,
        "cases": len(content.results),
        "resolved": {name: resolvable(content.results, name) for name in names},
        "table": engines.run_by_engine(content.results),
        "measures": engines.measures(content.results),
    }
