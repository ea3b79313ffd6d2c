"""What explains a column of a table that departs: tables with one fault of the measuring chain each, and faults that nothing explains.

The tables are by `mujoco` and `exudyn`, which share neither shapes nor integrator with the run that they are compared with.
"""

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest
from scipy.signal import butter, lfilter

from quickreturn.cases.comparison.causes import UNEXPLAINED, Causes, Explained, Explanation, causes
from quickreturn.cases.comparison.tables import recorded_run
from quickreturn.cases.files.recorded import table_of
from quickreturn.cases.library import load_case
from quickreturn.cases.motion.request import Run, RunRequest
from quickreturn.cases.motion.steady_state import steady_state
from quickreturn.engines.accurate import simulate
from quickreturn.engines.registry import engine
from quickreturn.engines.start import standard_start
from quickreturn.reference_model.arrays import Array

Columns = dict[str, Array]
CASE = load_case("thesis-24")
NAMES = ("time", "crank_angle", "crank_speed", "tip_deflection", "tip_acceleration", "strain_1", "strain_2", "strain_3", "slider_force")
STEP = 1e-3


@pytest.fixture(scope="module", params=["mujoco", pytest.param("exudyn", marks=pytest.mark.verify)])
def table(request: pytest.FixtureRequest) -> Columns:
    """The columns of the table, of two seconds from the standard start."""
    scene, chosen = CASE.mechanism, engine(request.param)
    found = simulate(chosen, scene, standard_start(scene), 2.0, STEP, {}, estimate=False)
    return {name: found.trajectory[name] for name in NAMES}


@pytest.fixture(scope="module")
def reference() -> Run:
    return steady_state(RunRequest(mechanism=CASE.mechanism, duration=1.97, engine="reference", turn=5))


def found(columns: Columns, reference: Run, noise: float = 0.0) -> Causes:
    chance = np.random.default_rng(4)
    for name in NAMES[3:]:
        columns = columns | {name: columns[name] + noise * np.std(columns[name]) * chance.standard_normal(len(columns[name]))}
    return causes(recorded_run(table_of(columns), CASE), reference)


def late(values: Array, time: Array, by: float) -> Array:
    return np.interp(time - by, time, values)


def low_pass(order: int, frequency: float) -> Callable[[Array, Array], Array]:
    return lambda values, _: np.asarray(lfilter(*butter(order, frequency, fs=1.0 / STEP), values))


#: Kind of the explanation that holds -> the fault of a column, by its values and the time.
FAULTS: dict[str, tuple[str, Callable[[Array, Array], Array]]] = {
    "a gain": ("a factor", lambda values, _: 1.03 * values),
    "a sign": ("a factor", lambda values, _: -values),
    "a unit": ("a factor", lambda values, _: 1e6 * values),
    "a gauge that is not zeroed": ("an offset", lambda values, _: values + 0.1 * np.std(values)),
    "a gauge that drifts": ("a drift", lambda values, time: values + 0.15 * np.std(values) * time),
    "a late channel": ("a delay", lambda values, time: late(values, time, 5e-3)),
    "an amplifier": ("a low-pass of order 1", low_pass(1, 60.0)),
    "a filter": ("a low-pass of order 2", low_pass(2, 80.0)),
    "a converter at its end": ("a limit", lambda values, _: np.minimum(values, 0.7 * np.max(values))),
    "the mains": ("50 Hz", lambda values, time: values + 0.1 * np.std(values) * np.sin(2.0 * np.pi * 50.0 * time + 1.0)),
    "an encoder": ("steps", lambda values, _: 0.2 * np.std(values) * np.floor(values / (0.2 * np.std(values)))),
}


@pytest.mark.parametrize("noise", [pytest.param(0.0, marks=pytest.mark.verify), 0.005])
@pytest.mark.parametrize("fault", FAULTS)
@pytest.mark.parametrize("column", ["strain_2", pytest.param("tip_acceleration", marks=pytest.mark.verify)])
def test_a_fault_of_the_measuring_chain_is_named(table: Columns, reference: Run, column: str, fault: str, noise: float) -> None:
    """No other is named, but for a filter and a delay that do the same within what is left, of which both are named."""
    kind, change = FAULTS[fault]
    wrong = table | {column: change(table[column], table["time"])}
    causes_found = found(wrong, reference, 0.0 if kind == "steps" else noise)
    assert not causes_found.open
    assert set(causes_found.told(CASE.name)) == {column}
    holding = {each.kind for each in causes_found.columns[column].holding}
    alike = {"a delay", "a low-pass of order 1", "a low-pass of order 2"}
    assert kind in holding
    assert holding <= (alike if kind in alike else {kind})


def test_the_constants_are_those_of_the_fault(table: Columns, reference: Run) -> None:
    def words(change: Callable[[Array, Array], Array]) -> str:
        wrong = table | {"strain_2": change(table["strain_2"], table["time"])}
        return found(wrong, reference).told(CASE.name)["strain_2"]

    assert words(lambda values, _: 1.2 * values).startswith("strain_2 is 1.2 times that of reference (that leaves 0.")
    assert "is 2.5e-05 above" in words(lambda values, _: values + 2.5e-5)
    assert " ms late" in words(lambda values, time: late(values, time, 5e-3))
    frequency = float(words(low_pass(1, 60.0)).split("first order at ")[1].split(" Hz")[0])
    assert frequency == pytest.approx(60.0, rel=0.03)
    assert "comes in steps of 2e-05" in words(lambda values, _: 2e-5 * np.round(values / 2e-5))


def test_a_row_beyond_the_turn_by_rounding_hides_no_factor(table: Columns, reference: Run) -> None:
    run = recorded_run(table_of(table | {"strain_2": 1.2 * table["strain_2"]}), CASE)
    wide = replace(run, cycle={**run.cycle, "crank_angle": (1.0 + 1e-12) * run.cycle["crank_angle"]})
    assert causes(wide, reference).told(CASE.name)["strain_2"].startswith("strain_2 is 1.2 times that of reference")


def test_one_delay_of_all_columns_is_told_once(table: Columns, reference: Run) -> None:
    delayed = {name: late(table[name], table["time"], 3e-3) for name in NAMES[2:]}
    told = found(table | delayed, reference).told(CASE.name)
    assert set(told) == {"crank_angle"}
    assert float(told["crank_angle"].split("crank_angle are ")[1].split(" ms late")[0]) == pytest.approx(3.0, abs=0.02)


def test_a_clock_that_runs_fast_is_told_where_no_crank_angle_was_recorded(table: Columns, reference: Run) -> None:
    timed = {name: values for name, values in table.items() if name != "crank_angle"} | {"time": 1.005 * table["time"]}
    told = found(timed, reference).told(CASE.name)
    assert set(told) == {"crank_angle"}
    assert float(told["crank_angle"].removeprefix("time runs ").split(" %")[0]) == pytest.approx(0.5, abs=0.05)
    assert "too fast" in told["crank_angle"]


@pytest.mark.parametrize(
    "wrong",
    [
        lambda t: 0.0 * t["strain_2"],
        lambda t: t["tip_acceleration"],
        lambda t: np.std(t["strain_2"]) * np.sin(41.0 * t["time"] ** 2),
        lambda t: t["strain_2"] + 0.3 * np.abs(t["strain_2"]),
    ],
)
def test_nothing_else_is_given_a_cause(table: Columns, reference: Run, wrong: Callable[[Columns], Array]) -> None:
    told = found(table | {"strain_2": wrong(table)}, reference, 0.005).told(CASE.name)
    assert set(told) == {UNEXPLAINED}
    assert "nothing that was tried explains the difference of strain_2 (off by " in told[UNEXPLAINED]


def test_a_right_table_needs_no_explanation(table: Columns, reference: Run) -> None:
    assert found(table, reference, 0.02).told(CASE.name) == {}


def test_of_explanations_that_leave_as_much_the_simplest_hold() -> None:
    def held(*tries: tuple[str, float, int]) -> list[str]:
        return [each.kind for each in Explained(0.2, [Explanation(kind, kind, left, count) for kind, left, count in tries]).holding]

    assert held(("one", 3e-3, 1), ("other", 5e-3, 1), ("worse", 8e-3, 1)) == ["one", "other"]
    assert held(("two constants", 3e-3, 2), ("one", 5e-3, 1)) == ["one"]
    assert held(("two constants", 1e-3, 2), ("one", 5e-3, 1)) == ["two constants"]
    assert held(("beyond the errors", 0.02, 1), ("much", 0.1, 1)) == []
    assert held() == []
