"""Runs without a full result, and whether that counts as a failure of the report."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

from cases.runs.comparison import CaseResult
from cases.runs.request import FAILED, INACCURATE, NOT_SETTLED, REFUSED, SETTLED, UNAVAILABLE

#: Status -> what it means to a reader.
MEANINGS: Final = {
    SETTLED: "reached its steady state, and by its own estimate the accuracy asked",
    INACCURATE: "reached its steady state, but its own estimate misses the accuracy asked; its numbers are used and marked",
    NOT_SETTLED: "did not repeat from cycle to cycle within the number of cycles allowed; its numbers are not used",
    FAILED: "broke down; its numbers are not used",
    REFUSED: "says that it cannot model this scene",
    UNAVAILABLE: "cannot be used on this machine",
}


@dataclass(frozen=True)
class Trouble:
    """A run that is not simply settled."""

    case: str
    engine: str
    status: str
    remark: str

    @property
    def is_failure(self) -> bool:
        """Whether the engine did not complete. One that says what it cannot model has done what it should."""
        return self.status in (FAILED, NOT_SETTLED, UNAVAILABLE)


def troubles(results: Sequence[CaseResult]) -> list[Trouble]:
    """All of them, in the order of the cases."""
    return [
        Trouble(result.case.name, name, run.status, run.remark)
        for result in results
        for name, run in result.runs.items()
        if run.status != SETTLED
    ]
