"""Runs of the program with faulty engines, and what they leave behind."""

import subprocess
from pathlib import Path
from typing import Any

import pytest

from tests.engines.faulty_engines import DIARY, install_faulty_engines
from tests.quickreturn.conftest import Answer
from tests.quickreturn.program import started
from tests.quickreturn.scene_file import SCENE


def prepared(folder: Path) -> Path:
    """A folder with a small case and the faulty engines."""
    install_faulty_engines(folder)
    (folder / "small.toml").write_text(SCENE)
    return folder


@pytest.fixture
def place(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Where the program is started or called."""
    prepared(tmp_path)
    monkeypatch.syspath_prepend(tmp_path / "packages")
    return tmp_path


def engines(*names: str) -> list[str]:
    return [word for name in names for word in ("--engine", name)]


def answer_of(program: "subprocess.Popen[str]") -> Answer:
    output, errors = program.communicate(timeout=300.0)
    return Answer(program.returncode, output, errors)


def run(folder: Path, *names: str, **more: Any) -> "subprocess.Popen[str]":
    """A run of these engines, started."""
    return started("run", "--quiet", "small.toml", *engines(*names), "--json", folder=folder, **more)


def stored(folder: Path) -> list[Path]:
    """Results of engines; the periodic state in which they begin is no engine's."""
    return sorted(file for file in (folder / ".quickreturn").glob("*.result") if b'"engine"' in file.read_bytes())


def simulations(folder: Path) -> list[str]:
    """The engines that were asked to simulate, each once per simulation."""
    diary = folder / DIARY
    return diary.read_text().split() if diary.exists() else []


def nothing_half_done(folder: Path) -> bool:
    return not [file for file in folder.rglob("*.part") if "packages" not in file.parts]
