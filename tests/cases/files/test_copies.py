"""Copies of a case with other values: their names, their titles, and that they are what the file would describe."""

from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

from quickreturn.cases.files.case import parse_case
from quickreturn.cases.files.document import LONGEST_NAME
from quickreturn.cases.files.errors import CaseError
from quickreturn.cases.library import load_case, with_times
from tests.cases.files.scene_texts import SCENE


def test_a_copy_tells_its_changes_in_name_and_title() -> None:
    run = load_case("thesis-24")
    copy = run.with_({"crank.length": "5 in"})
    assert (copy.name, copy.title) == ("thesis-24-crank.length-5-in", f"{run.title}, with crank.length = 5 in")
    assert copy.mechanism.crank.length == pytest.approx(0.127)
    assert copy.notes == run.notes
    assert run.name == "thesis-24"
    assert run.mechanism.crank.length == pytest.approx(0.1016)
    speeds = [run.with_({"crank.initial_speed": f"{speed} rpm"}) for speed in range(150, 160)]
    assert len({speed.name for speed in speeds}) == len({speed.title for speed in speeds}) == 10


def test_a_copy_is_what_the_file_with_these_values_describes() -> None:
    """Not what its numbers in SI would give: stiffness and mass follow from material and section, the start from the torque."""
    for name, changes in (("shaper-cutting", {"follower.thickness": "30 mm"}), ("example", {"crank.torque": "2 N*m"})):
        assert load_case(name).with_(changes).scene == load_case(name, changes).scene
    text = SCENE.replace('initial_speed = "16.617773 rad/s"\n', "")
    whole = parse_case(text, "scene.toml")
    speeds = [case.values["crank"]["initial_speed"] for case in (whole, whole.with_({"crank.torque": "5 lbf*in"}))]
    assert speeds[1] == pytest.approx(0.5 * speeds[0])


def test_copies_of_copies_tell_what_holds_at_last() -> None:
    run = load_case("thesis-24")
    again = run.with_({"crank.length": "5 in"}).with_({"crank.length": "3 in"})
    assert (again.name, again.title) == ("thesis-24-crank.length-3-in", f"{run.title}, with crank.length = 3 in")
    driven = again.with_({"crank.damping": "1 N*m*s"}).with_({"crank.prescribed_speed": "90 rpm"})
    assert driven.title == f"{run.title}, with crank.length = 3 in and crank.prescribed_speed = 90 rpm"
    assert driven.scene == load_case("thesis-24", {"crank.length": "3 in", "crank.prescribed_speed": "90 rpm"}).scene


def test_names_are_names_whatever_is_changed() -> None:
    run = load_case("thesis-24")
    long = [run.with_({"mechanism.gravity": f'["{x} m/s^2", "-9.81 m/s^2"]', "follower.bending_stiffness": "1e+1 N*m^2"}) for x in "012"]
    assert all(len(copy.name) <= LONGEST_NAME for copy in long)
    assert len({copy.name for copy in long}) == 3
    assert "mechanism.gravity = (0 m/s^2, -9.81 m/s^2)" in long[0].title
    for copy in long:
        assert parse_case(SCENE.replace('name = "scene"', f'name = "{copy.name}"'), "scene.toml").name == copy.name
    gauges = {"follower.strain_gauges": '["1 in", "2 in", "3 in"]', "tip.mass": "0 kg", "tip.inertia": "0 kg*m^2"}
    times = {"simulation.duration": "1.000000000000 s", "simulation.output_step": "0.001000000000 s"}
    crank = {"crank.length": "100.000000000000 mm", "crank.initial_angle": "180.0000000000 deg", "crank.initial_speed": "16 rad/s"}
    assert run.with_({**gauges, **times, **crank}).title == f"{run.title}, with 8 other values"


def test_a_name_and_changes_from_elsewhere_are_kept() -> None:
    run = with_times(load_case("thesis-24"), 0.5)
    named = run.with_(name="short")
    assert (named.name, named.title, named.scene, named.duration) == ("short", run.title, run.scene, 0.5)
    heavier = replace(run, title="Mine", scene=replace(run.mechanism, gravity=(0.0, -1.0))).with_({"crank.length": "5 in"})
    assert (heavier.title, heavier.mechanism.gravity, heavier.duration) == ("Mine, with crank.length = 5 in", (0.0, -1.0), 0.5)


def test_a_doubt_that_the_change_removes_is_not_told() -> None:
    thick = load_case("thesis-24", {"follower.thickness": "9 in"})
    assert any("quarter of the length" in note for note in thick.notes)
    thin = thick.with_({"follower.thickness": "0.125 in"})
    assert thin.notes == load_case("thesis-24").notes


def test_a_file_keeps_its_source(tmp_path: Path) -> None:
    (tmp_path / "scene.toml").write_text(SCENE)
    case = load_case(str(tmp_path / "scene.toml"))
    assert case.with_({"crank.length": "0.1 m"}).source == case.source


@pytest.mark.parametrize(
    ("overrides", "name", "told"),
    [
        ({}, None, "^thesis-24: a copy without a change needs a name"),
        ({"crank.length": "5 in"}, "five inches", '^copy of thesis-24: name: "five inches" is not a name; up to 64 letters'),
    ],
)
def test_what_cannot_be_is_answered_with_a_sentence(overrides: Any, name: str | None, told: str) -> None:
    with pytest.raises(CaseError, match=told):
        load_case("thesis-24").with_(overrides, name=name)
