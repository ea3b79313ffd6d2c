"""Runs engines on cases: what is stored is taken, the rest is computed in processes of their own and stored as it comes.

Stored is what would come out again: a result, a refusal, an engine's own failure. What the machine did to a run is not: a process
that was killed, a limit of time or memory, a full disk, an engine that is not installed. It is tried again the next time.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any, Final

from cases.engine_run import EngineRun, engine_run, task_key
from cases.orbit import begins_in_orbit, orbit_key, orbits
from cases.steady_run import FAILED, UNAVAILABLE, SteadyRun, Task
from cases.store import Store
from cases.stored_jobs import Result, stored
from cases.workers import Job, Limits, Outcome
from engines.registry import engine

#: The slowest first, so that the last core does not wait for one of them.
_SLOWEST: Final = ("exudyn", "mujoco", "reference")


@dataclass(frozen=True)
class Named:
    """A task with the name under which its result is wanted, e.g. ("thesis-24", "exudyn")."""

    name: tuple[str, ...]
    task: Task


def run_tasks(
    tasks: Sequence[Named], store: Store, jobs: int | None = None, title: str = "runs", limits: Limits | None = None
) -> dict[tuple[str, ...], EngineRun]:
    """Results of all tasks by name. Equal tasks are computed once.

    Args:
        tasks: what to run.
        store: where results are looked up and kept.
        jobs: processes at a time; None: one per core.
        title: of the progress bar.
        limits: of each task; None: `cases.workers.default_limits`.

    Raises:
        ValueError: a name is given twice.
        KeyboardInterrupt: Ctrl-C; what was computed is stored.
    """
    if len({named.name for named in tasks}) < len(tasks):
        raise ValueError("two tasks have one name")
    tasks = _with_orbits(tasks, store, jobs, limits)
    keys = {named.name: task_key(named.task) for named in tasks}
    work = [Job(keys[named.name], engine_run, (named.task,)) for named in _in_order(tasks)]
    entries, others = stored(work, store, title, at_once=jobs, limits=limits, keep=_kept)
    found = {key: EngineRun(entry.document, entry.arrays) for key, entry in entries.items()}
    for named in tasks:
        if (key := keys[named.name]) not in found:
            found[key] = _of_the_machine(others[key], named.task)
    return {name: found[key] for name, key in keys.items()}


def _in_order(tasks: Sequence[Named]) -> list[Named]:
    """One of each engine first: what it compiles is there for the others, which would compile the same beside it."""
    by_engine: dict[str, list[Named]] = {}
    for named in tasks:
        by_engine.setdefault(named.task.engine, []).append(named)
    slowest = sorted(by_engine, key=lambda name: _SLOWEST.index(name) if name in _SLOWEST else len(_SLOWEST))
    return [by_engine[name][0] for name in reversed(slowest)] + [named for name in slowest for named in by_engine[name][1:]]


def _with_orbits(tasks: Sequence[Named], store: Store, jobs: int | None, limits: Limits | None) -> list[Named]:
    """The same, those that shall begin in the orbit of `reference` with that orbit."""
    chosen = [_marches_from_orbit(named.task) for named in tasks]
    found = orbits([named.task.mechanism for named, wanted in zip(tasks, chosen, strict=True) if wanted], store, jobs, limits)
    return [
        replace(named, task=replace(named.task, orbit=found[orbit_key(named.task.mechanism)])) if wanted else named
        for named, wanted in zip(tasks, chosen, strict=True)
    ]


def _marches_from_orbit(task: Task) -> bool:
    found = engine(task.engine)
    if task.straight or task.orbit is not None or found.unavailable() or not begins_in_orbit(found):
        return False
    try:
        found.check(task.mechanism)
    except Exception:  # it refuses the scene, or will tell in its own process what is wrong
        return False
    return True


def _kept(outcome: Outcome) -> Result | None:
    """What would come out again."""
    run = outcome.value
    return (run.document, run.cycle) if isinstance(run, SteadyRun) and run.document["status"] != UNAVAILABLE else None


def _of_the_machine(outcome: Outcome, task: Task) -> EngineRun:
    run = outcome.value
    return EngineRun(run.document, run.cycle) if isinstance(run, SteadyRun) else _failed(task, outcome.explanation)


def _failed(task: Task, cause: str) -> EngineRun:
    document: dict[str, Any] = {
        "engine": task.engine,
        "estimate_of": engine(task.engine).estimates,
        "status": FAILED,
        "remark": cause,
        "cause": cause,
        "settled": False,
        "cycles": 0,
        "solve_seconds": None,
        "start": None,
        "settling": None,
        "settling_error": None,
        "settling_errors": None,
        "measures": [],
        "consensus": [],
        "unestimated": cause,
    }
    return EngineRun(document, {})
