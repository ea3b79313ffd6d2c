"""A study: the rows of a grid are computed and stored one by one, and combined point by point."""

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from quickreturn.cases.motion.endings import Ending
from quickreturn.cases.running.isolation import STOPPED
from quickreturn.cases.running.job import Job, Outcome
from quickreturn.cases.running.workshop import Workshop
from quickreturn.plugins.studies.sweep.grid import Grid, job
from quickreturn.plugins.studies.sweep.rows import MeasureRequest, Row
from quickreturn.reference_model.arrays import Array


@dataclass(frozen=True)
class Study:
    """The measured points of a grid."""

    grid: Grid  # the case and its axes
    asked: MeasureRequest  # what was measured
    values: Array  # values of each measure, shape (*grid, measures); nan if unavailable
    errors: Array  # errors of the values by the engine's own estimate, likewise
    statuses: NDArray[np.object_]  # status of each point, shape (*grid,)
    sentences: NDArray[np.object_]  # reason of each status, "" if the point settled

    @property
    def counts(self) -> dict[str, int]:
        """Status -> number of points, the most frequent first."""
        return dict(Counter(map(str, self.statuses.flat)).most_common())


def study(grid: Grid, asked: MeasureRequest, workshop: Workshop) -> Study:
    """Compute a grid.

    Raises:
        KeyboardInterrupt: Ctrl-C; the rows that were computed are stored.
        UnknownEngine: there is no engine of a name.
    """
    along = grid.along
    values, errors = (np.full((*grid.shape, len(asked.measures)), np.nan) for _ in range(2))
    statuses, sentences = (np.full(grid.shape, "", dtype=object) for _ in range(2))
    jobs, places = list[Job[Row]](), list[Any]()
    for place in grid.rows():
        where: tuple[int | slice, ...] = (*place[:-1], slice(place[-1], place[-1] + 1))
        points = [place]
        if along is not None:
            before, behind = place[:along], place[along + 1 :]
            where = (*before, slice(None), *behind)
            points = [(*before, at, *behind) for at in range(grid.shape[along])]
        changes = [grid.changes(each) for each in points]
        jobs.append(job(grid.case, changes, replace(asked, engine=grid.engine_at(place, asked.engine))))
        places.append(where)
    for at, row in zip(places, computed(jobs, workshop), strict=True):
        values[at], errors[at], statuses[at], sentences[at] = row.values, row.errors, row.statuses, row.sentences
    return Study(grid, asked, values, errors, statuses, sentences)


def computed(jobs: Sequence[Job[Row]], workshop: Workshop) -> list[Row]:
    """The rows of jobs. Where a process died, each point gets a process of its own, so that one failure costs no other point.

    The points of a row that exceeded its time share as much time again. A row of one point is not tried twice.
    """
    return [outcome.value or _point_by_point(outcome, workshop) for outcome in workshop.outcomes(jobs, "points")]


def joined(rows: Sequence[Row]) -> Row:
    """Several rows joined to one."""
    values, errors = (np.concatenate([getattr(row, name) for row in rows]) for name in ("values", "errors"))
    statuses, sentences = (tuple(text for row in rows for text in getattr(row, name)) for name in ("statuses", "sentences"))
    return Row(values, errors, statuses, sentences)


def _point_by_point(died: Outcome[Row], workshop: Workshop) -> Row:
    case, changes, asked = died.job.arguments
    outcomes = [died]
    if len(changes) > 1:
        limits, given = None, workshop.executor.limits
        if died.failure.startswith(STOPPED) and given.seconds is not None:
            limits = replace(given, seconds=given.seconds / len(changes))
        points = [replace(job(case, [each], asked), limits=limits) for each in changes]
        outcomes = workshop.outcomes(points, "points of a row whose process died")
    nothing = np.full((1, len(asked.measures)), np.nan)
    return joined([each.value or Row(nothing, nothing, (Ending.FAILED,), (f"its process {each.explanation}",)) for each in outcomes])
