"""Runs engines on cases: what is stored is taken, the rest is computed in processes of their own and stored as it comes."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

from cases.engine_run import PARTS, EngineRun, engine_run, task_key
from cases.progress import with_progress
from cases.steady_run import FAILED, SteadyRun, Task
from cases.store import Store
from cases.workers import PRELOAD, Job, Limits, Outcome, run_jobs

#: What one engine on one scene may take: an hour, and 8 GiB. Far above what any run needs; it ends what would never end.
LIMITS: Final = Limits(seconds=3600.0, memory=8 * 2**30)
#: Slow engines first, so that the last core does not wait for one of them.
_ORDER: Final = {"reference": 0, "exudyn": 1, "mujoco": 2, "thesis": 9}


@dataclass(frozen=True)
class Named:
    """A task with the name under which its result is wanted, e.g. ("thesis-24", "exudyn")."""

    name: tuple[str, ...]
    task: Task


def run_tasks(tasks: Sequence[Named], store: Store, jobs: int | None = None, title: str = "runs") -> dict[tuple[str, ...], EngineRun]:
    """Results of all tasks by name. Equal tasks are computed once.

    Args:
        tasks: what to run.
        store: where results are looked up and kept.
        jobs: processes at a time; None: one per core.
        title: of the progress bar.

    Raises:
        StoreError: a result cannot be written.
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
        preload = (*PRELOAD, "cases.engine_run", *(part for part in PARTS if part.startswith("cases")))
        for outcome in with_progress(run_jobs(work, jobs, LIMITS, preload), len(work), title):
            key = outcome.job.name
            run = _result(outcome, missing[key].task)
            if outcome.completed:  # a run that was killed may go better next time: it is not kept
                store.put(key, run.document, run.cycle)
            found[key] = run
    return {name: found[key] for name, key in keys.items()}


def _result(outcome: Outcome, task: Task) -> EngineRun:
    if outcome.completed and isinstance(outcome.value, SteadyRun):
        return EngineRun(outcome.value.document, outcome.value.cycle)
    document = {
        "engine": task.engine,
        "status": FAILED,
        "remark": outcome.failure,
        "cause": outcome.failure,
        "settled": False,
        "cycles": 0,
        "solve_seconds": None,
        "measures": [],
        "consensus": [],
    }
    return EngineRun(document, {})
