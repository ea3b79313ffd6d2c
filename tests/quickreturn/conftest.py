"""The command line in this process, with the fake engine installed as a third-party package."""

from collections.abc import Callable
from pathlib import Path
from typing import NamedTuple

import pytest

from quickreturn.cases.running.isolation import LocalProcesses
from quickreturn.cases.running.job import Job
from quickreturn.cases.running.store import VARIABLE
from quickreturn.command_line import main
from tests.engines.fake_package import FAKE_ENGINE, install


class Answer(NamedTuple):
    """What a call of the program left behind."""

    code: int
    output: str
    errors: str


Call = Callable[..., Answer]


@pytest.fixture(scope="session", autouse=True)
def warm_workers() -> None:
    """The first job of a process decides what its fork server has imported: here what all later jobs need."""
    list(LocalProcesses().run([Job("warm", len, ((),))]))


@pytest.fixture(autouse=True)
def own_store(monkeypatch: pytest.MonkeyPatch) -> None:
    """A store that the environment names would answer with results of others; each test has its folder's."""
    monkeypatch.delenv(VARIABLE, raising=False)


@pytest.fixture
def call(capfd: pytest.CaptureFixture[str], tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Call:
    """Call the program's entry function in a folder of its own."""
    install(tmp_path / "packages", "fakes", {"command_line_fake": FAKE_ENGINE}, {"fake": "command_line_fake:FakeEngine"})
    monkeypatch.syspath_prepend(tmp_path / "packages")
    monkeypatch.chdir(tmp_path)

    def called(*arguments: str) -> Answer:
        capfd.readouterr()
        code = main(("--quiet", *arguments) if arguments else ())  # what is on its way is told or not, by how fast the machine is
        return Answer(code, *capfd.readouterr())

    return called
