"""Facts of the chapters on the next steps, the provenance and the files."""

import shlex
from collections.abc import Sequence
from typing import Any

from quickreturn.cases.runs.endings import Ending
from quickreturn.reports.page.content import Content
from quickreturn.reports.tables import engines as engine_tables
from quickreturn.reports.tables import provenance as tables
from quickreturn.reports.tables.table import Column, Table


def next_steps(content: Content) -> dict[str, Any]:
    """The facts for `chapters/next.html`."""
    case = content.results[0].case
    return {
        "file": shlex.quote(case.source if case.source not in ("", "library") else case.name),
        "crank_length": case.mechanism.crank.length,
        "failures": [(result.case, run) for result in content.results for run in result.failures],
        "departing": [result.case.name for result in content.results if result.missed],
        "measured": bool(content.benchmarks),
    }


def provenance(content: Content) -> dict[str, Any]:
    """The facts for `chapters/provenance.html`: engines, versions, machine, settings, failures, assumptions, verification."""
    runs = [run for result in content.results for run in result.runs.values()]
    return {
        "troubles": content.troubles,
        "meanings": {ending.value: ending.sentence for ending in Ending if ending in {run.status for _, run in content.troubles}},
        "settled": Ending.SETTLED.sentence,
        "of_integration": list(dict.fromkeys(run.engine for run in runs if run.usable and run.estimate_of == "integration")),
        "study_failures": () if content.studies is None else content.studies.failures,
        "notices": content.notices,
        "assumed": content.assumed,
        "date": content.facts.get("date", ""),
        "verification": content.verification,
        "failures": tables.troubles(content.troubles),
        "engines": tables.engines(content.results, content.conformance),
        "machine": tables.machine({**content.facts, "code": content.code}),
        "settings": engine_tables.settings(content.results),
        "verified": [_table(index, part) for index, part in enumerate(content.verification.chapters, start=1)],
    }


def _table(number: int, part: dict[str, Any]) -> Table:
    heads, rows = part["columns"], part["rows"]
    forms = [".4g" if any(isinstance(row[i], float) for row in rows) else "" for i in range(len(heads))]
    columns = [Column(f"column_{i}", str(head), form=form) for i, (head, form) in enumerate(zip(heads, forms, strict=True))]
    table = Table("verification_", columns, of=str(number), title=part["title"])
    for row in rows:
        table.add(**{column.key: value for column, value in zip(columns, row, strict=True)})
    return table


def files(content: Content, listed: Sequence[Table]) -> dict[str, Any]:
    """The facts for `chapters/files.html`: the list of all CSV files with tables `listed`, and their number."""
    about = {"date": content.facts.get("date", ""), "code": content.code}
    return {"count": len(listed), "table": tables.catalogue(listed, about)}
