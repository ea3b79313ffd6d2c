"""Several jobs at once: whatever one does, the others complete, and each is named for what it did.

The jobs are functions of the standard library, so that every worker can import them.
"""

import os
import signal
import threading
import time
from concurrent.futures import Future
from pathlib import Path
from typing import Any

import pytest

from quickreturn.cases.running import fork_server
from quickreturn.cases.running.isolation import LocalProcesses, computed, end_waiting, isolated
from quickreturn.cases.running.job import Job, Limits, Outcome
from tests.cases.running.jobs import GIB, done, gone


@pytest.mark.parametrize("at_once", [0, -1])
def test_fewer_than_one_at_a_time_is_refused(at_once: int) -> None:
    with pytest.raises(ValueError, match="at least 1 is needed"):
        LocalProcesses(at_once)


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


@pytest.mark.skipif(not fork_server.FORKS, reason="it stops the fork server")
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


def test_what_the_executor_loses_is_named() -> None:
    future: Future[Outcome[Any]] = Future()
    future.set_exception(RuntimeError("the machine burned down"))
    (outcome,) = computed(lambda _: future, [Job("job", len, ((),))])
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


def test_outcomes_come_as_jobs_end(tmp_path: Path) -> None:
    wait = f"import os, time\nwhile not os.path.exists({str(tmp_path / 'go')!r}): time.sleep(0.02)"
    outcomes = LocalProcesses(2, Limits(seconds=60.0)).run([Job("slow", exec, (wait,)), Job("quick", len, ((),))])
    assert next(outcomes).job.name == "quick"
    (tmp_path / "go").touch()
    assert [(outcome.job.name, outcome.failure) for outcome in outcomes] == [("slow", "")]
