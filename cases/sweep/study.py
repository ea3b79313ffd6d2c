"""A study: the rows of a grid, computed and stored one by one, put together again point by point."""

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Final, Literal

import numpy as np
from numpy.typing import NDArray

from cases.jobs.job import Outcome
from cases.jobs.workshop import Workshop
from cases.runs.request import FAILED, SETTLED
from cases.sweep.grid import Grid, job
from cases.sweep.rows import Asked, Row

#: Which way the points of a row are gone through: as they are given, backwards, or both.
Path = Literal["up", "down", "both"]
#: Numbers that differ by so many times what both claim, or by this part where nothing is claimed, are of two motions.
TWO: Final = 3.0
APART: Final = 0.02


@dataclass(frozen=True)
class Study:
    """What came of a grid.

    Attributes:
        grid: the case and its axes.
        asked: what was measured.
        ways: "up", "down" or both.
        values: of each measure, shape (ways, *grid, measures); nan where it is not to be had.
        errors: how far off each may be by the engine's own estimate, likewise.
        statuses: how each point ended, shape (ways, *grid).
        sentences: why, "" where it settled.
    """

    grid: Grid
    asked: Asked
    ways: tuple[str, ...]
    values: NDArray[np.float64]
    errors: NDArray[np.float64]
    statuses: NDArray[np.object_]
    sentences: NDArray[np.object_]

    @property
    def counts(self) -> dict[str, int]:
        """Status -> number of points that ended so, the commonest first."""
        return dict(Counter(map(str, self.statuses.flat)).most_common())

    @property
    def two_motions(self) -> NDArray[np.bool_]:
        """Where the ways settle on two stable motions, shape (*grid)."""
        if len(self.ways) < 2:
            return np.zeros(self.grid.shape, dtype=bool)
        known = [place for place, name in enumerate(self.asked.measures) if name != "solve_seconds"]
        one, other = self.values[..., known]
        claimed = np.nan_to_num(np.nansum(self.errors[..., known], axis=0))
        least = np.maximum(TWO * claimed, APART * np.fmax(np.abs(one), np.abs(other)))
        both = np.all(self.statuses == SETTLED, axis=0)
        return np.asarray(both & np.any(np.abs(one - other) > least, axis=-1))


def study(grid: Grid, asked: Asked, workshop: Workshop, path: Path = "up") -> Study:
    """Compute a grid.

    Raises:
        KeyboardInterrupt: Ctrl-C; the rows that were computed are stored.
        UnknownEngine: see there.
    """
    ways = ("up", "down") if path == "both" else (path,)
    begun = [(way, place) for way in ways for place in grid.rows()]
    asked_of = [replace(asked, engine=grid.engine_at(place, asked.engine)) for _, place in begun]
    rows = [_Row(grid, way, place, one) for (way, place), one in zip(begun, asked_of, strict=True)]
    outcomes = workshop.outcomes([each.job for each in rows], "points")
    found = [each.result(outcome, workshop) for each, outcome in zip(rows, outcomes, strict=True)]
    return _together(grid, asked, ways, begun, found)


class _Row:
    """A row of the grid that begins at a place, and the changes of its points in the order in which they are computed."""

    def __init__(self, grid: Grid, way: str, place: tuple[int, ...], asked: Asked) -> None:
        along = grid.along
        places = [(*place[:along], at, *place[along + 1 :]) for at in range(grid.shape[along])]
        self._changes = [grid.overrides(each) for each in (reversed(places) if way == "down" else places)]
        self._case, self._asked = grid.case, asked
        self.job = job(grid.case, self._changes, asked)

    def result(self, outcome: Outcome[Row], workshop: Workshop) -> Row:
        """The row; where its process died, its points each in a process of its own, so that one costs no other."""
        if outcome.value is not None:
            return outcome.value
        alone = [job(self._case, [each], self._asked) for each in self._changes]
        outcomes = workshop.outcomes(alone, "points of a row whose process died")
        parts = [each.value or self._lost(each) for each in outcomes]
        return Row(
            np.concatenate([part.values for part in parts]),
            np.concatenate([part.errors for part in parts]),
            tuple(part.statuses[0] for part in parts),
            tuple(part.sentences[0] for part in parts),
        )

    def _lost(self, outcome: Outcome[Row]) -> Row:
        nothing = np.full((1, len(self._asked.measures)), np.nan)
        return Row(nothing, nothing, (FAILED,), (f"its process {outcome.explanation}",))


def _together(grid: Grid, asked: Asked, ways: tuple[str, ...], begun: Sequence[tuple[str, tuple[int, ...]]], rows: Sequence[Row]) -> Study:
    shape = (len(ways), *grid.shape)
    numbers = np.full((2, *shape, len(asked.measures)), np.nan)
    texts = np.full((2, *shape), "", dtype=object)
    for (way, place), found in zip(begun, rows, strict=True):
        at = (ways.index(way), *place[: grid.along], slice(None, None, -1 if way == "down" else 1), *place[grid.along + 1 :])
        for kind, values in enumerate((found.values, found.errors)):
            numbers[kind][at] = values
        for kind, words in enumerate((found.statuses, found.sentences)):
            texts[kind][at] = words
    return Study(grid, asked, ways, numbers[0], numbers[1], texts[0], texts[1])
