"""What is to be computed, what it may take, who computes it, how far it is, and how it ended."""

import os
from collections.abc import Callable, Generator, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Final, Generic, Protocol, TypeVar

from quickreturn.reference_model.errors import ToldError

if TYPE_CHECKING:
    from quickreturn.engines.progress import Progress

#: Failure of a job that is not stored where nothing is computed.
MISSING: Final = "is not stored"
#: Exceptions that are the machine's doing.
_OF_THE_MACHINE: Final = (MemoryError, OSError, ImportError)

T = TypeVar("T")
V = TypeVar("V")

_LONGEST_WORDS: Final = 200  # characters of what a job printed last that are worth repeating in a sentence


@dataclass(frozen=True)
class Limits:
    """What one job may take; None: as much as there is."""

    seconds: float | None = None  # wall time
    memory: int | None = None  # bytes of address space, on top of what a worker has at its start


def default_limits() -> Limits:
    """An hour, and 8 GiB or what the machine has, if that is less: far above what any run needs, to end what would never end."""
    return Limits(seconds=3600.0, memory=min(8 * 2**30, os.sysconf("SC_PHYS_PAGES") * os.sysconf("SC_PAGE_SIZE")))


def would_come_again(outcome: "Outcome[Any]") -> bool:
    """Whether a job would end so again: with a result, or with an exception of its own."""
    return outcome.completed or (isinstance(outcome.error, Exception) and not isinstance(outcome.error, _OF_THE_MACHINE))


@dataclass(frozen=True)
class Job(Generic[T]):
    """A result to be had: `function(*arguments)`, both picklable, the function importable by its name."""

    name: str  # for people
    function: Callable[..., T]  # makes the result; the type that it is annotated with is what comes back from the store
    arguments: tuple[Any, ...] = ()  # of the function
    kind: str = ""  # of result; counts in the key under which it is stored
    engines: tuple[str, ...] = ()  # names of those whose versions, and code where they are from elsewhere, it depends on
    code: tuple[str, ...] = ()  # packages and modules that it depends on besides those of a simulation (`cases.jobs.key.SIMULATION`)
    inputs: Any = None  # what determines the result besides engines and code; None: the arguments
    limits: Limits | None = None  # None: those of the executor
    # whether it is one of many short ones, whose processes would take longer to get ready than they compute. A process may do several of
    # them one after the other. What crashes or hangs there costs its own job and the process.
    brief: bool = False
    points: int = 1  # how much of the whole it is, for the person who waits
    lasts: Callable[["Outcome[Any]"], bool] | None = would_come_again  # whether an ending is stored; None: none is, nor looked for


@dataclass(frozen=True)
class Outcome(Generic[T]):
    """How a job ended."""

    job: Job[T]
    value: T | None = None  # what its function returned; None if it failed
    failure: str = ""  # "" if it completed, else one clause, e.g. "killed by SIGSEGV"
    error: BaseException | None = None  # the exception that it raised, where there is one and it can travel between processes
    seconds: float = 0.0  # wall time of the job
    output: str = ""  # the last of what it printed, with the traceback of an exception
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
        """The failure in the engine's words where it has some; of a process that died with the last line of a native library."""
        if self.error is not None:
            from quickreturn.engines.base import EngineFailure, Refusal

            return str(self.error) if isinstance(self.error, (EngineFailure, Refusal)) else self.failure
        lines = self.output.splitlines()
        if self.completed or not lines:
            return self.failure
        return f'{self.failure} (its last words: "{lines[-1].strip()[:_LONGEST_WORDS]}")'


#: Called with a job that has begun (None), or with how far it is.
Watch = Callable[[Job[Any], "Progress | None"], None]


class ExecutorError(ToldError):
    """Jobs cannot be computed where they were sent; the text is one sentence."""


class Executor(Protocol):
    """Computes jobs somewhere, apart from each other: what one does to itself costs that one and no other."""

    @property
    def quiet(self) -> bool:
        """Whether nobody is to be told how far the jobs are."""

    @property
    def at_once(self) -> int:
        """How many jobs are computed at a time."""

    @property
    def limits(self) -> Limits:
        """Those of a job that has none of its own."""

    def run(self, jobs: Sequence[Job[V]], watch: Watch | None = None) -> Generator[Outcome[V], None, None]:
        """Outcomes as jobs end, in whatever order that is; closing the generator ends those that are at work.

        Args:
            jobs: what to do, started in this order.
            watch: is told how far they are; None: nobody wants to know.

        Raises:
            KeyboardInterrupt: Ctrl-C; nothing is left running.
            ExecutorError: the machines that compute them are lost, or would compute something else than this one.
        """
