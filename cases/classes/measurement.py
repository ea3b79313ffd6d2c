"""The time that each method needs to reach an error in a scene of the map: solve time and waiting time."""

import time
from dataclasses import dataclass, replace
from typing import Any, Final

from quickreturn.cases.benchmark.findings import LEVELS as ALL_LEVELS
from quickreturn.cases.benchmark.findings import Point, fastest_at
from quickreturn.cases.benchmark.measurement import Attempt, seconds_of
from quickreturn.cases.benchmark.methods import methods
from quickreturn.cases.benchmark.truth import Confirmation, confirmation_of, truth_of
from quickreturn.cases.case import Case
from quickreturn.cases.classes.grid import case_of
from quickreturn.cases.classes.groups import Groups
from quickreturn.engines.accurate import simulate
from quickreturn.engines.base import AnyEngine, EngineFailure, Refusal
from quickreturn.engines.relative import relative_error
from quickreturn.engines.start import standard_start
from quickreturn.engines.trajectory import REQUIRED, Trajectory

#: Errors of the tip deflection at which the map compares methods.
LEVELS: Final = ALL_LEVELS[:2]
#: Limit of processor time, s, for the runs of a method's ladder, and for its answer to a request for an error. A run is not begun if it
#: would end later, assuming that it takes as long as the one before.
LIMIT: Final = 5.0
#: Largest number of repetitions of a run, and of an answer that takes less than `BRIEF` (s); the least time counts.
REPETITIONS: Final = 3
BRIEF: Final = 1.0

REACHED: Final = "reached"
REFUSED: Final = "refused"
FAILED: Final = "failed"
NOT_REACHED: Final = "not reached"
TOO_SLOW: Final = "too slow"
#: Remark if settings reach an error in time, but the engine's own estimate does not confirm it in time.
SLOW_ANSWER: Final = "its estimate takes too long"
#: Remark if the estimate does not include the distance from the scene's solution, as for a model that differs from the scene.
OF_ITSELF: Final = "its estimate covers another error"


@dataclass(frozen=True)
class Reach:
    """Whether and how fast a method reaches an error of the tip deflection on a scene."""

    scene: str  # name of the scene
    engine: str  # name of the method
    level: float  # the error, relative
    status: str  # `REACHED` by settings of its ladder, or why not
    solve_seconds: float | None = None  # solve time with the fastest settings within the level; None if there are none
    # set-up and solve time of all runs if the engine is asked for this error, with those for its estimate; None if it does not reach the
    # error, or its estimate does not show that
    waited_seconds: float | None = None
    error: float | None = None  # error of its result when asked; if no settings are within the level, the least error of its ladder
    remark: str = ""  # the reason in words


def truth(groups: Groups) -> tuple[Trajectory, Confirmation]:
    """The solution of a scene that defines errors, and the difference of a second one from it.

    EngineFailure: there is none, for example because the slider leaves the follower.
    """
    case = case_of(groups)
    converged = truth_of(case)
    required = replace(converged, columns={name: converged[name] for name in REQUIRED})
    return required, confirmation_of(case, required)


def measured(groups: Groups, name: str, true: Trajectory) -> list[Reach]:
    """An engine, by its name, on the scene of some groups at each of `LEVELS`, in this process; errors are those against `true`."""
    case = case_of(groups)
    method = methods([name], case)[0]
    unknown = [Reach(case.name, name, level, NOT_REACHED) for level in LEVELS]
    try:
        method.engine.check(case.mechanism)
    except Refusal as refusal:
        return [replace(each, status=REFUSED, remark=str(refusal)) for each in unknown]
    attempts, points = [Attempt(method, settings) for settings in method.ladder], list[Point]()
    attempts[0].warm_up(case)
    clock = _Clock()
    for attempt in attempts:
        if clock.late:
            break
        attempt.repeat(case, 0)
        points.append(attempt.point(case, true))
        if (error := points[-1].error()) is not None and error <= LEVELS[-1]:
            break
    return [_reach(each, attempts[: len(points)], points, clock, case, true) for each in unknown]


class _Clock:
    """Tells whether the next run would end after `LIMIT` if it took as long as the one before; to be asked once before each run.

    It counts processor time, so that other work of the machine does not affect the result.
    """

    def __init__(self) -> None:
        self.began = self.last = time.process_time()
        self.ran_out = False

    @property
    def late(self) -> bool:
        """Whether the next run must not begin."""
        now = time.process_time()
        self.ran_out = self.ran_out or (now - self.began) + (now - self.last) > LIMIT
        self.last = now
        return self.ran_out


class _Limited:
    """An engine that begins a run only if the time suffices."""

    def __init__(self, engine: AnyEngine, clock: _Clock) -> None:
        self._engine, self._clock = engine, clock

    def __getattr__(self, name: str) -> Any:
        return getattr(self._engine, name)

    def prepare(self, *arguments: Any) -> Any:
        """As the engine's `prepare`. EngineFailure: the time does not suffice."""
        if self._clock.late:
            raise EngineFailure(0.0, "time has run out", "ask for less")
        return self._engine.prepare(*arguments)


def _reach(unknown: Reach, attempts: list[Attempt], points: list[Point], clock: _Clock, case: Case, true: Trajectory) -> Reach:
    """The result for a level from the completed runs of the ladder."""
    best = fastest_at(points, unknown.level).get(attempts[0].method.name)
    if best is None:
        errors = [error for point in points if (error := point.error()) is not None]
        if not errors:
            return replace(unknown, status=FAILED, remark=points[-1].status)
        remark = "" if points[-1].measured else points[-1].status
        return replace(unknown, status=TOO_SLOW if clock.ran_out else NOT_REACHED, error=min(errors), remark=remark)
    attempt = next(each for each, point in zip(attempts, points, strict=True) if point is best[0])
    for repetition in range(len(attempt.times), REPETITIONS):
        attempt.repeat(case, repetition)
    return _answered(replace(unknown, status=REACHED, solve_seconds=min(attempt.times)), attempt.method.engine, case, true)


def _answered(reach: Reach, engine: AnyEngine, case: Case, true: Trajectory) -> Reach:
    """The result with the answer of the engine when it is asked for the level, unless its estimate covers another error."""
    if engine.estimates != "total":
        return replace(reach, remark=OF_ITSELF)
    start, times = standard_start(case.mechanism), list[float]()
    while not times or (times[0] < BRIEF and len(times) < REPETITIONS):
        began, clock = time.perf_counter(), _Clock()
        limited: Any = _Limited(engine, clock)
        try:
            result = simulate(limited, case.mechanism, start, case.duration, case.output_step, accuracy=reach.level)
        except EngineFailure as failure:
            return replace(reach, remark=SLOW_ANSWER if clock.ran_out else str(failure))
        times.append(max(time.perf_counter() - began - result.compile_seconds, seconds_of(result.runs.values())))
    error = relative_error(result.trajectory["tip_deflection"], true["tip_deflection"])
    if error > reach.level and result.reached:
        return replace(reach, error=error, remark=f"it claims {result.error_estimate:.1e}")
    if not result.reached:
        return replace(reach, error=error, remark=SLOW_ANSWER if clock.ran_out else result.remark)
    return replace(reach, error=error, waited_seconds=min(times))
