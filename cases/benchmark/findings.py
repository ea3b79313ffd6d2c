"""Findings of a benchmark: the Pareto front, the fastest method for an accuracy, and the orders of errors."""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Final

import numpy as np

#: Errors of the tip deflection at which methods are compared.
LEVELS: Final = (1e-2, 1e-3, 1e-4)


@dataclass(frozen=True, kw_only=True)
class Measured:
    """Measurements of a completed point; times in s."""

    degrees_of_freedom: int
    errors: dict[str, float | None]  # relative error of each column; None if the column is zero throughout
    solve_seconds: float  # the least of the repetitions
    solve_seconds_median: float
    solve_seconds_largest: float
    repetitions: int
    setup_seconds: float  # the least of the repetitions
    statistics: dict[str, float]  # statistics of the engine, and errors of the joint
    calls_per_period: float | None  # calls of the right-hand side per period of the highest mode; None for methods other than `reference`
    # set-up and solve time of the other runs for the engine's error estimate; None if not measured, or if there is no estimate
    estimate_seconds: float | None = None

    @property
    def waited_seconds(self) -> float | None:
        """Waiting time with compiled code: set-up, solution and error estimate; None if the estimate was not timed."""
        return None if self.estimate_seconds is None else self.setup_seconds + self.solve_seconds + self.estimate_seconds


@dataclass(frozen=True, kw_only=True)
class Point:
    """A method with some settings."""

    method: str  # name of the engine or of a variant
    engine: str
    settings: dict[str, Any]
    changing: dict[str, Any]  # the settings that change along the method's ladder
    status: str  # "completed", or why not
    measured: Measured | None = None

    def error(self, column: str = "tip_deflection") -> float | None:
        """Error of a column, see `error_of`; None if the point did not complete."""
        return None if self.measured is None else error_of(self.measured.errors, column)


def error_of(errors: Mapping[str, float | None], column: str = "tip_deflection") -> float | None:
    """Error of a column; "strain" is the worst of the three gauges."""
    if column == "strain":
        return max((error for name in ("strain_1", "strain_2", "strain_3") if (error := errors.get(name)) is not None), default=None)
    return errors.get(column)


def completed(points: Iterable[Point]) -> list[tuple[Point, Measured]]:
    """The completed points with their measurements."""
    return [(point, point.measured) for point in points if point.measured is not None]


def pareto_front(points: Sequence[Point], column: str = "tip_deflection") -> list[Point]:
    """The points that no other point beats in both solve time and error of a column, fastest first."""
    front: list[Point] = []
    least = np.inf
    done = [(measured.solve_seconds, error, point) for point, measured in completed(points) if (error := point.error(column)) is not None]
    for _, error, point in sorted(done, key=lambda entry: entry[:2]):
        if error < least:
            front.append(point)
            least = error
    return front


def fastest_at(points: Sequence[Point], level: float) -> dict[str, tuple[Point, Measured]]:
    """The fastest point of each method with an error of the tip deflection of at most `level`; fastest method first."""
    best: dict[str, tuple[Point, Measured]] = {}
    for point, measured in sorted(completed(points), key=lambda pair: pair[1].solve_seconds):
        error = point.error()
        if error is not None and error <= level:
            best.setdefault(point.method, (point, measured))
    return best


def soonest_at(points: Sequence[Point], level: float) -> list[tuple[str, float]]:
    """The methods of `fastest_at` whose error estimate was timed, with their waiting time (s); the least first."""
    waited = [(name, measured.waited_seconds) for name, (_, measured) in fastest_at(points, level).items()]
    return sorted(((name, seconds) for name, seconds in waited if seconds is not None), key=lambda pair: pair[1])


def observed_order(points: Sequence[Point], method: str) -> float | None:
    """Slope of -log(error) of the tip deflection over log(degrees of freedom), by least squares over a method's completed points.

    None if fewer than three numbers of degrees of freedom completed. Of several points with the same number the one with the least error
    counts: the others differ in the time step.
    """
    least: dict[int, float] = {}
    for point, measured in completed(points):
        error, free = point.error(), measured.degrees_of_freedom
        if point.method == method and error:
            least[free] = min(error, least.get(free, np.inf))
    if len(least) < 3:
        return None
    free_log, error_log = np.log(list(least)), np.log(list(least.values()))
    return float(-np.polyfit(free_log, error_log, 1)[0])
