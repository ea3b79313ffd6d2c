"""Relative differences of trajectories: what they are of known signals, and laws that hold for all."""

import json
import math
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from hypothesis import given, settings
from hypothesis import strategies as some

import quickreturn as qr
from tests.quickreturn.conftest import Call

TIME = np.linspace(0.0, 1.0, 101)
SIGNALS = some.lists(some.floats(-1e3, 1e3), min_size=101, max_size=101).filter(lambda values: any(abs(each) > 1e-3 for each in values))


def test_known_signals() -> None:
    """A sine of another amplitude, and one that is a quarter period late: RMS differences in closed form."""
    theirs = {"time": TIME, "tip_x": np.sin(20.0 * np.pi * TIME), "strain_1": np.sin(20.0 * np.pi * TIME)}
    ours = {"time [ms]": 1e3 * TIME, "tip_x [mm]": 1.1e3 * theirs["tip_x"], "strain_1 [microstrain]": -1e6 * np.cos(20.0 * np.pi * TIME)}
    found = qr.difference(ours, theirs)
    assert list(found) == ["tip_x", "strain_1"]
    assert found["tip_x"] == pytest.approx(0.1, rel=1e-12)
    assert found["strain_1"] == pytest.approx(math.sqrt(2.0), rel=0.01)  # the last row counts a point of the period twice
    assert found.absolute["tip_x"] == pytest.approx(0.1 * math.sqrt(0.5), rel=0.01)
    assert (found.rows, found.step) == (101, pytest.approx(0.01))
    assert "101 rows" in repr(found)
    assert "strain_1" in repr(found)


@settings(max_examples=30, deadline=None)
@given(SIGNALS, SIGNALS)
def test_it_is_zero_for_itself_and_does_not_depend_on_units(signal: list[float], other: list[float]) -> None:
    ours, theirs = ({"time": TIME, "tip_x": np.array(each)} for each in (signal, other))
    in_inches = [{"time [ms]": 1e3 * TIME, "tip_x [in]": table["tip_x"] / 0.0254} for table in (ours, theirs)]
    assert qr.difference(ours, ours)["tip_x"] == 0.0
    assert qr.difference(*in_inches)["tip_x"] == pytest.approx(qr.difference(ours, theirs)["tip_x"], rel=1e-9)
    # the size of the difference does not depend on which is which
    assert qr.difference(ours, theirs).absolute["tip_x"] == qr.difference(theirs, ours).absolute["tip_x"]


@pytest.mark.parametrize(("every", "begin", "end"), [(2, 0, 101), (5, 0, 101), (1, 20, 61), (2, 20, 101)])
def test_a_grid_within_the_other_is_held_against_the_same_rows_either_way(every: int, begin: int, end: int) -> None:
    whole, part = {"time": TIME, "tip_x": np.exp(TIME)}, slice(begin, end, every)
    some_rows = {"time": np.round(TIME[part], 5), "tip_x": 1.02 * np.exp(TIME[part])}
    assert qr.difference(some_rows, whole)["tip_x"] == pytest.approx(0.02, rel=1e-12)
    assert qr.difference(whole, some_rows)["tip_x"] == pytest.approx(0.02 / 1.02, rel=1e-12)
    assert qr.difference(whole, some_rows).rows == qr.difference(some_rows, whole).rows == len(some_rows["time"])


def test_a_column_that_is_zero() -> None:
    zero, one = ({"time": TIME, "tip_y": value + 0.0 * TIME} for value in (0.0, 1.0))
    assert qr.difference(zero, zero)["tip_y"] == 0.0
    assert qr.difference(one, zero)["tip_y"] == math.inf


def test_rounding_is_no_difference() -> None:
    """Two columns that are zero but for rounding, and a gap, which is relative to the slider's distance from the pivot."""
    ours = {"time": TIME, "strain_1": 1e-17 + 0.0 * TIME, "slider_position": 0.5 + 0.0 * TIME, "constraint_gap": 1e-10 + 0.0 * TIME}
    theirs = ours | {"strain_1": 3e-17 + 0.0 * TIME, "constraint_gap": 1e-16 + 0.0 * TIME}
    found = qr.difference(ours, theirs)
    assert found["strain_1"] == 0.0
    assert found["constraint_gap"] == pytest.approx(2e-10, rel=1e-4)
    assert found.absolute["constraint_gap"] == pytest.approx(1e-10, rel=1e-4)


def test_a_column_has_one_scale_in_differences_and_estimates() -> None:
    """Normal forces are relative to the largest of them, moments at the ends to the largest along the arm."""
    forces = {"axial_base": 10.0, "axial_slider": 4.0, "axial_tip": 0.5, "moment_05": 2.0, "moment_tip": 1e-3}
    theirs = {"time": TIME} | {name: force + 0.0 * TIME for name, force in forces.items()}
    ours = theirs | {name: theirs[name] + 0.01 for name in forces}
    assert dict(qr.difference(ours, theirs)) == {
        "axial_base": pytest.approx(1e-3), "axial_slider": pytest.approx(1e-3), "axial_tip": pytest.approx(1e-3),
        "moment_05": pytest.approx(5e-3), "moment_tip": pytest.approx(5e-3),
    }  # fmt: skip


@pytest.mark.parametrize(
    ("ours", "words"),
    [
        ({"time": TIME + 0.003, "tip_x": TIME}, ["time", "0.003 s", "the other has none", "output step"]),
        ({"time": TIME + 5.0, "tip_x": TIME}, ["fewer than two rows", "from 5 to 6 s"]),
        ({"time": TIME, "tip_y": TIME}, ["no column in common", "tip_y", "tip_x"]),
        ({"time": TIME, "tipx": TIME}, ["ours", "tipx", "tip_x"]),
        ({"time": TIME, "tip_x": TIME[1:]}, ["ours", "tip_x", "(100,)"]),
        ({"time": TIME[::-1], "tip_x": TIME}, ["ours", "row 1, time", "does not rise"]),
        (5, ["ours", "int is no table", "DataFrame"]),
        ("none.csv", ["none.csv", "no such file"]),
    ],
)
def test_what_cannot_be_compared_is_told_in_a_sentence(ours: object, words: list[str]) -> None:
    with pytest.raises(qr.CaseError) as told:
        qr.difference(ours, {"time": TIME, "tip_x": TIME})
    assert "\n" not in str(told.value)
    for word in words:
        assert word in str(told.value)


def test_files_frames_and_solutions_alike(tmp_path: Path) -> None:
    solution = qr.simulate(qr.case("rigid", duration=0.1), "reference", store=False)
    frame = solution.frame
    frame.to_csv(tmp_path / "table.csv", index=False)
    off = frame.assign(tip_x=frame["tip_x"] + 1e-3)
    found = qr.difference(off, solution)
    assert found.absolute["tip_x"] == pytest.approx(1e-3, rel=1e-9)
    assert found["tip_y"] == 0.0
    same = qr.difference(tmp_path / "table.csv", pd.DataFrame({"time [ms]": 1e3 * frame["time"], "tip_x [mm]": 1e3 * frame["tip_x"]}))
    assert dict(same) == {"tip_x": pytest.approx(0.0, abs=1e-12)}


def test_two_files_are_compared_by_the_command(call: Call) -> None:
    frame = pd.DataFrame({"time": TIME, "tip_x [mm]": np.exp(TIME)})
    frame.to_csv("old.csv", index=False)
    frame.assign(**{"tip_x [mm]": 1.02 * np.exp(TIME)}).to_parquet("new.parquet")
    answer = call("compare", "new.parquet", "old.csv", "--json")
    assert answer.code == 0
    assert json.loads(answer.output)["relative"] == {"tip_x": pytest.approx(0.02, rel=1e-12)}
    assert "101 rows, 0.01 s apart" in call("compare", "new.parquet", "old.csv").output
    days = (pd.Timestamp("2026-05-04") + pd.to_timedelta(TIME + 86_400.0 * day, "s") for day in (0, 1))
    old, late = (pd.DataFrame({"time": day, "tip_x": TIME}) for day in days)
    old.to_csv("dates.csv", index=False)
    old[50:].to_parquet("later.parquet")
    assert qr.difference("later.parquet", "dates.csv") == {"tip_x": 0.0}
    late.to_csv("other_day.csv", index=False)
    with pytest.raises(qr.CaseError, match="from 86400 to 86401 s"):
        qr.difference("other_day.csv", "dates.csv")
    for files, told in ((["old.csv"] * 3, "3 files"), (["old.csv", "old.csv", "--engine", "reference"], "--engine")):
        answer = call("compare", *files)
        assert answer.code == 2
        assert f"{told}: without a CASE two files are compared" in answer.errors
