"""What a benchmark says: which points no other beats, who is fastest at an accuracy, and how fast errors fall."""

from collections.abc import Mapping, Sequence
from typing import Any, Final

import numpy as np

#: Errors of the tip deflection at which methods are compared.
LEVELS: Final = (1e-2, 1e-3, 1e-4)

Point = Mapping[str, Any]


def error_of(point: Point, column: str = "tip_deflection") -> float | None:
    """Error of a column; "strain" is the worst of the three gauges; None of a point that did not complete."""
    errors = point.get("errors")
    if not errors:
        return None
    if column == "strain":
        return max((errors[name] for name in ("strain_1", "strain_2", "strain_3") if errors[name] is not None), default=None)
    return errors[column]


def pareto_front(points: Sequence[Point], column: str = "tip_deflection") -> list[Point]:
    """The points that no other beats in both solve time and error of a column, fastest first."""
    done = [(point["solve_seconds"], error, i) for i, point in enumerate(points) if (error := error_of(point, column)) is not None]
    front: list[Point] = []
    least = np.inf
    for _, error, i in sorted(done):
        if error < least:
            front.append(points[i])
            least = error
    return front


def fastest_at(points: Sequence[Point], level: float, column: str = "tip_deflection") -> dict[str, Point]:
    """Of each method that reaches an error of at most `level`, its fastest point that does; fastest method first."""
    best: dict[str, Point] = {}
    for point in points:
        error = error_of(point, column)
        if error is None or error > level:
            continue
        held = best.get(point["method"])
        if held is None or point["solve_seconds"] < held["solve_seconds"]:
            best[point["method"]] = point
    return dict(sorted(best.items(), key=lambda item: item[1]["solve_seconds"]))


def observed_order(points: Sequence[Point], method: str, column: str = "tip_deflection") -> float | None:
    """Slope of -log(error) over log(degrees of freedom) of a method, by least squares over its completed points.

    None where fewer than three numbers of degrees of freedom completed. Of several points with the same number, that of the least error
    counts: the others differ in the time step.
    """
    least: dict[int, float] = {}
    for point in points:
        error = error_of(point, column)
        if point["method"] == method and error:
            free = int(point["degrees_of_freedom"])
            least[free] = min(error, least.get(free, np.inf))
    if len(least) < 3:
        return None
    free_log, error_log = np.log(list(least)), np.log(list(least.values()))
    return float(-np.polyfit(free_log, error_log, 1)[0])
