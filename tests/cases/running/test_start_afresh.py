"""Processes that start afresh, as on systems other than Linux."""

import os
import subprocess
import sys
from pathlib import Path

import pytest

TESTS = [str(Path(__file__).with_name(f"test_{name}.py")) for name in ("isolation", "processes")]


@pytest.mark.verify
def test_the_tests_of_processes_pass_where_each_process_starts_afresh() -> None:
    run = [sys.executable, "-P", "-m", "pytest", "-n", "0", "-q", *TESTS]
    done = subprocess.run(run, env={**os.environ, "QUICKRETURN_START_METHOD": "spawn"}, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stdout
