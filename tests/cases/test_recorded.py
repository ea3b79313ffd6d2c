"""Recorded tables are read as they declare themselves, and what cannot be read is told with place, value and what is accepted."""

import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from quickreturn.cases import recorded
from quickreturn.cases.errors import CaseError
from quickreturn.cases.recorded import read_table, table_of

HEADING = "time [ms],crank_angle [deg],tip_deflection [mm],strain_1 [percent]"
ROWS = "0,180,-2.5,0\n1,181,1e-3,0.1\n"


def written(folder: Path, text: str, name: str = "tool.csv") -> str:
    (folder / name).write_bytes(text.encode())
    return str(folder / name)


def refusal(folder: Path, text: str) -> str:
    with pytest.raises(CaseError) as told:
        read_table(written(folder, text))
    return str(told.value)


@pytest.mark.parametrize(
    "text",
    [
        f"{HEADING}\n{ROWS}",
        f"\ufeff{HEADING}\r\n{ROWS}".replace("\n", "\r\n"),  # as Excel writes it
        f"\n# case = x\n# version = Tool 7\n\n{HEADING}\n\n{ROWS}\n\n",
        '"time [ms]", "crank_angle (deg)","tip_deflection [mm]","strain_1 [%]"\n"0",180,-2.5,0\n1, 181 ,1e-3,0.1',
    ],
)
def test_units_are_turned_into_si_and_nothing_else_is_touched(tmp_path: Path, text: str) -> None:
    table = read_table(written(tmp_path, text))
    assert table.name == "tool.csv"
    assert table.bare == frozenset()
    np.testing.assert_allclose(table.columns["time"], [0.0, 1e-3], rtol=1e-15)
    np.testing.assert_allclose(table.columns["crank_angle"], np.radians([180.0, 181.0]), rtol=1e-15)
    np.testing.assert_allclose(table.columns["tip_deflection"], [-2.5e-3, 1e-6], rtol=1e-15)
    np.testing.assert_allclose(table.columns["strain_1"], [0.0, 1e-3], rtol=1e-15)
    assert table.declared in ({}, {"case": "x", "version": "Tool 7"})


@pytest.mark.parametrize(
    ("heading", "size"),
    [
        ("tip_acceleration [g]", 9.80665),
        ("tip_acceleration [in/s^2]", 0.0254),
        ("strain_3 [microstrain]", 1e-6),
        ("strain_3 [µm/m]", 1e-6),
        ("strain_3 [µε]", 1e-6),
        ("strain_3 [mm/mm]", 1.0),
        ("strain_3 [-]", 1.0),
        ("strain_3", 1.0),
        ("crank_torque [lbf*in]", 0.1129848290276167),
        ("kinetic_energy [mJ]", 1e-3),
        ("crank_speed [rpm]", np.pi / 30.0),
    ],
)
def test_units(tmp_path: Path, heading: str, size: float) -> None:
    table = read_table(written(tmp_path, f"time,{heading}\n0,2\n"))
    (name,) = set(table.columns) - {"time"}
    np.testing.assert_allclose(table.columns[name], [2.0 * size], rtol=1e-15)
    assert (name in table.bare) == ("[" not in heading)


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("", ["is empty"]),
        ("# case = x\n", ["no heading"]),
        ("time,tip_deflection\n", ["no rows"]),
        ("time,tip_deflecton [mm]\n0,1", ["line 1", "tip_deflecton", "tip_deflection", "--for-other-tools"]),
        ("time;tip_deflection\n0;1", ["line 1", "semicolons", "commas"]),
        ("time\ttip_deflection\n0\t1", ["line 1", "tabulators"]),
        ("time,tip_deflection\n0;1\n", ["line 2, time", "0;1", "semicolons"]),
        ("time,tip_deflection\n0,1,5\n", ["line 2", "0,1,5", "3 numbers", "2 columns", "comma"]),
        ("time,tip_deflection [kg]\n0,1", ["line 1, tip_deflection", "kg", "a mass", "a length", "mm"]),
        ("time,tip_deflection [m m]\n0,1", ["line 1, tip_deflection", "unreadable unit"]),
        ("time,strain_1 [mm]\n0,1", ["strain_1", "mm", "a length", "a pure number", "microstrain", "percent"]),
        ("time,crank_speed [Hz]\n0,1", ["crank_speed", "Hz", 'meant as "rps"', "rpm"]),
        ("time,crank_speed [1/min]\n0,1", ['meant as "rpm"']),
        ("time,crank_speed [1/s]\n0,1", ['meant as "rps" or "rad/s"']),
        ('time,tip_x\n0,"1,5"\n', ["line 2, tip_x", "1,5", "the decimal sign is a point"]),
        ("time,tip_x\n0,1.5D-3\n", ["line 2, tip_x", "1.5D-3", "e for D"]),
        ("time,tip_x\n0,1\n# end\n", ["line 3", "# end", "no row of numbers"]),
        ("time,tip_x\n0,1\n2,1\n\n1,2", ["line 5, time", "1", "does not rise"]),
        ("time,tip_x\n0,1\n0,2", ["line 3, time", "does not rise"]),
        ("time,tip_x\n0,1\n1,nan", ["line 3, tip_x", "nan"]),
        ("time,tip_x\n0,1\n1,1e999", ["line 3, tip_x", "1e999"]),
        ("time,tip_x\n0,1\n1,", ["line 3, tip_x", "is empty", "leave out"]),
        ("time,tip_x\n0,1\n1", ["line 3", "1 numbers", "2 columns"]),
        ("time,tip_x\n0,1_0", ["line 2, tip_x", "1_0"]),
        ("time,tip_x\n[s],[m]\n0,1", ["line 2", "[s],[m]", "headings", "brackets"]),
        ("0,1\n1,2", ["line 1", "heading"]),
        ("time,time [ms]\n0,1", ["line 1", "second time"]),
        ("tip_x\n0", ["no column time"]),
        ("time\n0", ["time alone"]),
        ("# orgin = x\ntime,tip_x\n0,1", ["line 1", "orgin", "origin"]),
        ("# origin = guessed\ntime,tip_x\n0,1", ["line 1, origin", "guessed", "measured"]),
        ("# case = a\n# case = b\ntime,tip_x\n0,1", ["line 2", "twice"]),
        ("# just a remark\ntime,tip_x\n0,1", ["line 1", "# key = value"]),
    ],
)
def test_what_cannot_be_read_is_told(tmp_path: Path, text: str, words: list[str]) -> None:
    told = refusal(tmp_path, text)
    assert told.startswith(f"{tmp_path}/tool.csv: ")
    assert "\n" not in told
    for word in words:
        assert word in told


@pytest.mark.parametrize(
    ("rows", "place"),
    [
        ("0,180\n1,181\n1,182\n2,x\n", "line 4, time: 1 does not rise"),
        ("0,180\n1,x\n1,182\n", 'line 3, crank_angle: "x" is no plain number'),
        ("0,180\n1,181\n0.5,182\n2,183,9\n", "line 4, time: 0.5 does not rise"),
        ("0,180\n\n1,inf\n1,182\n", 'line 4, crank_angle: "inf" is no plain number'),
    ],
)
def test_of_several_mistakes_in_a_file_the_first_is_named(tmp_path: Path, rows: str, place: str) -> None:
    told = refusal(tmp_path, f"time [s],crank_angle [deg]\n{rows}")
    assert f"tool.csv: {place}" in told
    assert "\n" not in told


@pytest.mark.parametrize(
    ("columns", "told"),
    [
        ({"time": [0.0, 1.0, 2.0, 1.5], "crank_angle": [1.0, math.nan, 2.0, 3.0]}, "row 1, crank_angle: nan is not finite"),
        ({"time": [0.0, 0.0, 1.0], "crank_angle": [1.0, 2.0, math.inf]}, "row 1, time: 0 does not rise"),
        ({"time": [0.0, 1.0, 2.0], "crank_angle": [1.0, 2.0, math.inf], "tip_x": [1.0, math.nan, 3.0]}, "row 1, tip_x: nan is not finite"),
        ({"time": [0.0, 1.0, "later"], "crank_angle": [1.0, "west", 2.0]}, 'row 1, crank_angle: "west" is no number'),
        ({"time": [0.0, 1.0, "later"], "crank_angle": [1.0, 2.0, 3.0]}, 'row 2, time: "later" is no number'),
    ],
)
def test_of_several_mistakes_in_memory_the_first_is_named(columns: dict[str, list[Any]], told: str) -> None:
    with pytest.raises(CaseError) as refused:
        table_of(columns)
    assert str(refused.value).startswith(f"table: {told}")
    assert "\n" not in str(refused.value)


def test_a_name_is_safe_to_print(tmp_path: Path) -> None:
    assert read_table(written(tmp_path, f"{HEADING}\n{ROWS}", "a\x1b[31m\n.csv")).name == "a\\x1b[31m\\n.csv"


def test_files_that_are_none(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    with pytest.raises(CaseError, match=r"no such file; give the path of a recorded table"):
        read_table(str(tmp_path / "none.csv"))
    (tmp_path / "excel.csv").write_bytes("time,tip_x\n0,1\n".encode("utf-16"))
    with pytest.raises(CaseError, match="not in UTF-8"):
        read_table(str(tmp_path / "excel.csv"))
    monkeypatch.setattr(recorded, "MOST_ROWS", 3)
    with pytest.raises(CaseError, match="has 5 rows; at most 3 are accepted"):
        read_table(written(tmp_path, "time,tip_x\n" + "\n".join(f"{row},0" for row in range(5))))
