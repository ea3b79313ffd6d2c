"""Faults that strike at any time, on the real engines too: what takes too long for every day."""

import json
import os
import random
import signal
import subprocess
import time
from pathlib import Path
from typing import Any

import pytest

from tests.engines.faulty_engines import install_faulty_engines
from tests.reports.conftest import Answer
from tests.reports.program import descendants, running, started, wait_until
from tests.reports.scene_file import SCENE

pytestmark = pytest.mark.verify

ENGINES = ("--engine", "sound", "--engine", "thesis", "--engine", "also-sound")


@pytest.fixture
def place(tmp_path: Path) -> Path:
    install_faulty_engines(tmp_path)
    (tmp_path / "small.toml").write_text(SCENE)
    return tmp_path


def run(folder: Path, *more: str, **options: Any) -> "subprocess.Popen[str]":
    return started("run", *more, "--json", folder=folder, process_group=0, **options)


def interrupted(program: "subprocess.Popen[str]") -> bool:
    """Press Ctrl-C; whether that came before the program was done. It must have said one word and left no process behind."""
    below = descendants(program.pid)
    os.killpg(program.pid, signal.SIGINT)
    output, errors = program.communicate(timeout=30.0)
    wait_until(lambda: not any(map(running, below)))
    if program.returncode != 130:
        assert json.loads(output)["cases"]
        return False
    assert Answer(130, output, errors) == Answer(130, "", "quickreturn: interrupted\n")
    return True


def maps(process: int) -> str:
    """The files that a process has mapped, its libraries among them."""
    try:
        return Path(f"/proc/{process}/maps").read_text()
    except (FileNotFoundError, ProcessLookupError):
        return ""


def measures(folder: Path) -> list[Any]:
    program = run(folder, "small.toml", *ENGINES)
    output, errors = program.communicate(timeout=300.0)
    assert errors == ""
    return [(engine["engine"], engine["status"], engine["measures"]) for engine in json.loads(output)["cases"][0]["engines"]]


def test_interrupt_at_any_time(place: Path, record_property: Any) -> None:
    """From the first imports until the run is done."""
    pressed = 0
    for number in range(40):
        program = run(place, "small.toml", *ENGINES, variables={"QUICKRETURN_STORE": str(place / f"store {number}")})
        wait_until(lambda program=program: "numpy" in maps(program.pid), program)  # the program proper has begun
        time.sleep(0.15 * number)
        if not interrupted(program):
            break
        pressed += 1
        assert not list(place.rglob("*.part"))
    assert pressed > 3
    record_property("interrupts", pressed)


def test_interrupt_while_numba_compiles(place: Path) -> None:
    program = run(place, "thesis-24", "--engine", "reference", variables={"NUMBA_CACHE_DIR": str(place / "compiled")})
    wait_until(lambda: list((place / "compiled").rglob("*.nbc")), program, seconds=120.0)  # the first of many functions is done
    assert interrupted(program)
    assert not list(place.rglob("*.result"))


def test_interrupt_while_exudyn_holds_the_interpreter(place: Path) -> None:
    program = run(place, "thesis-24", "--engine", "exudyn", "--set", "engine.elements=64", "--set", "engine.step=2e-5")
    wait_until(lambda: any("exudynCPP" in maps(process) for process in descendants(program.pid)), program)
    time.sleep(5.0)  # building the model takes a fraction of this, the run minutes
    assert interrupted(program)


def test_killed_at_any_time_again_and_again(place: Path, tmp_path_factory: pytest.TempPathFactory, record_property: Any) -> None:
    """What is there in the end is what an undisturbed run finds, and no result that was there once is lost."""
    chance = random.Random(1)
    kills, there = 0, set[Path]()
    for _ in range(20):
        program = run(place, "small.toml", *ENGINES)
        try:
            program.wait(chance.uniform(0.5, 6.0))
        except subprocess.TimeoutExpired:
            below = descendants(program.pid)
            program.kill()
            kills += 1
            wait_until(lambda below=below: not any(map(running, below)))
        program.communicate()
        now = set(place.rglob("*.result"))
        assert there <= now
        there = now
    assert kills > 0
    record_property("kills", kills)
    undisturbed = tmp_path_factory.mktemp("undisturbed")
    install_faulty_engines(undisturbed)
    (undisturbed / "small.toml").write_text(SCENE)
    assert measures(place) == measures(undisturbed)
