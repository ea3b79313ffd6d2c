"""Facts of the chapters on every run and engine, on recorded tables, and run by run; the script draws the curves."""

from typing import Any

from quickreturn.reports.findings.agreement import engines_of, outward, resolvable
from quickreturn.reports.page.content import Content
from quickreturn.reports.tables import engines
from quickreturn.reports.tables import recorded as tables
from quickreturn.reports.tables.claims import table_departures


def runs(content: Content) -> dict[str, Any]:
    """The facts for `chapters/runs.html`: all measures."""
    names = engines_of(content.results)
    return {
        "troubles": content.troubles,
        "resolved": {name: resolvable(content.results, name) for name in names},
        "table": engines.run_by_engine(content.results),
        "measures": engines.measures(content.results),
    }


def recorded(content: Content) -> dict[str, Any] | None:
    """The facts for `chapters/recorded.html`; None if no recorded table was given."""
    runs = [run for result in content.results for run in result.recorded.values()]
    if not runs:
        return None
    checks = [check for result in content.results for check in result.table_checks]
    return {
        "names": [run.engine for run in runs],
        "synthetic": [run.engine for run in runs if run.recording and run.recording.declared.get("origin") == "synthetic"],
        "checks": len(checks),
        "missed": sum(not check.passed for check in checks),
        "tables": tables.recorded(content.results),
        "comparison": tables.curve_comparison(content.comparisons, engines_of(content.results)),
        "departures": table_departures(content.results),
    }


def run_by_run(content: Content) -> dict[str, Any]:
    """The facts for `chapters/each.html`: one section per case, without the notes that another chapter gives."""
    sections = [
        {
            "case": result.case,
            "notes": [note for note in result.case.notes if note not in content.general_notes],
            "failures": result.failures,
            "departures": result.departures,
            "table": engines.case_table(result),
        }
        for result in content.results
    ]
    return {"sections": sections, "outward": outward, "tables": [section["table"] for section in sections]}
