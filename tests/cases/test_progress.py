"""The progress bar: for a terminal only, and never on standard output."""

import os
import pty
import subprocess
import sys

import pytest

from cases.progress import with_progress

CODE = "from cases.progress import with_progress; print(list(with_progress([1, 2, 3], 3, 'runs')))"


def test_nothing_is_shown_where_there_is_no_terminal(capfd: pytest.CaptureFixture[str]) -> None:
    assert list(with_progress(iter("abc"), 3, "runs")) == ["a", "b", "c"]
    assert capfd.readouterr() == ("", "")


def test_a_terminal_gets_the_bar_and_standard_output_stays_clean() -> None:
    reading, writing = pty.openpty()
    environment = {**os.environ, "TERM": "xterm", "COLUMNS": "100"}
    answer = subprocess.run([sys.executable, "-c", CODE], stdout=subprocess.PIPE, stderr=writing, env=environment, check=True)
    os.close(writing)
    shown = os.read(reading, 65536).decode()
    os.close(reading)
    assert answer.stdout == b"[1, 2, 3]\n"
    assert "runs" in shown
    assert "3/3" in shown
    assert "left" in shown
