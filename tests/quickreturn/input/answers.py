"""Answers of the program, and an engine that differs from the fake one in one line."""

import json
from pathlib import Path
from typing import Any

import pytest

from tests.engines.fake_package import install
from tests.quickreturn.conftest import Answer, Call
from tests.quickreturn.scene_file import SCENE


@pytest.fixture(autouse=True)
def scene(tmp_path: Path) -> Path:
    """A case file `small.toml` in the folder from which the program is called."""
    file = tmp_path / "small.toml"
    file.write_text(SCENE)
    return file


def simulated(call: Call, *more: str, case: str = "small.toml", engine: str = "fake") -> Answer:
    return call("simulate", case, "--engine", engine, "--output", "out.csv", *more)


def document(answer: Answer) -> Any:
    """The one JSON document on standard output; json.loads refuses anything beside it."""
    return json.loads(answer.output)


def refused(answer: Answer, *words: str) -> None:
    """Exit code 2, nothing on standard output, one line on standard error with these words."""
    assert answer.code == 2, answer
    assert answer.output == ""
    assert answer.errors.count("\n") == 1, answer.errors
    assert answer.errors.startswith("quickreturn: ")
    assert "Traceback" not in answer.errors
    for word in words:
        assert word in answer.errors.replace('\\"', '"')


def variant(tmp_path: Path, line: str) -> None:
    """Install an engine `variant`: the fake one with one line of its class changed."""
    source = f"from command_line_fake import FakeEngine\nclass Engine(FakeEngine):\n    name = 'variant'\n    {line}\n"
    install(tmp_path / "packages", "variants", {"command_line_variant": source}, {"variant": "command_line_variant:Engine"})
