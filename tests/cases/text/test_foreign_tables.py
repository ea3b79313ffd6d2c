"""Tables as programs of other countries and trades export them: encodings, titles, blocks of LabVIEW, thousands, units, clock times."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from quickreturn.cases.errors import CaseError
from quickreturn.cases.recorded import read_table

GERMAN = "Zeit\u00e4hler;time [ms];crank_angle [\u00b0];tip_x [\u00b5m]\n7;0;180;1234,5\n8;0,5;181,25;2\n"
LABVIEW = """LabVIEW Measurement\t
Writer_Version\t2
Separator\tTab
Decimal_Separator\t{sign}
Multi_Headings\tNo
X_Columns\t{columns}
Date\t2024/05/06
Time\t10:11:12,123
***End_of_Header***\t
\t
Channels\t2\t\t
Samples\t2\t2\t
Y_Unit_Label\tdeg\tum\t
X_Dimension\tTime\tTime\t
X0\t0{sign}0E+0\t0{sign}0E+0\t
Delta_X\t0{sign}0005\t0{sign}0005\t
***End_of_Header***\t\t\t
X_Value\tcrank_angle\ttip_x\tComment
"""
ROWS = ("0\t180\t1234,5\tbegun\n0,0005\t181,25\t2\n", "\t180\t1234.5\n\t181.25\t2\n")
FORMS: dict[str, tuple[bytes, str]] = {
    "cp1252": (GERMAN.encode("cp1252"), "Windows-1252, semicolons, decimal comma, ignored: Zeit\u00e4hler"),
    "UTF-16 with a mark": (GERMAN.replace(";", "\t").encode("utf-16"), "UTF-16, tabulators, decimal comma, ignored: Zeit\u00e4hler"),
    "UTF-16 without": (GERMAN.encode("utf-16-be"), "UTF-16, semicolons, decimal comma, ignored: Zeit\u00e4hler"),
    "LabVIEW": (
        (LABVIEW.format(sign=",", columns="One") + ROWS[0]).encode(),
        "tabulators, decimal comma, header of LabVIEW",
    ),
    "LabVIEW without X values": (
        (LABVIEW.format(sign=".", columns="No") + ROWS[1]).encode(),
        "tabulators, header of LabVIEW, time from X0 and Delta_X",
    ),
    "Simpack": (
        b"SIMPACK, model shaper\nSolver: SODASRT 2, 2 s\ntime [ms],crank_angle [deg],tip_x [um]\n0,180,1234.5\n0.5,181.25,2\n",
        "2 lines above the headings left out",
    ),
    "Adams": (
        b"Model: shaper\nA\nTime\tcrank_angle\ttip_x\n(ms)\t(deg)\t(um)\n0.0\t180.0\t1.2345E+003\n5.0E-001\t181.25\t2.0\n",
        "tabulators, units in the second row, 2 lines above the headings left out",
    ),
    "Abaqus": (
        b"\n      time [ms]   crank_angle [deg]   tip_x [um]\n\n      0.      180.     1.2345E+03\n      500.E-03   181.25   2.\n\n\n",
        "blanks",
    ),
    "Simcenter": (
        b'"Simcenter Motion","shaper","run 3"\n\n"TIME (ms)","Crank Angle (deg)","Tip X (um)"\n0,180,1234.5\n0.5,181.25,2\n',
        "1 line above the headings left out",
    ),
    "commas at the ends": (b"time [ms],crank_angle [deg],tip_x [um]\n0,180,1234.5,\n0.5,181.25,2,\n", ""),
    "French": (
        "time [ms];crank_angle [deg];tip_x [um]\n0;180;1\u202f234,5\n0,5;181,25;2\n".encode(),
        "semicolons, decimal comma, thousands in groups",
    ),
    "Swiss": (b"time [ms];crank_angle [deg];tip_x [um]\n0;180;1'234.5\n0.5;181.25;2\n", "semicolons, thousands in groups"),
    "blanks in groups": (b"time [ms];crank_angle [deg];tip_x [um]\n0;180;1 234,5\n0,5;181,25;2\n", "semicolons, decimal comma"),
    "Excel's headings of two lines, and empty rows": (
        b'"time\n[ms]";"crank_angle\n[deg]";"tip_x\n[um]"\r\n0;180;1234,5\r\n0,5;181,25;2\r\n;;\r\n;;\r\n',
        "semicolons, decimal comma",
    ),
    "inches in a comment, and the end of a file of DOS": (
        b'# beam of 25" and 1"\n# beam of 25"\ntime [ms],crank_angle [deg],tip_x [um]\n0,180,1234.5\n0.5,181.25,2\n\x1a',
        "2 comment lines",
    ),
    "clock": (
        b"time [hh:mm:ss.fff],crank_angle [deg],tip_x [um]\n00:00:00.000,180,1234.5\n00:00:00.0005,181.25,2\n",
        "durations",
    ),
}


def written(folder: Path, content: bytes) -> str:
    (folder / "tool.csv").write_bytes(content)
    return str(folder / "tool.csv")


@pytest.mark.parametrize("form", FORMS)
def test_exports_are_read_and_what_was_recognised_is_told(tmp_path: Path, form: str) -> None:
    content, told = FORMS[form]
    table = read_table(written(tmp_path, content))
    assert table.told == (f"read as: {told}, 2 rows" if told else "")
    assert set(table.columns) == {"time", "crank_angle", "tip_x"}
    np.testing.assert_allclose(table.columns["time"], [0.0, 5e-4], rtol=1e-14)
    np.testing.assert_allclose(table.columns["crank_angle"], np.radians([180.0, 181.25]), rtol=1e-14)
    np.testing.assert_allclose(table.columns["tip_x"], [1.2345e-3, 2e-6], rtol=1e-14)


@pytest.mark.parametrize(
    ("text", "words"),
    [
        # a heading in milliseconds above clock times or a row of units in seconds: which is it?
        ("time [ms],tip_x\n00:00:00,1\n00:00:01,2\n", ["line 1", "time [ms]", '"s"', "one unit"]),
        ("time,tip_x [mm]\ns,m\n0,1\n", ["line 1", "tip_x [mm]", '"m"', "one unit"]),
        ("time,crank_angle [Grad]\n0,1\n", ["crank_angle", "Grad", "two ways", "gon"]),
        ("time,tip_x [Mm]\n0,1\n", ["tip_x", "Mm", "two ways", '"mm"']),
        ("s,mm\ntime,tip_x\n0,1\n", ["line 1", "s,mm", "above the headings", "below the headings"]),
        ("[s];[mm]\ntime;tip_x\n0;1\n", ["line 1", "above the headings"]),
        ("time,tip_x\n00:01.5,1\n", ["line 2, time", "hours, minutes and seconds"]),
        ("time,crank_angle [grad]\n0,1\n", ["crank_angle", "grad", "two ways", "gon"]),
        ("time;tip_x\n0;1\n1;2\nSumme;3\n", ["line 4, time", "Summe", "no plain number"]),
        ("sample,tip_x\n0,1\n1,2\n", ["no column time", 'add --column "sample = 1000 * time [s]"', "1000 a second"]),
        (LABVIEW.format(sign=",", columns="One") + ROWS[0] + "***End_of_Header***\n", ["line 21", "2 blocks of rows", "keep one"]),
        (LABVIEW.format(sign=".", columns="No").replace("Delta_X", "Step") + ROWS[1], ["Delta_X", "not one number", "X values"]),
        (LABVIEW.format(sign=".", columns="No").replace("0005\t0", "0005\t1") + ROWS[1], ["Delta_X", "not one number", "X values"]),
        (LABVIEW.format(sign=".", columns="One").replace("Time\tTime", "Frequency\t") + "1\t2\t3\n", ["no column time"]),
        (LABVIEW.format(sign=",", columns="Multi").replace("tip_x", "X_Value\ttip_x") + "0\t1\t0\t2\n", ["time", "a second time"]),
    ],
)
def test_what_has_two_meanings_is_asked_back(tmp_path: Path, text: str, words: list[str]) -> None:
    with pytest.raises(CaseError) as told:
        read_table(written(tmp_path, text.encode()))
    assert "\n" not in str(told.value)
    for word in words:
        assert word in str(told.value)


@pytest.mark.parametrize(("path", "columns", "words"), [
    (None, (), ["NoneType is no path", "qr.compare"]),
    ({"time": [0.0]}, (), ["dict is no path"]),
    (3, (), ["int is no path"]),
    (b"tool.csv", (), ["bytes is no path"]),
    ("tool.csv", None, ["columns", "None", "is not a text"]),
])  # fmt: skip
def test_arguments_of_another_kind_are_told(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, path: Any, columns: Any, words: list[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    written(tmp_path, b"time,tip_x\n0,1\n")
    with pytest.raises(CaseError) as told:
        read_table(path, columns)
    for word in words:
        assert word in str(told.value)
