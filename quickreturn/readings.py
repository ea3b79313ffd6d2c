"""What plugins read off results apart from the catalogue's measures, by name, such as "loads"."""

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from functools import cache
from typing import TYPE_CHECKING, Any

from quickreturn.cases.files.case import Case
from quickreturn.cases.files.shown import Cell
from quickreturn.cases.motion.solving import TrajectoryRequest
from quickreturn.cases.running.job import Job
from quickreturn.engines.accurate import Result
from quickreturn.engines.plugins import entries, found
from quickreturn.reference_model.mechanism import Mechanism

if TYPE_CHECKING:  # a trajectory does not need it, and it takes long to load
    from quickreturn.cases.motion.request import Run


@dataclass(frozen=True, kw_only=True)
class Reading:
    """What a plugin reads off a trajectory or a run: its value, and how it is shown.

    Attributes:
        job: the job that gives the value of a trajectory.
        of_run: the value of a run; None if it has no usable cycle.
        document: a value -> its entry in JSON documents, under the name of the reading; {} of None.
        of_simulation: case, result and value -> rows of the table of `simulate`, each a name and a text.
        lines: results of engines on a case (`CaseResult`) -> lines in the text of `run`.
        rows: the same results -> rows of a table, each column -> value.
    """

    job: Callable[[TrajectoryRequest, Result], Job[Any]]
    of_run: "Callable[[Mechanism, Run], Any]"
    document: Callable[[Any], Mapping[str, Any]]
    of_simulation: Callable[[Case, Result, Any], Iterable[tuple[str, Cell]]]
    lines: Callable[[Any], Iterable[str]]
    rows: Callable[[Any], Iterable[dict[str, Any]]]


@cache
def readings() -> Mapping[str, Reading]:
    """The readings of the installed plugins by name."""
    return {name: found(place) for name, place in entries("readings").items()}
