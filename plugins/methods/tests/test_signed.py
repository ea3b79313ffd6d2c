"""Lines that somebody signs: those of the project are valid, and a mistake in a file is one clear sentence."""

from pathlib import Path

import pytest

from quickreturn.cases.files.errors import CaseError
from quickreturn.cases.library import load_case
from quickreturn.plugins.methods.signed import read_lines
from tests.quickreturn.conftest import Call


def test_the_projects_lines_are_settings_of_their_engines_and_signed() -> None:
    lines = read_lines()
    assert {"exudyn", "mujoco"} <= {line.engine for line in lines}
    for line in lines:
        assert line.signed_by
        settings = line.settings_for(load_case("thesis-24").mechanism).as_dict()
        assert {name: settings[name] for name in line.settings} == line.settings


@pytest.mark.parametrize(
    ("text", "told"),
    [
        ('name = "x"\n[[line]]\nengine = "mujoco"', 'has "name", "line"; give [[line]]'),
        ("line = [3]", 'has "line"; give [[line]]'),
        ('[[line]]\nengine = "mujoco"\nsigned_by = " "', "line 1: lacks its engine, or who signs it; give [[line]]"),
        ('[[line]]\nengine = "mujocco"\nsigned_by = "me"', 'line 1: "mujocco": no such engine (perhaps mujoco'),
        ('[[line]]\nengine = "mujoco"\nsigned_by = "me"\nlinks = 0', "line 1: engine.links: 0 is outside 1 to"),
    ],
)
def test_a_mistake_is_one_sentence(text: str, told: str, tmp_path: Path) -> None:
    file = tmp_path / "mine.toml"
    file.write_text(text)
    with pytest.raises(CaseError) as mistake:
        read_lines(file)
    assert told in str(mistake.value)
    assert str(mistake.value).startswith(str(file))
    assert "\n" not in str(mistake.value)


def test_the_command_refuses_a_file_that_is_not_there(call: Call) -> None:
    code, output, errors = call("benchmark", "thesis-24", "--lines", "nowhere.toml")
    assert (code, output) == (2, "")
    assert "nowhere.toml" in errors
