"""Tries whether an adapter does what it says: an engine on mild scenes, against identities, closed forms and `reference`.

A coarse engine conforms, too: its own error estimate is the tolerance of each column. Without an estimate a check fails only if a mistake
explains the difference: a sign, a unit, an exchanged column, an ignored quantity. An engine that models a follower alone, and no mechanism,
is tried as a rod.
"""

import os
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from itertools import chain
from typing import Final

from quickreturn.cases.conformance.alone import alone
from quickreturn.cases.conformance.bench import Bench, engine_from, truth
from quickreturn.cases.conformance.checks import LEFT_OUT, NOT_QUICK, TELL_THE_AUTHOR, Check, Conformance, LeftOut, ended
from quickreturn.cases.conformance.failures import failures
from quickreturn.cases.conformance.frequencies import frequencies
from quickreturn.cases.conformance.motion import motion
from quickreturn.cases.conformance.quantities import quantities
from quickreturn.cases.conformance.repetition import NOT_TRIED, OtherProcesses, elsewhere, repetition
from quickreturn.cases.conformance.resolution import resolution
from quickreturn.cases.conformance.rods import motion_alone, rods
from quickreturn.cases.conformance.turning import turning
from quickreturn.cases.jobs.display import watched
from quickreturn.cases.jobs.in_process import ThisProcess
from quickreturn.cases.jobs.isolation import STOPPED
from quickreturn.cases.jobs.job import Executor, Job, Limits, Outcome
from quickreturn.engines.base import AnyEngine, Refusal
from quickreturn.engines.registry import UnknownEngine

__all__ = ["GROUPS", "QUICK", "Check", "Conformance", "conform", "job", "trial"]


@dataclass(frozen=True)
class Group:
    """A group of checks."""

    checks: Callable[[Bench, OtherProcesses], Iterator[Check]]  # makes them
    runs: tuple[int, int]  # approximate number of runs of the engine, and of runs with an error estimate
    quick: bool  # whether a quick trial makes them


def _follower_alone(bench: Bench) -> Iterator[Check]:
    """The follower alone; of an engine that models nothing else, as a clamped rod first."""
    if bench.mild.scene.crank is None:
        yield from rods(bench)
    yield from alone(bench)


#: The group of checks that tries an engine without mechanism.
_ALONE: Final = "follower alone"
#: Groups of checks by name, in the order of the output. Numbers of runs are those of `reference`.
GROUPS: Final[Mapping[str, Group]] = {
    "motion": Group(lambda bench, _: motion(bench), (6, 2), True),
    "quantities": Group(lambda bench, _: chain(quantities(bench), turning(bench)), (66, 61), True),
    "resolution": Group(lambda bench, _: resolution(bench), (12, 2), False),
    "frequencies": Group(lambda bench, _: frequencies(bench), (0, 0), True),
    "failures": Group(lambda bench, _: failures(bench), (3, 0), True),
    _ALONE: Group(lambda bench, _: _follower_alone(bench), (14, 13), False),
    "repetition": Group(repetition, (0, 0), False),
}
#: Wall time of the engine's runs in a quick trial, s; and what its process may take besides to begin and to compile, s.
QUICK: Final = 20.0
_TO_BEGIN: Final = 60.0
_QUICK_TRIAL: Final = "quick trial"


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
        quick: whether checks that do not fit into `QUICK` seconds are left out.
        quiet: in this process, whether progress on standard error is left out.

    Raises:
        UnknownEngine: there is no engine of this name.
        Refusal: it cannot be used here.
    """
    engine = os.fspath(engine) if isinstance(engine, os.PathLike) else engine
    name, seconds = engine_from(engine).name, QUICK if quick else None
    executor = executor or ThisProcess(quiet)
    groups = (_ALONE,) if motion_alone(engine_from(engine)) else groups
    # here, because the process of a job may not start processes
    other = elsewhere(engine) if not quick and "repetition" in groups else NOT_TRIED
    parts = {_QUICK_TRIAL: groups} if quick else {group: (group,) for group in groups}
    limits = None if seconds is None else Limits(2.0 * seconds + _TO_BEGIN, executor.limits.memory)
    jobs = [Job(part, trial, (part, of_part, engine, other, seconds), limits=limits) for part, of_part in parts.items()]
    outcomes = {outcome.job.name: outcome for outcome in watched(executor, jobs, f"engine {name}")}
    checks = {group: made for part in parts for group, made in _checks_by(part, outcomes[part]).items()}
    return Conformance(name, _verdict(checks), tuple(check for of_group in checks.values() for check in of_group))


def trial(
    part: str, groups: tuple[str, ...], engine: AnyEngine | str, other: OtherProcesses = NOT_TRIED, seconds: float | None = None
) -> dict[str, list[Check]]:
    """The checks of some groups one after the other.

    Args:
        part: name of this part of the trial, for a check that says why there are no others.
        groups: names of the groups.
        engine: as for `conform`.
        other: its results in other processes.
        seconds: limit of wall time, for quick groups alone; checks that do not fit into it are left out. None: no limit.
    """
    try:
        bench = Bench(engine_from(engine), seconds, motion_alone(engine_from(engine)))
        if seconds is None:
            bench.expected = sum(_expected(bench, GROUPS[group]) for group in groups)
    except Refusal as refusal:
        return {part: [Check(part, "not judged", f"the engine refuses the mild scene, with either drive: {refusal}", TELL_THE_AUTHOR)]}
    except Exception as error:  # an author's engine may raise anything
        return {part: [ended(part, error)]}
    if seconds is not None:
        truth(bench.mild)  # what is compiled and computed once for all engines takes no time of the trial
        bench.begin()
    without = bench.mild.scene.crank is None
    checks = {group: _checks(group, bench, other) for group in groups if seconds is None or without or GROUPS[group].quick}
    cause = f"{LEFT_OUT}: a quick trial does not make it"
    return checks | {group: [Check(group, "not judged", cause, NOT_QUICK)] for group in groups if group not in checks}


def _verdict(checks: Mapping[str, list[Check]]) -> bool | None:
    """Whether an engine conforms: no check fails, and one passes; if checks were left out, one of a motion must pass."""
    statuses = {check.status for of_group in checks.values() for check in of_group}
    if "failed" in statuses:
        return False
    left_out = any(check.left_out for of_group in checks.values() for check in of_group)
    counted = {check.status for group in ("motion", _ALONE) for check in checks.get(group, [])} if left_out else statuses
    return True if "passed" in counted else None


def job(engine: str) -> Job[Conformance]:
    """The stored form of `conform` for an installed engine: for this version and code of the engine."""
    return Job(f"conformance of {engine}", conform, (engine,), "conformance", (engine,))


def _checks(group: str, bench: Bench, other: OtherProcesses) -> list[Check]:
    """The checks of one group; an exception that no engine may raise ends them."""
    checks: list[Check] = []
    try:
        checks.extend(GROUPS[group].checks(bench, other))
    except LeftOut as left_out:
        checks.append(ended(f"{group}: the rest", left_out))
    except Exception as error:  # an author's engine may raise anything
        checks.append(ended(group, error))
    return checks


def _expected(bench: Bench, group: Group) -> int:
    """Approximate number of runs of the engine in a group."""
    plain, estimated = group.runs
    settings = bench.settings(bench.mild.scene)
    pairs = bench.engine.comparisons(settings, bench.mild.scene, bench.mild.output_step) if bench.claims else ()
    every = [pair for one in pairs for pair in (one, one.before, one.besides) if pair is not None]
    others = {run for pair in every for run in (pair.run, pair.other)} - {settings}
    return plain + estimated * len(others)


def _checks_by(part: str, outcome: Outcome[dict[str, list[Check]]]) -> dict[str, list[Check]]:
    """The checks of a part from its process, or one on how the process ended. UnknownEngine, Refusal: the engine cannot be used."""
    if isinstance(outcome.error, (Refusal, UnknownEngine)):
        raise outcome.error
    if outcome.failure.startswith(STOPPED):
        return {part: [Check(part, "not judged", f"{LEFT_OUT}: it was {outcome.failure}", NOT_QUICK)]}
    return outcome.value or {part: [Check(part, "failed", f"the engine's process ends: {outcome.explanation}", TELL_THE_AUTHOR)]}
