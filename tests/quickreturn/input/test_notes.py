"""Doubtful values are told by every command that computes, on standard error, once; published inconsistencies are not repeated there."""

import json
import re
import shlex
from pathlib import Path

import pytest

from tests.quickreturn.conftest import Call
from tests.quickreturn.scene_file import SCENE

NOTE = "tip.mass is 3 kg, 14.4 times the follower's (0.208 kg)"  # 0.328 kg/m x 0.635 m
HEAVY = ("--set", "tip.mass=3 kg", "--set", "tip.inertia=1e-5 kg*m^2")


@pytest.fixture(autouse=True)
def _scene(tmp_path: Path) -> None:
    (tmp_path / "my press.toml").write_text(SCENE.replace('"small"', '"press"'))


@pytest.mark.parametrize(
    "arguments",
    [
        ("simulate", "--set", "engine.step=0.1"),
        ("modes",),
        pytest.param(("run",), marks=pytest.mark.verify),
    ],
    ids=lambda arguments: arguments[0],
)
def test_a_doubt_is_one_line_on_standard_error(call: Call, arguments: tuple[str, ...]) -> None:
    command, *more = arguments
    answer = call(command, "my press.toml", "--engine", "fake", *HEAVY, *more)
    told = [line for line in answer.errors.splitlines() if ": note: " in line]
    assert len(told) == 1
    assert told[0].startswith(f"quickreturn: press: note: {NOTE}")
    assert NOTE not in answer.output
    assert ": note: " not in call(command, "my press.toml", "--engine", "fake", *more).errors


def test_a_doubt_is_among_the_notes_of_a_json_document(call: Call) -> None:
    answer = call("simulate", "my press.toml", "--engine", "fake", "--set", "engine.step=0.1", *HEAVY, "--json")
    (note,) = json.loads(answer.output)["notes"]
    assert note.startswith(NOTE)
    assert answer.errors == f"quickreturn: press: note: {note}\n"


def test_what_is_known_of_published_values_is_not_told_again(call: Call) -> None:
    answer = call("modes", "thesis-24", "--engine", "fake")
    assert (answer.code, answer.errors) == (0, "")


def test_a_doubt_about_many_cases_is_told_once(call: Call) -> None:
    answer = call("modes", "thesis-0[1-3]", "--engine", "fake", "--set", "tip.mass=3 kg")
    assert answer.code == 0
    assert re.fullmatch(r"quickreturn: thesis-01 and 2 more: note: tip\.mass is 3 kg, [^\n]+\n", answer.errors)


def test_the_hint_on_notes_names_the_file_and_its_changes(call: Call) -> None:
    answer = call("simulate", "my press.toml", "--engine", "fake", "--set", "engine.step=0.1", *HEAVY)
    (hint,) = re.findall(r"^notes +1 on this case: see `(.*)`$", answer.output, re.MULTILINE)
    assert hint == "quickreturn show 'my press.toml' --set 'tip.mass=3 kg' --set 'tip.inertia=1e-5 kg*m^2'"
    assert f"note: {NOTE}" in call(*shlex.split(hint)[1:]).output
    failed = call("simulate", "my press.toml", "--engine", "fake", "--set", "engine.behaviour=fails", *HEAVY)
    assert f"see `{hint}`" in failed.output


def test_the_hint_on_notes_names_a_library_case_as_it_was_given(call: Call) -> None:
    answer = call("simulate", "thesis-24", "--engine", "fake", "--duration", "0.1", "--set", "engine.step=0.1")
    assert re.search(r"^notes +3 on this case: see `quickreturn show thesis-24`$", answer.output, re.MULTILINE)
