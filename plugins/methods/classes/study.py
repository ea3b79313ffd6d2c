"""The study: every method on every scene of the map, from the store if it is there."""

from collections.abc import Iterable
from dataclasses import dataclass, replace
from typing import Final

from quickreturn.cases.motion.solving import inputs_of
from quickreturn.cases.running.isolation import STOPPED
from quickreturn.cases.running.job import Job, Outcome, default_limits
from quickreturn.cases.running.workshop import Workshop
from quickreturn.engines.registry import MAIN, engine
from quickreturn.engines.trajectory import Trajectory
from quickreturn.plugins.methods.classes.grid import case_of, grid, name_of
from quickreturn.plugins.methods.classes.groups import Groups
from quickreturn.plugins.methods.classes.measurement import FAILED, LEVELS, LIMIT, TOO_SLOW, asked_for, measured, truth
from quickreturn.plugins.methods.rivals import RIVALS
from quickreturn.plugins.methods.trials.trial import Trial
from quickreturn.plugins.methods.trials.truth import CONFIRMING_ONE, TRUTH

ENGINES: Final = (*MAIN, *RIVALS)
#: Time limit (s) of a method on a scene: its ladder and two answers take `LIMIT` each, and some runs are repeated.
STOP: Final = 12.0 * LIMIT


@dataclass(frozen=True)
class ClassScene:
    """A scene of the map."""

    name: str  # see `cases.classes.grid.name_of`
    groups: Groups  # its groups
    # difference of the confirming solution's tip deflection from the one that defines errors; None if there is none
    difference: float | None = None
    failure: str = ""  # why there is no solution, or no confirming one; "" if there are both


def study(workshop: Workshop, among: Iterable[Groups] | None = None) -> tuple[list[ClassScene], list[Trial]]:
    """The scenes, and the result of each method on each of them; results that are missing in the workshop are left out.

    `among`: groups of the scenes; None: all of the map. KeyboardInterrupt: Ctrl-C; finished measurements are stored.
    """
    groups = list(grid() if among is None else among)
    truths = workshop.outcomes([_truth_job(each) for each in groups], "solutions to measure against")
    scenes = [_scene(each, solution) for each, solution in zip(groups, truths, strict=True) if not solution.missing]
    jobs = [
        _job(each, name, solution.value[0])
        for each, solution in zip(groups, truths, strict=True)
        if solution.value is not None
        for name in ENGINES
        if not engine(name).unavailable()
    ]
    outcomes = [_kept(workshop, outcome) for outcome in workshop.outcomes(jobs, "methods on scenes") if not outcome.missing]
    return scenes, [trial for outcome in outcomes for trial in outcome.value or ()]


def _truth_job(groups: Groups) -> Job[tuple[Trajectory, Trial]]:
    engines = (TRUTH[0], CONFIRMING_ONE)
    return Job(name_of(groups), truth, (groups,), "truth of a class", engines, inputs=inputs_of(case_of(groups)))


def _job(groups: Groups, name: str, true: Trajectory) -> Job[list[Trial]]:
    arguments = (groups, name, true)
    limits = replace(default_limits(), seconds=STOP)
    return Job(f"{name_of(groups)}: {name}", measured, arguments, "class", (name,), inputs=inputs_of(case_of(groups)), limits=limits)


def _scene(groups: Groups, outcome: Outcome[tuple[Trajectory, Trial]]) -> ClassScene:
    name = name_of(groups)
    if outcome.value is None:
        return ClassScene(name, groups, failure=outcome.explanation)
    _, confirmation = outcome.value
    return ClassScene(name, groups, confirmation.error, "" if confirmation.completed else confirmation.status)


def _kept(workshop: Workshop, outcome: Outcome[list[Trial]]) -> Outcome[list[Trial]]:
    """The outcome; for a method that ended without one results that say why: of a stopped method they are stored, of a crashed one not."""
    if outcome.completed:
        return outcome
    groups, name, _ = outcome.job.arguments
    slow = outcome.failure.startswith(STOPPED)
    status = TOO_SLOW if slow else FAILED
    without = Outcome(outcome.job, [asked_for(groups, name, level, status, outcome.explanation) for level in LEVELS])
    return workshop.kept(without) if slow else without
