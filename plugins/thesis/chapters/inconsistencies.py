"""Published inconsistencies: contradictions and gaps of the thesis, and the values that are used instead."""

from collections.abc import Sequence

from quickreturn.cases.library.thesis import RUNS
from quickreturn.cases.library.thesis.inconsistencies import Inconsistency, inconsistencies
from quickreturn.plugins.thesis.page_data import ThesisData
from quickreturn.reports.page.chapter import Chapter
from quickreturn.reports.tables import Column, Table
from quickreturn.reports.words import counted


def published_inconsistencies(_: ThesisData) -> Chapter:
    """The chapter."""
    rows = inconsistencies()
    return Chapter("inconsistencies", "Published inconsistencies", finding(len(rows)), {"table": inconsistency_table(rows)})


def finding(count: int) -> str:
    """The number of contradictions and gaps."""
    return f"{counted(count, 'contradiction or gap', 'contradictions and gaps')} in the published data, none corrected silently"


def inconsistency_table(rows: Sequence[Inconsistency]) -> Table:
    """Contradictions and gaps of the thesis."""
    table = Table(
        "inconsistencies",
        "Published inconsistencies and gaps, and the values that are used here instead. Nothing is corrected silently.",
        ("runs", "what", "published", Column("used", "used here"), Column("reason", "because")),
    )
    for row in rows:
        table.add(row, runs=_runs(row.runs))
    return table


def _runs(numbers: Sequence[int]) -> str:
    if tuple(numbers) == tuple(RUNS):
        return "all"
    if len(numbers) > 2 and list(numbers) == list(range(numbers[0], numbers[-1] + 1)):
        return f"{numbers[0]} to {numbers[-1]}"
    return ", ".join(map(str, numbers))
