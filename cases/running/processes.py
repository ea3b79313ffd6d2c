"""Executors for many jobs at once, each job isolated."""

import os
import threading
from collections.abc import Callable, Generator, Sequence
from concurrent.futures import CancelledError, Future, ThreadPoolExecutor, as_completed
from dataclasses import replace
from functools import partial

from quickreturn.cases.running.fork_server import PRELOAD
from quickreturn.cases.running.isolation import end_waiting, isolated
from quickreturn.cases.running.job import ExecutorError, Job, Limits, Outcome, V, Watch, default_limits


def available_cores() -> int:
    """Number of cores that this process may use."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


def computed(
    submit: Callable[[Job[V]], "Future[Outcome[V]]"],
    jobs: Sequence[Job[V]],
    cancel: Callable[[], object] = lambda: None,
    blamed: type[Exception] | None = None,
) -> Generator[Outcome[V], None, None]:
    """Outcomes as they come from the executor behind `submit`.

    Closing the generator, or Ctrl-C, calls `cancel` and then cancels the remaining jobs one by one, which may take long. An executor may
    end a job by an error `blamed` although another job that was there too is at fault: such jobs are computed once more after all others,
    one at a time.
    """
    waiting: dict[Future[Outcome[V]], Job[V]] = {}
    suspected: list[Job[V]] = []
    try:
        waiting.update((submit(job), job) for job in jobs)
        for future in as_completed(list(waiting)):
            job = waiting.pop(future)
            if blamed is not None and len(jobs) > 1 and not future.cancelled() and isinstance(future.exception(), blamed):
                suspected.append(job)
            else:
                yield _outcome(job, future)
        for job in suspected:
            alone = submit(job)
            waiting[alone] = job
            for future in as_completed([alone]):
                yield _outcome(waiting.pop(future), future)
    finally:
        cancel()
        for future in waiting:
            future.cancel()


def _outcome(job: Job[V], future: "Future[Outcome[V]]") -> Outcome[V]:
    try:
        return replace(future.result(), job=job)  # from another process comes a copy of the job
    except ExecutorError:
        raise
    except CancelledError as error:
        raise ExecutorError("the connection to the machines that compute is lost; what they delivered is stored") from error
    except Exception as error:  # of whatever kind the executor raises
        return Outcome(job, failure=f"was lost ({type(error).__name__}: {str(error).partition('. ')[0]})")


class LocalProcesses:
    """The executor on this machine: several jobs at a time, each in its process, all from one fork server.

    Args:
        at_once: number of jobs at a time; None: one per core. ValueError: it is below 1.
        limits: see `cases.running.job.Executor`; None: `default_limits`.
        preload: modules that the fork server imports once; only the first job of a process decides.
        quiet: whether progress is not reported.
    """

    def __init__(
        self,
        at_once: int | None = None,
        limits: Limits | None = None,
        preload: Sequence[str] = PRELOAD,
        quiet: bool = True,
    ) -> None:
        if at_once is not None and at_once < 1:
            raise ValueError(f"jobs={at_once}: at least 1 is needed")
        self.at_once, self.quiet, self._preload = at_once or available_cores(), quiet, preload
        self.limits = limits or default_limits()

    def run(self, jobs: Sequence[Job[V]], watch: Watch | None = None) -> Generator[Outcome[V], None, None]:
        """See `cases.running.job.Executor`."""
        ended = threading.Event()
        pool = ThreadPoolExecutor(self.at_once)
        try:
            yield from computed(
                partial(pool.submit, isolated, limits=self.limits, watch=watch, stopped=ended.is_set, preload=self._preload), jobs
            )
        finally:
            ended.set()
            pool.shutdown()
            end_waiting()
