"""The fork server: it has the slow imports done, computes with one thread, and starts the processes of the jobs.

Several threads may start processes. Whenever `multiprocessing` starts one it looks at all others, and two looks at once at the same
process spoil its exit code; so one lock guards them.
"""

import contextlib
import multiprocessing
import os
import signal
import sys
import threading
import warnings
from collections.abc import Callable, Iterator, Sequence
from multiprocessing import connection, forkserver, resource_tracker
from types import ModuleType
from typing import Any, Final

#: Variables by which numerical libraries are told how many threads to use.
THREADS: Final = tuple(f"{library}_NUM_THREADS" for library in ("OMP", "OPENBLAS", "MKL", "BLIS", "NUMBA"))
#: Modules that a fork server imports once for all its workers.
PRELOAD: Final = (
    "quickreturn.cases.jobs.worker",
    "quickreturn.cases.jobs.warm",
    "scipy.integrate",
    "quickreturn.engines.accurate",
    "quickreturn.engines.registry",
    "quickreturn.engines.own.simulation",
    "quickreturn.reference_model.periodic",
    "quickreturn.engines.exudyn.simulation",
    "quickreturn.engines.mujoco.simulation",
    "quickreturn.cases.runs.steady_state",
)

_LOCK: Final = threading.Lock()
#: Number of the fork server as long as no process was asked of it.
_without_job: Final[list[int]] = []


def get_ready(preload: Sequence[str]) -> None:
    """Start the fork server now, so that it has its imports done when the first job comes; what fails here is told then."""
    with contextlib.suppress(OSError, EOFError), _LOCK:
        before = _number()
        _context(preload)
        if _number() != before:
            _without_job.append(_number())


def not_needed() -> None:
    """End the fork server if it was started for a job that has not come: it would go on with its imports."""
    with _LOCK:
        for number in (_without_job.pop() for _ in list(_without_job)):
            if number == _number():
                with contextlib.suppress(ProcessLookupError):
                    os.kill(number, signal.SIGKILL)


def _number() -> Any:
    """Of the fork server's process; None: there is none."""
    return vars(forkserver._forkserver)["_forkserver_pid"]


class Process:
    """A process that calls `target(*pipes)` with the worker's ends of its pipes, and ends when it returns.

    Args:
        target: a function of a module.
        receives: for each pipe whether the worker reads from it; else it writes.
        preload: modules that the fork server imports; the first process decides.
        hide_main: whether the worker shall not run the caller's script, which would do again what the script does at its top.

    Raises:
        OSError, EOFError: no process can be started.
    """

    def __init__(self, target: Callable[..., None], receives: Sequence[bool], preload: Sequence[str], hide_main: bool) -> None:
        with _LOCK:
            context = _context(preload)
            _without_job.clear()
            pairs = [context.Pipe(duplex=False) for _ in receives]
            its = [pair[0 if reads else 1] for pair, reads in zip(pairs, receives, strict=True)]
            self.pipes = [pair[1 if reads else 0] for pair, reads in zip(pairs, receives, strict=True)]  # this process' ends
            self._process = context.Process(target=target, args=its, daemon=True)
            with _hidden_main() if hide_main else contextlib.nullcontext():
                self._process.start()  # waits until the fork server has its imports done
            #: Becomes ready when the process has ended, or the fork server that watches over it.
            self.sentinel: int = self._process.sentinel
        for end in its:  # only the worker may hold these: their closing tells that it ended
            end.close()

    def exit_code(self, patience: float) -> int | None:
        """As of `multiprocessing.Process.exitcode`, waiting up to `patience` (s) for it; None: it has not ended."""
        connection.wait([self.sentinel], patience)
        with _LOCK:
            return self._process.exitcode

    def exists(self) -> bool:
        """Whether there is a process of this number: not once the fork server has told of its end."""
        try:
            os.kill(self._process.pid, 0)
        except ProcessLookupError:
            return False
        return True

    def kill(self) -> None:
        """End it, if it has not ended."""
        with contextlib.suppress(ProcessLookupError):
            os.kill(self._process.pid, signal.SIGKILL)

    def close(self) -> None:
        """Wait for the end of the process, and leave no pipe behind."""
        connection.wait([self.sentinel])
        with _LOCK:
            self._process.join()
            self._process.close()
        for pipe in self.pipes:
            pipe.close()


def _context(preload: Sequence[str]) -> Any:
    """The multiprocessing context of a fork server that computes with one thread and does not see Ctrl-C, nor do its workers."""
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


@contextlib.contextmanager
def _hidden_main() -> Iterator[None]:
    main = sys.modules["__main__"]
    sys.modules["__main__"] = ModuleType("__main__")
    try:
        yield
    finally:
        sys.modules["__main__"] = main
