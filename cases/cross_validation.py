"""Several engines on several cases: the tasks, their results, and the comparison."""

from collections.abc import Mapping, Sequence

from cases.case import Case
from cases.comparison import CaseResult, compare
from cases.runner import Named, run_tasks
from cases.steady_run import Task
from cases.store import Store
from cases.workers import Limits
from engines.registry import MAIN


def cross_validate(
    cases: Sequence[Case],
    store: Store,
    engines: Sequence[str] = MAIN,
    accuracy: float | None = None,
    settings: Mapping[str, str] | None = None,
    jobs: int | None = None,
    limits: Limits | None = None,
) -> list[CaseResult]:
    """Bring every engine to its steady state on every case and compare.

    Args:
        cases: what to run.
        store: results are taken from here and kept here.
        engines: names.
        accuracy: error of the tip deflection asked of every engine; None: each engine's default.
        settings: engine settings as text, the same for all engines.
        jobs: processes at a time; None: one per core.
        limits: of each engine on each case; None: `cases.workers.default_limits`.

    Raises:
        CaseError: a case without crank and slider: there is no cycle to measure.
        UnknownEngine: see there.
    """
    tasks = [
        Named(
            (case.name, engine),
            Task(mechanism=case.mechanism, duration=case.duration, engine=engine, accuracy=accuracy, settings=dict(settings or {})),
        )
        for case in cases
        for engine in engines
    ]
    results = run_tasks(tasks, store, jobs, "engines on cases", limits)
    return [compare(case, {engine: results[case.name, engine] for engine in engines}) for case in cases]
