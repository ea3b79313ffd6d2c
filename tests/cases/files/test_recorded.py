"""Recorded tables are read as they declare themselves, and what cannot be read is told with place, value and what is accepted."""

import math
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import pytest

import quickreturn as qr
from quickreturn.cases.files import recorded
from quickreturn.cases.files.errors import CaseError
from quickreturn.cases.files.recorded import read_table

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
    np.testing.assert_allclose(table.columns["time"], [0.0, 1e-3], rtol=1e-15)
    np.testing.assert_allclose(table.columns["crank_angle"], np.radians([180.0, 181.0]), rtol=1e-15)
    np.testing.assert_allclose(table.columns["tip_deflection"], [-2.5e-3, 1e-6], rtol=1e-15)
    np.testing.assert_allclose(table.columns["strain_1"], [0.0, 1e-3], rtol=1e-15)
    assert table.declared in ({}, {"case": "x", "version": "Tool 7"})


@pytest.mark.parametrize(
    ("heading", "size"),
    [
        ("tip_acceleration [g]", 9.80665),
        ("strain_3 [microstrain]", 1e-6),
        ("strain_3 [µm/m]", 1e-6),
        ("strain_3 [µε]", 1e-6),
        ("strain_3", 1.0),
        ("crank_torque [lbf*in]", 0.1129848290276167),
        ("crank_torque [lbf in]", 0.1129848290276167),
        ("crank_speed [rpm]", np.pi / 30.0),
    ],
)
def test_units(tmp_path: Path, heading: str, size: float) -> None:
    table = read_table(written(tmp_path, f"time,{heading}\n0,2\n"))
    (name,) = set(table.columns) - {"time"}
    np.testing.assert_allclose(table.columns[name], [2.0 * size], rtol=1e-15)


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("", ["is empty"]),
        ("PK\x03\x04\x14", ["is an Excel workbook"]),
        ("time,tip_deflection\n", ["no rows"]),
        ("time,tip_deflecton [mm]\n0,1", ["line 1", "tip_deflecton", "tip_deflection", "--for-other-tools"]),
        ("Time,crank.phi,tip_deflecton\n0,1,2", ["crank.phi", "crank_angle", "tip_deflecton", "tip_deflection", "--write-mapping"]),
        ("time;tip_x\n0;3\n1;1,234\n", ["line 3", "1,234", "two ways", "--decimal"]),
        ("time;tip_x\n0;3,5\n1;1.5\n", ["line 2", "3,5", "decimal points too", "--decimal"]),
        ("time [s];tip_x\nms;m\n0;1\n", ["line 1", "time [s]", "ms", "one unit"]),
        ("time,tip_deflection\n0,1,5\n", ["line 2", "0,1,5", "3 columns", "of 2", "--decimal"]),
        ("Solver 7, 2 s\ntime [ms],tip_x [um]\n0,1\n", ["line 1", "no column time", "--skip"]),
        ("time,tip_deflection [kg]\n0,1", ["line 1, tip_deflection", "kg", "a mass", "a length", "mm"]),
        ("time,strain_1 [mm]\n0,1", ["strain_1", "mm", "a length", "a pure number", "microstrain", "percent"]),
        ("time,crank_angle [Grad]\n0,1\n", ["crank_angle", "Grad", "two ways", "gon"]),
        ("time,tip_x [Mm]\n0,1\n", ["tip_x", "Mm", "two ways", '"mm"']),
        ('time,tip_x\n0,"1,5"\n', ["line 2, tip_x", "1,5", "no plain number"]),
        ("time,tip_x\n0,1\n2,1\n\n1,2", ["line 5, time", "1", "does not rise"]),
        ("time,tip_x\n0,1\n1,2\n0.9,3\n2,x\n", ["line 4, time", "0.9 does not rise"]),  # the first of two mistakes
        ("0,1\n1,2", ["line 1", "heading"]),
        ("time,tip_x,time,tip_y\n0,1,0,1\n1,2,,\n", ["time a second time", '--column "3 = -"']),
        ("time,tip_x,tip_y\n0,1,\n1,,2\n2,1,\n", ["an empty cell in each", '--column "tip_y = -"']),
        ("time,tip_x\n10:00:01,1\n10:00:00,2\n", ["line 3, time", "-1 does not rise"]),
        ("time,tip_x\n02.01.2026 10:00,1\n", ["line 2, time", "02.01.2026 10:00", "no plain number", "2026-05-04T08:15:00.25"]),
        ("tip_x\n0", ["no column time"]),
        ("# origin = guessed\ntime,tip_x\n0,1", ["line 1, origin", "guessed", "measured"]),
        ("# origin\ntime,tip_x\n0,1", ["line 1", "# key = value"]),
    ],
)
def test_what_cannot_be_read_is_told(tmp_path: Path, text: str, words: list[str]) -> None:
    told = refusal(tmp_path, text)
    assert told.startswith(f"{tmp_path}/tool.csv: ")
    assert "\n" not in told
    for word in words:
        assert word in told


ROWS_OF_TWO = "0;180;1234,5\n0,5;181,25;2\n"
#: Text, arguments of `read_table`, and what is told.
FORMS: dict[str, tuple[str | bytes, dict[str, Any], str]] = {
    "semicolons": (f"\ufefftime [ms];crank_angle [deg];tip_x [mm]\r\n{ROWS_OF_TWO};;\r\n", {}, "semicolons, decimal comma"),
    "tabs": ("Time (ms)\tcrank angle (deg)\tTip X (mm)\n0\t180\t1234.5\n0.5\t181.25\t2\n", {}, "tabulators"),
    "cp1252": (f"time [ms];crank_angle [\u00b0];tip_x [mm]\n{ROWS_OF_TWO}".encode("cp1252"), {}, "semicolons, decimal comma"),
    "UTF-16": (f"time [ms];crank_angle [\u00b0];tip_x [mm]\n{ROWS_OF_TWO}".encode("utf-16"), {}, "semicolons, decimal comma"),
    "Exudyn": (
        "#Exudyn version = 1.13.6; date=2026\n#sensor type = Body\n#time [ms],crank_angle [deg],tip_x [mm]\n0,180,1234.5\n0.5,181.25,2\n",
        {},
        "heading in a comment",
    ),
    "Dymola": ('"time [ms]","crank_angle [deg]","tip_x [mm]","world.g"\n0,180,1234.5,9.81\n0.5,181.25,2,9.81\n', {}, "ignored: world.g"),
    "units below": (f"time;crank_angle;tip_x\nms;(deg);[mm]\n{ROWS_OF_TWO}", {}, "semicolons, units in the second row, decimal comma"),
    "blanks": ("% MBDyn\n  time [ms]  crank_angle [deg]  tip_x [mm]\n  0 180 1234.5\n 0.5   181.25 2\n", {}, "blanks, 1 comment line"),
    "a title": ("Run 7, 2 s\ntime [ms],crank_angle [deg],tip_x [mm]\n0,180,1234.5\n0.5,181.25,2\n", {"skip": 1}, ""),
    "a declared separator": (
        f"time crank_angle;phi tip_x\n{ROWS_OF_TWO}",
        {"separator": ";", "columns": {"1": "time [ms]", "2": "crank_angle [deg]", "3": "tip_x [mm]"}, "skip": 1},
        "semicolons, decimal comma",
    ),
    "dates": (
        "time;crank_angle [deg];tip_x [mm]\n2026-03-01T23:59:59,9998;180;1234,5\n2026-03-02T00:00:00,0003;181,25;2\n",
        {},
        "semicolons, decimal comma, dates counted from the first row",
    ),
    "times of day, two rates": (
        "time [ms],crank_angle [deg],tip_x [mm]\n23:59:59.9999,180,1234.5\n00:00:00.00015,180.5,\n00:00:00.0004,181.25,2\n",
        {},
        "dates counted from the first row, 1 row with an empty cell left out, most for tip_x",
    ),
    "LabVIEW": (
        "LabVIEW\t\nTime\t10:12:33,45\nX_Value\tcrank_angle\ttip_x\tComment\nms\tdeg\tmm\t\n0\t180\t1234,5\t\n0,5\t181,25\t2\t\n",
        {"skip": 2, "columns": "X_Value = time"},
        "tabulators, units in the second row, decimal comma, ignored: Comment",
    ),
}


@pytest.mark.parametrize("form", FORMS)
def test_forms_of_other_programs_are_recognised_or_declared(tmp_path: Path, form: str) -> None:
    text, arguments, told = FORMS[form]
    (tmp_path / "tool.csv").write_bytes(text.encode() if isinstance(text, str) else text)
    table = read_table(tmp_path / "tool.csv", **arguments)
    assert table.told == (f"read as: {told}, 2 rows" if told else "")
    assert set(table.columns) == {"time", "crank_angle", "tip_x"}
    np.testing.assert_allclose(table.columns["time"], [0.0, 5e-4], rtol=1e-14)
    np.testing.assert_allclose(table.columns["crank_angle"], np.radians([180.0, 181.25]), rtol=1e-14)
    np.testing.assert_allclose(table.columns["tip_x"], [1.2345, 2e-3], rtol=1e-14)


WRITERS: dict[str, Callable[[pd.DataFrame, Path], Any]] = {
    ".parquet": lambda frame, path: frame.to_parquet(path),
    ".json": lambda frame, path: frame.to_json(path, double_precision=15),
    ".nc": lambda frame, path: frame.set_index(frame.columns[0]).to_xarray().to_netcdf(path, engine="h5netcdf"),
}


@pytest.mark.parametrize("ending", WRITERS)
def test_files_of_columns_are_read_as_text_is(tmp_path: Path, ending: str) -> None:
    frame = pd.DataFrame({"time [ms]": [0.0, 0.1], "phi": [-90.0, 1.0 / 3.0], "tip_x [mm]": [1234.5, math.pi]})
    WRITERS[ending](frame, path := tmp_path / f"tool{ending}")
    table = read_table(path, "phi = crank_angle [deg]")
    np.testing.assert_allclose(table["time"], [0.0, 1e-4], rtol=1e-14)
    np.testing.assert_allclose(table.columns["crank_angle"], np.radians([-90.0, 1.0 / 3.0]), rtol=1e-14)
    np.testing.assert_allclose(table.columns["tip_x"], [1.2345, 1e-3 * math.pi], rtol=1e-14)
    path.write_bytes(b"{1}")
    with pytest.raises(CaseError, match=rf"tool{ending}: is no {ending} of columns .*; write the columns of one rate"):
        read_table(path)


def test_a_dataset_is_read_with_the_units_of_its_attributes_and_has_one_dimension(tmp_path: Path) -> None:
    trajectory = qr.simulate(qr.case("rigid", duration=0.1), "reference", store=False)
    trajectory.to_xarray().to_netcdf(tmp_path / "own.nc", engine="h5netcdf")
    assert set(qr.difference(tmp_path / "own.nc", trajectory).values()) == {0.0}
    grid = trajectory.to_xarray().expand_dims({"crank.length": [0.1, 0.2]})
    grid.to_netcdf(tmp_path / "grid.nc", engine="h5netcdf")
    with pytest.raises(CaseError, match=r"its dimensions are .*crank\.length"):
        read_table(tmp_path / "grid.nc")


def test_the_decimal_sign_that_is_declared_is_used(tmp_path: Path) -> None:
    path = written(tmp_path, "time;tip_x\n0;3\n1;1,234\n")
    assert read_table(path, decimal=",").columns["tip_x"][1] == pytest.approx(1.234, rel=1e-15)
    with pytest.raises(CaseError, match='line 3, tip_x: "1,234" is no plain number'):
        read_table(path, decimal=".")


@pytest.mark.parametrize("path", [None, {"time": [0.0]}, 3, b"tool.csv"])
def test_what_is_no_path_is_told(path: Any) -> None:
    with pytest.raises(CaseError, match="is no path"):
        read_table(path)


FOREIGN = "t,phi,state,tip_x [mm]\n0,-90,on,1\n0.5,-450,off,2\n"
MAPPED = ("t = time [ms]", "phi = -2 * crank_angle [deg] + 270")


def test_columns_are_mapped_by_heading_with_sign_factor_offset_and_unit(tmp_path: Path) -> None:
    table = read_table(written(tmp_path, FOREIGN), MAPPED)
    np.testing.assert_allclose(table.columns["time"], [0.0, 5e-4], rtol=1e-14)
    np.testing.assert_allclose(table.columns["crank_angle"], np.radians([180.0, 360.0]), rtol=1e-14)
    np.testing.assert_allclose(table.columns["tip_x"], [1e-3, 2e-3], rtol=1e-14)
    assert table.told == "read as: ignored: state, 2 rows"


def test_a_mapping_beside_the_table_is_written_and_read(tmp_path: Path) -> None:
    path = written(tmp_path, FOREIGN)
    (tmp_path / "tool.toml").write_text(recorded.suggested_mapping(path, MAPPED))
    table = read_table(path)
    np.testing.assert_allclose(table.columns["crank_angle"], np.radians([180.0, 360.0]), rtol=1e-14)
    assert "columns by" in table.told
    assert "tool.toml" in table.told
    (tmp_path / "tool.toml").write_text('name = "x"\n[mechanism]\n[columns]\n')  # a case file beside it
    with pytest.raises(CaseError, match="no column"):
        read_table(path)


def test_a_table_without_headings_is_mapped_by_position(tmp_path: Path) -> None:
    path = written(tmp_path, "0 7 1234,5\n0,5 8 2\n")
    table = read_table(path, ["1 = time [ms]", "3 = tip_x [mm]"], separator="blank")
    np.testing.assert_allclose(table.columns["time"], [0.0, 5e-4], rtol=1e-14)
    np.testing.assert_allclose(table.columns["tip_x"], [1.2345, 2e-3], rtol=1e-14)
    with pytest.raises(CaseError, match="numbers where a heading is due; name the columns by position"):
        read_table(path, separator=" ")


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("phi", ["names no column", "crank.phi = crank_angle [deg]"]),
        ("phi = crank_angel [deg]", ["crank_angel", "did you mean crank_angle"]),
        ("phi = crank_angle [mm]", ["phi", "mm", "a length", "an angle"]),
        ("phi = 0 * crank_angle", ["factor 0"]),
        ("psi = crank_angle", ["psi", "no heading of this table", "t, phi, state"]),
    ],
)
def test_a_mapping_that_cannot_be_is_told(tmp_path: Path, text: str, words: list[str]) -> None:
    with pytest.raises(CaseError) as told:
        read_table(written(tmp_path, FOREIGN), ["t = time [ms]", text])
    for word in words:
        assert word in str(told.value)


def test_angles_that_wrap_are_made_continuous(tmp_path: Path) -> None:
    turned = np.arange(170.0, 900.0, 7.0)
    follower = 180.0 + 10.0 * np.sin(np.radians(turned))
    rows = [f"{k},{(a + 180) % 360 - 180},{(b + 180) % 360 - 180}" for k, (a, b) in enumerate(zip(turned, follower, strict=True))]
    table = read_table(written(tmp_path, "time,crank_angle [deg],follower_angle [deg]\n" + "\n".join(rows)))
    np.testing.assert_allclose(table.columns["crank_angle"], np.radians(turned), rtol=1e-12)
    np.testing.assert_allclose(table.columns["follower_angle"], np.radians(follower), rtol=1e-12)
    assert "crank_angle made continuous, follower_angle made continuous" in table.told


def test_files_that_are_none(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    with pytest.raises(CaseError, match=r"no such file; give the path of a recorded table"):
        read_table(str(tmp_path / "none.csv"))
    (tmp_path / "result.csv").write_bytes(b"time,tip_x\n\x00\x01\xff\x80\x07")
    with pytest.raises(CaseError, match="is no text, but a program's own binary form; export it as plain text"):
        read_table(str(tmp_path / "result.csv"))
    monkeypatch.setattr(recorded, "MOST_ROWS", 3)
    with pytest.raises(CaseError, match="has 5 rows; at most 3 are accepted"):
        read_table(written(tmp_path, "time,tip_x\n" + "\n".join(f"{row},0" for row in range(5))))


def test_a_suggested_mapping_keeps_the_unit_in_a_heading(tmp_path: Path) -> None:
    text = recorded.suggested_mapping(written(tmp_path, "time_s,crank_angle_deg,Beam strain_1 (%)\n0,180,1\n"))
    for line in ('"crank_angle_deg" = "-"  # perhaps crank_angle [deg]', "# perhaps time [s]", "# perhaps strain_1 [%]"):
        assert line in text


def test_a_heading_in_a_unit_of_another_quantity_is_foreign_and_no_misspelling(tmp_path: Path) -> None:
    text = "time,Linear Acceleration x (m/s^2),acc (m/s^2)\n0,1,2\n"
    table = read_table(written(tmp_path, text), ["acc = tip_acceleration"])
    assert "ignored: Linear Acceleration x (m/s^2)" in table.told
    np.testing.assert_array_equal(table.columns["tip_acceleration"], [2.0])


@pytest.mark.parametrize("comment", ["#Exudyn version = 1.13.6; Python3.11.2", "# orgin = x", "% source: a rig"])
def test_comments_of_other_programs_are_left_alone(tmp_path: Path, comment: str) -> None:
    table = read_table(written(tmp_path, f"{comment}\n# source = rig 7\ntime,tip_x\n0,1\n1,2\n"))
    assert dict(table.declared) == {"source": "rig 7"}
    assert table.columns["tip_x"].tolist() == [1.0, 2.0]


@pytest.mark.parametrize("empty", ["", "nan", " ", '""', "NaN"])
@pytest.mark.parametrize("separator", [",", ";"])
def test_a_row_with_an_empty_cell_is_left_out_and_told(tmp_path: Path, empty: str, separator: str) -> None:
    path, rows = tmp_path / "rig.csv", [[f"{0.001 * row:.3f}", f"{row}.5", f"{row}.25"] for row in range(3000)]
    rows[17][1], rows[2000][2] = empty, empty
    path.write_text("\n".join(separator.join(row) for row in [["time [s]", "tip_x [mm]", "strain_1"], *rows]) + "\n")
    table = read_table(path)
    assert "2 rows with an empty cell left out" in table.told
    assert len(table.columns["time"]) == 2998
    kept = [row for row in range(3000) if row not in (17, 2000)]
    assert table.columns["strain_1"] == pytest.approx(np.array(kept) + 0.25)
    assert table.columns["time"] == pytest.approx(1e-3 * np.array(kept), abs=1e-12)


@pytest.mark.parametrize(
    ("text", "offset", "drift"), [("+ 5 * time", 0.0, 5.0), ("+ 150 - 2.5 * time", 150.0, -2.5), ("- 1e1", -10.0, 0.0)]
)
def test_a_straight_line_is_taken_off(tmp_path: Path, text: str, offset: float, drift: float) -> None:
    """In the unit of the table, and for each second whatever the time's unit."""
    path, time = tmp_path / "rig.csv", np.arange(5.0, 15.0)
    right = np.sin(time)
    rows = np.column_stack([1e3 * time, 2.0 * right + offset + drift * time])
    path.write_text("time [ms],gauge\n" + "\n".join(",".join(map(repr, row)) for row in rows.tolist()))
    table = read_table(path, [f"gauge = 2 * strain_1 [microstrain] {text}"])
    assert table.columns["strain_1"] == pytest.approx(1e-6 * right, abs=1e-15)
