"""The folders of the pack: what they hold, what their bounds say, and values that are known from elsewhere."""

import csv
import json
import math
import re
import xml.etree.ElementTree as ET
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from quickreturn.pack.check import judged
from quickreturn.plugins.pack.problems import PROBLEMS, made, written

PACK = Path(__file__).resolve().parents[3] / "pack"
LARGEST = 900_000  # bytes
FEWEST_TIGHT, TIGHT = 9, 1e-4


def bounds_of(problem: str) -> dict[str, Any]:
    return json.loads((PACK / problem / "bounds.json").read_text("utf-8"))


def table_of(problem: str) -> dict[str, np.ndarray]:
    names, *rows = csv.reader((PACK / problem / "results.csv").open())
    return dict(zip(names, np.array(rows, dtype=float).T, strict=True))


def test_the_folders_are_the_problems_that_are_made() -> None:
    assert {each.parent.name for each in PACK.glob("*/bounds.json")} == set(PROBLEMS)
    assert len(PROBLEMS) >= 12
    assert sum(each.stat().st_size for each in PACK.rglob("*") if each.suffix != ".pyc" and each.is_file()) < LARGEST


@pytest.mark.parametrize("problem", PROBLEMS)
def test_a_folder_holds_values_table_bounds_and_picture(problem: str) -> None:
    assert {each.name for each in (PACK / problem).iterdir()} == {"problem.md", "picture.svg", "results.csv", "bounds.json"}
    told, table, text = bounds_of(problem), table_of(problem), (PACK / problem / "problem.md").read_text("utf-8")
    assert told["problem"] == problem
    assert told["version"] == (PACK / "VERSION").read_text("utf-8").strip()
    assert list(table) == ["time", *told["signals"]]
    assert [each["main"] for each in told["signals"].values()].count(True) == 1
    assert told["confirmed_by"]
    assert told["formulation"] not in told["confirmed_by"]
    for name, each in told["signals"].items():
        nearest = min(each["differences"].values())
        assert set(each["differences"]) <= set(told["confirmed_by"])
        # each number is told in two digits
        assert each["bound"] >= 0.95 * (max(2 * nearest, 2 * each["own"]) + each["interpolation"])
        assert 0 < each["horizon"] <= table["time"][-1]
        assert each["scale"] == pytest.approx(np.max(np.abs(table[name])), rel=1e-4)
        rms = math.sqrt(np.mean(table[name][table["time"] <= each["horizon"] * (1 + 1e-9)] ** 2))
        assert each["relative"] == pytest.approx(each["bound"] / rms, rel=0.05)
        assert f"| `{name}` | {each['unit']} |" in text
    ET.parse(PACK / problem / "picture.svg")


def test_enough_bounds_are_tight() -> None:
    mains = [each for problem in PROBLEMS for each in bounds_of(problem)["signals"].values() if each["main"]]
    assert sum(each["relative"] <= TIGHT for each in mains) >= FEWEST_TIGHT


def test_the_page_tells_the_main_bounds_and_leads_to_the_folders() -> None:
    page = (PACK / "README.md").read_text("utf-8")
    rows = re.findall(r"^\| \[(\S+)\]\((\S+)/problem.md\) \|.*\| `(\w+)` \| (\S+) \|$", page, re.MULTILINE)
    assert [row[0] for row in rows] == [row[1] for row in rows] == list(PROBLEMS)
    for problem, _, signal, bound in rows:
        assert bounds_of(problem)["signals"][signal]["main"]
        assert float(bound) == bounds_of(problem)["signals"][signal]["relative"]
    assert f"version {(PACK / 'VERSION').read_text('utf-8').strip()}" in page
    assert (PACK / "LICENSE").read_text("utf-8") == (PACK.parent / "LICENSE").read_text("utf-8")


def test_the_double_four_bar_ends_as_published() -> None:
    """IFToMM library: the converging submissions agree to 1e-6."""
    last = {name: column[-1] for name, column in table_of("double-four-bar").items()}
    found = [last[name] for name in ("tip_x", "tip_y", "tip_vx", "tip_vy")]
    np.testing.assert_allclose(found, [0.3284581, 0.9445185, 1.423051, -0.494869], atol=2e-6)


def test_the_strip_of_decay_settles_where_statics_says_and_as_fast_as_its_modes() -> None:
    """At F L^3 / 3 EI; each mode swings and decays by the square of its frequency. The third is gone when the fit begins."""
    table = table_of("decay")
    rest, omega = 0.005 * 0.5**3 / (3 * 0.42), np.array([1.875104069, 4.694091133]) ** 2 / 0.25 * math.sqrt(0.42 / 0.2)
    rate = (0.4 / 0.2 + 2e-4 * omega**2) / 2
    late = table["time"] > 0.5
    t, w = table["time"][late], table["tip_deflection"][late]
    swing = np.hstack([np.exp(-rate * t[:, None]) * turn(np.sqrt(omega**2 - rate**2) * t[:, None]) for turn in (np.cos, np.sin)])
    (level, *_), (left,), *_ = np.linalg.lstsq(np.column_stack([np.ones_like(t), swing]), w, rcond=None)
    assert level == pytest.approx(rest, rel=1e-4)
    assert math.sqrt(left / len(t)) < 1e-4 * rest


def test_the_bead_keeps_its_energy() -> None:
    table = table_of("bead")
    angle, speed, place = (table[name] for name in ("rod_angle", "rod_speed", "bead_place"))
    along = np.gradient(place, table["time"], edge_order=2)
    kinetic = 0.3 / 3 * speed**2 / 2 + 0.1 * (along**2 + (place * speed) ** 2) / 2
    potential = (0.3 * 0.5 + 0.1 * place) * 9.81 * np.sin(angle) + 20 * (place - 0.5) ** 2 / 2
    assert np.ptp(kinetic + potential) < 2e-3 * np.max(kinetic)  # by differences of the rows


@pytest.mark.verify
@pytest.mark.parametrize("problem", PROBLEMS)
def test_what_is_made_anew_is_within_and_has_the_bounds_of_the_pack(problem: str, tmp_path: Path) -> None:
    new = made(PROBLEMS[problem])
    written(tmp_path, problem, new)
    assert {each.status for each in judged(problem, tmp_path / problem / "results.csv")} == {"within"}
    for name, each in bounds_of(problem)["signals"].items():
        assert new[1]["signals"][name]["bound"] <= 1.2 * each["bound"], name
