"""Of several processes one compiles, and the others wait and load."""

import os
import subprocess
import sys
import threading
import time
from pathlib import Path

import pytest

from quickreturn.reference_model.native import cache_folder
from quickreturn.reference_model.native.cache_folder import Turn, waits_for
from tests.package_copy import ROOT

#: Takes the turn of a file, says so, and keeps it until its input ends, or until it is killed.
HOLDER = """
import sys
from pathlib import Path
from quickreturn.reference_model.native.cache_folder import Turn
turn = Turn(Path(sys.argv[1]))
turn.take()
print("taken", flush=True)
sys.stdin.read()
turn.give_back()
"""
#: Compiles a function, and prints how often this was the compiler's work. It takes long enough for the other to come.
COMPILES = """
import sys, time
sys.path.insert(0, sys.argv[1])
from quickreturn.reference_model.native.kept import OwnCompiler
from quickreturn.reference_model.native.compilation import compiled
made = []
compile_extra = OwnCompiler.compile_extra
def slow(self, func):
    made.append(func.__name__)
    time.sleep(1.0)
    return compile_extra(self, func)
OwnCompiler.compile_extra = slow
from small import double
assert compiled(double)(4.0) == 8.0
print(len(made))
"""


@pytest.fixture
def holder(tmp_path: Path) -> "subprocess.Popen[str]":
    """A process that has the turn."""
    command = [sys.executable, "-c", HOLDER, str(tmp_path / "code.turn")]
    process = subprocess.Popen(
        command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True, env={**os.environ, "PYTHONPATH": str(ROOT)}
    )
    assert process.stdout.readline() == "taken\n"
    return process


def waiting(path: Path) -> tuple[threading.Thread, list[int]]:
    """A thread that takes the turn, and for whom it waits."""
    thread = threading.Thread(target=Turn(path).take)
    thread.start()
    seen: list[int] = []
    until = time.monotonic() + 10.0
    while not seen and time.monotonic() < until:
        seen += [process] if (process := waits_for()) else []
    return thread, seen


@pytest.mark.parametrize("killed", [False, True])
def test_a_process_waits_and_knows_for_whom_until_that_gives_back_or_ends(
    holder: "subprocess.Popen[str]", tmp_path: Path, killed: bool
) -> None:
    thread, seen = waiting(tmp_path / "code.turn")
    assert seen == [holder.pid]
    assert thread.is_alive()
    if killed:
        holder.kill()
    holder.communicate("")
    thread.join(10.0)
    assert not thread.is_alive()
    assert waits_for() == 0


def test_nobody_waits_for_ever(holder: "subprocess.Popen[str]", tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(cache_folder, "PATIENCE", 0.3)
    thread, seen = waiting(tmp_path / "code.turn")
    thread.join(10.0)
    assert (seen, thread.is_alive()) == ([holder.pid], False)
    holder.communicate("")


def test_an_attempt_that_failed_in_this_process_is_not_waited_for(tmp_path: Path) -> None:
    failed = Turn(tmp_path / "code.turn")
    failed.take()
    began = time.monotonic()
    Turn(tmp_path / "code.turn").take()
    assert time.monotonic() - began < 5.0
    failed.give_back()


def test_where_nothing_can_be_written_nobody_waits(tmp_path: Path) -> None:
    (tmp_path / "file").touch()
    Turn(tmp_path / "file/code.turn").take()


@pytest.mark.verify
def test_one_process_compiles_what_two_need(tmp_path: Path) -> None:
    (tmp_path / "small.py").write_text("def double(x):\n    return x + x\n")
    environment = {**os.environ, "PYTHONPATH": str(ROOT), "NUMBA_CACHE_DIR": str(tmp_path / "cache")}
    command = [sys.executable, "-P", "-c", COMPILES, str(tmp_path)]
    both = [subprocess.Popen(command, env=environment, stdout=subprocess.PIPE, text=True) for _ in range(2)]
    assert sorted(process.communicate()[0].strip() for process in both) == ["0", "1"]
