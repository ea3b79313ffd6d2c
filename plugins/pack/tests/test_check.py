"""`quickreturn check`: the pack's Python checker as a command."""

import json
import shutil
from pathlib import Path

from quickreturn.plugins.pack.tests.test_problems import PACK, bounds_of
from tests.quickreturn.conftest import Call


def test_a_right_table_a_wrong_one_and_bad_input(call: Call, tmp_path: Path) -> None:
    mine = tmp_path / "mine.csv"
    shutil.copy(PACK / "sag" / "results.csv", mine)
    answer = call("check", "sag", str(mine), "--json")
    found = json.loads(answer.output)
    assert (answer.code, found["problem"]) == (0, "sag")
    assert [each["status"] for each in found["signals"]] == ["within"] * len(bounds_of("sag")["signals"])
    mine.write_text(mine.read_text("utf-8").replace(",-0.1", ",-0.15"), "utf-8")
    answer = call("check", "sag", str(mine))
    assert (answer.code, answer.errors) == (1, "")
    assert "outside            off by" in answer.output
    assert call("check", "sag", str(mine), "--share", "0.5").code == 0


def test_mistakes_are_told_in_a_sentence(call: Call, tmp_path: Path) -> None:
    for arguments, told in (
        (("sagg", "mine.csv"), "sagg: no such problem; there are bead, "),
        (("sag", "mine.csv"), "mine.csv: cannot be read"),
        (("sag", "mine.csv", "--share", "1"), '--share "1"'),
    ):
        answer = call("check", *arguments)
        assert (answer.code, answer.output) == (2, "")
        assert told in answer.errors
        assert len(answer.errors.splitlines()) == 1
