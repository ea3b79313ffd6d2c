"""What explains a column of a table that departs: a factor or a lateness, and nothing else.

The table is computed with other settings than the engine's run, so that it differs from it by 1e-3 without any mistake.
"""

import re
from collections.abc import Callable

import numpy as np
import pytest
from numpy.typing import NDArray

from quickreturn.cases.comparison.column_differences import UNEXPLAINED, Causes, causes
from quickreturn.cases.comparison.tables import recorded_run
from quickreturn.cases.files.case_file import load_case
from quickreturn.cases.files.recorded import table_of
from quickreturn.cases.motion.request import Run, RunRequest
from quickreturn.cases.motion.steady_state import steady_state
from quickreturn.engines.accurate import simulate
from quickreturn.engines.registry import engine
from quickreturn.engines.relative import rms
from quickreturn.engines.start import standard_start

Columns = dict[str, NDArray[np.float64]]
CASE = load_case("thesis-24")
NAMES = ("time", "crank_angle", "crank_speed", "tip_deflection", "tip_acceleration", "strain_2", "slider_force")


@pytest.fixture(scope="module")
def table() -> Columns:
    """The columns of the table, of two seconds from the standard start."""
    scene = CASE.mechanism
    found = simulate(engine("reference"), scene, standard_start(scene), 2.0, 1e-3, {"modes": "6"}, estimate=False)
    return {name: found.trajectory[name] for name in NAMES}


@pytest.fixture(scope="module")
def reference() -> Run:
    return steady_state(RunRequest(mechanism=CASE.mechanism, duration=1.95, engine="reference", turn=5))


def found(columns: Columns, reference: Run) -> Causes:
    return causes(recorded_run(table_of(columns), CASE), reference)


@pytest.mark.parametrize(
    ("column", "factor"),
    [
        *(("strain_2", factor) for factor in (-1.0, 0.1, 1.2, 1e6)),
        ("slider_force", 1e-3),
        ("crank_speed", 30.0 / np.pi),
        *(("tip_deflection", factor) for factor in (0.0254, 1e3)),
    ],
)
def test_a_factor_is_told_and_is_no_quantity_of_the_scene(table: Columns, reference: Run, column: str, factor: float) -> None:
    """Least of all 0.0254 of the deflection: about what ten times the stiffness makes of it."""
    causes_found = found(table | {column: factor * table[column]}, reference)
    (sentence,) = causes_found.told(CASE.name).values()
    number = re.fullmatch(rf"{column} is (\S+) times that of reference", sentence)
    assert number
    assert float(number[1]) == pytest.approx(factor, rel=2e-3)
    assert not causes_found.open


def test_a_factor_is_told_through_noise(table: Columns, reference: Run) -> None:
    noise = 0.01 * rms(table["strain_2"]) * np.random.default_rng(4).standard_normal(len(table["time"]))
    told = found(table | {"strain_2": noise - table["strain_2"]}, reference).told(CASE.name)
    number = re.fullmatch(r"strain_2 is (\S+) times that of reference", told["strain_2"])
    assert number
    assert float(number[1]) == pytest.approx(-1.0, rel=0.01)


def test_a_lateness_is_told(table: Columns, reference: Run) -> None:
    late = np.interp(table["time"] - 2e-3, table["time"], table["strain_2"])
    told = found(table | {"strain_2": late}, reference).told(CASE.name)
    number = re.fullmatch(r"strain_2 is (\S+) ms late", told["strain_2"])
    assert number
    assert float(number[1]) == pytest.approx(2.0, rel=0.1)


@pytest.mark.parametrize(
    "wrong",
    [
        lambda t: 0.0 * t["strain_2"],
        lambda t: t["strain_2"] + 1e-3,
        lambda t: 1e-3 * np.sin(41.0 * t["time"] ** 2),
        lambda t: t["tip_acceleration"],
    ],
)
def test_nothing_else_is_given_a_cause(table: Columns, reference: Run, wrong: Callable[[Columns], NDArray[np.float64]]) -> None:
    told = found(table | {"strain_2": wrong(table)}, reference).told(CASE.name)
    assert set(told) == {UNEXPLAINED}
    assert re.fullmatch(r"no factor and no lateness explains the difference of strain_2 \(off by \S+ %\)", told[UNEXPLAINED])
