"""Does an adapter do what it says? A trial of an engine on mild scenes, against identities, closed forms and `reference`.

Nobody is accused of being coarse: by how much a column may be off follows from the engine's own estimate of its error. Where it makes
none, it must show a mistake to be found wrong: a sign, a unit, a column exchanged, a quantity ignored.
"""

from collections.abc import Callable, Iterator, Mapping
from typing import Any, Final

from cases.conformance.bench import Bench, found_engine
from cases.conformance.checks import TELL_THE_AUTHOR, Array, Check, Conformance
from cases.conformance.failures import failures
from cases.conformance.frequencies import frequencies
from cases.conformance.motion import motion
from cases.conformance.quantities import quantities
from cases.conformance.repetition import elsewhere, repetition
from cases.conformance.resolution import resolution
from cases.jobs.display import watched
from cases.jobs.job import Executor, Job
from engines.accurate import raised_at
from engines.base import AnyEngine, Refusal
from engines.registry import UnknownEngine

__all__ = ["GROUPS", "Check", "Conformance", "conform", "job"]

#: Groups of checks by name, in the order in which they are told.
GROUPS: Final[Mapping[str, Callable[[Bench], Iterator[Check]]]] = {
    "motion": motion,
    "quantities": quantities,
    "resolution": resolution,
    "frequencies": frequencies,
    "failures": failures,
    "repetition": repetition,
}


def conform(engine: AnyEngine | str, executor: Executor | None = None, groups: tuple[str, ...] = tuple(GROUPS)) -> Conformance:
    """Try an engine.

    Args:
        engine: an instance, or the name of one that is installed.
        executor: computes the groups, each apart from the others, so that one that crashes costs its own answer; None: this process.
        groups: of checks, names of `GROUPS`.

    Raises:
        UnknownEngine: there is no engine of this name.
        Refusal: it cannot be used here.
    """
    name = engine if isinstance(engine, str) else engine.name
    # a job's process may have no process of its own
    other = elsewhere(engine) if "repetition" in groups else "not tried"
    if executor is None:
        return _told(name, [check for group in groups for check in checks_of(group, engine, other)])
    jobs: list[Job[Any]] = [Job(group, checks_of, (group, engine, other)) for group in groups]
    outcomes = {outcome.job.name: outcome for outcome in watched(executor, jobs, f"engine {name}")}
    checks: list[Check] = []
    for group in groups:
        outcome = outcomes[group]
        if isinstance(outcome.error, (Refusal, UnknownEngine)):
            raise outcome.error
        checks += outcome.value or [Check(group, "failed", f"the engine's process ends: {outcome.explanation}", TELL_THE_AUTHOR)]
    return _told(name, checks)


def job(engine: str) -> Job[Conformance]:
    """`conform` of an installed engine, as its outcome is kept: for this version and code of the engine."""
    return Job(f"conformance of {engine}", conform, (engine,), "conformance", (engine,), (__name__,))


def checks_of(group: str, engine: AnyEngine | str, other: dict[str, Array] | str = "not tried") -> list[Check]:
    """The checks of one group; `other`: what came of it in another process. What an engine raises that no engine may ends them."""
    found = found_engine(engine)
    try:
        bench = Bench(found, other)
    except Refusal as refusal:
        return [Check(group, "not judged", f"the engine refuses the mild scene, with either drive: {refusal}", TELL_THE_AUTHOR)]
    checks: list[Check] = []
    try:
        checks.extend(GROUPS[group](bench))
    except Exception as error:  # an author's engine may raise anything
        cause = f"the engine raises {type(error).__name__}{raised_at(error)}: {error}"
        checks.append(Check(group, "failed", cause, "only Refusal, EngineFailure and SettingError say something to a user"))
    return checks


def _told(name: str, checks: list[Check]) -> Conformance:
    judged = {check.status for check in checks}
    conforms = False if "failed" in judged else (True if "passed" in judged else None)
    return Conformance(name, conforms, tuple(checks))
