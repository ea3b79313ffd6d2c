"""`quickreturn calibrate` from outside."""

import json

import numpy as np
import pytest

from quickreturn.plugins.studies.tests.uncertainty.test_calibration import STIFFNESS, computed
from tests.quickreturn.conftest import Call


@pytest.fixture
def table(call: Call) -> str:
    """The name of a table of a little more than a turn, computed with the case's own values."""
    names = ("time", "crank_angle", "tip_deflection", "strain_2")
    rows = np.column_stack([computed("reference")[name][:401] for name in names])
    np.savetxt("table.csv", rows, delimiter=",", header=",".join(names), comments="")
    return "table.csv"


@pytest.mark.verify
def test_a_parameter_is_found_and_written(call: Call, table: str) -> None:
    arguments = ("--set", "follower.bending_stiffness=2500 lbf*in^2", "--output", "fitted.toml", "--json")
    answer = call("calibrate", "thesis-24", table, "--free", "follower.bending_stiffness", *arguments)
    assert answer.code == 0, answer.errors
    (found,) = json.loads(answer.output)["found"]
    # the table is of the engine's default accuracy, the search finer: five modes change the frequencies by some 1e-4
    assert abs(found["value"] / STIFFNESS - 1.0) < 5e-4
    shown = json.loads(call("show", "fitted.toml", "--json").output)
    assert shown["name"] == "thesis-24-fitted"


@pytest.mark.parametrize(
    ("arguments", "told"),
    [
        (("--free", "tip.mas"), "the nearest known one is tip.mass"),
        (("--free", "tip.mass", "--free", "tip.mass"), "give each key once"),
        (("--free", "tip.mass", "--output", "fitted.txt"), ".toml"),
        ((), "Missing option '--free'"),
    ],
)
def test_bad_input_gets_one_sentence(call: Call, table: str, arguments: tuple[str, ...], told: str) -> None:
    answer = call("calibrate", "thesis-24", table, *arguments)
    assert answer.code == 2
    assert told in answer.errors
    assert answer.errors.count("\n") == 1
