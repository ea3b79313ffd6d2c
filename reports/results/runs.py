"""Results of library cases, and the mean speed of a run."""

from collections.abc import Sequence
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from quickreturn.cases.runs.comparison import CaseResult
    from quickreturn.cases.runs.request import Run


def of_library(results: "Sequence[CaseResult]", name: str) -> "CaseResult | None":
    """The result of a case of the library, if it is among the cases shown. A user's case file of the same name does not count."""
    return next((result for result in results if result.case.name == name and result.case.source == "library"), None)


def settled_speed(result: "CaseResult") -> float | None:
    """Mean crank speed (rad/s) of the settled motion by `reference`, or else by the first engine that has one; None without one."""
    usable = {name: run for name, run in result.runs.items() if run.usable}
    return mean_crank_speed(usable.get("reference", next(iter(usable.values())))) if usable else None


def mean_crank_speed(run: "Run") -> float:
    """Mean crank speed over a run's cycle, rad/s."""
    angle, time = run.cycle["crank_angle"], run.cycle["time"]
    return float(angle[-1] - angle[0]) / float(time[-1] - time[0])
