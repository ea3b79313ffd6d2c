"""Jobs, their limits, executors, progress and outcomes.

`ThisProcess` computes jobs in the caller's own process: definitions of a notebook or a test exist only there.
"""

import os
import time
from collections.abc import Callable, Generator, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Final, Generic, Protocol, TypeVar

from quickreturn.engines import progress
from quickreturn.reference_model.errors import OF_THE_MACHINE, ToldError

if TYPE_CHECKING:
    from quickreturn.engines.progress import Progress

#: Failure of a job that is not stored if nothing is computed.
MISSING: Final = "is not stored"

T = TypeVar("T")
V = TypeVar("V")

_LONGEST_WORDS: Final = 200  # largest number of characters of a job's last output in a sentence


@dataclass(frozen=True)
class Limits:
    """Limits of one job; None: no limit."""

    seconds: float | None = None  # wall time
    memory: int | None = None  # bytes of address space, on top of what a worker has at its start


def default_limits() -> Limits:
    """An hour, and 8 GiB or the machine's memory if that is less: far above the needs of any run, to stop endless ones."""
    return Limits(seconds=3600.0, memory=min(8 * 2**30, os.sysconf("SC_PHYS_PAGES") * os.sysconf("SC_PAGE_SIZE")))


def would_repeat(outcome: "Outcome[Any]") -> bool:
    """Whether the outcome of a job would repeat: a result, or an exception of its own."""
    return outcome.completed or (isinstance(outcome.error, Exception) and not isinstance(outcome.error, OF_THE_MACHINE))


@dataclass(frozen=True)
class Job(Generic[T]):
    """A result to compute: `function(*arguments)`, both picklable, the function importable by its name."""

    name: str  # for people
    function: Callable[..., T]  # computes the result, by its module's code; its annotated return type is the type that the store returns
    arguments: tuple[Any, ...] = ()  # of the function
    kind: str = ""  # kind of result; part of the key under which it is stored
    engines: tuple[str, ...] = ()  # engines on whose versions it depends, and on whose code if they are of other packages
    inputs: Any = None  # further data that determine the result, besides engines and code; None: the arguments
    limits: Limits | None = None  # None: those of the executor
    # whether it is one of many short jobs whose processes would take longer to start than to compute. A process may do several of them one
    # after the other. A crash or hang loses only its own job and the process.
    brief: bool = False
    pieces: bool = False  # whether its function takes `store.Pieces` as a last argument; it gets them where there is a store
    points: int = 1  # weight of the job in the display of progress
    lasts: Callable[["Outcome[Any]"], bool] | None = would_repeat  # whether an outcome is stored; None: the store is not used


@dataclass(frozen=True)
class Outcome(Generic[T]):
    """How a job ended."""

    job: Job[T]
    value: T | None = None  # result of its function; None if it failed
    failure: str = ""  # "" if it completed, else one clause, e.g. "killed by SIGSEGV"
    error: BaseException | None = None  # its exception, if there is one that can be pickled
    seconds: float = 0.0  # wall time of the job
    output: str = ""  # the end of its output, with the traceback of an exception
    stored: bool = False  # whether it was in the store before

    @property
    def completed(self) -> bool:
        """Whether there is a value."""
        return not self.failure

    @property
    def missing(self) -> bool:
        """Whether nobody computed it, and it is not stored."""
        return self.failure == MISSING

    @property
    def explanation(self) -> str:
        """The failure, in the engine's words if there are any; for a process that died also the last line of its output."""
        if self.error is not None:
            from quickreturn.engines.base import EngineFailure, Refusal

            return str(self.error) if isinstance(self.error, (EngineFailure, Refusal)) else self.failure
        lines = self.output.splitlines()
        if self.completed or not lines:
            return self.failure
        return f'{self.failure} (its last words: "{lines[-1].strip()[:_LONGEST_WORDS]}")'


#: Called with a job and None when it begins, or with its progress.
Watch = Callable[[Job[Any], "Progress | None"], None]


class ExecutorError(ToldError):
    """The executor cannot compute jobs; the text is one sentence."""


class Executor(Protocol):
    """Computes jobs separately from each other: a crash loses only its own job."""

    @property
    def quiet(self) -> bool:
        """Whether progress is not reported."""

    @property
    def limits(self) -> Limits:
        """Limits of a job that has none of its own."""

    def run(self, jobs: Sequence[Job[V]], watch: Watch | None = None) -> Generator[Outcome[V], None, None]:
        """Outcomes as jobs end, in any order; closing the generator stops those at work.

        Args:
            jobs: the jobs, started in this order.
            watch: called with their progress; None: progress is not reported.

        Raises:
            KeyboardInterrupt: Ctrl-C; nothing is left running.
            ExecutorError: the connection to the computing machines is lost, or these have other code than this one.
        """


class ThisProcess:
    """The executor without processes. Limits do not apply, and a job that crashes ends the caller."""

    limits = Limits()

    def __init__(self, quiet: bool = True) -> None:
        self.quiet = quiet

    def run(self, jobs: Sequence[Job[V]], watch: Watch | None = None) -> Generator[Outcome[V], None, None]:
        """See `cases.running.job.Executor`."""
        for job in jobs:
            if watch is not None:
                watch(job, None)
                progress.listen(lambda how_far, job=job, watch=watch: watch(job, how_far))  # type: ignore[misc]
            try:
                yield done(job)
            finally:
                if watch is not None:
                    progress.listen(None)


class Nobody:
    """The executor that computes nothing: jobs that are not stored are reported as missing."""

    limits, quiet = Limits(), True

    def run(self, jobs: Sequence[Job[V]], watch: Watch | None = None) -> Generator[Outcome[V], None, None]:
        """See `cases.running.job.Executor`."""
        yield from (Outcome(job, failure=MISSING) for job in jobs)


def done(job: Job[V]) -> Outcome[V]:
    """The outcome of a job in this process."""
    began = time.monotonic()
    try:
        return Outcome(job, job.function(*job.arguments), seconds=time.monotonic() - began)
    except Exception as error:
        return Outcome(job, failure=f"raised {type(error).__name__}: {error}", error=error, seconds=time.monotonic() - began)
