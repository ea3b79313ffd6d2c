"""Doubtful values are told by every command that computes, on standard error, once; published inconsistencies are not repeated there."""

from pathlib import Path

import pytest

from tests.quickreturn.conftest import Call
from tests.quickreturn.scene_file import SCENE


@pytest.fixture(autouse=True)
def _scene(tmp_path: Path) -> None:
    (tmp_path / "my press.toml").write_text(SCENE.replace('"small"', '"press"'))


FAKE = ("--engine", "fake")
DOUBTFUL = ("--set", "tip.mass=3 kg", "--set", "tip.inertia=1e-5 kg*m^2")


@pytest.mark.parametrize(
    ("arguments", "cases"),
    [
        (("simulate", "my press.toml", *FAKE, "--set", "engine.step=0.1", *DOUBTFUL), 1),
        (("simulate", "my press.toml", *FAKE, "--set", "engine.step=0.1"), 0),
        (("modes", "my press.toml", *FAKE, *DOUBTFUL), 1),
        (("modes", "thesis-24", *FAKE), 0),  # published inconsistencies are no doubts
        (("modes", "thesis-0[1-3]", *FAKE, *DOUBTFUL), 3),
        pytest.param(("run", "my press.toml", *FAKE, *DOUBTFUL), 1, marks=pytest.mark.verify),
    ],
    ids=str,
)
def test_a_doubt_is_one_line_on_standard_error_for_all_cases(call: Call, arguments: tuple[str, ...], cases: int) -> None:
    answer = call(*arguments)
    notes = [line for line in answer.errors.splitlines() if ": note: " in line]
    assert len(notes) == min(cases, 1)
    assert all("tip.mass is 3 kg, 14.4 times the follower's (0.208 kg)" in note for note in notes if cases == 1)  # 0.328 kg/m x 0.635 m
    assert all("and 2 more" in note for note in notes if cases == 3)
    assert ": note: " not in answer.output
