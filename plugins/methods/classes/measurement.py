"""The time that each method needs to reach an error in a scene of the map: solve time and waiting time."""

import time
from collections.abc import Sequence
from dataclasses import replace
from typing import Any, Final

from quickreturn.engines.accurate import simulate
from quickreturn.engines.base import AnyEngine, EngineFailure, Refusal
from quickreturn.engines.relative import relative_error
from quickreturn.engines.start import standard_start
from quickreturn.engines.trajectory import REQUIRED, Trajectory
from quickreturn.plugins.methods.classes.grid import case_of, name_of
from quickreturn.plugins.methods.classes.groups import Groups
from quickreturn.plugins.methods.trials.methods import Plan, methods
from quickreturn.plugins.methods.trials.queries import LEVELS as ALL_LEVELS
from quickreturn.plugins.methods.trials.queries import fastest_at
from quickreturn.plugins.methods.trials.trial import Trial, repeated, seconds_of, trial_of, warm_up, worth_repeating
from quickreturn.plugins.methods.trials.truth import confirmation_of, truth_of

#: Errors of the tip deflection at which the map compares methods.
LEVELS: Final = ALL_LEVELS[:2]
#: Limit of processor time, s, for the runs of a method's ladder, and for its answer to a request for an error. A run is not begun if it
#: would end later, assuming that it takes as long as the one before.
LIMIT: Final = 5.0
#: Largest number of repetitions of a run, and of an answer that takes less than `BRIEF` (s); the least time counts.
REPETITIONS: Final = 3
BRIEF: Final = 1.0

TIP: Final = "tip_deflection"
REACHED: Final = "reached"
REFUSED: Final = "refused"
FAILED: Final = "failed"
NOT_REACHED: Final = "not reached"
TOO_SLOW: Final = "too slow"
#: Remark if settings reach an error in time, but the engine's own estimate does not confirm it in time.
SLOW_ANSWER: Final = "its estimate takes too long"
#: Remark if the estimate does not include the distance from the scene's solution, as for a model that differs from the scene.
OF_ITSELF: Final = "its estimate covers another error"


def truth(groups: Groups) -> tuple[Trajectory, Trial]:
    """The solution of a scene that defines errors, and the difference of a second one from it.

    EngineFailure: there is none, for example because the slider leaves the follower.
    """
    case = case_of(groups)
    converged = truth_of(case)
    required = replace(converged, columns={name: converged[name] for name in REQUIRED})
    return required, confirmation_of(case, required)


def measured(groups: Groups, name: str, true: Trajectory) -> list[Trial]:
    """An engine, by its name, on the scene of some groups at each of `LEVELS`, in this process; errors are those against `true`."""
    case = case_of(groups)
    method = methods([name], case)[0]
    try:
        method.engine.check(case.mechanism)
    except Refusal as refusal:
        return [asked_for(groups, name, level, REFUSED, str(refusal)) for level in LEVELS]
    warm_up(next(method.plans(case)))
    clock, ladder = _Clock(), list[tuple[Plan, list[Trial]]]()
    for plan in method.plans(case):
        if clock.late:
            break
        ladder.append((plan, [trial_of(plan, true)]))
        if (error := ladder[-1][1][0].error) is not None and error <= LEVELS[-1]:
            break
    return [_reached(asked_for(groups, name, level, NOT_REACHED), ladder, clock, true) for level in LEVELS]


def asked_for(groups: Groups, name: str, level: float, status: str, remark: str = "") -> Trial:
    """The trial of an engine, by its name, that is asked for an error in the scene of some groups."""
    return Trial(scene=name_of(groups), engine=name, level=level, status=status, remark=remark)


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


def _reached(unknown: Trial, ladder: Sequence[tuple[Plan, list[Trial]]], clock: _Clock, true: Trajectory) -> Trial:
    """The trial for a level from the runs of the ladder: plans and their repetitions, of which the best gets more."""
    trials = [repetitions[0] for _, repetitions in ladder]
    best = next(iter(fastest_at(trials, unknown.level or 0.0).values()), None)
    if best is None:
        errors = [trial.error for trial in trials if trial.error is not None]
        if not errors:
            return replace(unknown, status=FAILED, remark=trials[-1].status)
        remark = "" if trials[-1].completed else trials[-1].status
        return replace(unknown, status=TOO_SLOW if clock.ran_out else NOT_REACHED, errors={TIP: min(errors)}, remark=remark)
    plan, repetitions = next(each for each in ladder if each[1][0] is best)
    while len(repetitions) < REPETITIONS and worth_repeating(repetitions):
        repetitions.append(trial_of(plan, true))
    return _answered(replace(unknown, status=REACHED, solve_seconds=repeated(repetitions).solve_seconds), plan, true)


def _answered(trial: Trial, plan: Plan, true: Trajectory) -> Trial:
    """The trial with the answer of the engine when it is asked for the level, unless its estimate covers another error."""
    engine, case = plan.method.engine, plan.case
    if engine.estimates != "total":
        return replace(trial, remark=OF_ITSELF)
    start, times = standard_start(case.mechanism), list[float]()
    while not times or (times[0] < BRIEF and len(times) < REPETITIONS):
        began, clock = time.perf_counter(), _Clock()
        limited: Any = _Limited(engine, clock)
        try:
            result = simulate(limited, case.mechanism, start, case.duration, case.output_step, accuracy=trial.level)
        except EngineFailure as failure:
            return replace(trial, remark=SLOW_ANSWER if clock.ran_out else str(failure))
        times.append(max(time.perf_counter() - began - result.compile_seconds, seconds_of([*result.runs.values()])))
    error = relative_error(result.trajectory[TIP], true[TIP])
    trial = replace(trial, errors={TIP: error}, claim=result.error_estimate)
    if not result.reached:
        return replace(trial, remark=SLOW_ANSWER if clock.ran_out else result.remark)
    if error > (trial.level or 0.0):
        return replace(trial, remark=f"it claims {result.error_estimate:.1e}")
    return replace(trial, answer_seconds=min(times))
