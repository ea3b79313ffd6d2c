"""Many jobs at once: each is isolated, wherever it is computed."""

import os
import threading
from collections.abc import Callable, Generator, Sequence
from concurrent import futures
from contextlib import closing
from dataclasses import replace
from functools import partial

from cases.jobs.fork_server import PRELOAD
from cases.jobs.isolation import end_waiting, isolated
from cases.jobs.job import Job, Limits, Outcome, V, Watch, default_limits


def available_cores() -> int:
    """Number of cores that this process may use."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


def computed(pool: futures.Executor, compute: Callable[[Job[V]], Outcome[V]], jobs: Sequence[Job[V]]) -> Generator[Outcome[V], None, None]:
    """Outcomes as `compute` delivers them where the pool calls it; closing the generator cancels those jobs that have not begun."""
    waiting = {pool.submit(compute, job): job for job in jobs}
    try:
        for future in futures.as_completed(waiting):
            yield _outcome(waiting.pop(future), future)
    finally:
        for future in waiting:
            future.cancel()


def _outcome(job: Job[V], future: "futures.Future[Outcome[V]]") -> Outcome[V]:
    try:
        return replace(future.result(), job=job)  # from another process comes a copy of the job
    except Exception as error:
        return Outcome(job, failure=f"was lost ({type(error).__name__}: {error})")


class LocalProcesses:
    """The executor on this machine: some jobs at a time, each in its process; all of a process share a fork server.

    Args:
        at_once: how many jobs at a time; None: one per core. ValueError: it is below 1.
        limits: of a job that has none of its own; None: `default_limits`.
        preload: modules that the fork server imports once; only the first job of a process decides.
        quiet: whether nobody is to be told how far the jobs are.
    """

    def __init__(
        self, at_once: int | None = None, limits: Limits | None = None, preload: Sequence[str] = PRELOAD, quiet: bool = True
    ) -> None:
        if at_once is not None and at_once < 1:
            raise ValueError(f"jobs={at_once}: at least 1 is needed")
        self.at_once, self.quiet, self._preload = at_once or available_cores(), quiet, preload
        self.limits = limits or default_limits()

    def run(self, jobs: Sequence[Job[V]], watch: Watch | None = None) -> Generator[Outcome[V], None, None]:
        """See `cases.jobs.job.Executor`."""
        ended = threading.Event()
        compute = partial(isolated, limits=self.limits, watch=watch, stopped=ended.is_set, preload=self._preload)
        pool = futures.ThreadPoolExecutor(self.at_once)
        try:
            with closing(computed(pool, compute, jobs)) as outcomes:
                yield from outcomes
        finally:
            ended.set()
            pool.shutdown()
            end_waiting()
