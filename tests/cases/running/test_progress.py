"""What the person who waits gets to see: a line that changes on a terminal, lines on a pipe, and never on standard output."""

import contextlib
import os
import pty
import re
import subprocess
import sys
import time
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

from quickreturn.cases.running.display import Tally, answers
from quickreturn.cases.running.isolation import LocalProcesses
from quickreturn.cases.running.job import Job, Outcome
from quickreturn.engines.progress import Progress

CODE = """
from quickreturn.cases.running.display import answers
from quickreturn.cases.running.job import Job
from quickreturn.cases.running.isolation import LocalProcesses
told = "from quickreturn.engines.progress import tell; tell(engine='fake', phase='marching'); tell(cycle=7, most=60)"
work = told + "; import time; time.sleep(0.6)"
jobs = [Job(name, exec, (work,)) for name in ("one", "two")]
print([outcome.failure for outcome in answers(LocalProcesses(1, preload=(), quiet=False), jobs, "runs")])
"""


@pytest.fixture
def script(tmp_path: Path) -> Path:
    """Its top has no guard: that workers do not run it again is what it also shows."""
    file = tmp_path / "watched.py"
    file.write_text(CODE)
    return file


def test_nothing_is_shown_where_it_is_not_asked_for(capfd: pytest.CaptureFixture[str]) -> None:
    jobs = [Job(text, str.upper, (text,)) for text in "abc"]
    assert [outcome.value for outcome in answers(LocalProcesses(), jobs, "runs")] == ["A", "B", "C"]
    assert capfd.readouterr() == ("", "")


def test_a_pipe_gets_lines_and_standard_output_stays_clean(script: Path) -> None:
    program = subprocess.run([sys.executable, script], capture_output=True, text=True, check=True)
    assert program.stdout == "['', '']\n"
    for line in ("runs: 0 of 2 done after 0 s", r"one: done in \d+ s; 1 of 2 done, about \d+ s left", r"two: done in \d+ s; 2 of 2 done"):
        assert re.search(f"^  {line}", program.stderr, re.MULTILINE), program.stderr


@pytest.mark.verify
def test_a_terminal_gets_what_is_at_work_and_standard_output_stays_clean(script: Path) -> None:
    reading, writing = pty.openpty()
    environment = {**os.environ, "TERM": "xterm", "COLUMNS": "100"}
    program = subprocess.Popen([sys.executable, script], stdout=subprocess.PIPE, stderr=writing, env=environment)
    os.close(writing)
    shown = b""
    with contextlib.suppress(OSError):  # the other end is closed
        while piece := os.read(reading, 65536):
            shown += piece
    os.close(reading)
    assert program.communicate()[0] == b"['', '']\n"
    for text in ("runs", "1 of 2 done", "left", "one: fake, marching, cycle 7 of at most 60", "two: fake, marching, cycle 7 of at most 60"):
        assert text in shown.decode()


def job(name: str) -> Job[Any]:
    return Job(name, len)


def test_what_is_at_work_is_told_with_engine_phase_rung_and_cycle() -> None:
    one, two = job("thesis-24 mujoco"), job("thesis-23")
    tally = Tally([one, two], 2)
    tally.watch(one, None)
    tally.watch(two, Progress("exudyn", "estimating the error", rung=2))
    assert tally.at_work() == ["thesis-24 mujoco: beginning", "thesis-23: exudyn, estimating the error at rung 2"]
    tally.watch(one, Progress("mujoco", "marching", cycle=12, most=60))
    assert tally.at_work()[0] == "thesis-24 mujoco: marching, cycle 12 of at most 60"


def test_the_time_left_follows_from_what_was_done() -> None:
    jobs = [job(str(number)) for number in range(5)]
    tally = Tally(jobs, 2)
    assert tally.left is None
    for number in (0, 1):
        tally.ended(Outcome(jobs[number], seconds=10.0))
    assert tally.left == pytest.approx(15.0)  # three of ten seconds each, two at a time
    tally.watch(jobs[2], None)
    assert tally.left == pytest.approx(15.0, abs=1.0)
    assert str(tally) == "2 of 5 done, about 15 s left"


def test_no_time_is_told_from_jobs_of_another_sort() -> None:
    """Quick runs of one engine say nothing of the slow ones of another, nor of another kind of work."""
    quick, slow, other = job("quick"), replace(job("slow"), engines=("slow",)), replace(job("other"), kind="other")
    tally = Tally([quick, slow, other], 2)
    tally.ended(Outcome(quick, seconds=1.0))
    tally.ended(Outcome(other, seconds=1.0))
    assert tally.left is None
    assert str(tally) == "2 of 3 done"


def test_what_takes_longer_than_usual_is_not_about_to_end(monkeypatch: pytest.MonkeyPatch) -> None:
    """After 30 s in place of the usual 5 it is as likely to take another 30 as to end before."""
    now = [100.0]
    monkeypatch.setattr(time, "monotonic", lambda: now[0])
    jobs = [job(str(number)) for number in range(3)]
    tally = Tally(jobs, 2)
    tally.watch(jobs[1], None)
    tally.ended(Outcome(jobs[0], seconds=5.0))
    now[0] += 2.0
    assert tally.left == pytest.approx(5.0)  # 3 s of the one at work, and 5 s of the one that begins beside it
    now[0] += 28.0
    assert tally.left == pytest.approx(30.0)


def test_jobs_of_several_points_are_counted_by_their_points(monkeypatch: pytest.MonkeyPatch) -> None:
    """A row of 30 of 40 points took 3 s: 10 a second, and the other 10 points take one more second."""
    now = [100.0]
    monkeypatch.setattr(time, "monotonic", lambda: now[0])
    long = replace(job("long"), points=30)
    tally = Tally([long, replace(job("short"), points=10)], 1)
    tally.watch(long, None)
    now[0] += 3.0
    tally.ended(Outcome(long, 0, seconds=3.0))
    assert tally.left == pytest.approx(1.0)
    assert str(tally) == "30 of 40 done, 10 a second, about 1 s left"
