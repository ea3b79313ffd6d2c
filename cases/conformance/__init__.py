"""Tries whether an adapter does what it says: an engine on mild scenes, against identities, closed forms and `reference`.

A coarse engine conforms, too: its own error estimate is the tolerance of each column. Without an estimate a check fails only if a mistake
explains the difference: a sign, a unit, an exchanged column, an ignored quantity.
"""

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from typing import Final

from quickreturn.cases.conformance.alone import alone
from quickreturn.cases.conformance.bench import Bench, engine_from
from quickreturn.cases.conformance.checks import NOT_QUICK, TELL_THE_AUTHOR, Check, Conformance, LeftOut, raising
from quickreturn.cases.conformance.failures import failures
from quickreturn.cases.conformance.frequencies import frequencies
from quickreturn.cases.conformance.motion import motion
from quickreturn.cases.conformance.quantities import quantities
from quickreturn.cases.conformance.repetition import NOT_TRIED, OtherProcesses, elsewhere, repetition
from quickreturn.cases.conformance.resolution import resolution
from quickreturn.cases.jobs.display import watched
from quickreturn.cases.jobs.here import ThisProcess
from quickreturn.cases.jobs.isolation import STOPPED
from quickreturn.cases.jobs.job import Executor, Job, Limits, Outcome
from quickreturn.engines.base import AnyEngine, EngineFailure, Refusal
from quickreturn.engines.registry import UnknownEngine

__all__ = ["GROUPS", "QUICK", "Check", "Conformance", "conform", "job"]


@dataclass(frozen=True)
class Group:
    """A group of checks."""

    checks: Callable[[Bench, OtherProcesses], Iterator[Check]]  # makes them
    runs: tuple[int, int]  # approximate number of runs of the engine, and of runs with an error estimate
    share: float  # share of a limited time


#: Groups of checks by name, in the order of the output. Numbers of runs are those of `reference`.
GROUPS: Final[Mapping[str, Group]] = {
    "motion": Group(lambda bench, _: motion(bench), (6, 2), 0.3),
    "quantities": Group(lambda bench, _: quantities(bench), (65, 60), 0.3),
    "resolution": Group(lambda bench, _: resolution(bench), (12, 2), 0.1),
    "frequencies": Group(lambda bench, _: frequencies(bench), (0, 0), 0.05),
    "failures": Group(lambda bench, _: failures(bench), (3, 0), 0.05),
    "follower alone": Group(lambda bench, _: alone(bench), (14, 13), 0.1),
    "repetition": Group(repetition, (0, 0), 0.1),
}
#: Wall time of a quick trial, s; and the additional time for the start of a process, s.
QUICK: Final = 60.0
_TO_BEGIN: Final = 5.0


def conform(
    engine: AnyEngine | str,
    executor: Executor | None = None,
    groups: tuple[str, ...] = tuple(GROUPS),
    *,
    seconds: float | None = None,
    quiet: bool = False,
) -> Conformance:
    """Try an engine.

    Args:
        engine: an instance, or the name of one that is installed.
        executor: computes each group separately, so that a crash loses only that group; None: this process.
        groups: names of groups of checks, see `GROUPS`.
        seconds: limit of wall time; checks that do not fit into it are left out. None: no limit.
        quiet: in this process, whether progress on standard error is left out.

    Raises:
        UnknownEngine: there is no engine of this name.
        Refusal: it cannot be used here.
    """
    name = engine_from(engine).name
    executor = executor or ThisProcess(quiet)
    total = sum(GROUPS[group].share for group in groups)
    shares = {group: None if seconds is None else GROUPS[group].share / total * seconds for group in groups}
    # here, because the process of a job may not start processes
    other = elsewhere(engine, shares["repetition"]) if "repetition" in groups else NOT_TRIED
    jobs: list[Job[list[Check]]] = []
    for group, share in shares.items():
        allotted = None if share is None else share * executor.at_once
        limits = None if allotted is None else Limits(2.0 * allotted + _TO_BEGIN, executor.limits.memory)
        jobs.append(Job(group, checks_of, (group, engine, other, allotted), limits=limits))
    outcomes = {outcome.job.name: outcome for outcome in watched(executor, jobs, f"engine {name}")}
    checks = {group: _checks_by(group, outcomes[group]) for group in groups}
    return Conformance(name, _verdict(checks), tuple(check for of_group in checks.values() for check in of_group))


def _verdict(checks: Mapping[str, list[Check]]) -> bool | None:
    """Whether an engine conforms: no check fails, and one passes; if checks were left out, one of its motion must pass."""
    statuses = {check.status for of_group in checks.values() for check in of_group}
    if "failed" in statuses:
        return False
    left_out = any(check.left_out for of_group in checks.values() for check in of_group)
    counted = {check.status for check in checks.get("motion", [])} if left_out else statuses
    return True if "passed" in counted else None


def job(engine: str) -> Job[Conformance]:
    """The stored form of `conform` for an installed engine: for this version and code of the engine."""
    return Job(f"conformance of {engine}", conform, (engine,), "conformance", (engine,))


def checks_of(group: str, engine: AnyEngine | str, other: OtherProcesses = NOT_TRIED, seconds: float | None = None) -> list[Check]:
    """The checks of one group; engine and seconds as for `conform`; `other`: its results in other processes.

    An exception that no engine may raise ends them.
    """
    checks: list[Check] = []
    try:
        bench = Bench(engine_from(engine), seconds)
        bench.expected = _expected(bench, GROUPS[group])
    except Refusal as refusal:
        return [Check(group, "not judged", f"the engine refuses the mild scene, with either drive: {refusal}", TELL_THE_AUTHOR)]
    except Exception as error:  # an author's engine may raise anything
        return [raising(group, error)]
    try:
        checks.extend(GROUPS[group].checks(bench, other))
    except LeftOut as left_out:
        checks.append(Check(f"{group}: the rest", left_out.status, left_out.cause, left_out.advice))
    except EngineFailure as failure:
        checks.append(Check(group, "failed", f"a run breaks down: {failure.cause}", failure.advice))
    except Exception as error:  # likewise
        checks.append(raising(group, error))
    return checks


def _expected(bench: Bench, group: Group) -> int:
    """Approximate number of runs of the engine in a group."""
    plain, estimated = group.runs
    settings = bench.settings(bench.scene)
    pairs = bench.engine.comparisons(settings, bench.scene, bench.mild.output_step) if bench.claims else ()
    others = {run for pair in pairs for run in (pair.run, pair.other, pair.before and pair.before.other)} - {None, settings}
    return plain + estimated * len(others)


def _checks_by(group: str, outcome: Outcome[list[Check]]) -> list[Check]:
    """The checks of a group from its process, or one on how the process ended. UnknownEngine, Refusal: the engine cannot be used."""
    if isinstance(outcome.error, (Refusal, UnknownEngine)):
        raise outcome.error
    if outcome.failure.startswith(STOPPED):
        return [Check(group, "not judged", f"left out: it was {outcome.failure}", NOT_QUICK)]
    return outcome.value or [Check(group, "failed", f"the engine's process ends: {outcome.explanation}", TELL_THE_AUTHOR)]
