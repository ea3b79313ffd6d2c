"""Recorded tables: what they are, and how far the engines lie from them."""

from typing import Any

from reports.findings.agreement import engines_of
from reports.page.content import Content
from reports.tables import experiment as tables
from reports.tables.claims import table_departures


def recorded(content: Content) -> dict[str, Any] | None:
    """None where no table was given."""
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
