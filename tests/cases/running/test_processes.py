"""Several jobs at once: whatever one does, the others complete, and each is named for what it did.

The jobs are functions of the standard library, so that every worker can import them.
"""

import _thread
import ctypes
import operator
import os
import resource
import signal
import sys
import threading
import time
from collections.abc import Callable
from typing import Any

import pytest

from quickreturn.cases.running.isolation import LocalProcesses, end_waiting, isolated
from quickreturn.cases.running.job import Job, Limits
from tests.cases.running.jobs import GIB, done, gone


def test_limits_of_a_job_come_before_those_of_the_executor() -> None:
    jobs = [Job("hurried", time.sleep, (3600.0,), limits=Limits(seconds=0.3)), Job("usual", time.sleep, (0.5,))]
    outcomes = {outcome.job.name: outcome for outcome in LocalProcesses(2, Limits(seconds=60.0)).run(jobs)}
    assert outcomes["hurried"].failure == "stopped at the time limit of 0.3 s"
    assert outcomes["usual"].completed


def test_a_watcher_is_told_how_far_a_job_is_and_nobody_else() -> None:
    code = "from quickreturn.engines.progress import tell; tell(engine='fake', phase='marching'); tell(cycle=1); tell(cycle=2)"
    seen: list[tuple[str, str]] = []
    job = Job("job", exec, (code,))
    (outcome,) = LocalProcesses(1).run([job], lambda job, progress: seen.append((job.name, str(progress))))
    assert outcome.completed
    assert seen == [("job", "None"), ("job", "fake, marching"), ("job", "fake, marching, cycle 1"), ("job", "fake, marching, cycle 2")]
    assert done(exec, code).completed


def brief(name: str, code: str, **changes: Any) -> Job[Any]:
    return Job(name, eval, (code,), brief=True, **changes)


PID = "__import__('os').getpid()"


def test_brief_jobs_share_a_process_until_one_breaks_it() -> None:
    jobs = [brief("first", PID), brief("second", PID), brief("dies", "__import__('os').abort()"), brief("third", PID)]
    jobs += [brief("hangs", "__import__('time').sleep(3600)", limits=Limits(seconds=0.3)), brief("fourth", PID), Job("apart", os.getpid)]
    outcomes = {outcome.job.name: outcome for outcome in LocalProcesses(1).run(jobs)}
    assert {name: outcome.failure for name, outcome in outcomes.items() if outcome.failure} == {
        "dies": "killed by SIGABRT",
        "hangs": "stopped at the time limit of 0.3 s",
    }
    first, second, third, fourth, apart = (outcomes[name].value for name in ("first", "second", "third", "fourth", "apart"))
    assert first == second
    assert len({first, third, fourth, apart}) == 4
    assert gone(fourth)  # nothing waits for more once all are done


def test_each_brief_job_has_its_own_output_progress_and_limits() -> None:
    seen: list[tuple[str, str]] = []
    loud = "print('loud'), __import__('quickreturn.engines.progress', fromlist=['tell']).tell(engine='fake', phase='marching')"
    jobs = [brief("loud", loud), brief("greedy", f"len(bytearray({2 * GIB}))", limits=Limits(memory=GIB)), brief("quiet", "7")]
    jobs.insert(1, brief("frugal", "len(bytearray(1000))", limits=Limits(memory=GIB)))
    outcomes = LocalProcesses(1, Limits()).run(jobs, lambda job, progress: seen.append((job.name, str(progress))))
    assert [(outcome.failure, outcome.output) for outcome in outcomes if outcome.job.name != "greedy"] == [("", "loud"), ("", ""), ("", "")]
    assert seen == [("loud", "None"), ("loud", "fake, marching"), ("frugal", "None"), ("greedy", "None"), ("quiet", "None")]


def test_a_process_that_was_killed_while_it_waited_is_replaced() -> None:
    outcomes = LocalProcesses(1).run([brief("first", PID), brief("waits", "__import__('time').sleep(0.5)"), brief("last", PID)])
    first = next(outcomes).value
    assert next(outcomes).completed
    assert next(outcomes).value == first
    process, server = isolated(brief("one", f"{PID}, __import__('os').getppid()")).value
    os.kill(server, signal.SIGSTOP)  # it does not report the death before the next job comes
    os.kill(process, signal.SIGKILL)
    assert gone(process)
    threading.Timer(0.3, os.kill, (server, signal.SIGCONT)).start()
    assert isolated(brief("two", "7")).value == 7
    end_waiting()


def test_exception_comes_back_as_what_it_was() -> None:
    outcome = done(operator.truediv, 1, 0)
    assert not outcome.completed
    assert outcome.failure == "raised ZeroDivisionError: division by zero"
    assert isinstance(outcome.error, ZeroDivisionError)
    assert "Traceback" in outcome.output


@pytest.mark.parametrize(
    ("function", "arguments", "failure"),
    [
        (os._exit, (7,), "ended without a result (exit code 7)"),
        (os._exit, (0,), "ended without a result (exit code 0)"),
        (sys.exit, ("enough",), "raised SystemExit: enough"),
        (signal.raise_signal, (signal.SIGSEGV,), "killed by SIGSEGV"),
        (ctypes.string_at, (0,), "killed by SIGSEGV"),
        (os.abort, (), "killed by SIGABRT"),
        (signal.raise_signal, (signal.SIGKILL,), "killed by SIGKILL (by the user, or by the system for lack of memory)"),
        (_thread.allocate_lock, (), "raised TypeError: cannot pickle '_thread.lock' object"),
    ],
)
def test_death_is_named(function: Callable[..., Any], arguments: tuple[Any, ...], failure: str) -> None:
    assert done(function, *arguments).failure == failure


def test_function_that_the_worker_cannot_import_is_a_failure_of_the_job() -> None:
    module = type(sys)("no_such_module_in_the_worker")
    exec("def work(): pass", module.__dict__)
    sys.modules[module.__name__] = module
    try:
        outcome = done(module.work)
    finally:
        del sys.modules[module.__name__]
    assert outcome.failure == "raised ModuleNotFoundError: No module named 'no_such_module_in_the_worker'"


@pytest.mark.parametrize("words", ["Error: engine error: Could not allocate memory", "std::bad_alloc", "Unable to allocate 2 GiB for it"])
def test_a_library_that_gets_no_memory_is_named_as_such(words: str) -> None:
    """MuJoCo raises ValueError, which was the author's fault by the message."""
    outcome = done(exec, f"raise ValueError({words!r})", limits=Limits(memory=GIB))
    assert outcome.failure == "ran out of memory (memory limit of 1 GiB)"
    assert isinstance(outcome.error, MemoryError)


def test_output_is_caught_and_its_end_kept(capfd: pytest.CaptureFixture[str]) -> None:
    assert done(print, "hello", "world").output == "hello world"
    assert done(os.write, 1, b"from C").output == "from C"
    assert done(print, "x" * 1_000_000 + "end").output.endswith("xxxend")
    assert capfd.readouterr() == ("", "")


def test_workers_compute_with_one_thread() -> None:
    assert done(os.getenv, "OMP_NUM_THREADS").value == "1"
    assert done(os.getenv, "NUMBA_NUM_THREADS").value == "1"


def test_job_that_cannot_be_started_is_named_and_the_next_one_runs() -> None:
    """As many files are open as may be."""
    done(len, ())  # the fork server is there
    before = resource.getrlimit(resource.RLIMIT_NOFILE)
    resource.setrlimit(resource.RLIMIT_NOFILE, (3, before[1]))
    try:
        outcome = done(len, ())
    finally:
        resource.setrlimit(resource.RLIMIT_NOFILE, before)
    assert outcome.failure == "could not be started ([Errno 24] Too many open files)"
    assert done(len, ()).completed
