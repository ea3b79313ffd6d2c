"""`quickreturn sweep` and `qr.sweep` from outside: files, datasets, and what is told of mistakes."""

import json
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
import xarray as xr

import quickreturn as qr
from tests.quickreturn.conftest import Call

SPEEDS = "crank.prescribed_speed = 80 rpm .. 120 rpm : 3"
USUAL = ("sweep", "thesis-24", "--vary", SPEEDS, "--measure", "peak.tip_acceleration", "--measure", "multiplier")


def test_a_grid_becomes_a_file_with_units(call: Call) -> None:
    answer = call(*USUAL, "--vary", "tip.mass = 0 g; 500 kg", "--path", "both", "--output", "map.nc", "--json")
    assert answer.code == 0, answer.errors
    assert json.loads(answer.output)["points"] == 12
    with xr.open_dataset("map.nc", engine="h5netcdf") as found:
        assert dict(found.sizes) == {"path": 2, "crank.prescribed_speed": 3, "tip.mass": 2}
        assert found["crank.prescribed_speed"].attrs["units"] == "rad/s"
        assert found["crank.prescribed_speed"].values == pytest.approx(np.pi / 30.0 * np.array([80.0, 100.0, 120.0]))
        assert found["peak.tip_acceleration"].attrs["units"] == "m/s^2"
        light = found.sel({"tip.mass": 0.0})
        assert set(light["status"].values.flat) == {"settled"}
        assert np.all(light["peak.tip_acceleration.error"] < 0.02 * light["peak.tip_acceleration"])
        assert not light["two_motions"].any()
        case = qr.case_at(found, {"crank.prescribed_speed": 10.4, "tip.mass": 0.01})
    again = qr.sweep(case, {"tip.mass": [0.0]}, ["peak.tip_acceleration"], claims=False, quiet=True)
    assert float(again["peak.tip_acceleration"][0]) == pytest.approx(float(light["peak.tip_acceleration"][0, 1]), rel=1e-3)


@pytest.mark.parametrize("ending", ["csv", "parquet"])
def test_tables_have_a_row_for_each_point(call: Call, ending: str) -> None:
    answer = call(*USUAL, "--no-claims", "--output", f"map.{ending}")
    assert answer.code == 0, answer.errors
    assert "3 points: 3 settled" in answer.output
    table = pd.read_csv("map.csv") if ending == "csv" else pd.read_parquet("map.parquet")
    assert list(table.columns) == [
        "crank.prescribed_speed [rad/s]",
        "peak.tip_acceleration [m/s^2]",
        "multiplier [1]",
        "status",
        "sentence",
    ]
    assert len(table) == 3
    assert np.all(np.diff(table["peak.tip_acceleration [m/s^2]"]) > 0.0)


@pytest.mark.parametrize(
    ("arguments", "told"),
    [
        (("--vary", SPEEDS, "--measure", "peak.tip_aceleration"), "peak.tip_acceleration"),
        (("--vary", "crank.prescribed_sped = 1 rpm; 2 rpm"), "crank.prescribed_speed"),
        (("--vary", SPEEDS, "--path", "sideways"), "up, down, both"),
        (("--vary", SPEEDS, "--engine", "reference", "--engine", "mujoco", "--set", "engine.modes=3"), "one engine"),
    ],
)
def test_a_mistake_costs_one_sentence(call: Call, arguments: tuple[str, ...], told: str) -> None:
    answer = call("sweep", "thesis-24", *arguments, "--output", "map.nc")
    assert answer.code == 2
    assert told in answer.errors
    assert "Traceback" not in answer.errors
    assert not Path("map.nc").exists()


def test_a_wrong_key_is_told_before_a_missing_output(call: Call) -> None:
    answer = call("sweep", "thesis-24", "--vary", "crank.prescribed_sped = 1 rpm; 2 rpm")
    assert "crank.prescribed_speed" in answer.errors
    answer = call("sweep", "thesis-24", "--vary", SPEEDS)
    assert (answer.code, "Missing option '--output'" in answer.errors) == (2, True)


def test_a_file_of_another_kind_is_refused(call: Call) -> None:
    answer = call(*USUAL, "--output", "map.xlsx")
    assert answer.code == 2
    assert ".nc" in answer.errors


def test_help_lists_the_measures(call: Call) -> None:
    answer = call("sweep", "--help")
    assert "peak.COLUMN" in answer.output
    assert "pre.frequency" in answer.output
    assert len(qr.measures()) > 150


def test_where_nothing_can_be_the_code_says_so(call: Call) -> None:
    answer = call("sweep", "thesis-24", "--vary", "crank.length = 20 in; 21 in", "--output", "map.csv")
    assert answer.code == 3
    assert "crank.length" in answer.errors
    assert set(pd.read_csv("map.csv")["status"]) == {"loop cannot close"}


def test_a_picture_goes_beside_the_table(call: Call) -> None:
    answer = call(*USUAL, "--no-claims", "--output", "map.csv", "--plot", "map.svg")
    assert answer.code == 0, answer.errors
    assert "<svg" in Path("map.svg").read_text()


@pytest.mark.parametrize(
    ("more", "told"),
    [
        (("--vary", "tip.mass = 0 g; 1 g", "--vary", "engine = reference; mujoco", "--plot", "map.svg"), "at most one more"),
        (("--plot", "map.txt"), ".svg"),
    ],
)
def test_what_has_no_picture_is_refused_before_anything_runs(call: Call, more: tuple[str, ...], told: str) -> None:
    answer = call(*USUAL, *more, "--output", "map.csv")
    assert answer.code == 2
    assert told in answer.errors
    assert not Path("map.csv").exists()
