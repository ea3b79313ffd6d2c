"""A wrong column of a table is told as what it is: every usual mistake, and generated ones, made here by formulas of their own.

The table is computed with other settings than the engine's run, so that it differs from it by 1e-3 without any mistake.
"""

import math
import random
import re
from collections.abc import Callable
from types import SimpleNamespace

import numpy as np
import pytest
from numpy.typing import NDArray

from quickreturn.cases.case_file import load_case
from quickreturn.cases.measures.steady_state import on_common_grid
from quickreturn.cases.mistakes.diagnosis import Finding, diagnose
from quickreturn.cases.recorded import table_of
from quickreturn.cases.runs.column_differences import LEAST_DIFFERENCE, UNEXPLAINED_COLUMNS, causes
from quickreturn.cases.runs.marching import channels_of
from quickreturn.cases.runs.recorded import recorded_run
from quickreturn.cases.runs.request import Run, RunRequest
from quickreturn.cases.runs.steady_state import steady_state
from quickreturn.engines.accurate import simulate
from quickreturn.engines.registry import engine
from quickreturn.engines.relative import rms
from quickreturn.engines.start import standard_start

Array = NDArray[np.float64]
Columns = dict[str, Array]
CASE = load_case("thesis-24")
D, L, THICKNESS = 18 * 0.0254, 25 * 0.0254, 0.125 * 0.0254
POUND, G = 4.4482216152605, 9.80665


@pytest.fixture(scope="module")
def table() -> Columns:
    """The columns of the table, of two seconds from the standard start."""
    scene = CASE.mechanism
    found = simulate(engine("reference"), scene, standard_start(scene), 2.0, 1e-3, {"modes": "6"}, estimate=False)
    return dict(found.trajectory.columns)


@pytest.fixture(scope="module")
def reference() -> Run:
    return steady_state(RunRequest(mechanism=CASE.mechanism, duration=1.95, engine="reference", turn=5))


@pytest.fixture(scope="module")
def grids(table: Columns, reference: Run) -> tuple[Columns, Columns]:
    """Columns of the table and of the engine at the same crank angles of the fifth turn."""
    run = recorded_run(table_of(table), CASE)
    mine, right = (on_common_grid(channels_of(each.cycle, each.cycle.keys())) for each in (run, reference))
    return mine, right


def finding(grids: tuple[Columns, Columns], column: str, found: Array) -> Finding | None:
    right = grids[1]
    return diagnose(column, found, right[column], LEAST_DIFFERENCE * max(rms(right[column]), rms(found)), right, CASE.mechanism)


def rate(time: Array, values: Array) -> Array:
    return np.asarray(np.gradient(values, time, edge_order=2))


def slider(t: SimpleNamespace) -> tuple[Array, Array]:
    """The crank's tip from P along n1 and n2; the crank is 4 in long."""
    return 4 * 0.0254 * np.cos(t.crank_angle) - D, 4 * 0.0254 * np.sin(t.crank_angle)


def accelerations(t: SimpleNamespace) -> tuple[Array, Array]:
    """Of the tip, along n1 and n2."""
    return rate(t.time, rate(t.time, t.tip_x)), rate(t.time, rate(t.time, t.tip_y))


Form = tuple[str, Callable[[SimpleNamespace], Array], str]
#: Column, what stands in it, and the words that name that.
FORMS: tuple[Form, ...] = (
    ("strain_2", lambda t: -t.strain_2, "has the wrong sign"),
    ("strain_2", lambda t: np.abs(t.strain_2), "is a size without sign"),
    ("strain_2", lambda t: 100 * t.strain_2, "is in percent, not in parts of one"),
    ("strain_2", lambda t: -1e6 * t.strain_2, "is in microstrain, not in parts of one, and has the wrong sign"),
    ("strain_2", lambda t: 0.01 * t.strain_2, "is converted from percent though it comes in 1"),
    ("strain_2", lambda t: 1e-6 * t.strain_2, "is converted from microstrain though it comes in 1"),
    ("strain_2", lambda t: 2.0 * t.strain_2, "is twice what it should be"),
    ("strain_2", lambda t: 0.5 * t.strain_2, "is half what it should be"),
    ("strain_2", lambda t: 2.0 / THICKNESS * t.strain_2, "is the curvature, not the surface strain"),
    ("strain_2", lambda t: -2.0 / THICKNESS * t.strain_2, "is minus the curvature, not the surface strain"),
    ("strain_1", lambda t: t.strain_3, "holds strain_3"),
    ("strain_1", lambda t: -t.strain_3, "holds minus strain_3"),
    ("strain_1", lambda t: t.tip_deflection, "holds tip_deflection"),
    ("strain_2", lambda t: 0.0 * t.strain_2, "is zero in every row"),
    ("strain_2", lambda t: 0.0 * t.strain_2 + 2e-4, "is 0.0002 in every row"),
    ("strain_2", lambda t: 0.1 * t.strain_2, "is off by a plain factor of 0.1"),
    ("strain_2", lambda t: t.strain_2 + 1e-4, "is 0.0001 too large throughout"),
    ("strain_2", lambda t: rate(t.time, t.strain_2), "is the rate of strain_2"),
    ("slider_force", lambda t: 1e-3 * t.slider_force, "is in kilonewtons, not in N"),
    ("slider_force", lambda t: -1e-3 * t.slider_force, "is in kilonewtons, not in N, and has the wrong sign"),
    ("slider_force", lambda t: 1e3 * t.slider_force, "is in millinewtons, not in N"),
    ("slider_force", lambda t: t.slider_force / POUND, "is in pounds, not in N"),
    ("slider_force", lambda t: POUND * t.slider_force, "is converted from pounds though it comes in N"),
    ("slider_force", lambda t: 0.3 * t.slider_force, "is off by a plain factor of 0.3"),
    ("slider_force", lambda t: 4.0 * t.slider_force, "is off by a plain factor of 4"),
    ("slider_force", lambda t: -4.0 * t.slider_force, "is off by a plain factor of -4"),
    ("crank_speed", lambda t: 30.0 / np.pi * t.crank_speed, "is in rpm, not in rad/s"),
    ("crank_speed", lambda t: t.crank_speed / (2.0 * np.pi), "is in turns per second (Hz), not in rad/s"),
    ("crank_speed", lambda t: np.pi / 180.0 * t.crank_speed, "is converted from degrees per second though it comes in rad/s"),
    ("follower_angle", lambda t: np.degrees(t.follower_angle), "is in degrees, not in rad"),
    ("follower_angle", lambda t: (t.follower_angle + np.pi) % (2.0 * np.pi) - np.pi, "is wrapped to -180 to 180 degrees"),
    ("follower_angle", lambda t: t.follower_angle - np.pi, "is counted from -n1, half a turn off"),
    ("follower_angle", lambda t: t.follower_angle - 2.0 * np.pi, "is a turn too small"),
    ("follower_angle", lambda t: t.follower_angle + 2.0 * np.pi, "is a turn too large"),
    ("slider_position", lambda t: L - t.slider_position, "is counted from the tip"),
    ("slider_position", lambda t: t.slider_position - t.slider_position[0], "is counted from its place at the start"),
    ("slider_position", lambda t: rate(t.time, t.slider_position), "is the rate of slider_position"),
    ("tip_x", lambda t: t.tip_x - D, "is counted from P, not from O"),
    ("tip_y", lambda t: 1e3 * t.tip_y, "is in millimetres, not in m"),
    ("tip_y", lambda t: t.tip_y / 0.0254, "is in inches, not in m"),
    ("tip_deflection", lambda t: t.tip_y - np.sin(t.follower_angle) * L, "is measured along n2, not along b2"),
    (
        "tip_deflection",
        lambda t: (slider(t)[0] * t.tip_y - slider(t)[1] * (t.tip_x - D)) / np.hypot(*slider(t)),
        "is measured from the line",
    ),
    ("tip_acceleration", lambda t: t.tip_acceleration / G, "is in g, not in m/s^2"),
    ("tip_acceleration", lambda t: accelerations(t)[1], "is along n2"),
    ("tip_acceleration", lambda t: np.hypot(*accelerations(t)), "is the size of the vector, without sign"),
    ("tip_acceleration", lambda t: rate(t.time, rate(t.time, t.tip_deflection)), "is relative to the base frame"),
    ("tip_acceleration", lambda t: rate(t.time, t.tip_deflection), "is the rate of tip_deflection"),
    (
        "tip_acceleration",
        lambda t: np.cos(t.follower_angle) * rate(t.time, t.tip_y) - np.sin(t.follower_angle) * rate(t.time, t.tip_x),
        "is the velocity of the tip along the follower's normal",
    ),
    ("pivot_force_y", lambda t: t.pivot_force_y + np.cos(t.follower_angle) * t.slider_force, "lacks the slider's part"),
    ("pivot_force_x", lambda t: t.pivot_force_y, "holds pivot_force_y"),
    ("strain_energy", lambda t: t.kinetic_energy + t.strain_energy, "contains kinetic_energy besides"),
    ("kinetic_energy", lambda t: 1e3 * t.kinetic_energy, "is in millijoules, not in J"),
)


@pytest.mark.parametrize(("column", "form", "words"), FORMS, ids=[f"{column} {words}" for column, _, words in FORMS])
def test_every_usual_mistake_is_named(
    grids: tuple[Columns, Columns], column: str, form: Callable[[SimpleNamespace], Array], words: str
) -> None:
    told = finding(grids, column, form(SimpleNamespace(**grids[0])))
    assert told is not None
    assert told.explained
    assert words in told.cause


NAMES = (
    "crank_speed",
    "slider_position",
    "tip_x",
    "tip_y",
    "tip_deflection",
    "tip_acceleration",
    "strain_1",
    "strain_2",
    "strain_3",
    "slider_force",
)


def drawn(chance: random.Random, t: Columns) -> tuple[str, Array, str]:
    """A column, what stands in it, and a pattern of the words that name that; "" if it is no single mistake."""
    column, kind = chance.choice(NAMES[4:]), chance.choice(("factor", "offset", "both", "rate", "other", "size", "constant"))
    factor = chance.choice((-1.0, 1.0)) * math.exp(chance.uniform(-9.0, 9.0))
    right, size = t[column], rms(t[column])
    if kind == "factor":
        return column, factor * right, rf"plain factor of {number(factor)}\b"
    if kind == "offset":
        offset = chance.choice((-1.0, 1.0)) * size * math.exp(chance.uniform(-1.0, 5.0))
        return column, right + offset, rf"is {number(abs(offset))}.* too {'large' if offset > 0 else 'small'} throughout"
    if kind == "both":
        return column, factor * right + factor * size * chance.uniform(1.0, 5.0), ""
    if kind == "size":
        return column, abs(factor) * np.abs(right), ""
    if kind == "constant":
        return column, np.full_like(right, factor), rf"is {number(factor)}.* in every row"
    other = chance.choice([name for name in NAMES if name != column])
    values = rate(t["time"], t[other]) if kind == "rate" else t[other]
    return column, factor * values, ""


def number(value: float) -> str:
    """A pattern for a number that is right to two digits; the table differs from the engine by a part in a thousand."""
    lead, _, exponent = f"{value:.3e}".partition("e")
    near = {f"{float(f'{float(lead) + k * 1e-3:.3f}e{exponent}'):.4g}" for k in range(-40, 41)}
    return f"(?:{'|'.join(map(re.escape, near))})"


@pytest.mark.parametrize("seed", range(80))
def test_generated_mistakes_are_named_or_told_as_a_factor(grids: tuple[Columns, Columns], seed: int) -> None:
    """No unit is named that nobody used: a factor drawn at random is that of a unit with a chance of 1 in 30."""
    column, found, pattern = drawn(random.Random(seed), grids[0])
    told = finding(grids, column, found)
    assert told is not None
    if pattern or told.explained:  # other columns, and their rates, may look alike
        assert re.search(pattern or "plain factor|is the rate of|holds", told.cause), f"{pattern}: {told.cause}"


@pytest.mark.parametrize("seed", range(20))
def test_nonsense_gets_no_cause(grids: tuple[Columns, Columns], seed: int) -> None:
    """A sum of three sines of other frequencies, of any size."""
    chance, mine = random.Random(seed), grids[0]
    size, time = math.exp(chance.uniform(-15.0, 5.0)), mine["time"] - mine["time"][0]
    found = size * sum(np.sin(chance.uniform(7.0, 90.0) * time + chance.uniform(0.0, 6.0)) for _ in range(3))
    column = chance.choice(NAMES)
    told = finding(grids, column, np.asarray(found))
    assert told is not None
    assert not told.explained, told.cause


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"strain_2": 0.1}, "strain_2 is off by a plain factor of 0.1;"),
        ({"slider_force": 1e-3}, "slider_force is in kilonewtons, not in N;"),
        ({"slider_force": 0.3}, "slider_force is off by a plain factor of 0.3;"),
        ({"strain_2": 0.0}, "strain_2 is zero in every row;"),
    ],
)
def test_a_small_column_of_a_table_is_told_as_that(table: Columns, reference: Run, changes: dict[str, float], words: str) -> None:
    names = ("time", "crank_angle", "tip_deflection", "tip_acceleration", "strain_2", "slider_force")
    told = causes(recorded_run(table_of({name: changes.get(name, 1.0) * table[name] for name in names}), CASE), reference, CASE).told(
        CASE.name
    )
    (sentence,) = told.values()
    assert sentence.startswith(words)


def test_a_column_of_nonsense_is_told_without_a_cause(table: Columns, reference: Run) -> None:
    nonsense = {name: table[name] for name in ("time", "crank_angle", "tip_deflection")} | {
        "strain_2": 1e-3 * np.sin(41.0 * table["time"] ** 2)
    }
    told = causes(recorded_run(table_of(nonsense), CASE), reference, CASE).told(CASE.name)
    assert set(told) == {UNEXPLAINED_COLUMNS}
    assert re.match(r"none of these explains the difference of strain_2 \(off by [0-9.]+ (times its size|%)\): ", told[UNEXPLAINED_COLUMNS])


@pytest.mark.parametrize("size", [0.1, *(pytest.param(size, marks=pytest.mark.verify) for size in (0.03, 0.4))])
def test_noise_is_told_by_its_size(table: Columns, reference: Run, size: float) -> None:
    random = np.random.default_rng(3)
    noisy = table["strain_2"] + size * rms(table["strain_2"][1500:]) * random.standard_normal(len(table["time"]))
    told = causes(recorded_run(table_of(table | {"strain_2": noisy}), CASE), reference, CASE).told(CASE.name)
    assert set(told) == {"strain_2"}
    assert "look like noise of" in told["strain_2"]
    assert float(told["strain_2"].split("noise of ")[1].split(" %")[0]) == pytest.approx(100.0 * size, rel=0.25)


def test_a_sign_is_named_through_noise(table: Columns, reference: Run) -> None:
    random = np.random.default_rng(4)
    noisy = -table["strain_2"] + 0.05 * rms(table["strain_2"]) * random.standard_normal(len(table["time"]))
    told = causes(recorded_run(table_of(table | {"strain_2": noisy}), CASE), reference, CASE).told(CASE.name)
    assert set(told) == {"strain_2"}
    assert "sign" in told["strain_2"]


@pytest.mark.parametrize(("column", "factor"), [("tip_deflection", 0.0254), ("tip_deflection", 1e3), ("slider_force", -1.0)])
def test_one_wrong_column_is_no_quantity_of_the_scene(table: Columns, reference: Run, column: str, factor: float) -> None:
    """Least of all 0.0254 of the deflection: about what ten times the stiffness makes of it."""
    found = causes(recorded_run(table_of(table | {column: factor * table[column]}), CASE), reference, CASE)
    assert set(found.told(CASE.name)) == {column}
    assert not found.open
