"""One job that misbehaves, in every way: each is named for what it did.

The jobs are functions of the standard library, so that every worker can import them.
"""

import _thread
import codecs
import ctypes
import operator
import os
import resource
import signal
import sys
from collections.abc import Callable
from typing import Any

import pytest

from quickreturn.cases.running.job import Limits
from quickreturn.engines.base import EngineFailure
from tests.cases.running.jobs import GIB, done

RAISE = codecs.strict_errors  # raises whatever exception it is given


def test_a_time_limit_of_years_is_one() -> None:
    assert done(operator.add, 2, 3, limits=Limits(seconds=1e9)).value == 5


def test_large_value_comes_back() -> None:
    # Larger than any pipe's buffer, so that it takes many reads.
    assert len(done(operator.mul, b"x", 5_000_000).value) == 5_000_000


def test_exception_comes_back_as_what_it_was() -> None:
    outcome = done(operator.truediv, 1, 0)
    assert not outcome.completed
    assert outcome.failure == "raised ZeroDivisionError: division by zero"
    assert isinstance(outcome.error, ZeroDivisionError)
    assert "Traceback" in outcome.output


def test_engine_failure_keeps_time_cause_and_advice() -> None:
    outcome = done(RAISE, EngineFailure(0.25, "the beam snapped", "try another beam"))
    assert (outcome.error.time, outcome.error.cause, outcome.error.advice) == (0.25, "the beam snapped", "try another beam")


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


def test_worker_is_the_first_to_go_where_memory_is_short() -> None:
    assert done(exec, "print(open('/proc/self/oom_score_adj').read())").output == "500"


def test_last_words_of_a_process_that_died() -> None:
    dying = done(exec, "import os; os.write(2, b'terminate called\\n  what(): bad alloc\\n'); os.abort()")
    assert dying.explanation == 'killed by SIGABRT (its last words: "what(): bad alloc")'
    assert done(operator.truediv, 1, 0).explanation == "raised ZeroDivisionError: division by zero"
