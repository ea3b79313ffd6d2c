"""`show` says what follows from the numbers of a scene, and which of them can hardly be meant."""

import json
import math
import re
import shlex
from collections.abc import Iterator
from pathlib import Path

import pytest

from quickreturn.cases.files.keys import PATHS
from quickreturn.cases.library import load_case
from quickreturn.command_line import main
from quickreturn.commands.console import ExitCode
from quickreturn.reference_model.native.cache_folder import folder
from quickreturn.reference_model.scene_values import SPIN_UP
from tests.quickreturn.conftest import Call
from tests.quickreturn.input.answers import refused


def test_what_follows_from_the_follower_is_shown(call: Call) -> None:
    derived = json.loads(call("show", "thesis-24", "--json").output)["derived"]
    # 4.75987e-5 lbf s²/in² over 25 in; 25 in over 1/8 in
    assert derived["mass"]["value"] == pytest.approx(4.75987e-5 * 175.126835 * 25.0, rel=1e-8)
    assert derived["slenderness"]["value"] == pytest.approx(200.0, rel=1e-12)
    # the lowest over the turn is that with the slider nearest to the pivot, 10.925 Hz to the digits of an independent solution
    assert derived["first_bending_frequency"] == {
        "value": pytest.approx(10.925, abs=5e-4),
        "unit": "Hz",
        "meaning": derived["first_bending_frequency"]["meaning"],
    }


def test_a_follower_alone_has_the_frequency_of_its_cantilever(call: Call) -> None:
    derived = json.loads(call("show", "spin-up", "--json").output)["derived"]
    # 1.8751² sqrt(EI / rho A) / L² / 2 pi
    assert derived["first_bending_frequency"]["value"] == pytest.approx(1.87510407**2 * (14e3 / 1.2) ** 0.5 / 100.0 / 6.283185307, rel=1e-6)


def test_the_scene_stands_there_before_an_engine_has_answered(capfd: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch) -> None:
    """Engines may take a minute of compiling on a new machine; each is shown as it comes."""
    seen = []

    def slow(*_: object) -> Iterator[dict[str, object]]:
        for engine in ("one", "two"):
            seen.append(capfd.readouterr().out)
            yield {"engine": engine, "refused": "as told"}

    monkeypatch.setattr("quickreturn.commands.case_document.models", slow)
    assert main(("--quiet", "show", "thesis-24")) == ExitCode.GOOD
    assert "pivot_distance" in seen[0]
    assert "what follows" in seen[0]
    assert seen[1] == "\none: as told\n"


def test_a_command_on_a_machine_without_compiled_code_says_at_once_that_it_compiles(
    capfd: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    """Before its imports and its first job; with code in the folder it says nothing, nor with --quiet."""
    monkeypatch.setenv("NUMBA_CACHE_DIR", str(tmp_path))
    monkeypatch.setattr("quickreturn.commands.case_document.models", lambda scene: iter(()))
    told = []
    for arguments in (("show", "thesis-24"), ("--quiet", "show", "thesis-24")):
        assert main(arguments) == ExitCode.GOOD
        told.append(capfd.readouterr().err)
    folder().mkdir()
    (folder() / "kernel.object").touch()
    assert main(("show", "thesis-24")) == ExitCode.GOOD
    assert ["compiling, once for this machine" in each for each in (*told, capfd.readouterr().err)] == [True, False, False]


def test_how_far_the_speed_is_from_a_resonance(call: Call) -> None:
    document = json.loads(call("show", "example", "--json").output)
    derived = document["derived"]
    # torque / damping is 120 rpm, two turns a second; the damping of the pivot takes 1.1 % of it
    turns = derived["mean_crank_speed"]["value"] / (2.0 * math.pi)
    assert turns == pytest.approx(2.0 * (1.0 - 0.011), rel=1e-3)
    assert derived["resonance"]["value"] == pytest.approx(derived["mean_bending_frequency"]["value"] / turns)
    assert derived["first_bending_frequency"]["value"] < derived["mean_bending_frequency"]["value"]
    assert "the 9th harmonic is nearest" in derived["resonance"]["meaning"]
    assert document["scene"]["follower"]["yield_strength"] == 240e6
    assert "resonance" not in json.loads(call("show", "rigid", "--json").output)["derived"]


#: A joint as overrides, the numbers that engines name which model it, and the key that the others refuse.
JOINTS = [
    (("slider.joint_stiffness_plus=10 kN/m", "slider.preload=2 N"), "10000 N/m (plus)", "slider.joint_stiffness_plus"),
    (("slider.joint_stiffness=100 kN/m", "slider.clearance=0.2 mm", "slider.friction=0.3"), "0.0002 m clearance", "slider.friction"),
]


@pytest.mark.parametrize(("overrides", "numbers", "key"), JOINTS)
def test_every_engine_says_what_it_makes_of_the_joint(call: Call, overrides: tuple[str, ...], numbers: str, key: str) -> None:
    engines = json.loads(call("show", "thesis-24", *(word for each in overrides for word in ("--set", each)), "--json").output)["engines"]
    told = {each["engine"]: each["refused"] or " ".join((*each["bodies"], *each["joints"])) for each in engines}
    able = {"reference", "mujoco", "stiff-spring"} | ({"exudyn"} if key != "slider.friction" else set())
    assert {name for name in able if numbers in told[name]} == able
    assert all(told[name].startswith(f"{key}: ") for name in ("multiplier", "thesis", "exudyn") if name not in able and key in told[name])
    assert told["thesis"].startswith("slider.")


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
