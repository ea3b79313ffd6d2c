"""The scenes on which methods are compared, and their results in the store."""

import dataclasses
from collections.abc import Sequence
from typing import Any, Final

from quickreturn.cases.files.case import Case
from quickreturn.cases.motion.solving import inputs_of
from quickreturn.cases.running.display import answers
from quickreturn.cases.running.job import Executor, Job, Limits
from quickreturn.cases.running.workshop import Workshop
from quickreturn.engines.base import EngineFailure, Refusal
from quickreturn.engines.registry import MAIN, engine
from quickreturn.engines.settings import SettingError
from quickreturn.plugins.methods.benchmark.measurement import REPETITIONS, Benchmark, last_at_work, pinned
from quickreturn.plugins.methods.rivals import RIVALS
from quickreturn.plugins.methods.trials.methods import methods
from quickreturn.plugins.methods.trials.trial import run_of

#: Run 24; the run with the least strain; two hard scenes, one with a soft follower and one in which the slider reaches 96 % of the
#: follower; and run 24 at a prescribed crank speed, because one method requires this.
SCENES: Final = ("thesis-24", "thesis-17", "hard-ei-x0.1", "hard-crank-6in", "hard-prescribed-speed")

ENGINES: Final = (*MAIN, *RIVALS)


def stored(case: Case, workshop: Workshop, names: Sequence[str] = ENGINES) -> Benchmark | None:
    """The latest result that this code and these libraries computed, or None."""
    outcome = workshop.stored(_job(case, names, ()))
    return None if outcome is None else outcome.value


def measure(case: Case, workshop: Workshop, names: Sequence[str] = ENGINES, repetitions: int = REPETITIONS) -> Benchmark:
    """Measure engines (names) anew in one new process, and store the result; see `cases.benchmark.measurement.benchmark`.

    If an engine dies or exceeds the executor's limits, the other engines are measured again without it, and the result is not stored. The
    time limit holds for each engine. A run is repeated, and its shortest time is its result.

    Raises:
        EngineFailure, Refusal: the solution that defines the errors cannot be computed, or the process ended without an answer.
        KeyboardInterrupt: Ctrl-C.
    """
    limits, failures = workshop.executor.limits, unsafe_engines(case, workshop.executor, names)
    while True:
        sound = tuple(name for name in names if name not in failures)
        allowed = Limits(None if limits.seconds is None else limits.seconds * (1 + len(sound)), limits.memory)
        job = dataclasses.replace(_job(case, names, (case, sound, repetitions)), limits=allowed)
        (outcome,) = answers(workshop.executor, [job], case.name)
        if outcome.value is not None:
            break
        if isinstance(outcome.error, (EngineFailure, Refusal)):
            raise outcome.error
        culprit, since = last_at_work(outcome.output)
        overrun = outcome.failure.startswith("stopped at the time limit")
        if overrun and limits.seconds is not None and outcome.seconds - since < limits.seconds:
            cause = f"the benchmark of all engines was {outcome.failure}, although no single engine exceeded its limit"
            raise EngineFailure(0.0, cause, "try a longer --time-limit, fewer engines or fewer repetitions")
        if culprit is None or culprit not in sound:
            raise EngineFailure(0.0, f"the process of the benchmark {outcome.explanation}", "try fewer engines at once")
        failures[culprit] = f"{outcome.failure}, at finer settings"
    result = dataclasses.replace(outcome.value, failures=failures)
    if not failures:
        workshop.kept(dataclasses.replace(outcome, value=result))
    return result


def unsafe_engines(case: Case, executor: Executor, names: Sequence[str]) -> dict[str, str]:
    """Engines that must not run in the common process, with the reason.

    Each engine runs its coarsest settings in a process of its own. An engine that reports a failure may run in the common process: the
    failure is a result, which the table shows.
    """
    failures = {}
    for outcome in answers(executor, [Job(name, _try, (case, name)) for name in names], "trying the engines"):
        if outcome.value:
            failures[outcome.job.name] = outcome.value
        elif not (outcome.completed or isinstance(outcome.error, (EngineFailure, Refusal, SettingError))):
            failures[outcome.job.name] = outcome.explanation
    return {name: failures[name] for name in names if name in failures}


def _try(case: Case, name: str) -> str:
    """Run the coarsest settings; return why the engine cannot be used here, "" if it can."""
    for method in methods([name], case)[:1]:
        if method.ladder:
            run_of(method.engine, case, method.ladder[0])
    return engine(name).unavailable() or ""


def _job(case: Case, names: Sequence[str], arguments: tuple[Any, ...]) -> Job[Benchmark]:
    """The job that measures a scene. Its key contains the scene and the engines, but neither the repetitions nor the time limit."""
    return Job(case.name, pinned, arguments, kind="benchmark", engines=tuple(names), inputs=inputs_of(case))
