"""`advise`: where a machine lies on the map of classes, what was fastest there, and what the map says nothing of."""

import json

import pytest

import quickreturn as qr
from quickreturn.plugins.methods import studies
from quickreturn.plugins.methods.tests.made_up_map import made_up_map
from tests.quickreturn.conftest import Call

#: Run 24 at a fifth of its speed.
SLOW = {"crank.torque": "2 lbf*in", "crank.initial_speed": "3.32 rad/s"}
ALONE, WAITED = "solve time", "waiting time"


@pytest.fixture(autouse=True)
def known(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(studies, "class_map", made_up_map)


def test_run_24_lies_near_the_scene_of_its_speed() -> None:
    found = qr.advise("thesis-24")
    assert found.scene == "speed 0.2"
    assert found.groups.speed == pytest.approx(0.242, abs=5e-4)
    assert found.use == {ALONE: "mujoco", WAITED: "mujoco"}
    slow = qr.advise(qr.case("thesis-24", SLOW))
    assert (slow.scene, slow.use) == ("speed 0.05", {ALONE: "reference", WAITED: "fixed-shapes"})


def test_who_refuses_the_machine_is_not_advised_and_says_why() -> None:
    found = qr.advise(qr.case("thesis-24", {**SLOW, "slider.joint_stiffness": "9e4 N/m"}))
    refused = {reach.engine: reach.remark for reach in found.reaches if reach.status == "refused"}
    assert set(refused) == {"thesis", "fixed-shapes", "multiplier"}  # exudyn, mujoco and reference have soft joints
    assert "slider.joint_stiffness" in refused["fixed-shapes"]
    assert found.use[WAITED] == "reference"  # the next one, as fixed-shapes cannot


def test_a_tighter_error_takes_the_next_level_and_beyond_the_last_one_that_is_said() -> None:
    assert qr.advise("thesis-24", accuracy=0.02).level == 0.01
    assert qr.advise("thesis-24", accuracy=5e-3).level == 0.001
    found = qr.advise("thesis-24", accuracy=1e-4)
    assert found.level == 0.001
    assert "an error of 0.01 % is asked for, the tightest of the map is 0.1 %" in found.outside
    with pytest.raises(ValueError, match="accuracy=1"):
        qr.advise("thesis-24", accuracy=1.0)


def test_what_lies_outside_the_map_is_called_an_extrapolation() -> None:
    told = str(qr.advise(qr.case("thesis-24", {"slider.friction": "0.1", "tip.mass": "2 kg"})))
    assert "outside the map, so this is an extrapolation: tip mass over arm mass is" in told
    assert "extrapolation: slider.friction is given, but no scene of the map has it" in told


def test_the_command_says_the_same_as_text_and_as_a_document(call: Call) -> None:
    answer = call("advise", "thesis-24", "--accuracy", "0.001")
    assert answer.code == 0
    assert "fastest by solve time: mujoco" in answer.output
    assert "not reached; 60 % remains" in answer.output
    document = json.loads(call("advise", "thesis-24", "--json").output)
    assert document["case"] == "thesis-24"
    assert document["use"] == {ALONE: "mujoco", WAITED: "mujoco"}
    assert document["groups"]["joint"] == "inf"
    assert {reach["engine"] for reach in document["reaches"]} == {"thesis", "multiplier", "mujoco", "reference", "exudyn"}


@pytest.mark.parametrize("arguments", [("rigid",), ("thesis-24", "--set", "engine.modes=3"), ("spin-up",)])
def test_what_has_no_place_on_the_map_is_bad_input(call: Call, arguments: tuple[str, ...]) -> None:
    assert call("advise", *arguments).code == 2
