"""The program as a process of its own, as a user starts it, with engines of the tests as third-party packages."""

import os
import subprocess
import sys
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

PROGRAM = Path(sys.executable).with_name("quickreturn")
ROOT = Path(__file__).resolve().parents[2]
#: A folder that holds the tests and nothing else (`tests.conftest`).
TESTS_ALONE = ROOT / "build/tests-alone"


def started(*arguments: str, folder: Path, variables: dict[str, str] | None = None, **more: Any) -> "subprocess.Popen[str]":
    """Start the program in a folder; packages in its folder `packages` are installed, and so is this project with its tests."""
    paths = [str(folder / "packages"), str(TESTS_ALONE), *filter(None, [os.environ.get("PYTHONPATH")])]
    environment = {**os.environ, "PYTHONPATH": os.pathsep.join(paths), **(variables or {})}
    pipes: dict[str, Any] = {"stdout": subprocess.PIPE, "stderr": subprocess.PIPE, "text": True}
    return subprocess.Popen([PROGRAM, *arguments], cwd=folder, env=environment, **(pipes | more))


def wait_until(condition: Callable[[], object], program: "subprocess.Popen[str] | None" = None, seconds: float = 300.0) -> None:
    """Wait until something holds, as long as the program runs; AssertionError if it does not come to that."""
    deadline = time.monotonic() + seconds
    while not condition():
        if program is not None and program.poll() is not None and not condition():
            raise AssertionError(program.communicate())
        assert time.monotonic() < deadline, "waited in vain"
        time.sleep(0.02)


def descendants(process: int) -> list[int]:
    """Numbers of all processes below a process."""
    try:
        children = [int(child) for child in Path(f"/proc/{process}/task/{process}/children").read_text().split()]
    except (FileNotFoundError, ProcessLookupError):
        return []
    return [found for child in children for found in (child, *descendants(child))]


def running(process: int) -> bool:
    """Whether a process still runs; a zombie that nobody has collected does not."""
    try:
        return Path(f"/proc/{process}/stat").read_text().rpartition(")")[2].split()[0] != "Z"
    except (FileNotFoundError, ProcessLookupError):
        return False
