"""Jobs on a cluster: a Dask scheduler distributes them, and each worker computes its jobs in processes of their own.

If a worker is killed, other workers compute its jobs again; a job that kills four of them is given up, with those that waited there.
Results go into the store of the machine that runs the command. This module needs the package distributed, which the extra `cluster`
installs.
"""

import multiprocessing
from collections.abc import Generator, Sequence
from functools import partial
from typing import Final

from distributed import Client, Status, get_worker

from quickreturn.cases.running.isolation import computed, isolated
from quickreturn.cases.running.job import ExecutorError, Job, Limits, Outcome, V, Watch, default_limits
from quickreturn.cases.running.key import LIBRARIES, code_fingerprint, key_of, library_version, version_of
from quickreturn.engines.base import first_line
from quickreturn.engines.registry import own_engines

#: Longest time, s, in which the scheduler must answer, and then the first worker join. On a busy machine they take a few seconds.
PATIENCE: Final = 10.0


def cluster(address: str, limits: Limits | None = None, quiet: bool = True) -> "Cluster":
    """The executor on a cluster, whose scheduler has an address such as "tcp://host:8786"; leaving its `with` block ends the connection.

    Limits and quiet as of `cases.running.job.Executor`; None: `default_limits` of this machine.

    Raises:
        ExecutorError: there is no such scheduler, no worker, or one with other code or versions than this machine.
    """
    try:
        if not address:  # the client would look for one elsewhere
            raise ValueError("missing port number in address ''")
        client = Client(address, timeout=PATIENCE, set_as_default=False)
    except (OSError, ValueError) as error:
        told = f"cluster {address}: no scheduler answers there ({first_line(error)}); start one with `dask scheduler`"
        raise ExecutorError(told) from error
    try:
        _check(client, address)
    except BaseException:
        client.close()
        raise
    return Cluster(client, limits or default_limits(), quiet)


class Cluster:
    """An executor on a cluster, made by `cluster`; see `cases.running.job.Executor`."""

    def __init__(self, client: Client, limits: Limits, quiet: bool) -> None:
        self._client, self.limits, self.quiet = client, limits, quiet

    def run(self, jobs: Sequence[Job[V]], watch: Watch | None = None) -> Generator[Outcome[V], None, None]:
        """See `cases.running.job.Executor`; `watch` is not called, because the workers do not report their progress."""
        executor = self._client.get_executor(pure=False)
        yield from computed(
            lambda job: executor.submit(_on_worker, job, key_of(job), self.limits), jobs, partial(executor.shutdown, wait=False)
        )

    def __enter__(self) -> "Cluster":
        return self

    def __exit__(self, *_: object) -> None:
        self._client.close()


def _check(client: Client, address: str) -> None:
    """Raise ExecutorError unless there are workers, all with this machine's versions, which may start processes."""
    try:
        client.wait_for_workers(1, timeout=PATIENCE)
    except TimeoutError as error:
        raise ExecutorError(f"cluster {address}: it has no worker; start one with `dask worker {address}`") from error
    here = installed()
    for worker, answer in client.run(_worker, on_error="return").items():
        place = f"cluster {address}: worker {worker}"
        if isinstance(answer, Exception):
            raise ExecutorError(f"{place} has no quickreturn of this version ({type(answer).__name__}: {answer}); install it there")
        daemon, there = answer
        differing = [name for name in here if there.get(name) != here[name]]
        if differing:
            name = differing[0]
            raise ExecutorError(f"{place} has {name} {there.get(name)}, this machine {here[name]}; both must have the same")
        if daemon:
            raise ExecutorError(f"{place} may start no processes; set DASK_DISTRIBUTED__WORKER__DAEMON=False where it is started")


def installed() -> dict[str, str]:
    """Versions that determine results, by name: libraries, engines, and this project's code."""
    engines = {f"engine {name}": version_of(name)[-2] for name in sorted(own_engines())}
    versions = {library: library_version(library) for library in LIBRARIES}
    return {**versions, **engines, "code of quickreturn": code_fingerprint()[:12]}


def _worker() -> tuple[bool, dict[str, str]]:
    """On a worker: whether it is a daemon, which may not start processes, and the installed versions."""
    return multiprocessing.current_process().daemon, installed()


def _on_worker(job: Job[V], key: str, limits: Limits) -> Outcome[V]:
    """On a worker: compute a job until it is cancelled. Its key shows other code or libraries, as on a worker that joined unchecked."""
    worker = get_worker()
    if key_of(job) != key:
        raise ExecutorError(f"worker {worker.address} has other code or libraries than the machine that asks for {job.name}")
    task = worker.get_current_task()

    def unwanted() -> bool:
        """Whether the client is gone or has cancelled the job, or the worker is closing."""
        return worker.state.tasks[task].state == "cancelled" or worker.status in (Status.closing, Status.closed, Status.failed)

    return isolated(job, limits, stopped=unwanted)
