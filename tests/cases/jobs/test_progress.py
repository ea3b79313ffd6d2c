"""The progress bar: for a terminal only, and never on standard output."""

import contextlib
import os
import pty
import subprocess
import sys
from pathlib import Path

import pytest

from cases.jobs.job import Job, answers
from cases.jobs.processes import LocalProcesses

CODE = """
from cases.jobs.job import Job
from cases.jobs.processes import LocalProcesses
from cases.jobs.job import answers
if __name__ == "__main__":
    work = "import time; from engines.progress import tell; tell(engine='fake', phase='marching', cycle=7); time.sleep(0.5)"
    jobs = [Job(name, exec, (work,)) for name in ("one", "two")]
    print([outcome.failure for outcome in answers(LocalProcesses(1, preload=()), jobs, "runs")])
"""


def test_nothing_is_shown_where_there_is_no_terminal(capfd: pytest.CaptureFixture[str]) -> None:
    jobs = [Job(text, str.upper, (text,)) for text in "abc"]
    assert [outcome.value for outcome in answers(LocalProcesses(preload=()), jobs, "runs")] == ["A", "B", "C"]
    assert capfd.readouterr() == ("", "")


def test_a_terminal_gets_the_bar_and_what_is_at_work_and_standard_output_stays_clean(tmp_path: Path) -> None:
    script = tmp_path / "watched.py"
    script.write_text(CODE)
    reading, writing = pty.openpty()
    environment = {**os.environ, "TERM": "xterm", "COLUMNS": "100"}
    program = subprocess.Popen([sys.executable, str(script)], stdout=subprocess.PIPE, stderr=writing, env=environment)
    os.close(writing)
    shown = b""
    with contextlib.suppress(OSError):  # the other end is closed
        while piece := os.read(reading, 65536):
            shown += piece
    os.close(reading)
    assert program.communicate()[0] == b"['', '']\n"
    for text in ("runs", "1/2", "left", "one: fake, marching, cycle 7", "two: fake, marching, cycle 7"):
        assert text in shown.decode()
