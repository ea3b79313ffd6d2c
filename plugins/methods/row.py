"""A row of the race: an engine with some settings, or asked for an error, in a scene; its errors, and what they cost."""

import math
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from typing import Any, Final

from quickreturn.engines.error_parts import ESTIMATED
from quickreturn.engines.trajectory import Trajectory, relative_error

#: Errors at which methods are compared.
LEVELS: Final = (1e-2, 1e-3, 1e-4)
TIP: Final = "tip_deflection"
#: Status of a row whose settings were given and that has a result; the others are those of an engine that was asked for an error.
COMPLETED: Final = "completed"
REACHED, NOT_REACHED, WRONG, OWN_EQUATIONS = "reached", "not reached", "wrong", "own equations"
ENDED, TOO_SLOW, FAILED, REFUSED = "ended", "too slow", "failed", "refused"
MEANINGS: Final[Mapping[str, str]] = {
    REACHED: "its own estimate is within the error asked, and so is the solution that is known here",
    ENDED: "the slider leaves the follower, and up to shortly before that the run is accurate; the time is given",
    OWN_EQUATIONS: "the run solves the equations of its model as accurately as asked, but their solution is further off than asked",
    NOT_REACHED: "a result that its own estimate says is not as accurate as asked",
    TOO_SLOW: "the time of the race is not enough",
    FAILED: "the run broke down; the time and the cause are known",
    REFUSED: "the engine says that it cannot model this scene, and why",
    WRONG: "the engine claims an error that it does not keep",
}


@dataclass(frozen=True, kw_only=True)
class Row:
    """A row of a study. Times are in s. None: not measured, or there is no result."""

    scene: str  # name of the case
    engine: str
    variant: str = ""  # what distinguishes the combination from the engine's usual one: "hermite"
    settings: dict[str, Any] = field(default_factory=dict)
    signed: str = ""  # who chose the settings; "": the search, or the engine
    level: float | None = None  # error of the tip deflection that was asked for; None: the settings were given
    status: str = COMPLETED
    remark: str = ""
    errors: dict[str, float | None] = field(default_factory=dict)  # relative error of each column; None if it is zero throughout
    claim: float | None = None  # the engine's estimate of the error of the tip deflection
    calls: float | None = None  # evaluations of the right-hand side; of a package its time steps
    call_seconds: float | None = None  # for one of them: the least, measured in turns
    rows_seconds: float | None = None  # part of the solve time for the table of observables, where that is known
    solve_seconds: float | None = None  # from the prepared model to the finished table
    setup_seconds: float | None = None
    answer_seconds: float | None = None  # set-up and solve time of all runs of an answer to `level`
    time: float | None = None  # when the run broke down or the scene ended

    @property
    def method(self) -> str:
        """Name of the combination."""
        return f"{self.engine}, {self.variant}" if self.variant else self.engine

    @property
    def completed(self) -> bool:
        """Whether there is a result for given settings."""
        return self.status == COMPLETED

    @property
    def seconds(self) -> float:
        """Solve time; infinite without a result."""
        return math.inf if self.solve_seconds is None else self.solve_seconds

    @property
    def error(self) -> float | None:
        """Relative error of the tip deflection."""
        return self.errors.get(TIP)

    @property
    def worst(self) -> float | None:
        """The largest relative error of deflection, acceleration, strains and slider force."""
        return max((error for error in self.errors.values() if error is not None), default=None)


def by_method(rows: Iterable[Row]) -> dict[str, list[Row]]:
    """Combination -> its rows."""
    found: dict[str, list[Row]] = {}
    for row in rows:
        found.setdefault(row.method, []).append(row)
    return found


def errors_of(columns: Trajectory | Mapping[str, Any], truth: Trajectory) -> dict[str, float | None]:
    """Relative error of each column of `ESTIMATED` over the rows that both have; None if the truth is zero throughout."""
    rows = min(len(columns[TIP]), len(truth))
    errors = {column: relative_error(columns[column][:rows], truth[column][:rows]) for column in ESTIMATED}
    return {column: error if math.isfinite(error) else None for column, error in errors.items()}
