"""`quickreturn sweep` and `qr.sweep` from outside: files, datasets, and what is told of mistakes."""

import json
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
import xarray as xr

import quickreturn as qr
from tests.quickreturn.conftest import Call
from tests.quickreturn.input.answers import refused

SPEEDS = "crank.prescribed_speed = 80 rpm .. 120 rpm : 3"
USUAL = ("sweep", "thesis-24", "--vary", SPEEDS, "--measure", "peak.tip_acceleration", "--measure", "multiplier")


def test_a_grid_becomes_a_file_with_units(call: Call) -> None:
    answer = call(*USUAL, "--vary", "tip.mass = 0 g; 500 kg", "--output", "map.nc", "--json")
    assert answer.code == 0, answer.errors
    assert json.loads(answer.output)["points"] == 6
    with xr.open_dataset("map.nc", engine="h5netcdf") as found:
        assert dict(found.sizes) == {"crank.prescribed_speed": 3, "tip.mass": 2}
        assert found["crank.prescribed_speed"].attrs["units"] == "rad/s"
        assert found["crank.prescribed_speed"].values == pytest.approx(np.pi / 30.0 * np.array([80.0, 100.0, 120.0]))
        assert found["peak.tip_acceleration"].attrs["units"] == "m/s^2"
        light = found.sel({"tip.mass": 0.0})
        assert set(light["status"].values.flat) == {"settled"}
        assert np.all(light["peak.tip_acceleration.error"] < 0.02 * light["peak.tip_acceleration"])
    again = qr.sweep(
        qr.case("thesis-24", {"crank.prescribed_speed": "100 rpm"}),
        {"tip.mass": [0.0]},
        ["peak.tip_acceleration"],
        claims=False,
        quiet=True,
    )
    assert float(again["peak.tip_acceleration"][0]) == pytest.approx(float(light["peak.tip_acceleration"][1]), rel=1e-3)


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


BOTH = ("--engine", "reference", "--engine", "mujoco")


@pytest.mark.parametrize(
    ("more", "words"),
    [
        (("--output", "map.nc", "--measure", "peak.tip_aceleration"), ("--measure", "peak.tip_acceleration")),
        (("--vary", "crank.prescribed_sped = 1 rpm; 2 rpm"), ("--vary", "crank.prescribed_speed")),  # before the missing --output
        ((), ("Missing option '--output'",)),
        (("--output", "map.nc", *BOTH, "--set", "engine.modes=3"), ("--set", "one engine")),
        (("--output", "map.xlsx"), ("--output", "map.xlsx", ".nc")),
    ],
    ids=str,
)
def test_mistakes(call: Call, more: tuple[str, ...], words: tuple[str, ...]) -> None:
    refused(call("sweep", "thesis-24", "--vary", SPEEDS, *more), *words)
    assert not Path("map.nc").exists()
