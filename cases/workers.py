"""Many jobs, each in its own process: what one does to itself, the others do not notice.

A worker comes from a fork server that has the slow imports done (or is spawned where there is none). It computes with one thread,
its output is caught, and its result comes back through a pipe. It may be limited in time and memory, and it ends with the runner,
even if that is killed. Whatever happens to it becomes an `Outcome` with one clause that says so.
"""

import contextlib
import multiprocessing
import os
import pickle
import signal
import time
from collections import deque
from collections.abc import Callable, Generator, Iterable, Iterator, Sequence
from dataclasses import dataclass, field
from multiprocessing import connection, resource_tracker
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
PRELOAD: Final = ("cases.worker_process", "numba", "scipy.integrate", "engines.accurate", "engines.registry")

_KEPT_OUTPUT: Final = 4000  # bytes: the last of what a job printed
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


@dataclass(frozen=True)
class Outcome:
    """How a job ended.

    Attributes:
        job: the job.
        value: what its function returned; None if it failed.
        failure: "" if it completed, else one clause, e.g. "killed by SIGSEGV".
        error: the exception that it raised, where there is one and it can travel between processes.
        seconds: wall time of the job, with the start of its process.
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
        KeyboardInterrupt: Ctrl-C; no worker is left.
    """
    waiting, running = deque(jobs), list[_Worker]()
    limits = limits or Limits()
    context = _context(preload)
    try:
        while waiting or running:
            while waiting and len(running) < (at_once or available_cores()):
                running.append(_Worker(context, waiting.popleft(), limits))
            deadline = min((worker.deadline for worker in running if worker.deadline is not None), default=None)
            timeout = None if deadline is None else max(0.0, deadline - time.monotonic())
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


def _context(preload: Sequence[str]) -> Any:
    if "forkserver" not in multiprocessing.get_all_start_methods():
        return multiprocessing.get_context("spawn")
    context = multiprocessing.get_context("forkserver")
    context.set_forkserver_preload(list(preload))
    return context


@contextlib.contextmanager
def _quiet_start() -> Iterator[None]:
    """What is started within computes with one thread and does not see Ctrl-C; this process gets a Ctrl-C afterwards."""
    resource_tracker.ensure_running()  # it lifts the block when it starts, so it must run before
    before = {name: os.environ.get(name) for name in THREADS}
    os.environ.update(dict.fromkeys(THREADS, "1"))
    mask = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
    try:
        yield
    finally:
        for name, value in before.items():
            if value is None:
                del os.environ[name]
            else:
                os.environ[name] = value
        signal.pthread_sigmask(signal.SIG_SETMASK, mask)


@dataclass
class _Pipes:
    """The runner's ends."""

    answer: Connection
    output: Connection
    lifeline: Connection
    text: bytearray = field(default_factory=bytearray)


class _Worker:
    """A job in its process, seen from the runner."""

    def __init__(self, context: Any, job: Job, limits: Limits) -> None:
        self._job, self._limits = job, limits
        work = pickle.dumps((job.function, job.arguments))
        ours_answer, its_answer = context.Pipe(duplex=False)
        ours_output, its_output = context.Pipe(duplex=False)
        its_lifeline, ours_lifeline = context.Pipe(duplex=False)
        self._pipes = _Pipes(ours_answer, ours_output, ours_lifeline)
        arguments = (work, limits.memory, its_lifeline, its_output, its_answer)
        self._begin = time.monotonic()
        self._process = context.Process(target=serve, args=arguments, name=job.name, daemon=True)
        with _quiet_start():
            self._process.start()
        for end in (its_answer, its_output, its_lifeline):  # only the worker may hold these: their closing tells that it ended
            end.close()

    @property
    def deadline(self) -> float | None:
        return None if self._limits.seconds is None else self._begin + self._limits.seconds

    def handles(self) -> list[Any]:
        """What becomes ready when something happens."""
        pipes = [pipe for pipe in (self._pipes.answer, self._pipes.output) if not pipe.closed]
        return [*pipes, self._process.sentinel]

    def outcome(self, ready: list[Any]) -> Outcome | None:
        """The outcome if the job has ended or run out of time, else None. `ready`: those of the handles that are."""
        if self._pipes.output in ready:
            self._read_output()
        if self._pipes.answer in ready or self._process.sentinel in ready:
            return self._ended()
        if self.deadline is not None and time.monotonic() >= self.deadline:
            self._process.kill()
            return self._outcome(failure=f"stopped at the time limit of {self._limits.seconds:g} s")
        return None

    def end(self) -> None:
        """Leave neither process nor pipe behind."""
        if self._process.is_alive():
            self._process.kill()
        self._process.join()
        self._process.close()
        for pipe in (self._pipes.answer, self._pipes.output, self._pipes.lifeline):
            pipe.close()

    def _ended(self) -> Outcome:
        try:
            message = pickle.loads(self._pipes.answer.recv_bytes())
        except (EOFError, OSError):
            self._process.join()
            return self._outcome(failure=_cause_of_death(self._process.exitcode))
        except Exception as error:  # the value's class cannot be rebuilt here
            return self._outcome(failure=f"its result cannot be read: {type(error).__name__}: {error}")
        if message[0] == "value":
            return self._outcome(value=message[1])
        _, raised, description = message
        return self._outcome(failure=self._clause(raised, description), error=raised)

    def _clause(self, raised: BaseException | None, description: str) -> str:
        if not isinstance(raised, MemoryError):
            return f"raised {description}"
        limit = "" if self._limits.memory is None else f" (limit {self._limits.memory / 2**20:.0f} MiB)"
        return f"ran out of memory{limit}"

    def _outcome(self, value: Any = None, failure: str = "", error: BaseException | None = None) -> Outcome:
        seconds = time.monotonic() - self._begin
        self._process.join(1.0)  # its last words are in the pipe once it is gone
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


def _cause_of_death(exit_code: int | None) -> str:
    if exit_code is None or exit_code >= 0:
        return f"ended without a result (exit code {exit_code})"
    try:
        name = signal.Signals(-exit_code).name
    except ValueError:
        name = f"signal {-exit_code}"
    return f"killed by {name}{_SIGKILL_HINT if name == 'SIGKILL' else ''}"
