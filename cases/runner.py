"""Runs engines on cases: what is stored is taken, the rest is computed in processes of their own and stored as it comes.

Stored is what would come out again: a result, a refusal, an engine's own failure. What the machine did to a run is not: a process
that was killed, a limit of time or memory, a full disk, an engine that is not installed. It is tried again the next time.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, Final

from cases.engine_run import EngineRun, engine_run, task_key
from cases.steady_run import FAILED, UNAVAILABLE, SteadyRun, Task
from cases.store import Store
from cases.stored_jobs import Result, stored
from cases.workers import Job, Limits, Outcome

#: The slowest first, so that the last core does not wait for one of them: `reference` where its equations are not yet machine code.
_ORDER: Final = {"reference": 0, "exudyn": 1, "mujoco": 2, "thesis": 9}


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
    keys = {named.name: task_key(named.task) for named in tasks}
    if len(keys) < len(tasks):
        raise ValueError("two tasks have one name")
    ordered = sorted(tasks, key=lambda named: _ORDER.get(named.task.engine, 5))
    work = [Job(keys[named.name], engine_run, (named.task,)) for named in ordered]
    entries, others = stored(work, store, title, at_once=jobs, limits=limits, keep=_kept)
    found = {key: EngineRun(entry.document, entry.arrays) for key, entry in entries.items()}
    for named in tasks:
        if (key := keys[named.name]) not in found:
            found[key] = _of_the_machine(others[key], named.task)
    return {name: found[key] for name, key in keys.items()}


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
        "status": FAILED,
        "remark": cause,
        "cause": cause,
        "settled": False,
        "cycles": 0,
        "solve_seconds": None,
        "measures": [],
        "consensus": [],
    }
    return EngineRun(document, {})
