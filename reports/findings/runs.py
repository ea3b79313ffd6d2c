"""Which run of the thesis a case is."""

from collections.abc import Sequence
from typing import TYPE_CHECKING

from quickreturn.cases.library.thesis import RUNS, run_name

if TYPE_CHECKING:
    from quickreturn.cases.runs.comparison import CaseResult
    from quickreturn.cases.runs.request import Run


def run_number(case_name: str) -> int | None:
    """Number of the run whose library case has this name, None for any other case."""
    return {run_name(number): number for number in RUNS}.get(case_name)


def of_library(results: "Sequence[CaseResult]", name: str) -> "CaseResult | None":
    """The result of a case of the library, if it is among the cases shown. A user's case file of the same name does not count."""
    return next((result for result in results if result.case.name == name and result.case.source == "library"), None)


def thesis_runs(results: "Sequence[CaseResult]") -> "dict[int, CaseResult]":
    """The runs of the thesis among the cases shown, by number."""
    found = ((number, of_library(results, run_name(number))) for number in RUNS)
    return {number: result for number, result in found if result is not None}


def mean_crank_speed(run: "Run") -> float:
    """Mean crank speed over a run's cycle, rad/s."""
    angle, time = run.cycle["crank_angle"], run.cycle["time"]
    return float(angle[-1] - angle[0]) / float(time[-1] - time[0])
