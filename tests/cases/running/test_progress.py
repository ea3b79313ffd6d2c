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
    tally = Tally([one, two])
    tally.watch(one, None)
    tally.watch(two, Progress("exudyn", "estimating the error", rung=2))
    assert tally.at_work() == ["thesis-24 mujoco: beginning", "thesis-23: exudyn, estimating the error at rung 2"]
    tally.watch(one, Progress("mujoco", "marching", cycle=12, most=60))
    assert tally.at_work()[0] == "thesis-24 mujoco: marching, cycle 12 of at most 60"


def test_the_time_left_follows_from_what_was_done(monkeypatch: pytest.MonkeyPatch) -> None:
    """Three of 40 points a second: a row of 30 took ten seconds, and one of 10 is left."""
    now = [100.0]
    monkeypatch.setattr(time, "monotonic", lambda: now[0])
    long = replace(job("long"), points=30)
    tally = Tally([long, replace(job("short"), points=10)])
    assert str(tally) == "0 of 40 done"
    tally.watch(long, None)
    now[0] += 10.0
    tally.ended(Outcome(long, 0, seconds=10.0))
    assert str(tally) == "30 of 40 done, 3 a second, about 3 s left"
    assert tally.at_work() == []
