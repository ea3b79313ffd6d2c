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
import multiprocessing
import os
import pickle
import signal
import time
import warnings
from collections import deque
from collections.abc import Callable, Generator, Iterable, Sequence
from dataclasses import dataclass, field
from multiprocessing import connection, forkserver, resource_tracker
from multiprocessing.connection import Connection
from typing import Any, Final

from cases.worker_process import serve

#: Variables by which numerical libraries are told how many threads to use.
THREADS: Final = (
    "OMP_NUM_THREADS",
    "OPENBLAS_NUM_THREADS",
    "MKL_NUM_THREADS",
    "BLIS_NUM_THREADS",
    "VECLIB_MAXIMUM_THREADS",
    "NUMBA_NUM_THREADS",
)
#: What a fork server imports once for all its workers.
PRELOAD: Final = ("cases.worker_process", "numba", "scipy.integrate", "engines.accurate", "engines.registry", "cases.engine_run")

_KEPT_OUTPUT: Final = 4000  # bytes: the last of what a job printed
_LONGEST_WORDS: Final = 200  # characters of it that are worth repeating in a sentence
_LONGEST_WAIT: Final = 86400.0  # s: poll takes no more than 24 days
_GRACE: Final = 2.0  # s: how long a process that is done may take to be gone
_SIGKILL_HINT: Final = " (by the user, or by the system for lack of memory)"


@dataclass(frozen=True)
class Job:
    """A call to make: `function(*arguments)`, both picklable, the function importable by its name."""

    name: str
    function: Callable[..., Any]
    arguments: tuple[Any, ...] = ()


@dataclass(frozen=True)
class Limits:
    """What one job may take; None: as much as there is."""

    seconds: float | None = None  # wall time
    memory: int | None = None  # bytes of address space, on top of what a worker has at its start


def default_limits() -> Limits:
    """What one engine on one scene may take: an hour, and 8 GiB or what the machine has, if that is less.

    Far above what any run needs (minutes, and less than 1 GiB); it ends what would never end.
    """
    return Limits(seconds=3600.0, memory=min(8 * 2**30, os.sysconf("SC_PHYS_PAGES") * os.sysconf("SC_PAGE_SIZE")))


@dataclass(frozen=True)
class Outcome:
    """How a job ended.

    Attributes:
        job: the job.
        value: what its function returned; None if it failed.
        failure: "" if it completed, else one clause, e.g. "killed by SIGSEGV".
        error: the exception that it raised, where there is one and it can travel between processes.
        seconds: wall time of the job.
        output: the last of what it printed, with the traceback of an exception.
    """

    job: Job
    value: Any = None
    failure: str = ""
    error: BaseException | None = None
    seconds: float = 0.0
    output: str = ""

    @property
    def completed(self) -> bool:
        """Whether there is a value."""
        return not self.failure

    @property
    def explanation(self) -> str:
        """The failure and, where a process died, its last line of output: native libraries tell the cause there if anywhere."""
        lines = self.output.splitlines()
        if self.completed or self.error is not None or not lines:
            return self.failure
        return f'{self.failure} (its last words: "{lines[-1].strip()[:_LONGEST_WORDS]}")'


def available_cores() -> int:
    """Number of cores that this process may use."""
    with contextlib.suppress(AttributeError):  # not on every system
        return len(os.sched_getaffinity(0))
    return os.cpu_count() or 1


def run_jobs(
    jobs: Iterable[Job], at_once: int | None = None, limits: Limits | None = None, preload: Sequence[str] = PRELOAD
) -> Generator[Outcome, None, None]:
    """Run jobs in processes of their own and yield their outcomes as they end, in whatever order that is.

    Workers are killed when the iterator is closed or left by an exception, Ctrl-C included. Time limits are enforced while the
    caller waits for the next outcome.

    Args:
        jobs: what to do, started in this order.
        at_once: how many at a time; None: one per core.
        limits: of each job.
        preload: modules that the fork server imports once; only the first call of a process decides.

    Raises:
        ValueError: `at_once` is below 1.
        KeyboardInterrupt: Ctrl-C; no worker is left.
    """
    if at_once is not None and at_once < 1:
        raise ValueError(f"at_once: {at_once} jobs at a time; at least 1 is needed")
    waiting, running = deque(jobs), list[_Worker]()
    limits = limits or Limits()
    try:
        while waiting or running:
            while waiting and len(running) < (at_once or available_cores()):
                job = waiting.popleft()
                try:
                    running.append(_started(job, limits, preload))
                except (OSError, EOFError) as error:
                    yield Outcome(job, failure=f"could not be started ({error or type(error).__name__})")
            if not running:  # none could be started
                continue
            deadline = min((worker.deadline for worker in running if worker.deadline is not None), default=None)
            timeout = None if deadline is None else min(max(0.0, deadline - time.monotonic()), _LONGEST_WAIT)
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


def _fork_server(preload: Sequence[str]) -> Any:
    """The multiprocessing context of a fork server that computes with one thread and does not see Ctrl-C, and so do its workers."""
    context = multiprocessing.get_context("forkserver")
    context.set_forkserver_preload(list(preload))
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # if the tracker was killed: it says so, but nothing here uses what it tracks
        resource_tracker.ensure_running()  # it lifts the block when it starts, so it must run before
    # nor does it look for modules where the user stands: a folder `cases` there is not ours
    environment = {**dict.fromkeys(THREADS, "1"), "PYTHONSAFEPATH": "1"}
    before = {name: os.environ.get(name) for name in environment}
    os.environ.update(environment)
    mask = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})  # this process gets a Ctrl-C afterwards
    try:
        forkserver.ensure_running()
    finally:
        for name, value in before.items():
            if value is None:
                del os.environ[name]
            else:
                os.environ[name] = value
        signal.pthread_sigmask(signal.SIG_SETMASK, mask)
    return context


def _started(job: Job, limits: Limits, preload: Sequence[str]) -> "_Worker":
    """A worker at its job, from a new fork server if the old one turns out to be dying: until it is gone it still counts as alive."""
    patience = time.monotonic() + _GRACE
    while True:
        try:
            return _Worker(job, limits, preload)
        except (ConnectionError, EOFError):
            if time.monotonic() >= patience:
                raise
            time.sleep(0.02)


@dataclass
class _Pipes:
    """The runner's ends."""

    answer: Connection
    output: Connection
    lifeline: Connection
    text: bytearray = field(default_factory=bytearray)


class _Worker:
    """A job in its process, seen from the runner."""

    def __init__(self, job: Job, limits: Limits, preload: Sequence[str]) -> None:
        self._job, self._limits = job, limits
        context = _fork_server(preload)
        ours_answer, its_answer = context.Pipe(duplex=False)
        ours_output, its_output = context.Pipe(duplex=False)
        its_lifeline, ours_lifeline = context.Pipe(duplex=False)
        self._pipes = _Pipes(ours_answer, ours_output, ours_lifeline)
        arguments = (pickle.dumps((job.function, job.arguments)), limits.memory, its_lifeline, its_output, its_answer)
        self._process = context.Process(target=serve, args=arguments, name=job.name, daemon=True)
        self._process.start()  # waits until the fork server has its imports done
        self._begin = time.monotonic()
        self._watched = True  # by the fork server, which tells how it ends
        for end in (its_answer, its_output, its_lifeline):  # only the worker may hold these: their closing tells that it ended
            end.close()

    @property
    def deadline(self) -> float | None:
        return None if self._limits.seconds is None else self._begin + self._limits.seconds

    def handles(self) -> list[Any]:
        """What becomes ready when something happens."""
        pipes = [pipe for pipe in (self._pipes.answer, self._pipes.output) if not pipe.closed]
        return [*pipes, self._process.sentinel] if self._watched else pipes

    def outcome(self, ready: list[Any]) -> Outcome | None:
        """The outcome if the job has ended or run out of time, else None. `ready`: those of the handles that are."""
        if self._pipes.output in ready:
            self._read_output()
        if self._process.sentinel in ready and self._exists() and not self._pipes.answer.poll():
            self._watched = False  # not the worker ended but the fork server: the worker's answer is still to come
        elif self._pipes.answer in ready or self._process.sentinel in ready:
            return self._ended()
        if self.deadline is not None and time.monotonic() >= self.deadline:
            self._kill()
            return self._outcome(failure=f"stopped at the time limit of {self._limits.seconds:g} s")
        return None

    def end(self) -> None:
        """Leave neither process nor pipe behind."""
        if self._process.is_alive() or not self._watched:
            self._kill()
        self._process.join()
        self._process.close()
        for pipe in (self._pipes.answer, self._pipes.output, self._pipes.lifeline):
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

    def _ended(self) -> Outcome:
        try:
            message = pickle.loads(self._pipes.answer.recv_bytes())
        except (EOFError, OSError):
            return self._outcome(failure=self._cause_of_death())
        except Exception as error:  # the value's class cannot be rebuilt here
            return self._outcome(failure=f"its result cannot be read: {type(error).__name__}: {error}")
        if message[0] == "value":
            return self._outcome(value=message[1])
        _, raised, description = message
        return self._outcome(failure=self._clause(raised, description), error=raised)

    def _cause_of_death(self) -> str:
        self._process.join(_GRACE)
        code = self._process.exitcode
        if not self._watched or (code is not None and self._exists()):  # the fork server is gone, and what it knew
            return "ended without a result"
        if code is None:
            return "cut its connection to the runner"
        if code >= 0:
            return f"ended without a result (exit code {code})"
        try:
            name = signal.Signals(-code).name
        except ValueError:
            name = f"signal {-code}"
        return f"killed by {name}{_SIGKILL_HINT if name == 'SIGKILL' else ''}"

    def _clause(self, raised: BaseException | None, description: str) -> str:
        if not isinstance(raised, MemoryError):
            return f"raised {description}"
        limit = "" if self._limits.memory is None else f" (limit {self._limits.memory / 2**20:.0f} MiB)"
        return f"ran out of memory{limit}"

    def _outcome(self, value: Any = None, failure: str = "", error: BaseException | None = None) -> Outcome:
        seconds = time.monotonic() - self._begin
        self._process.join(_GRACE)  # its last words are in the pipe once it is gone
        while not self._pipes.output.closed and self._pipes.output.poll():
            self._read_output()
        text = self._pipes.text.decode(errors="replace").strip()
        return Outcome(self._job, value, failure, error, seconds, text)

    def _read_output(self) -> None:
        piece = os.read(self._pipes.output.fileno(), 65536)
        if not piece:
            self._pipes.output.close()
        self._pipes.text += piece
        del self._pipes.text[:-_KEPT_OUTPUT]
