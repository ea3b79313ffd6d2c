"""Many jobs, each in its own process: what one does to itself, the others do not notice.

A worker comes from a fork server that has the slow imports done. It computes with one thread, its output is caught, and its result
comes back through a pipe. It may be limited in time and memory, and it ends with the runner, even if that is killed. Whatever
happens to it becomes an `Outcome` with one clause that says so:

| what a job does, or what is done to it | `Outcome.failure` |
|---|---|
| raises an exception | raised ZeroDivisionError: division by zero |
| dies of a signal | killed by SIGSEGV |
| is killed by the user or by a system that lacks memory | killed by SIGKILL (by the user, or by the system for lack of memory) |
| ends its process | ended without a result (exit code 7) |
| takes longer than it may | stopped at the time limit of 60 s |
| asks for more memory than it may have | ran out of memory (limit 1024 MiB); a native library may die of SIGABRT or SIGSEGV instead |
| closes the pipe for its result and goes on | cut its connection to the runner |
| cannot be started: no process, file handle or temporary folder left | could not be started (...) |

If the fork server is killed its workers finish what they are at, and the next job gets a new server.
"""

import contextlib
import math
import multiprocessing
import os
import pickle
import signal
import sys
import time
import warnings
from collections import deque
from collections.abc import Generator, Iterator, Sequence
from multiprocessing import connection, forkserver, resource_tracker
from types import ModuleType
from typing import Any, Final

from cases.jobs.job import Job, Limits, Outcome, V, Watch, default_limits
from cases.jobs.worker import serve

#: Variables by which numerical libraries are told how many threads to use.
THREADS: Final = tuple(f"{library}_NUM_THREADS" for library in ("OMP", "OPENBLAS", "MKL", "BLIS", "NUMBA"))
#: What a fork server imports once for all its workers.
PRELOAD: Final = (
    "cases.jobs.worker",
    "cases.jobs.warm",
    "scipy.integrate",
    "engines.accurate",
    "engines.registry",
    "engines.own.simulation",
    "reference_model.periodic",
    "engines.exudyn.simulation",
    "engines.mujoco.simulation",
    "cases.runs.steady_state",
)

#: How the failure of a job begins that took longer than it may.
STOPPED: Final = "stopped at the time limit"
_KEPT_OUTPUT: Final = 4000  # bytes: the last of what a job printed
_LONGEST_WAIT: Final = 86400.0  # s: poll takes no more than 24 days
_GRACE: Final = 2.0  # s: how long a process that is done may take to be gone
_SIGKILL_HINT: Final = " (by the user, or by the system for lack of memory)"


def available_cores() -> int:
    """Number of cores that this process may use."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


class LocalProcesses:
    """The executor on this machine: a process for each job, some of them at a time; all of a process share a fork server.

    Time limits are enforced while the caller waits for the next outcome.

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
        waiting, running = deque(jobs), list[_Worker]()
        try:
            while waiting or running:
                while waiting and len(running) < self.at_once:
                    job = waiting.popleft()
                    try:
                        running.append(_started(job, job.limits or self.limits, self._preload, watch))
                        if watch is not None:
                            watch(job, None)
                    except (OSError, EOFError) as error:
                        yield Outcome(job, failure=f"could not be started ({error or type(error).__name__})")
                if not running:  # none could be started
                    continue
                deadline = min(worker.deadline for worker in running)
                timeout = min(max(0.0, deadline - time.monotonic()), _LONGEST_WAIT)
                ready = connection.wait([handle for worker in running for handle in worker.handles()], timeout)
                for worker in list(running):
                    outcome = worker.outcome(ready)
                    if outcome is not None:
                        running.remove(worker)
                        worker.end()
                        yield outcome
        finally:
            for worker in running:
                worker.end()


def get_ready(preload: Sequence[str]) -> None:
    """Start the fork server now, so that it has its imports done when the first job comes; what fails here is told then."""
    with contextlib.suppress(OSError, EOFError):
        _fork_server(preload)


def _fork_server(preload: Sequence[str]) -> Any:
    """The multiprocessing context of a fork server that computes with one thread and does not see Ctrl-C, nor do its workers."""
    context = multiprocessing.get_context("forkserver")
    context.set_forkserver_preload(list(preload))
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # if the tracker was killed: it says so, but nothing here uses what it tracks
        resource_tracker.ensure_running()  # it lifts the block when it starts, so it must run before
    # nor does it look for modules where the user stands: a folder `cases` there is not ours
    environment = {**dict.fromkeys(THREADS, "1"), "PYTHONSAFEPATH": "1"}
    before = dict(os.environ)
    os.environ.update(environment)
    mask = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})  # this process gets a Ctrl-C afterwards
    try:
        forkserver.ensure_running()
    finally:
        for name in environment.keys() - before.keys():
            del os.environ[name]
        os.environ.update(before)
        signal.pthread_sigmask(signal.SIG_SETMASK, mask)
    return context


@contextlib.contextmanager
def _hidden_main(job: Job[Any]) -> Iterator[None]:
    """Have a worker not run the caller's script unless it is needed: what a script does at its top it would do again."""
    if getattr(job.function, "__module__", None) == "__main__":
        yield
        return
    main = sys.modules["__main__"]
    sys.modules["__main__"] = ModuleType("__main__")
    try:
        yield
    finally:
        sys.modules["__main__"] = main


def _started(job: Job[Any], limits: Limits, preload: Sequence[str], watch: Watch | None) -> "_Worker":
    """A worker at its job, from a new fork server if the old one is dying: until it is gone it still counts as alive."""
    patience = time.monotonic() + _GRACE
    while True:
        try:
            return _Worker(job, limits, preload, watch)
        except (ConnectionError, EOFError):
            if time.monotonic() >= patience:
                raise
            time.sleep(0.02)


class _Worker:
    """A job in its process, seen from the runner."""

    def __init__(self, job: Job[Any], limits: Limits, preload: Sequence[str], watch: Watch | None) -> None:
        self._job, self._limits, self._watch = job, limits, watch
        context = _fork_server(preload)
        self._answer, its_answer = context.Pipe(duplex=False)
        self._output, its_output = context.Pipe(duplex=False)
        its_lifeline, self._lifeline = context.Pipe(duplex=False)
        self._text = bytearray()
        work = pickle.dumps((job.function, job.arguments))
        arguments = (work, limits.memory, watch is not None, its_lifeline, its_output, its_answer)
        self._process = context.Process(target=serve, args=arguments, name=job.name, daemon=True)
        with _hidden_main(job):
            self._process.start()  # waits until the fork server has its imports done
        self._begin = time.monotonic()
        self._guarded = True  # by the fork server, which tells how it ends
        for end in (its_answer, its_output, its_lifeline):  # only the worker may hold these: their closing tells that it ended
            end.close()

    @property
    def deadline(self) -> float:
        return math.inf if self._limits.seconds is None else self._begin + self._limits.seconds

    def handles(self) -> list[Any]:
        """What becomes ready when something happens."""
        pipes = [pipe for pipe in (self._answer, self._output) if not pipe.closed]
        return [*pipes, self._process.sentinel] if self._guarded else pipes

    def outcome(self, ready: list[Any]) -> Outcome[Any] | None:
        """The outcome if the job has ended or run out of time, else None. `ready`: those of the handles that are."""
        if self._output in ready:
            self._read_output()
        outcome = None
        if self._answer in ready:
            outcome = self._answered()
        elif self._process.sentinel in ready:
            if self._exists() and not self._answer.poll():
                self._guarded = False  # not the worker ended but the fork server: the worker's answer is still to come
            else:
                outcome = self._answered()
        if outcome is None and time.monotonic() >= self.deadline:
            self._kill()
            return self._outcome(failure=f"{STOPPED} of {self._limits.seconds:g} s")
        return outcome

    def end(self) -> None:
        """Leave neither process nor pipe behind."""
        if self._process.is_alive() or not self._guarded:
            self._kill()
        self._process.join()
        self._process.close()
        for pipe in (self._answer, self._output, self._lifeline):
            pipe.close()

    def _exists(self) -> bool:
        """Whether there is a process of this number: not once the fork server has told of its end."""
        try:
            os.kill(self._process.pid, 0)
        except ProcessLookupError:
            return False
        return True

    def _kill(self) -> None:
        with contextlib.suppress(ProcessLookupError):
            os.kill(self._process.pid, signal.SIGKILL)

    def _answered(self) -> Outcome[Any] | None:
        """What the next message, or the end of all messages, makes of the job; None where the message tells how far it is."""
        try:
            kind, *content = pickle.loads(self._answer.recv_bytes())
        except (EOFError, OSError):
            return self._outcome(failure=self._cause_of_death())
        except Exception as error:  # the value's class cannot be rebuilt here
            return self._outcome(failure=f"its result cannot be read: {type(error).__name__}: {error}")
        if kind == "progress":
            if self._watch is not None:
                self._watch(self._job, content[0])
            return None
        if kind == "value":
            return self._outcome(value=content[0])
        raised, description = content
        if not isinstance(raised, MemoryError):
            return self._outcome(failure=f"raised {description}", error=raised)
        limit = "" if self._limits.memory is None else f" (limit {self._limits.memory / 2**20:.0f} MiB)"
        return self._outcome(failure=f"ran out of memory{limit}", error=raised)

    def _cause_of_death(self) -> str:
        self._process.join(_GRACE)
        code = self._process.exitcode
        if not self._guarded or (code is not None and self._exists()):  # the fork server is gone, and what it knew
            return "ended without a result"
        if code is None:
            self._kill()
            return "cut its connection to the runner"
        if code >= 0:
            return f"ended without a result (exit code {code})"
        name = signal.Signals(-code).name if -code in list(signal.Signals) else f"signal {-code}"
        return f"killed by {name}{_SIGKILL_HINT if name == 'SIGKILL' else ''}"

    def _outcome(self, value: Any = None, failure: str = "", error: BaseException | None = None) -> Outcome[Any]:
        seconds = time.monotonic() - self._begin
        self._process.join(_GRACE)  # its last words are in the pipe once it is gone
        while not self._output.closed and self._output.poll():
            self._read_output()
        return Outcome(self._job, value, failure, error, seconds, self._text.decode(errors="replace").strip())

    def _read_output(self) -> None:
        piece = os.read(self._output.fileno(), 65536)
        if not piece:
            self._output.close()
        self._text += piece
        del self._text[:-_KEPT_OUTPUT]
