"""Speed against error: every engine over its ladder of settings on one scene, against a solution that a second engine confirms.

One process, pinned to one processor; the repetitions of all points are interleaved, so that a drift of the machine's speed meets all
of them alike. Times are solve times as measured: nothing is scaled. Points that fail or do not converge stay in the table.
"""

import os
import platform
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, Final

import numpy as np

from cases.case import Case
from engines.accurate import ESTIMATED, run_once
from engines.base import Engine, EngineFailure, Refusal
from engines.registry import engine
from engines.settings import Settings
from engines.start import standard_start
from engines.trajectory import Trajectory

#: Accuracies whose settings make up an engine's ladder.
ACCURACIES: Final = (5e-2, 1e-2, 3e-3, 1e-3, 3e-4, 1e-4)
#: Repetitions of a point, and the solve time (s) beyond which one has to do.
REPETITIONS: Final = 5
LONG: Final = 4.0
#: The solution that errors are measured against, and the one that confirms it.
TRUTH: Final = ("reference", 3e-5)
CONFIRMING: Final = ("mujoco", 3e-5)


@dataclass(frozen=True)
class Benchmark:
    """The table of one case.

    Attributes:
        case: its name.
        truth: engine and settings of the solution that errors are measured against.
        confirmation: engine, settings and difference of each column of the confirming solution; {"failure": ...} if there is none.
        points: one dict per engine and settings: engine, settings, status, degrees_of_freedom, errors by column, solve_seconds (the
            least), solve_seconds_median, solve_seconds_largest, setup_seconds, statistics.
        machine: processor, system and versions.
    """

    case: str
    truth: dict[str, Any]
    confirmation: dict[str, Any]
    points: list[dict[str, Any]]
    machine: dict[str, str]


def benchmark(case: Case, names: Sequence[str], repetitions: int = REPETITIONS) -> Benchmark:
    """Measure the engines on a case; best run in a process of its own, which it pins to one processor.

    Raises:
        EngineFailure: the solution to measure against cannot be computed.
        Refusal: likewise.
    """
    if hasattr(os, "sched_setaffinity"):
        os.sched_setaffinity(0, {min(os.sched_getaffinity(0))})
    truth_engine = engine(TRUTH[0])
    truth_settings = truth_engine.settings_for(TRUTH[1], case.mechanism)
    truth, _ = _run(truth_engine, case, truth_settings)
    points = [_Point(engine(name), settings) for name in names for settings in _ladder(engine(name), case)]
    for point in points:
        point.warm_up(case)
    for repetition in range(repetitions):
        for point in points:
            point.repeat(case, repetition)
    return Benchmark(
        case.name,
        {"engine": TRUTH[0], "settings": truth_settings.as_dict()},
        _confirmation(case, truth),
        [point.as_dict(case, truth) for point in points],
        {
            "processor": platform.processor() or platform.machine(),
            "system": platform.platform(),
            "python": platform.python_version(),
            **{name: engine(name).version() for name in names if not engine(name).unavailable()},
        },
    )


def _ladder(chosen: Engine, case: Case) -> list[Settings]:
    """The settings for `ACCURACIES`, each once, coarse to fine."""
    if chosen.unavailable():
        return []
    return list(dict.fromkeys(chosen.settings_for(accuracy, case.mechanism) for accuracy in ACCURACIES))


def _run(chosen: Engine, case: Case, settings: Settings) -> tuple[Trajectory, float]:
    return run_once(chosen, case.mechanism, standard_start(case.mechanism), case.duration, case.output_step, settings)


def _confirmation(case: Case, truth: Trajectory) -> dict[str, Any]:
    chosen = engine(CONFIRMING[0])
    settings = chosen.settings_for(CONFIRMING[1], case.mechanism)
    try:
        trajectory, _ = _run(chosen, case, settings)
    except (EngineFailure, Refusal) as failure:
        return {"engine": CONFIRMING[0], "failure": str(failure)}
    return {"engine": CONFIRMING[0], "settings": settings.as_dict(), "differences": _errors(trajectory, truth)}


def _errors(trajectory: Trajectory, truth: Trajectory) -> dict[str, float | None]:
    errors: dict[str, float | None] = {}
    for column in ESTIMATED:
        size = float(np.sqrt(np.mean(truth[column] ** 2)))
        errors[column] = float(np.sqrt(np.mean((trajectory[column] - truth[column]) ** 2))) / size if size > 0.0 else None
    return errors


class _Point:
    """One engine with one choice of settings."""

    def __init__(self, chosen: Engine, settings: Settings) -> None:
        self.engine, self.settings = chosen, settings
        self.trajectory: Trajectory | None = None
        self.failure = ""
        self.times: list[float] = []
        self.setup: list[float] = []

    def warm_up(self, case: Case) -> None:
        """What is compiled or loaded on first use must not be timed."""
        if self.engine.compiles:
            try:
                start = standard_start(case.mechanism)
                run_once(self.engine, case.mechanism, start, case.output_step, case.output_step, self.settings)
            except (EngineFailure, Refusal) as failure:
                self.failure = str(failure)

    def repeat(self, case: Case, repetition: int) -> None:
        """One more time, unless it has failed or takes so long that once must do."""
        if self.failure or (repetition and self.times[0] > LONG):
            return
        try:
            self.trajectory, setup = _run(self.engine, case, self.settings)
        except (EngineFailure, Refusal) as failure:
            self.failure = str(failure)
            return
        self.times.append(self.trajectory.solve_seconds)
        self.setup.append(setup)

    def as_dict(self, case: Case, truth: Trajectory) -> dict[str, Any]:
        point: dict[str, Any] = {"engine": self.engine.name, "settings": self.settings.as_dict(), "status": self.failure or "completed"}
        if self.failure or self.trajectory is None:
            return point
        return point | {
            "degrees_of_freedom": self.engine.describe(case.mechanism, self.settings).degrees_of_freedom,
            "errors": _errors(self.trajectory, truth),
            "solve_seconds": min(self.times),
            "solve_seconds_median": float(np.median(self.times)),
            "solve_seconds_largest": max(self.times),
            "repetitions": len(self.times),
            "setup_seconds": min(self.setup),
            "statistics": self.trajectory.statistics,
        }


def pareto_front(points: Sequence[dict[str, Any]], column: str = "tip_deflection") -> list[dict[str, Any]]:
    """The points that no other beats in both solve time and error of a column, fastest first."""
    done = [point for point in points if point.get("errors", {}).get(column) is not None]
    front: list[dict[str, Any]] = []
    for point in sorted(done, key=lambda point: (point["solve_seconds"], point["errors"][column])):
        if not front or point["errors"][column] < front[-1]["errors"][column]:
            front.append(point)
    return front
