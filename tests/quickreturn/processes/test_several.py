"""Several cases, engines and angles in one call; what the shell may ask; what is told meanwhile."""

import json
import os
import signal
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest

from quickreturn.command_line import main
from tests.engines.faulty_engines import install_faulty_engines
from tests.quickreturn.conftest import Call
from tests.quickreturn.program import PROGRAM
from tests.quickreturn.scene_file import SCENE


@pytest.fixture(autouse=True)
def _scenes(tmp_path: Path) -> None:
    """Three case files in the folder from which the program is called."""
    install_faulty_engines(tmp_path)
    for name in ("small", "smaller", "other"):
        (tmp_path / f"{name}.toml").write_text(SCENE.replace('"small"', f'"{name}"'))


def simulated(call: Call, *arguments: str) -> Any:
    answer = call("simulate", *arguments, "--set", "engine.step=0.1", "--json")
    assert answer.code == 0, answer
    return json.loads(answer.output)


def test_one_engine_on_one_case_is_one_document_and_several_are_a_list(call: Call, tmp_path: Path) -> None:
    one = simulated(call, "small.toml", "--engine", "fake", "--output", "{engine}.csv")
    assert one["output"] == "fake.csv"
    several = simulated(call, "small*.toml", "--engine", "fake", "--output", "{case}.csv")
    assert [(each["case"], each["output"]) for each in several] == [("small", "small.csv"), ("smaller", "smaller.csv")]
    assert (tmp_path / "smaller.csv").read_text() == (tmp_path / "fake.csv").read_text()
    engines = simulated(call, "small.toml", "--engine", "fake", "--engine", "sound", "--output", "{engine}.csv")
    assert [each["engine"] for each in engines] == ["fake", "sound"]


def test_one_that_fails_does_not_keep_the_others_from_being_written(call: Call, tmp_path: Path) -> None:
    answer = call("simulate", "small.toml", "--engine", "raises", "--engine", "sound", "--output", "{engine}.csv", "--json")
    assert answer.code == 3
    assert [each["reached"] for each in json.loads(answer.output)] == [False, True]
    assert (tmp_path / "sound.csv").exists()
    assert "engine raises: " in answer.errors


def test_settings_of_one_engine_among_several(call: Call) -> None:
    both = ("--engine", "fake", "--engine", "sound", "--output", "{engine}.csv", "--json", "--set", "engine.step=0.1")
    found = json.loads(call("simulate", "small.toml", *both, "--set", "sound.step=0.05").output)
    assert [each["settings"]["step"] for each in found] == [0.1, 0.05]


def test_angles_give_a_list_with_both_ends(call: Call) -> None:
    asked = ("modes", "small.toml", "--engine", "fake", "--count", "1", "--crank-angle")
    found = json.loads(call(*asked, "0:360:90", "--json").output)
    assert [each["crank_angle"] for each in found] == pytest.approx([0.0, 1.570796, 3.141593, 4.712389, 6.283185], abs=1e-6)
    assert [each["frequencies"][0] - 10.0 for each in found] == pytest.approx([each["crank_angle"] for each in found])
    assert json.loads(call(*asked, "90", "--json").output) == found[1]
    assert "crank deg  1\n0          10\n" in call(*asked, "0:360:90").output
    assert len(json.loads(call(*asked, "10:-10:-0.1", "--json").output)) == 201


def test_show_takes_patterns_and_tags(call: Call, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("quickreturn.commands.case_document.models", lambda scene: iter(()))  # what each engine builds takes seconds
    found = json.loads(call("show", "small*.toml", "--tag", "example", "--json").output)
    assert [each["name"] for each in found] == [
        "small",
        "smaller",
        "example",
        "return-spring",
        "shaper-chips",
        "shaper-cutting",
        "whitworth",
    ]
    assert call("show", "other.toml", "small.toml").output.count("what follows") == 2


def test_the_version_is_told(call: Call) -> None:
    from importlib.metadata import version

    told = f"quickreturn {version('quickreturn')}\n"
    assert call("--version").output == told
    assert subprocess.run([sys.executable, "-m", "quickreturn", "--version"], capture_output=True, text=True, check=True).stdout == told


@pytest.mark.parametrize(
    ("typed", "completed"),
    [
        ("quickreturn show thesis-2", "plain,thesis-24"),
        ("quickreturn run thesis-24 --engine muj", "plain,mujoco"),
        ("quickreturn simulate thesis-24 --acc", "plain,--accuracy"),
    ],
)
def test_the_shell_is_answered(typed: str, completed: str) -> None:
    asked = {"_QUICKRETURN_COMPLETE": "bash_complete", "COMP_WORDS": typed, "COMP_CWORD": str(len(typed.split()) - 1)}
    answer = subprocess.run([PROGRAM], env={**os.environ, **asked}, capture_output=True, text=True, check=True)
    assert completed in answer.stdout.splitlines()


def test_nothing_is_known_of_a_store_where_none_is_used(capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch) -> None:
    def interrupted(*_: object) -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr("quickreturn.commands.case_document.document_of", interrupted)
    before = signal.getsignal(signal.SIGINT)
    assert main(["show", "thesis-24"]) == 130
    assert "nothing is kept" in capsys.readouterr().err
    assert signal.getsignal(signal.SIGINT) is before, "who calls it from Python goes on and must hear the next Ctrl-C"
