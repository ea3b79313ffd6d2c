"""Leads from a table to the quantities that would explain it: tables of machines with one other value, with two, and with other physics."""

import re
from collections.abc import Mapping
from pathlib import Path

import numpy as np
import pytest

import quickreturn as qr
from quickreturn.cases.comparison.causes import QUANTITIES, Explained
from quickreturn.cases.files.recorded import RecordedTable, table_of
from quickreturn.cases.library import load_case
from quickreturn.engines.one_run import run_once
from quickreturn.engines.registry import engine
from quickreturn.engines.start import standard_start
from quickreturn.plugins.studies.uncertainty.parameters import Parameter
from quickreturn.plugins.studies.uncertainty.quantities import explanations
from quickreturn.reference_model.scene_values import changed

COLUMNS = ("time", "crank_angle", "follower_angle", "slider_position", "tip_deflection", "tip_acceleration", "strain_2")


def made(factors: Mapping[str, float], by: str = "reference", case: str = "thesis-24", noise: float = 0.0) -> RecordedTable:
    """A table of 0.6 s from the standard start, of the case with some values multiplied."""
    scene = load_case(case).mechanism
    values = {key: factor * Parameter.of_key(key, "test").of(scene) for key, factor in factors.items()}
    other, chosen, chance = changed(scene, values), engine(by), np.random.default_rng(1)
    run = run_once(chosen, other, standard_start(other), 0.6, 1e-3, chosen.settings_for(chosen.default_accuracy, other)).trajectory
    columns = {name: run[name] for name in COLUMNS}
    for name in COLUMNS[2:]:
        columns[name] = columns[name] + noise * np.std(columns[name]) * chance.standard_normal(len(columns[name]))
    return table_of(columns, "table", case)


def named(table: RecordedTable, case: str = "thesis-24") -> list[str]:
    """The words of the explanations by quantities that hold."""
    return [each.words for each in Explained(1.0, explanations(load_case(case), table)).holding]


def values(words: str) -> dict[str, float]:
    """Keys that are named -> their values over those of the case."""
    unit = r"(\S+) (?:\S+)"
    return {key: float(new) / float(old) for key, new, old in re.findall(rf"(\S+) of about {unit} in place of {unit}", words)}


#: Machines of which one quantity, or two, differ: their factors, who computes the table, and the noise of its columns.
WRONG: tuple[tuple[dict[str, float], str, float], ...] = (
    ({"follower.bending_stiffness": 1.05}, "reference", 0.01),
    ({"follower.bending_stiffness": 0.75}, "mujoco", 0.005),
    ({"follower.mass_per_length": 1.1}, "exudyn", 0.0),
    ({"follower.damping": 3.0}, "reference", 0.0),
    ({"follower.length": 1.02}, "mujoco", 0.0),
    ({"tip.mass": 1.2}, "exudyn", 0.005),
    ({"crank.length": 0.97}, "reference", 0.01),
    ({"crank.torque": 1.1}, "mujoco", 0.0),
    ({"mechanism.pivot_distance": 1.02}, "exudyn", 0.005),
    ({"base.inertia": 3.0}, "reference", 0.0),
    ({"follower.bending_stiffness": 0.8, "tip.mass": 1.2}, "reference", 0.005),
    ({"follower.bending_stiffness": 0.9, "crank.length": 1.02}, "mujoco", 0.0),
)


@pytest.mark.verify
@pytest.mark.parametrize(("factors", "by", "noise"), WRONG)
def test_what_was_planted_is_named(factors: dict[str, float], by: str, noise: float) -> None:
    """Other quantities that do the same may be named beside them; none is named alone that was not planted."""
    found = named(made(factors, by, noise=noise))
    print(factors, by, found, flush=True)
    assert any(values(words) == pytest.approx(factors, rel=0.1) for words in found)


@pytest.mark.verify
def test_other_physics_is_explained_by_no_quantity() -> None:
    """One cubic for the follower's shape, and gravity: no values of two quantities make up for them."""
    assert named(made({}, "thesis")) == []
    assert named(made({}, noise=0.02)) == []  # nothing differs
    scene = changed(load_case("thesis-24").mechanism, {"mechanism.gravity": (0.0, -9.81)})
    chosen = engine("reference")
    run = run_once(chosen, scene, standard_start(scene), 0.6, 1e-3, chosen.settings_for(1e-3, scene)).trajectory
    assert named(table_of({name: run[name] for name in COLUMNS}, "table")) == []


@pytest.mark.verify
def test_compare_leads_on_to_a_calibration(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("QUICKRETURN_STORE", str(tmp_path / "store"))
    softer = qr.case("thesis-24", duration=0.6).with_({"follower.bending_stiffness": "1600 lbf*in^2"})
    path = tmp_path / "softer.csv"
    qr.simulate(softer, "reference").frame.to_csv(path, index=False)
    compared = qr.compare("thesis-24", path, "reference", quiet=True)
    told = compared.explanations[QUANTITIES]
    assert told.startswith("follower.bending_stiffness of about 4.59 N*m^2 in place of 6.11 N*m^2 would explain it: ")
    assert f"`quickreturn calibrate thesis-24 {path} --free follower.bending_stiffness` fits that" in told
    assert told in repr(compared)


@pytest.mark.verify
@pytest.mark.parametrize("factor", [0.87, 0.94])
def test_a_softer_arm_is_found_in_a_steady_table(factor: float) -> None:
    """0.87 is too far for the phases of a steady table to agree: the search begins at several values."""
    scene, chosen = load_case("thesis-20").mechanism, engine("reference")
    softer = changed(scene, {"follower.bending_stiffness": factor * scene.follower.bending_stiffness})
    run = run_once(chosen, softer, standard_start(softer), 14.0, 2e-3, chosen.settings_for(1e-3, softer)).trajectory
    names = ("time", "crank_angle", "tip_acceleration", "strain_1", "strain_2", "strain_3")
    (words,) = named(table_of({name: run[name][run["time"] >= 12.0] for name in names}, "table"), "thesis-20")
    assert values(words) == pytest.approx({"follower.bending_stiffness": factor}, rel=0.01)
