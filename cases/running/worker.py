"""The child's side of jobs: everything that happens in the worker process. See `cases.running.isolation` for the runner's side."""

import contextlib
import fcntl
import os
import pickle
import resource
import select
import signal
import sys
import traceback
from multiprocessing.connection import Connection
from typing import Any, Final

from quickreturn.engines.one_run import lacks_memory
from quickreturn.engines.progress import listen

#: Exit code of a worker whose runner is gone.
ORPHANED: Final = 70


def serve(lifeline: Connection, orders: Connection, output: Connection, answer: Connection) -> None:
    """Do one job after the other, and leave when no more can come; never returns.

    Args:
        lifeline: nothing is ever sent; its other end closes when the runner ends, in whatever way.
        orders: delivers pickled (work, memory, watched): the pickled (function, arguments), which are opened as a part of the job, so that
            an import that fails is a failure of the job; bytes of address space that the job may take on top of those of the process at
            its beginning, or None; and whether progress is reported.
        output: takes standard output and standard error, of Python and of C libraries; a job's output is complete before its answer.
        answer: takes for each job pickled ("progress", progress), if watched, and last ("value", value) or ("error", exception or None,
            one-line description).
    """
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # Ctrl-C is the runner's; it ends its workers
    _die_with_the_runner(lifeline)
    _be_first_to_go()
    os.dup2(output.fileno(), 1)
    os.dup2(output.fileno(), 2)

    def send(message: bytes) -> None:
        with contextlib.suppress(OSError):  # the runner is gone
            answer.send_bytes(message)

    with contextlib.suppress(EOFError, OSError):
        while True:
            work, memory, watched = pickle.loads(orders.recv_bytes())
            listen((lambda progress: send(pickle.dumps(("progress", progress)))) if watched else None)
            _limit_memory(memory)
            done = _done(work)
            for stream in (sys.stdout, sys.stderr):
                with contextlib.suppress(Exception):
                    stream.flush()
            send(done)
    os._exit(0)  # no exit handlers: a library that crashes or hangs on its way out must not spoil a finished result


def _done(work: bytes) -> bytes:
    try:
        function, arguments = pickle.loads(work)
        return pickle.dumps(("value", function(*arguments)))
    except BaseException as error:
        _limit_memory(None)  # the report of the error also takes memory
        traceback.print_exc()
        if not isinstance(error, MemoryError) and lacks_memory(error):
            error = MemoryError(str(error))
        lines = str(error).splitlines()
        description = f"{type(error).__name__}: {lines[0]}" if lines else type(error).__name__
        return pickle.dumps(("error", _portable(error), description))


def _portable(error: BaseException) -> BaseException | None:
    """The exception, or None where pickling does not bring it back as what it was."""
    try:
        copy: Any = pickle.loads(pickle.dumps(error))
    except Exception:
        return None
    return error if type(copy) is type(error) and str(copy) == str(error) else None


def _die_with_the_runner(lifeline: Connection) -> None:
    """Let the system end this process (SIGIO) when the lifeline's other end closes, even while an engine holds the GIL."""
    signal.signal(signal.SIGIO, signal.SIG_DFL)
    fcntl.fcntl(lifeline, fcntl.F_SETOWN, os.getpid())
    fcntl.fcntl(lifeline, fcntl.F_SETFL, fcntl.fcntl(lifeline, fcntl.F_GETFL) | os.O_ASYNC)
    if select.select([lifeline], [], [], 0)[0]:  # it closed before the signal was asked for
        os._exit(ORPHANED)


def _be_first_to_go() -> None:
    """If the system must kill a process for lack of memory, let it be a worker, not its runner or another program."""
    with contextlib.suppress(OSError), open("/proc/self/oom_score_adj", "w", encoding="ascii") as file:
        file.write("500")


def _limit_memory(memory: int | None) -> None:
    """Limit the address space to what the process has now and `memory` (bytes) on top; None: to what the system allows."""
    _, hard = resource.getrlimit(resource.RLIMIT_AS)
    limit = hard
    if memory is not None:
        with open("/proc/self/statm", encoding="ascii") as file:
            present = int(file.read().split()[0]) * resource.getpagesize()
        limit = present + memory if hard == resource.RLIM_INFINITY else min(present + memory, hard)
    resource.setrlimit(resource.RLIMIT_AS, (limit, hard))
