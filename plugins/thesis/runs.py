"""The runs of the thesis among the cases of a report."""

from collections.abc import Sequence

from quickreturn.cases.comparison.engines import CaseResult
from quickreturn.cases.library.thesis.runs import RUNS, run_name
from quickreturn.reports.page.content import of_library


def thesis_runs(results: Sequence[CaseResult]) -> dict[int, CaseResult]:
    """The runs of the thesis among the cases shown, by number."""
    results_by_number = ((number, of_library(results, run_name(number))) for number in RUNS)
    return {number: result for number, result in results_by_number if result is not None}
