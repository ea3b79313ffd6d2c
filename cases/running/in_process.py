"""Computes jobs in the caller's own process, one after the other: definitions of a notebook or a test exist only there."""

import time
from collections.abc import Generator, Sequence

from quickreturn.cases.running.job import MISSING, Job, Limits, Outcome, V, Watch
from quickreturn.engines import progress


class ThisProcess:
    """The executor without processes. Limits do not apply, and a job that crashes ends the caller."""

    at_once = 1
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

    at_once, limits, quiet = 1, Limits(), True

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
