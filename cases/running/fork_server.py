"""The fork server: it has completed the slow imports, computes with one thread, and starts the processes of the jobs.

Several threads may start processes. When `multiprocessing` starts one it polls all others, and two polls of the same process at once spoil
its exit code; so one lock guards them.
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

from quickreturn.reference_model.native import cache_folder

#: Environment variables for the number of threads of numerical libraries.
THREADS: Final = tuple(f"{library}_NUM_THREADS" for library in ("OMP", "OPENBLAS", "MKL", "BLIS", "NUMBA"))
#: Modules that a fork server imports once for all its workers.
PRELOAD: Final = (
    "quickreturn.cases.running.worker",
    "quickreturn.cases.running.warm",
    "scipy.integrate",
    "quickreturn.engines.accurate",
    "quickreturn.engines.registry",
    "quickreturn.engines.own.simulation",
    "quickreturn.reference_model.cycles.periodic",
    "quickreturn.engines.exudyn.simulation",
    "mujoco",  # without our module of it, which is compiled at its import
    "quickreturn.cases.motion.steady_state",
)

#: Instead of these, those for processes that describe engines, and for those that simulate with them.
DESCRIBING: Final = ("quickreturn.cases.running.worker", "quickreturn.engines.registry", "quickreturn.engines.accurate")
COMPUTING: Final = (*DESCRIBING, "quickreturn.cases.motion.solving", "quickreturn.engines.own.simulation")

_LOCK: Final = threading.Lock()
#: Process number of a fork server that has not started a process yet.
_without_job: Final[list[int]] = []


def get_ready(preload: Sequence[str]) -> None:
    """Start the fork server now, so that its imports are complete when the first job comes; a failure is reported then."""
    with contextlib.suppress(OSError, EOFError), _LOCK:
        before = _number()
        _context(preload)
        if _number() != before:
            _without_job.append(_number())


def not_needed() -> None:
    """End a fork server without a job: it would otherwise go on with its imports."""
    with _LOCK:
        for number in (_without_job.pop() for _ in list(_without_job)):
            if number == _number():
                with contextlib.suppress(ProcessLookupError):
                    os.kill(number, signal.SIGKILL)


def _number() -> Any:
    """Process number of the fork server; None: there is none."""
    return vars(forkserver._forkserver)["_forkserver_pid"]


class Process:
    """A process that calls `target(*pipes)` with the worker's ends of its pipes, and ends when it returns.

    Args:
        target: a function of a module.
        receives: for each pipe whether the worker reads from it; otherwise it writes.
        preload: modules that the fork server imports; the first process decides.
        hide_main: whether the worker does not run the caller's script, whose top level would otherwise run again.

    Raises:
        OSError, EOFError: no process can be started.
    """

    def __init__(self, target: Callable[..., None], receives: Sequence[bool], preload: Sequence[str], hide_main: bool) -> None:
        with _LOCK:
            context = _context(preload)
            _without_job.clear()
            pairs = [context.Pipe(duplex=False) for _ in receives]
            worker_ends = [pair[0 if reads else 1] for pair, reads in zip(pairs, receives, strict=True)]
            self.pipes = [pair[1 if reads else 0] for pair, reads in zip(pairs, receives, strict=True)]  # this process' ends
            self._process = context.Process(target=target, args=worker_ends, daemon=True)
            with _hidden_main() if hide_main else contextlib.nullcontext():
                self._process.start()  # waits until the fork server has completed its imports
            #: Becomes ready when the process, or the fork server that watches it, has ended.
            self.sentinel: int = self._process.sentinel
        for end in worker_ends:  # only the worker may hold these: they close when it ends
            end.close()

    def exit_code(self, patience: float) -> int | None:
        """The exit code as in `multiprocessing.Process.exitcode`, after up to `patience` (s); None: the process has not ended."""
        connection.wait([self.sentinel], patience)
        with _LOCK:
            code: int | None = self._process.exitcode
        return code

    def exists(self) -> bool:
        """Whether there is a process of this number although its sentinel is ready, because the fork server has ended."""
        try:
            os.kill(self._process.pid, 0)
        except ProcessLookupError:
            return False
        return True

    def kill(self) -> None:
        """End the process if it has not ended."""
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
    """The multiprocessing context of the fork server, which runs afterwards."""
    context = multiprocessing.get_context("forkserver")
    context.set_forkserver_preload(list(preload))
    with _surroundings():
        forkserver.ensure_running()
    return context


@contextlib.contextmanager
def _surroundings() -> Iterator[None]:
    """Let a process that starts now, and all that come from it, compute with one thread and not see Ctrl-C."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # of a tracker that was killed: nothing here uses the resources that it tracks
        resource_tracker.ensure_running()  # its start unblocks SIGINT, so it must come before the block below
    # PYTHONSAFEPATH: the server must not import from the current folder, which may hold another folder `cases`
    environment = {**dict.fromkeys(THREADS, "1"), "PYTHONSAFEPATH": "1"}
    cache_folder.folder()  # where it is a temporary one, the workers use the same
    before = {name: os.environ.get(name) for name in environment}
    os.environ.update(environment)
    mask = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})  # a Ctrl-C meanwhile reaches this process afterwards
    try:
        yield
    finally:
        for name, value in before.items():
            if value is None:
                del os.environ[name]
            else:
                os.environ[name] = value
        signal.pthread_sigmask(signal.SIG_SETMASK, mask)


@contextlib.contextmanager
def _hidden_main() -> Iterator[None]:
    main = sys.modules["__main__"]
    sys.modules["__main__"] = ModuleType("__main__")
    try:
        yield
    finally:
        sys.modules["__main__"] = main
