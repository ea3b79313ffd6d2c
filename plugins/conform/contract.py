"""Tries whether an adapter does what it says: an engine on mild scenes, against `reference`, closed forms and its own claims.

A coarse engine conforms, too: its own error estimate is the tolerance of each column. Without an estimate a check fails only if the
difference has one plain explanation. An engine that models a follower alone, and no mechanism, is tried as a rod.
"""

import os
from collections.abc import Callable, Iterator, Mapping
from typing import Any, Final

from quickreturn.cases.running.display import answers
from quickreturn.cases.running.job import Executor, Job, ThisProcess
from quickreturn.engines.base import AnyEngine, Refusal
from quickreturn.engines.registry import UnknownEngine
from quickreturn.plugins.conform.behaviour import elsewhere, failures, repetition
from quickreturn.plugins.conform.bench import Bench, Check, Conformance, Fault, ended, engine_from
from quickreturn.plugins.conform.motion import motion
from quickreturn.plugins.conform.promises import frequencies, ladder
from quickreturn.plugins.conform.quantities import alone, quantities
from quickreturn.plugins.conform.rods import rods

__all__ = ["GROUPS", "Check", "Conformance", "conform", "job"]


def _follower_alone(bench: Bench, *_: Any) -> Iterator[Check]:
    """The follower alone; of an engine that models nothing else, as a clamped rod first."""
    if bench.scene.crank is None:
        yield from rods(bench)
    yield from alone(bench)


#: Groups of checks by name, in the order of the output. Each gets the bench, and the engine's results in other processes.
GROUPS: Final[Mapping[str, Callable[..., Iterator[Check]]]] = {
    "motion": lambda bench, _: motion(bench),
    "quantities": lambda bench, _: quantities(bench),
    "resolution": lambda bench, _: ladder(bench),
    "frequencies": lambda bench, _: frequencies(bench),
    "failures": lambda bench, _: failures(bench),
    "follower alone": _follower_alone,
    "repetition": repetition,
}
#: Groups of a quick trial.
QUICK: Final = ("motion", "frequencies", "failures")


def conform(
    engine: AnyEngine | str | os.PathLike[str],
    executor: Executor | None = None,
    groups: tuple[str, ...] = tuple(GROUPS),
    *,
    quick: bool = False,
    quiet: bool = False,
) -> Conformance:
    """Try an engine.

    Args:
        engine: an instance, the name of one that is installed, or the path of a file that declares one.
        executor: computes each group separately, so that a crash loses only that group; None: this process.
        groups: names of groups of checks, see `GROUPS`; of an engine without mechanism all are those of the follower alone.
        quick: whether only the groups `QUICK` are tried.
        quiet: in this process, whether progress on standard error is left out.

    Raises:
        UnknownEngine: there is no engine of this name.
        Refusal: it cannot be used here.
    """
    engine = os.fspath(engine) if isinstance(engine, os.PathLike) else engine
    tested = engine_from(engine)
    groups = ("follower alone",) if _models_no_mechanism(tested) else QUICK if quick else groups
    # here, because the process of a job may not start processes
    other = elsewhere(engine) if "repetition" in groups else ""
    jobs = [Job(group, trial, (group, engine, other)) for group in groups]
    checks = list[Check]()
    for outcome in answers(executor or ThisProcess(quiet), jobs, f"engine {tested.name}"):
        if isinstance(outcome.error, (Refusal, UnknownEngine)):
            raise outcome.error
        checks += outcome.value or [ended(outcome.job.name, Fault(f"the engine's process ends: {outcome.explanation}"))]
    statuses = {check.status for check in checks}
    return Conformance(tested.name, False if "failed" in statuses else True if "passed" in statuses else None, tuple(checks))


def _models_no_mechanism(engine: AnyEngine) -> bool:
    """Whether it models a follower alone."""
    try:
        return Bench(engine).scene.crank is None
    except Exception:  # of whatever kind: each group says so
        return False


def trial(group: str, engine: AnyEngine | str, other: Any) -> list[Check]:
    """The checks of one group; an exception that no engine may raise ends them. `other`: its results in other processes."""
    checks = list[Check]()
    try:
        checks.extend(GROUPS[group](Bench(engine_from(engine)), other))
    except Exception as error:  # an author's engine may raise anything
        checks.append(ended(group, error))
    return checks


def job(engine: str) -> Job[Conformance]:
    """The stored form of `conform` for an installed engine: for this version and code of the engine."""
    return Job(f"conformance of {engine}", conform, (engine,), "conformance", (engine,))
