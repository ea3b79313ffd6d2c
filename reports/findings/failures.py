"""Runs without a full result, and the statuses that count as a failure of the report."""

from collections.abc import Sequence
from typing import Final

from quickreturn.cases.runs.comparison import CaseResult
from quickreturn.cases.runs.request import FAILED, INACCURATE, NOT_SETTLED, REFUSED, SETTLED, UNAVAILABLE, Run

#: Status -> its meaning for a reader.
MEANINGS: Final = {
    SETTLED: "reached its steady state, and by its own estimate the accuracy asked",
    INACCURATE: "reached its steady state, but its own estimate misses the accuracy asked; its numbers are used and marked",
    NOT_SETTLED: "did not repeat from cycle to cycle within the number of cycles allowed; its numbers are not used",
    FAILED: "broke down; its numbers are not used",
    REFUSED: "says that it cannot model this scene",
    UNAVAILABLE: "cannot be used on this machine",
}


#: Statuses of an engine that did not complete. An engine that refuses a scene which it cannot model has done its duty.
INCOMPLETE: Final = (FAILED, NOT_SETTLED, UNAVAILABLE)


def troubles(results: Sequence[CaseResult]) -> list[tuple[str, Run]]:
    """All runs that are not simply settled, each with the name of its case, in the order of the cases."""
    return [(result.case.name, run) for result in results for run in result.runs.values() if run.status != SETTLED]
