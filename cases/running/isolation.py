"""Jobs in processes of their own: a crash affects no other job.

A worker comes from a fork server that has completed the slow imports. It computes with one thread, its output is captured, and its result
comes back through a pipe. It may be limited in time and memory, and it ends with the process that asked for it, even if that is killed.
Every end of it becomes an `Outcome` with one clause:

| what a job does, or what is done to it | `Outcome.failure` |
|---|---|
| raises an exception | raised ZeroDivisionError: division by zero |
| dies of a signal | killed by SIGSEGV |
| is killed by the user or by a system that lacks memory | killed by SIGKILL (by the user, or by the system for lack of memory) |
| ends its process | ended without a result (exit code 7) |
| takes longer than it may | stopped at the time limit of 60 s |
| asks for more memory than it may have | ran out of memory (memory limit of 1 GiB); a native library may die of SIGABRT instead |
| closes the pipe for its result and goes on | cut its connection to the runner |
| cannot be started: no process, file handle or temporary folder left | could not be started (...) |
| is not wanted any more | stopped |

If the fork server is killed, its workers finish their jobs, and the next job gets a new server.
"""

import math
import os
import pickle
import signal
import threading
import time
from collections.abc import Callable, Generator, Sequence
from concurrent.futures import CancelledError, Future, ThreadPoolExecutor, as_completed
from dataclasses import replace
from functools import partial
from multiprocessing import connection
from typing import Any, Final

from quickreturn.cases.running.fork_server import PRELOAD, Process
from quickreturn.cases.running.job import ExecutorError, Job, Limits, Outcome, T, V, Watch, default_limits
from quickreturn.cases.running.worker import serve

#: Beginning of the failure of a job that exceeded its time.
STOPPED: Final = "stopped at the time limit"
_KEPT_OUTPUT: Final = 4000  # bytes: the last of what a job printed
_LOOK_INTERVAL: Final = 0.1  # s, interval of checks whether the job is still wanted
_GRACE: Final = 2.0  # s, largest time for the end of a process after its answer
_SIGKILL_HINT: Final = " (by the user, or by the system for lack of memory)"

#: Workers that wait for their next job.
_waiting: Final[list["_Worker"]] = []
_LOCK: Final = threading.Lock()


def isolated(
    job: Job[T],
    limits: Limits | None = None,
    watch: Watch | None = None,
    stopped: Callable[[], bool] = lambda: False,
    preload: Sequence[str] = PRELOAD,
) -> Outcome[T]:
    """Compute a job in a process of its own; a `brief` job may reuse the process of other such jobs.

    Args:
        job: the job.
        limits: limits if the job has none of its own; None: `default_limits`.
        watch: called with the progress of the job; None: progress is not reported.
        stopped: whether the job is no longer wanted; called from time to time.
        preload: modules that the fork server imports once; only the first job of this process decides.
    """
    try:
        worker = _worker_for(job, preload)
    except (OSError, EOFError) as error:
        return Outcome(job, failure=f"could not be started ({error or type(error).__name__})")
    outcome = None
    try:
        if watch is not None:
            watch(job, None)
        outcome = worker.outcome(job, job.limits or limits or default_limits(), watch, stopped)
    finally:
        if outcome is not None and outcome.completed and _may_share(job):
            with _LOCK:
                _waiting.append(worker)
        else:
            worker.end()
    return outcome


def end_waiting() -> None:
    """End the processes that wait for another job."""
    with _LOCK:
        workers = [_waiting.pop() for _ in list(_waiting)]
    for worker in workers:
        worker.end()


def _may_share(job: Job[Any]) -> bool:
    return job.brief and not _defined_in_script(job)


def _defined_in_script(job: Job[Any]) -> bool:
    return getattr(job.function, "__module__", None) == "__main__"


def _worker_for(job: Job[Any], preload: Sequence[str]) -> "_Worker":
    """An idle worker if the job may share it, otherwise a new one, from a new fork server if the old one is dying.

    Until it is gone a dying server counts as alive.
    """
    while _may_share(job) and _waiting:
        with _LOCK:
            worker = _waiting.pop() if _waiting else None
        if worker is not None and worker.takes_another():
            return worker
        if worker is not None:
            worker.end()
    patience = time.monotonic() + _GRACE
    while True:
        try:
            return _Worker(preload, hide_main=not _defined_in_script(job))
        except (ConnectionError, EOFError):
            if time.monotonic() >= patience:
                raise
            time.sleep(0.02)


class _Worker:
    """The runner's side of a process that computes jobs one after the other."""

    def __init__(self, preload: Sequence[str], hide_main: bool) -> None:
        self._process = Process(serve, (True, True, False, False), preload, hide_main)
        self._lifeline, self._orders, self._output, self._answer = self._process.pipes
        self._guarded = True  # whether the fork server will report its end

    def outcome(self, job: Job[Any], limits: Limits, watch: Watch | None, stopped: Callable[[], bool]) -> Outcome[Any]:
        """Send the job to the process, and wait for its outcome."""
        self._job, self._limits, self._watch = job, limits, watch
        self._text = bytearray()
        order = pickle.dumps((pickle.dumps((job.function, job.arguments)), limits.memory, watch is not None))
        self._begin = time.monotonic()
        deadline = math.inf if limits.seconds is None else self._begin + limits.seconds
        try:
            self._orders.send_bytes(order)
        except OSError:
            return self._ended(failure=self._cause_of_death())
        while True:
            ready = connection.wait(self._handles(), min(max(0.0, deadline - time.monotonic()), _LOOK_INTERVAL))
            if (outcome := self._outcome_by(ready)) is not None:
                return outcome
            if time.monotonic() >= deadline or stopped():
                self._process.kill()
                return self._ended(failure="stopped" if time.monotonic() < deadline else f"{STOPPED} of {limits.seconds:g} s")

    def takes_another(self) -> bool:
        """Whether the process can take another job; the pipe of orders is ready once the process is dead, the sentinel some time later."""
        return self._guarded and not connection.wait([self._process.sentinel, self._orders], 0.0)

    def end(self) -> None:
        """End the process and close its pipes."""
        if not self._guarded or not connection.wait([self._process.sentinel], 0.0):
            self._process.kill()
        self._process.close()

    def _handles(self) -> list[Any]:
        """Handles that become ready when something happens."""
        pipes = [pipe for pipe in (self._answer, self._output) if not pipe.closed]
        return [*pipes, self._process.sentinel] if self._guarded else pipes

    def _outcome_by(self, ready: list[Any]) -> Outcome[Any] | None:
        """The outcome if the job has ended, else None. `ready`: the handles that are ready."""
        if self._output in ready:
            self._read_output()
        if self._answer in ready:
            return self._answered()
        if self._process.sentinel in ready:
            if not self._process.exists() or self._answer.poll():
                return self._answered()
            self._guarded = False  # the fork server ended, not the worker, whose answer is still to come
        return None

    def _answered(self) -> Outcome[Any] | None:
        """The outcome that the next message tells, or that follows from the end of all messages; None after a report of progress."""
        try:
            kind, *content = pickle.loads(self._answer.recv_bytes())
        except (EOFError, OSError):
            return self._ended(failure=self._cause_of_death())
        except Exception as error:  # the value's class cannot be rebuilt here
            return self._ended(failure=f"its result cannot be read: {type(error).__name__}: {error}")
        if kind == "progress":
            if self._watch is not None:
                self._watch(self._job, content[0])
            return None
        if kind == "value":
            return self._ended(value=content[0])
        raised, description = content
        if not isinstance(raised, MemoryError):
            return self._ended(failure=f"raised {description}", error=raised)
        limit = "" if self._limits.memory is None else f" (memory limit of {self._limits.memory / 2**30:.3g} GiB)"
        return self._ended(failure=f"ran out of memory{limit}", error=raised)

    def _cause_of_death(self) -> str:
        code = self._process.exit_code(_GRACE)
        if not self._guarded or (code is not None and self._process.exists()):  # the fork server is gone, and with it the exit code
            return "ended without a result"
        if code is None:
            self._process.kill()
            return "cut its connection to the runner"
        if code >= 0:
            return f"ended without a result (exit code {code})"
        name = signal.Signals(-code).name if -code in list(signal.Signals) else f"signal {-code}"
        return f"killed by {name}{_SIGKILL_HINT if name == 'SIGKILL' else ''}"

    def _ended(self, value: Any = None, failure: str = "", error: BaseException | None = None) -> Outcome[Any]:
        seconds = time.monotonic() - self._begin
        while not self._output.closed and self._output.poll():  # all output is in the pipe before the answer is
            self._read_output()
        return Outcome(self._job, value, failure, error, seconds, self._text.decode(errors="replace").strip())

    def _read_output(self) -> None:
        piece = os.read(self._output.fileno(), 65536)
        if not piece:
            self._output.close()
        self._text += piece
        del self._text[:-_KEPT_OUTPUT]


def available_cores() -> int:
    """Number of cores that this process may use."""
    return len(os.sched_getaffinity(0))


def computed(
    submit: Callable[[Job[V]], "Future[Outcome[V]]"], jobs: Sequence[Job[V]], cancel: Callable[[], object] = lambda: None
) -> Generator[Outcome[V], None, None]:
    """Outcomes as they come from the executor behind `submit`.

    Closing the generator, or Ctrl-C, calls `cancel` and then cancels the remaining jobs one by one, which may take long.
    """
    waiting: dict[Future[Outcome[V]], Job[V]] = {}
    try:
        waiting.update((submit(job), job) for job in jobs)
        for future in as_completed(list(waiting)):
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
        self, at_once: int | None = None, limits: Limits | None = None, preload: Sequence[str] = PRELOAD, quiet: bool = True
    ) -> None:
        if at_once is not None and at_once < 1:
            raise ValueError(f"jobs={at_once}: at least 1 is needed")
        self._at_once, self.quiet, self._preload = at_once or available_cores(), quiet, preload
        self.limits = limits or default_limits()

    def run(self, jobs: Sequence[Job[V]], watch: Watch | None = None) -> Generator[Outcome[V], None, None]:
        """See `cases.running.job.Executor`."""
        ended = threading.Event()
        pool = ThreadPoolExecutor(self._at_once)
        try:
            yield from computed(
                partial(pool.submit, isolated, limits=self.limits, watch=watch, stopped=ended.is_set, preload=self._preload), jobs
            )
        finally:
            ended.set()
            pool.shutdown()
            end_waiting()
