"""Runs engines on cases: what is stored is taken, the rest is computed in processes of their own and stored as it comes.

Stored is what would come out again: a result, a refusal, an engine's own failure. What the machine did to a run is not: a process
that was killed, a limit of time or memory, a full disk, an engine that is not installed. It is tried again the next time.
"""

from collections.abc import Sequence
from contextlib import closing
from dataclasses import dataclass
from typing import Any, Final

from cases.engine_run import EngineRun, engine_run, task_key
from cases.progress import with_progress
from cases.steady_run import FAILED, UNAVAILABLE, SteadyRun, Task
from cases.store import Store
from cases.workers import Job, Limits, Outcome, default_limits, run_jobs

#: Slow engines first, so that the last core does not wait for one of them.
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
        KeyboardInterrupt: Ctrl-C; what was computed is stored.
    """
    keys = {named.name: task_key(named.task) for named in tasks}
    found: dict[str, EngineRun] = {}
    missing: dict[str, Named] = {}
    for named in tasks:
        key = keys[named.name]
        if key in found or key in missing:
            continue
        entry = store.get(key)
        if entry is None:
            missing[key] = named
        else:
            found[key] = EngineRun(entry.document, entry.arrays)
    ordered = sorted(missing.items(), key=lambda item: _ORDER.get(item[1].task.engine, 5))
    if ordered:
        work = [Job(key, engine_run, (named.task,)) for key, named in ordered]
        with closing(run_jobs(work, jobs, limits or default_limits())) as outcomes:
            for outcome in with_progress(outcomes, len(work), title):
                key = outcome.job.name
                found[key] = _kept(outcome, missing[key].task, key, store)
    return {name: found[key] for name, key in keys.items()}


def _kept(outcome: Outcome, task: Task, key: str, store: Store) -> EngineRun:
    """What came of a task, stored if it would come out again."""
    if not isinstance(outcome.value, SteadyRun):
        return _failed(task, outcome.explanation)
    run = EngineRun(outcome.value.document, outcome.value.cycle)
    if run.status != UNAVAILABLE:
        try:
            store.put(key, run.document, run.cycle)
        except (TypeError, ValueError) as error:  # a third-party engine may hand anything on
            return _failed(task, f"its result cannot be stored: {error}")
    return run


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
