"""Where and how the jobs of commands and of public functions run."""

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from typing import TYPE_CHECKING

from quickreturn.cases.jobs.job import ExecutorError, Limits

if TYPE_CHECKING:
    from quickreturn.cases.case import Case
    from quickreturn.cases.jobs.workshop import Workshop


@dataclass(frozen=True)
class Computing:
    """Where and how jobs run.

    Attributes:
        jobs: processes of this machine at a time; None: one per core.
        cluster: address of the Dask scheduler that distributes the jobs in place of this machine; None: there is none.
        limits: time and memory that a job may take; None: the default ones.
        store: whether results are stored, and stored ones used, where that can be chosen.
        quiet: whether progress on standard error is left out.
    """

    jobs: int | None = None
    cluster: str | None = None
    limits: Limits | None = None
    store: bool = True
    quiet: bool = False

    def tell(self, notice: str) -> None:
        """Called with each notice of the store at once. Results of public functions carry the notices."""

    @contextmanager
    def opened(self, cases: "Sequence[Case]" = (), engines: Sequence[str] = ()) -> "Iterator[Workshop]":
        """The store of results, and what computes. A command announces `cases` and `engines`.

        Raises:
            StoreError: the folder of results cannot be used.
            ExecutorError: the cluster cannot be used.
        """
        from quickreturn.cases.jobs.processes import LocalProcesses
        from quickreturn.cases.jobs.store import Store
        from quickreturn.cases.jobs.workshop import Workshop

        store = Store(tell=self.tell)
        if self.cluster is None:
            yield Workshop(store, LocalProcesses(self.jobs, self.limits, quiet=self.quiet))
            return
        try:
            from quickreturn.cases.jobs.cluster import cluster
        except ModuleNotFoundError as error:
            advice = "try pip install 'quickreturn[cluster]'"
            raise ExecutorError(f"cluster {self.cluster}: the package {error.name} is not installed; {advice}") from error
        with cluster(self.cluster, self.limits, self.quiet) as executor:
            yield Workshop(store, executor)
