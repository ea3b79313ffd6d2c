"""Run by run: notes, numbers and failures of each case; its curves are drawn by the script."""

from typing import Any

from cases.library import inconsistencies
from cases.library.thesis import RUNS
from reports.page.content import Content
from reports.tables.engines import case_table


def run_by_run(content: Content) -> dict[str, Any]:
    """One section per case; what is said of every run of the thesis has a chapter of its own."""
    general = {found.sentence for found in inconsistencies() if set(found.runs) == set(RUNS)}
    sections = [
        {
            "case": result.case,
            "notes": [note for note in result.case.notes if note not in general],
            "failures": result.failures,
            "departures": result.departures,
            "table": case_table(result),
        }
        for result in content.results
    ]
    return {"sections": sections, "tables": [section["table"] for section in sections]}
