"""`quickreturn new`: a case file of one's own that runs as it is, and what is said of it."""

import re
import shlex
from pathlib import Path

import pytest

from quickreturn.cases.files.keys import PATHS
from quickreturn.cases.library import load_case
from quickreturn.reference_model.scene_values import SPIN_UP
from tests.quickreturn.conftest import Call
from tests.quickreturn.input.answers import refused
from tests.quickreturn.scene_file import SCENE


def test_from_nothing_it_is_a_machine_with_every_key(call: Call, tmp_path: Path) -> None:
    answer = call("new", "my-machine.toml")
    assert (answer.code, answer.errors) == (0, "")
    case, example = load_case("my-machine.toml"), load_case("example")
    assert (case.name, case.title, case.tags) == ("my-machine", "My machine", ())
    assert (case.scene, case.duration, case.output_step) == (example.scene, example.duration, example.output_step)
    assert case.notes == ()
    text = (tmp_path / "my-machine.toml").read_text()
    assert all(re.search(rf"^(# )?{path.partition('.')[2]} = ", text, re.MULTILINE) for path in PATHS if path not in SPIN_UP)
    assert max(map(len, text.splitlines())) <= 140


def test_a_copy_has_the_values_of_the_case_as_they_are_written(call: Call, tmp_path: Path) -> None:
    assert call("new", "stiffer_arm.toml", "--from", "thesis-24", "--set", "follower.bending_stiffness=3000 lbf*in^2").code == 0
    case = load_case("stiffer_arm.toml")
    assert case.scene == load_case("thesis-24", {"follower.bending_stiffness": "3000 lbf*in^2"}).scene
    assert (case.name, case.title, case.tags) == ("stiffer_arm", "Stiffer arm", ())
    text = (tmp_path / "stiffer_arm.toml").read_text()
    assert 'length = "4 in" ' in text
    prose = " ".join(line.removeprefix("# ") for line in text.splitlines() if line.startswith("#"))
    assert "A copy of thesis-24 (Run 24: crank 4 in, six plates, 16.6 rad/s, with follower.bending_stiffness = 3000 lbf*in^2)." in prose
    for note in load_case("thesis-24").notes:  # what was replaced of the published values is not forgotten in the copy
        assert f"Note: {note}." in prose


def test_a_file_can_be_copied_and_its_doubtful_values_are_told(call: Call, tmp_path: Path) -> None:
    (tmp_path / "small.toml").write_text(SCENE)
    answer = call("new", "other.toml", "--from", "small.toml", "--set", "follower.thickness=5 cm")
    assert answer.code == 0
    assert answer.errors.startswith("quickreturn: other: note: follower.thickness is 0.05 m")
    case = load_case("other.toml")
    assert (case.name, case.scene.follower.thickness) == ("other", 0.05)
    assert "Note:" not in (tmp_path / "other.toml").read_text()  # the notes of a file follow from its values


@pytest.mark.parametrize(("origin", "commands"), [("example", ["show", "plot", "simulate", "run"]), ("spin-up", ["show", "simulate"])])
def test_what_it_says_can_be_done_next_can_be_done(call: Call, tmp_path: Path, origin: str, commands: list[str]) -> None:
    (tmp_path / "my machines").mkdir()
    answer = call("new", "my machines/first.toml", "--from", origin)
    head, *lines = answer.output.splitlines()
    assert head.startswith("my machines/first.toml is written.")
    typed = [shlex.split(line) for line in lines]
    assert [(program, command) for program, command, *_ in typed] == [("quickreturn", command) for command in commands]
    for _, command, *arguments in typed:
        if command == "show":
            assert call(command, *arguments).code == 0
        # the others take long: they are given a mistake, and answer that and nothing about file or output
        answer = call(command, *arguments, "--set", "follower.lenght=1 mm")
        assert (answer.code, "follower.lenght" in answer.errors) == (2, True)


def test_what_is_there_is_never_overwritten_and_a_mistake_leaves_no_file(call: Call, tmp_path: Path) -> None:
    (tmp_path / "mine.toml").write_text("kept")
    (tmp_path / "link.toml").symlink_to("nowhere.toml")
    for name in ("mine.toml", "./mine.toml", "link.toml"):
        refused(call("new", name), "not overwritten")
    refused(call("new", "other.toml", "--from", "example", "--set", "crank.length=600 mm"), "crank.length")
    assert (tmp_path / "mine.toml").read_text() == "kept"
    assert not (tmp_path / "nowhere.toml").exists()
    assert not (tmp_path / "other.toml").exists()
