"""Where and how jobs run, and the accuracies that a caller may choose."""

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from contextvars import ContextVar
from dataclasses import dataclass
from numbers import Real
from typing import TYPE_CHECKING, Final

from quickreturn.cases.running.job import ExecutorError, Limits

if TYPE_CHECKING:
    from quickreturn.cases.files.case import Case
    from quickreturn.cases.running.workshop import Workshop

#: Relative errors of the tip deflection that a caller may choose.
LOWEST: Final = 1e-4
HIGHEST: Final = 0.05


def checked(accuracy: float | None) -> float | None:
    """The accuracy itself, which may be None. ValueError: it is no number in the range."""
    if accuracy is not None and not (isinstance(accuracy, Real) and LOWEST <= accuracy <= HIGHEST):
        raise ValueError(f"accuracy={accuracy!r}: numbers from {LOWEST:g} to {HIGHEST:g} can be asked for")
    return accuracy


@dataclass
class Computing:
    """Where and how jobs run. A command gives it limits, and tells what it does.

    Attributes:
        jobs: processes of this machine at a time; None: one per core.
        cluster: address of the Dask scheduler that distributes the jobs in place of this machine; None: there is none.
        quiet: whether progress on standard error is left out.
    """

    jobs: int | None = None
    cluster: str | None = None
    quiet: bool = False

    @property
    def limits(self) -> Limits | None:
        """Time and memory that a job may take; None: the default ones."""
        return None

    def tell(self, notice: str) -> None:
        """Called with each notice of the store at once; results of public functions carry the notices."""

    def begun(self, workshop: "Workshop", cases: "Sequence[Case]", engines: Sequence[str]) -> None:
        """Called before anything runs."""


#: The command that is called; None: a public function was called from Python, and its arguments count.
CHOSEN: ContextVar[Computing | None] = ContextVar("CHOSEN", default=None)


@contextmanager
def workshop(jobs: int | None, quiet: bool, cases: "Sequence[Case]" = (), engines: Sequence[str] = ()) -> "Iterator[Workshop]":
    """The store of results, and what computes: as a command has chosen, or else by the arguments of a public function.

    Raises:
        StoreError: the folder of results cannot be used.
        ExecutorError: the cluster cannot be used.
    """
    from quickreturn.cases.running.isolation import LocalProcesses
    from quickreturn.cases.running.store import Store
    from quickreturn.cases.running.workshop import Workshop

    how = CHOSEN.get() or Computing(jobs, quiet=quiet)
    store = Store(tell=how.tell)
    if not how.cluster:
        opened = Workshop(store, LocalProcesses(how.jobs, how.limits, quiet=how.quiet))
        how.begun(opened, cases, engines)
        yield opened
        return
    try:
        from quickreturn.cases.running.cluster import cluster
    except ModuleNotFoundError as error:
        advice = "try pip install 'quickreturn[cluster]'"
        raise ExecutorError(f"cluster {how.cluster}: the package {error.name} is not installed; {advice}") from error
    with cluster(how.cluster, how.limits, how.quiet) as executor:
        opened = Workshop(store, executor)
        how.begun(opened, cases, engines)
        yield opened
