"""Jobs that misbehave in every way: each is named for what it did, and the others complete.

The jobs are functions of the standard library, so that every worker can import them.
"""

import _thread
import codecs
import ctypes
import operator
import os
import resource
import signal
import subprocess
import sys
import textwrap
import threading
import time
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import Executor, Future, ThreadPoolExecutor
from multiprocessing import forkserver
from pathlib import Path
from typing import Any

import pytest

from quickreturn.cases.jobs import fork_server
from quickreturn.cases.jobs.isolation import end_waiting, isolated
from quickreturn.cases.jobs.job import Job, Limits, Outcome
from quickreturn.cases.jobs.processes import LocalProcesses, Pool, computed
from quickreturn.engines.base import EngineFailure

PRELOAD = ("quickreturn.cases.jobs.worker",)  # these jobs need nothing slow
GIB = 2**30
RAISE = codecs.strict_errors  # raises whatever exception it is given


@pytest.fixture(scope="module", autouse=True)
def a_warm_server_left_behind() -> Iterator[None]:
    """The tests after these get a fork server that has imported what their jobs need; otherwise each job would import it."""
    yield
    end_waiting()
    forkserver._forkserver._stop()  # type: ignore[attr-defined]
    done(len, (), preload=fork_server.PRELOAD)


def done(function: Callable[..., Any], *arguments: Any, limits: Limits | None = None, preload: Sequence[str] = PRELOAD) -> Outcome[Any]:
    return isolated(Job("job", function, arguments), limits, preload=preload)


def test_a_time_limit_of_years_is_one() -> None:
    assert done(operator.add, 2, 3, limits=Limits(seconds=1e9)).value == 5


@pytest.mark.parametrize("at_once", [0, -1])
def test_fewer_than_one_at_a_time_is_refused(at_once: int) -> None:
    with pytest.raises(ValueError, match="at least 1 is needed"):
        LocalProcesses(at_once)


def test_limits_of_a_job_come_before_those_of_the_executor() -> None:
    jobs = [Job("hurried", time.sleep, (3600.0,), limits=Limits(seconds=0.3)), Job("usual", time.sleep, (0.5,))]
    outcomes = {outcome.job.name: outcome for outcome in LocalProcesses(2, Limits(seconds=60.0), PRELOAD).run(jobs)}
    assert outcomes["hurried"].failure == "stopped at the time limit of 0.3 s"
    assert outcomes["usual"].completed


def test_a_watcher_is_told_how_far_a_job_is_and_nobody_else() -> None:
    code = "from quickreturn.engines.progress import tell; tell(engine='fake', phase='marching'); tell(cycle=1); tell(cycle=2)"
    seen: list[tuple[str, str]] = []
    job = Job("job", exec, (code,))
    (outcome,) = LocalProcesses(1, preload=PRELOAD).run([job], lambda job, progress: seen.append((job.name, str(progress))))
    assert outcome.completed
    assert seen == [("job", "None"), ("job", "fake, marching"), ("job", "fake, marching, cycle 1"), ("job", "fake, marching, cycle 2")]
    assert done(exec, code).completed


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
    assert isinstance(outcome.error, EngineFailure)
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


def test_memory_limit_ends_a_job_that_hoards() -> None:
    outcome = done(bytearray, 2 * GIB, limits=Limits(memory=GIB))
    assert outcome.failure == "ran out of memory (memory limit of 1 GiB)"
    assert done(bytearray, 1000, limits=Limits(memory=GIB)).completed


@pytest.mark.parametrize("words", ["Error: engine error: Could not allocate memory", "std::bad_alloc", "Unable to allocate 2 GiB for it"])
def test_a_library_that_gets_no_memory_is_named_as_such(words: str) -> None:
    """MuJoCo raises ValueError, which was the author's fault by the message."""
    outcome = done(exec, f"raise ValueError({words!r})", limits=Limits(memory=GIB))
    assert outcome.failure == "ran out of memory (memory limit of 1 GiB)"
    assert isinstance(outcome.error, MemoryError)


def test_one_failing_job_takes_no_other_with_it() -> None:
    jobs = [Job(f"good {number}", operator.neg, (number,)) for number in range(6)]
    jobs[1:1] = [Job("dies", os.abort), Job("raises", operator.truediv, (1, 0)), Job("hangs", time.sleep, (3600.0,))]
    outcomes = {outcome.job.name: outcome for outcome in LocalProcesses(3, Limits(seconds=3.0), PRELOAD).run(jobs)}
    assert [outcomes[f"good {number}"].value for number in range(6)] == [-number for number in range(6)]
    assert {name for name, outcome in outcomes.items() if outcome.failure} == {"dies", "raises", "hangs"}


def brief(name: str, code: str, **changes: Any) -> Job[Any]:
    return Job(name, eval, (code,), brief=True, **changes)


PID = "__import__('os').getpid()"


def test_brief_jobs_share_a_process_until_one_breaks_it() -> None:
    jobs = [brief("first", PID), brief("second", PID), brief("dies", "__import__('os').abort()"), brief("third", PID)]
    jobs += [brief("hangs", "__import__('time').sleep(3600)", limits=Limits(seconds=0.3)), brief("fourth", PID), Job("apart", os.getpid)]
    outcomes = {outcome.job.name: outcome for outcome in LocalProcesses(1, preload=PRELOAD).run(jobs)}
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
    outcomes = LocalProcesses(1, Limits(), PRELOAD).run(jobs, lambda job, progress: seen.append((job.name, str(progress))))
    assert [(outcome.failure, outcome.output) for outcome in outcomes if outcome.job.name != "greedy"] == [("", "loud"), ("", ""), ("", "")]
    assert seen == [("loud", "None"), ("loud", "fake, marching"), ("frugal", "None"), ("greedy", "None"), ("quiet", "None")]


def test_a_process_that_was_killed_while_it_waited_is_replaced() -> None:
    outcomes = LocalProcesses(1, preload=PRELOAD).run(
        [brief("first", PID), brief("waits", "__import__('time').sleep(0.5)"), brief("last", PID)]
    )
    first = next(outcomes).value
    assert next(outcomes).completed
    assert next(outcomes).value == first
    process, server = isolated(brief("one", f"{PID}, __import__('os').getppid()"), preload=PRELOAD).value
    os.kill(server, signal.SIGSTOP)  # it does not report the death before the next job comes
    os.kill(process, signal.SIGKILL)
    assert gone(process)
    threading.Timer(0.3, os.kill, (server, signal.SIGCONT)).start()
    assert isolated(brief("two", "7"), preload=PRELOAD).value == 7
    end_waiting()


def test_brief_jobs_wait_for_the_first_of_their_kind(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """What it compiles they find on the disk. Those that come later wait for nobody: each ends once the other has begun."""
    monkeypatch.setenv("NUMBA_CACHE_DIR", str(tmp_path / "new"))
    log = tmp_path / "log"
    begin = f"import os, time; open({str(log)!r}, 'a').write('b'); "
    for rest, written in (("time.sleep(0.3)", "bebe"), (f"\nwhile os.path.getsize({str(log)!r}) < 2: time.sleep(0.02)", "bbee")):
        code = f"{begin}{rest}\nopen({str(log)!r}, 'a').write('e')"
        jobs = [Job(name, exec, (code,), engines=("reference",), brief=True) for name in ("one", "two")]
        assert [outcome.failure for outcome in LocalProcesses(2, Limits(seconds=30.0), PRELOAD).run(jobs)] == ["", ""]
        assert log.read_text() == written
        log.unlink()


def test_any_executor_of_futures_will_do() -> None:
    with ThreadPoolExecutor(2) as threads:
        jobs = [Job("good", operator.neg, (3,)), Job("dies", os.abort), Job("raises", operator.truediv, (1, 0))]
        outcomes = {outcome.job.name: outcome for outcome in Pool(threads, 2, Limits(seconds=60.0)).run(jobs)}
    assert (outcomes["good"].value, outcomes["dies"].failure) == (-3, "killed by SIGABRT")
    assert isinstance(outcomes["raises"].error, ZeroDivisionError)
    assert all(outcomes[job.name].job is job for job in jobs)


def test_what_the_executor_loses_is_named() -> None:
    class Loses(Executor):
        def submit(self, *_: Any, **__: Any) -> "Future[Any]":  # type: ignore[override]
            future: Future[Any] = Future()
            future.set_exception(RuntimeError("the machine burned down"))
            return future

    (outcome,) = Pool(Loses()).run([Job("job", len, ((),))])
    assert (outcome.failure, outcome.error) == ("was lost (RuntimeError: the machine burned down)", None)


def test_jobs_that_are_blamed_together_are_computed_alone() -> None:
    """As on a cluster: what waits on a worker that another job kills is lost with it."""

    class Burned(Exception):
        """A machine is lost."""

    jobs, handed = [Job("good", len, ((),)), Job("burns", len, ((),)), Job("raises", len, ((),))], list[str]()

    def submit(job: Job[Any]) -> "Future[Outcome[Any]]":
        handed.append(job.name)
        future: Future[Outcome[Any]] = Future()
        if job.name == "raises":
            future.set_exception(ValueError("its own"))
        elif job.name == "burns" or len(handed) <= len(jobs):
            future.set_exception(Burned("all is lost"))
        else:
            future.set_result(Outcome(job, value=0))
        return future

    outcomes = {outcome.job.name: outcome for outcome in computed(submit, jobs, blamed=Burned)}
    assert outcomes["good"].value == 0
    assert outcomes["burns"].failure == "was lost (Burned: all is lost)"
    assert sorted(handed) == ["burns", "burns", "good", "good", "raises"]
    handed.clear()
    assert [outcome.failure for outcome in computed(submit, jobs[1:2], blamed=Burned)] == ["was lost (Burned: all is lost)"]
    assert handed == ["burns"]  # it was alone


def test_outcomes_come_as_jobs_end() -> None:
    jobs = [Job("slow", time.sleep, (2.0,)), Job("quick", time.sleep, (0.0,))]
    assert [outcome.job.name for outcome in LocalProcesses(2, preload=PRELOAD).run(jobs)] == ["quick", "slow"]


def test_output_is_caught_and_its_end_kept(capfd: pytest.CaptureFixture[str]) -> None:
    assert done(print, "hello", "world").output == "hello world"
    assert done(os.write, 1, b"from C").output == "from C"
    assert done(print, "x" * 1_000_000 + "end").output.endswith("xxxend")
    assert capfd.readouterr() == ("", "")


def test_workers_compute_with_one_thread() -> None:
    assert done(os.getenv, "OMP_NUM_THREADS").value == "1"
    assert done(os.getenv, "NUMBA_NUM_THREADS").value == "1"


def test_folders_where_the_user_stands_are_not_taken_for_packages(tmp_path: Path) -> None:
    """Not even one that is called `cases` and has a folder `library` in it."""
    (tmp_path / "cases/library").mkdir(parents=True)
    (tmp_path / "elsewhere").mkdir()
    script = tmp_path / "elsewhere/runner.py"
    script.write_text(
        textwrap.dedent(
            """
            import pkgutil
            from quickreturn.cases.jobs.job import Job
            from quickreturn.cases.jobs.processes import LocalProcesses
            if __name__ == "__main__":
                (outcome,) = LocalProcesses().run([Job("job", pkgutil.resolve_name, ("quickreturn.cases.thesis.runs:run_name",))])
                print(outcome.failure or outcome.value(24))
            """
        )
    )
    told = subprocess.run([sys.executable, str(script)], cwd=tmp_path, capture_output=True, text=True, check=True)
    assert told.stdout == "thesis-24\n", told.stderr


def sleeper(folder: Path) -> Job[Any]:
    """A job that writes its process id to the file `pid` in the folder and then sleeps with the GIL held, as a native solver does."""
    file = str(folder / "pid")
    write = f"open({file + '.part'!r}, 'w').write(str(os.getpid())); os.rename({file + '.part'!r}, {file!r})"
    code = f"import ctypes, os; {write}; ctypes.PyDLL(None).sleep(3600)"
    return Job("sleeper", exec, (code,))


def test_killed_fork_server_costs_nothing(tmp_path: Path) -> None:
    """The worker that it leaves behind delivers, and the next job gets a new server."""
    wait = f"import os, time\nwhile not os.path.exists({str(tmp_path / 'go')!r}): time.sleep(0.02)\nprint('done')"
    jobs = [Job("tells its parent", os.getppid), Job("waits", exec, (wait,)), Job("next", operator.add, (2, 3))]
    outcomes: list[Outcome[Any]] = []

    def kill_the_server() -> None:
        os.kill(outcomes[0].value, signal.SIGKILL)
        (tmp_path / "go").touch()

    for outcome in LocalProcesses(1, preload=PRELOAD).run(jobs):
        outcomes.append(outcome)
        if outcome.job.name == "tells its parent":
            threading.Timer(1.0, kill_the_server).start()  # the job that waits has started by then
    assert [(outcome.job.name, outcome.failure) for outcome in outcomes[1:]] == [("waits", ""), ("next", "")]
    assert outcomes[1].output == "done"
    assert outcomes[2].value == 5
    assert done(os.getppid).value != outcomes[0].value


def test_dying_fork_server_is_replaced() -> None:
    """Just killed it still counts as alive, and breaks every connection."""
    for _ in range(3):
        os.kill(done(os.getppid).value, signal.SIGKILL)
        assert done(operator.truth, 1).failure == ""


def test_worker_without_its_fork_server_is_limited_too() -> None:
    code = "import os, signal, time; os.kill(os.getppid(), signal.SIGKILL); time.sleep(3600)"
    assert done(exec, code, limits=Limits(seconds=1.0)).failure == "stopped at the time limit of 1 s"
    code = "import os, signal, time; os.kill(os.getppid(), signal.SIGKILL); time.sleep(0.5); os.abort()"
    assert done(exec, code).failure == "ended without a result"


def test_worker_that_cuts_its_pipes_is_ended() -> None:
    assert done(exec, "import os, time; os.closerange(0, 256); time.sleep(3600)").failure == "cut its connection to the runner"


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


def test_closing_the_iterator_kills_the_workers(tmp_path: Path) -> None:
    def wait_for_the_sleeper() -> str:
        return f"import os, time\nwhile not os.path.exists({str(tmp_path / 'pid')!r}): time.sleep(0.02)"

    outcomes = LocalProcesses(2, preload=PRELOAD).run([sleeper(tmp_path), Job("waits", exec, (wait_for_the_sleeper(),))])
    assert next(outcomes).job.name == "waits"
    outcomes.close()
    assert gone(int((tmp_path / "pid").read_text()))


def started_runner(tmp_path: Path) -> tuple["subprocess.Popen[str]", int]:
    """A runner with a sleeping worker, and the worker's process id."""
    script = tmp_path / "runner.py"
    script.write_text(
        textwrap.dedent(
            f"""
            from quickreturn.cases.jobs.job import Job
            from quickreturn.cases.jobs.processes import LocalProcesses
            import sys
            if __name__ == "__main__":
                try:
                    list(LocalProcesses(preload={PRELOAD!r}).run([Job("sleeper", exec, {sleeper(tmp_path).arguments!r})]))
                except KeyboardInterrupt:
                    sys.exit(130)
            """
        )
    )
    runner = subprocess.Popen([sys.executable, str(script)], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, process_group=0)
    while not (tmp_path / "pid").exists():
        assert runner.poll() is None, runner.communicate()
        time.sleep(0.02)
    return runner, int((tmp_path / "pid").read_text())


def gone(process: int) -> bool:
    """Whether a process has ended, waiting up to ten seconds for that; a zombie that nobody has collected counts as ended."""
    for _ in range(500):
        try:
            state = Path(f"/proc/{process}/stat").read_text().rpartition(")")[2].split()[0]
        except (FileNotFoundError, ProcessLookupError):
            return True
        if state == "Z":
            return True
        time.sleep(0.02)
    return False


def test_interrupt_of_the_whole_process_group_is_clean(tmp_path: Path) -> None:
    runner, worker = started_runner(tmp_path)
    os.killpg(runner.pid, signal.SIGINT)  # as a terminal does on Ctrl-C
    output, errors = runner.communicate(timeout=20.0)
    assert (runner.returncode, output, errors) == (130, "", "")
    assert gone(worker)


def test_killed_runner_takes_its_workers_with_it(tmp_path: Path) -> None:
    runner, worker = started_runner(tmp_path)
    runner.kill()
    runner.communicate(timeout=20.0)
    assert gone(worker)
