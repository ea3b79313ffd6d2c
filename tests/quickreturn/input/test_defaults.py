"""What `simulate` and `modes` do with a case alone."""

import json
from pathlib import Path

import pytest

from tests.quickreturn.conftest import Call
from tests.quickreturn.scene_file import SCENE


@pytest.fixture(autouse=True)
def _scene(tmp_path: Path) -> None:
    (tmp_path / "small.toml").write_text(SCENE)


@pytest.mark.verify
def test_simulate_runs_reference_and_writes_nothing_but_the_store_unless_asked(call: Call, tmp_path: Path) -> None:
    before = sorted(tmp_path.iterdir())
    answer = call("simulate", "small.toml", "--duration", "10 ms", "--no-store")
    assert sorted(tmp_path.iterdir()) == before
    assert call("simulate", "small.toml", "--duration", "10 ms").code == 0
    assert {*tmp_path.iterdir()} == {*before, tmp_path / ".quickreturn"}
    assert answer.code == 0
    assert "reference" in answer.output
    assert answer.output.splitlines()[-1] == "no trajectory is written; --output small.csv writes it"


def test_modes_holds_the_crank_at_both_dead_centres_and_between(call: Call) -> None:
    found = json.loads(call("modes", "small.toml", "--json").output)
    assert [(each["engine"], round(each["crank_angle"], 9)) for each in found] == [
        ("reference", angle) for angle in (0.0, 1.570796327, 3.141592654)
    ]
    one = json.loads(call("modes", "small.toml", "--crank-angle", "90", "--json").output)
    assert one["frequencies"] == found[1]["frequencies"]
