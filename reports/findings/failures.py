"""Runs without a full result."""

from collections.abc import Sequence

from quickreturn.cases.runs.comparison import CaseResult
from quickreturn.cases.runs.endings import Ending
from quickreturn.cases.runs.request import Run


def troubles(results: Sequence[CaseResult]) -> list[tuple[str, Run]]:
    """All runs that are not simply settled, each with the name of its case, in the order of the cases."""
    return [(result.case.name, run) for result in results for run in result.runs.values() if run.status != Ending.SETTLED]
