"""The tables of a tool's force and of the drive: what is read, what is refused and how, and that nothing needs the file afterwards."""

import math
import pickle
import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import quickreturn as qr
from quickreturn.cases.files.case import document_of
from quickreturn.cases.files.errors import CaseError
from quickreturn.cases.files.written import as_toml
from quickreturn.cases.library import library_case, load_case
from quickreturn.cases.running.key import hash_of
from quickreturn.reference_model.mechanism import Mechanism, TorqueDrive
from quickreturn.reference_model.scene_values import changed
from quickreturn.reference_model.table import Table
from quickreturn.reports.other_tools import for_other_tools
from tests.cases.files.scene_texts import SCENE, parse_case

ROWS = "0, 1, 2\n90, 3, 4\n180, -5, 6\n270, 7, -8\n"
TABLE = "# origin = measured\ncrank_angle [deg], force_n1 [kN], force_n2 [N]\n" + ROWS
FORCE = SCENE[SCENE.index("force = [") : SCENE.index("[slider]")]
WITH_TABLE = SCENE.replace(FORCE, 'force_table = "cutting.csv"\n\n')


def loaded(folder: Path, table: str | None = TABLE, text: str = WITH_TABLE) -> Mechanism:
    (folder / "scene.toml").write_text(text)
    if table is not None:
        (folder / "cutting.csv").write_text(table)
    return load_case(str(folder / "scene.toml")).mechanism


def test_a_table_beside_the_case_file_arrives_in_si(tmp_path: Path) -> None:
    table = loaded(tmp_path).tip_body.force_table
    assert table == Table(table.names, table.points, ((1e3, 3e3, -5e3, 7e3), (2.0, 4.0, 6.0, -8.0)))
    assert table.points == pytest.approx((0.0, 0.5 * math.pi, math.pi, 1.5 * math.pi), abs=1e-15)
    assert (table.names, table.file) == (("crank_angle", "force_n1", "force_n2"), "cutting.csv")
    assert str(table) == "cutting.csv of 4 points: force_n1 -5000 to 7000 N, force_n2 -8 to 6 N"


def test_columns_may_stand_in_any_order_and_the_force_may_follow(tmp_path: Path) -> None:
    table = loaded(tmp_path, "force_normal [N],crank_angle [rad],force_along [N]\n1,0.5,2\n3,1,4\n5,2,6\n7,5,8\n").tip_body.force_table
    assert table == Table(table.names, (0.5, 1.0, 2.0, 5.0), ((2.0, 4.0, 6.0, 8.0), (1.0, 3.0, 5.0, 7.0)))
    assert table.names == ("crank_angle", "force_along", "force_normal")


def test_a_last_row_a_turn_later_is_the_first_one(tmp_path: Path) -> None:
    assert loaded(tmp_path, TABLE + "360, 1, 2\n") == loaded(tmp_path)


@pytest.mark.parametrize(
    ("table", "told"),
    [
        (None, r'scene.toml: tip.force_table: "cutting.csv" there is no such file; give a CSV file that begins with'),
        ("", "cutting.csv (tip.force_table): is empty"),
        (TABLE.replace("n2", "n3"), 'line 2: "force_n3 [N]" is no column of this table; write "crank_angle [deg], '),
        (TABLE.replace(" [kN]", ""), 'line 2: "force_n1" has no unit; write it in brackets, such as "force_n1 [N]"'),
        (TABLE.replace("-5", ""), "lacks a number in 1 of its rows"),
        (TABLE.replace("180", "80"), "line 5, crank_angle: 80 does not rise"),
        (TABLE.replace("270, 7, -8\n", ""), "(tip.force_table): has 3 points; at least 4 are needed"),
        (TABLE + "360, 1, 2.5\n", "line 7, force_n2: 2.5 N differs from 2 N a turn before (line 3): the table does not close;"),
        (TABLE + "400, 1, 2\n", "line 7, crank_angle: 400 deg lies 40 deg beyond a turn from the first row"),
    ],
)
def test_each_mistake_is_one_sentence_with_file_row_and_column(tmp_path: Path, table: str | None, told: str) -> None:
    with pytest.raises(CaseError) as refused:
        loaded(tmp_path, table)
    assert told in str(refused.value), str(refused.value)
    assert "\n" not in str(refused.value)


MOTOR = "crank_speed [rpm], crank_torque [N*m]\n0, 2\n60, 1.5\n120, 0\n"
TIMES = "time [ms]; crank_speed [rad/s]\n0; 4,5\n200; 9,5\n"


STARTS = SCENE.replace('initial_speed = "16.617773 rad/s"\n', "")


def driven(folder: Path, monkeypatch: pytest.MonkeyPatch, key: str, table: str) -> Mechanism:
    monkeypatch.chdir(folder)
    (folder / "drive.csv").write_text(table)
    return parse_case(STARTS, "scene.toml", {f"crank.{key}": "drive.csv"}).mechanism


def test_tables_drive_the_crank_and_survive_a_round_trip(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Each takes the place of another drive. A motor begins at the speed without torque, a prescribed motion at the speed of its table."""
    motor = driven(tmp_path, monkeypatch, "torque_table", MOTOR)
    assert motor.crank.drive.torque_table.values == ((2.0, 1.5, 0.0),)
    assert motor.crank.drive.initial_speed == pytest.approx(4.0 * math.pi, rel=1e-15)
    timed = driven(tmp_path, monkeypatch, "speed_table", TIMES)
    assert (timed.crank.drive.speed_table.points, timed.crank.drive.initial_speed) == ((0.0, 0.2), 4.5)
    for scene in (motor, timed):
        case = parse_case(SCENE, "scene").with_({}, name="copy")
        copied = parse_case(as_toml(document_of(replace(case, scene=scene, document=None))), "copy")
        assert copied.mechanism == scene
        assert isinstance(changed(scene, {"crank.torque": 1.0, "crank.damping": 0.5}).crank.drive, TorqueDrive)


@pytest.mark.parametrize(
    ("key", "table", "told"),
    [
        (
            "torque_table",
            MOTOR.replace("crank_torque", "torque"),
            'line 1: "torque [N*m]" is no column of this table; write "crank_speed [rpm], ',
        ),
        ("torque_table", MOTOR[: MOTOR.index("60")], "(crank.torque_table): has 1 points; at least 2 are needed"),
        ("torque_table", MOTOR.replace("N*m", "N"), 'line 1, crank_torque: "N" is a force (kg*m/s^2), but a torque is needed'),
        ("torque_table", MOTOR.replace("60", "0"), "line 3, crank_speed: 0 does not rise"),
        ("torque_table", MOTOR.replace("120, 0", "120, 3"), "crank.initial_speed: is missing, and no speed"),
        ("speed_table", TIMES.replace("9,5", "-9,5"), "line 3, crank_speed: -9.5 rad/s lets the crank stand still or turn back"),
        ("speed_table", "time [s]; crank_speed [rad/s]\n2026-12-01 00:00; 4,5\n2026-12-01 00:01; 9,5\n", "has dates in place of a time"),
        ("speed_table", TIMES.replace("time [ms]", "crank_angle [deg]"), "(crank.speed_table): has 2 points; at least 4 are needed"),
    ],
)
def test_each_mistake_in_a_table_of_the_drive_is_one_sentence(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, key: str, table: str, told: str
) -> None:
    with pytest.raises(CaseError) as refused:
        driven(tmp_path, monkeypatch, key, table)
    assert told in str(refused.value), str(refused.value)
    assert "\n" not in str(refused.value)


def test_a_speed_over_time_has_no_cycle(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    driven(tmp_path, monkeypatch, "speed_table", TIMES)
    (tmp_path / "scene.toml").write_text(SCENE)
    with pytest.raises(CaseError, match=r"crank.speed_table: .* prescribes a speed over time, which has no cycle; use simulate, or give"):
        qr.run(load_case("scene.toml", {"crank.speed_table": "drive.csv"}), "reference")


def test_a_table_and_another_force_are_both_named(tmp_path: Path) -> None:
    both = WITH_TABLE.replace("force_table =", 'force = ["1 N", "0 N"]\nforce_table =')
    with pytest.raises(CaseError, match=r"tip.force_table: .* conflicts with tip.force; give one of them"):
        loaded(tmp_path, text=both)


def test_nothing_needs_the_file_once_the_case_is_read(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    loaded(tmp_path)
    case = load_case(str(tmp_path / "scene.toml"))
    (tmp_path / "cutting.csv").unlink()
    monkeypatch.chdir("/")
    there = pickle.loads(pickle.dumps(case))
    assert there.mechanism_with({"tip.force_scale": 2.0}).tip.force_scale == 2.0
    assert there.mechanism_with({"tip.force_scale": 2.0}).tip.force_table == case.mechanism.tip_body.force_table
    for text in (case.to_toml(), as_toml(document_of(case)), there.with_({"crank.length": "3 in"}).to_toml()):
        assert parse_case(text, "copy").mechanism.tip_body.force_table == case.mechanism.tip_body.force_table
    assert "force_n1 [kN]" in case.to_toml()  # as it was written


def test_the_values_are_a_part_of_the_key_and_the_name_of_the_file_is_not(tmp_path: Path) -> None:
    scene = loaded(tmp_path)
    (tmp_path / "other.csv").write_text(TABLE)
    assert hash_of(scene) == hash_of(loaded(tmp_path, text=WITH_TABLE.replace("cutting", "other")))
    assert hash_of(scene) != hash_of(loaded(tmp_path, TABLE.replace("-8", "-9")))


def test_one_force_takes_the_place_of_another_that_is_set_from_outside(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    loaded(tmp_path)
    monkeypatch.chdir(tmp_path)
    tip = parse_case(SCENE, "scene.toml", {"tip.force_table": "cutting.csv"}).mechanism.tip_body
    assert tip.force_table is not None
    assert (tip.force, tip.force_from) == ((0.0, 0.0), 0.0)
    tip = load_case("scene.toml", {"tip.force_following": '["1 N", "2 N"]'}).mechanism.tip_body
    assert (tip.force_table, tip.force_following, tip.follows) == (None, (1.0, 2.0), True)
    tip = load_case("scene.toml", {"tip.force": '["1 N", "2 N"]'}).mechanism.tip_body
    assert (tip.force_table, tip.components, tip.follows) == (None, (1.0, 2.0), False)


def test_another_tool_is_told_the_table() -> None:
    text = for_other_tools(library_case("shaper-chips"), "shaper-chips")
    rows = np.array([[float(each) for each in row] for row in re.findall(r"^  (\S+), (\S+), (\S+)$", text, re.MULTILINE)])
    table = library_case("shaper-chips").mechanism.tip_body.force_table
    np.testing.assert_array_equal(rows[-24:], np.array([table.points, *table.values]).T)
    assert "Fritsch and Butland" in " ".join(text.split())
    assert "- tip.friction_force x tanh(|v| / tip.friction_speed) v / |v|" in " ".join(text.split())
