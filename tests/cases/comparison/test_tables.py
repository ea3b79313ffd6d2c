"""A recorded table is measured in the state that it shows, and held against an engine in the same: against tables of known descent."""

import re
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import pytest

from quickreturn.cases.comparison.causes import QUANTITIES, UNEXPLAINED, Explanation, causes, column_differences, places
from quickreturn.cases.comparison.engines import CaseResult, compare
from quickreturn.cases.comparison.tables import recorded_run
from quickreturn.cases.files.errors import CaseError
from quickreturn.cases.files.recorded import read_table
from quickreturn.cases.library import load_case
from quickreturn.cases.motion.endings import Ending
from quickreturn.cases.motion.request import Run, RunRequest
from quickreturn.cases.motion.steady_state import steady_state
from quickreturn.engines.accurate import simulate
from quickreturn.engines.registry import engine
from quickreturn.engines.start import standard_start
from quickreturn.reference_model.scene_values import changed

CASE = load_case("thesis-24")
TURN = 2.0 * np.pi / 16.617773
COLUMNS = ["time", "crank_angle", "crank_speed", "tip_deflection", "tip_acceleration", "strain_2"]
Recorded = Callable[..., Run]


def table_of(duration: float) -> pd.DataFrame:
    found = simulate(engine("reference"), CASE.mechanism, standard_start(CASE.mechanism), duration, 1e-3, {"modes": "6"}, estimate=False)
    return found.trajectory.table()


@pytest.fixture(scope="module")
def transient() -> pd.DataFrame:
    return table_of(2.0)


@pytest.fixture(scope="module")
def settled() -> pd.DataFrame:
    return table_of(12.0)


@pytest.fixture(scope="module")
def in_turn_5() -> Run:
    return steady_state(RunRequest(mechanism=CASE.mechanism, duration=1.95, engine="reference", turn=5))


@pytest.fixture(scope="module")
def steady() -> Run:
    return steady_state(RunRequest(mechanism=CASE.mechanism, duration=2.0, engine="reference"))


@pytest.fixture
def recorded(tmp_path: Path) -> Recorded:
    """The run of a table that is written to a file and read again."""

    def made(table: pd.DataFrame, head: str = "", **columns: Any) -> Run:
        changed = table[[name for name in COLUMNS if name in table]].assign(**columns)
        (tmp_path / "tool.csv").write_text(head + changed.to_csv(index=False))
        return recorded_run(read_table(str(tmp_path / "tool.csv")), CASE)

    return made


def held(run: Run, other: Run) -> CaseResult:
    return compare(CASE, {"reference": other}, {run.engine: run}).with_tables


def test_a_table_from_the_standard_start_is_held_against_the_same_turn(transient: pd.DataFrame, in_turn_5: Run, recorded: Recorded) -> None:
    run = recorded(transient)
    assert (run.status, run.approach.turn, in_turn_5.status, in_turn_5.approach.turn) == (Ending.TRANSIENT, 5, Ending.TRANSIENT, 5)
    result = held(run, in_turn_5)
    assert result.passed is True, result.missed
    assert {check.quantity for check in result.checks} == {
        "consensus_frequency", "first_mode_frequency", "first_mode_amplitude", "minimum", "maximum",
    }  # fmt: skip
    assert {check.channel for check in result.checks} == {None, *COLUMNS[2:]}
    # the reference claims 0.1 % at its default
    assert column_differences(run, in_turn_5)["strain_2"] < 1e-3
    assert causes(run, in_turn_5).told(CASE.name) == {}


@pytest.mark.parametrize("share", [0.003, 0.03])
def test_noise_is_no_disagreement(transient: pd.DataFrame, in_turn_5: Run, recorded: Recorded, share: float) -> None:
    random = np.random.default_rng(1)
    noisy = {name: transient[name] + share * transient[name].std() * random.standard_normal(len(transient)) for name in COLUMNS[3:]}
    run = recorded(transient, **noisy)
    assert run.approach.turn == 5
    result = held(run, in_turn_5)
    assert result.passed is True, result.missed
    # and it is not bought with a tolerance that lets everything pass: an extreme may be off by some five times the noise
    for name in COLUMNS[3:]:
        assert 3.0 < run.approach.settling_errors[name] / (share * transient[name].std()) < 6.0


def test_where_no_column_tells_the_start_the_way_to_the_steady_state_does(transient: pd.DataFrame, recorded: Recorded) -> None:
    assert recorded(transient[["time", "crank_angle", "tip_acceleration"]]).approach.turn == 5
    assert recorded(transient[["time", "crank_angle", "tip_acceleration"]][:400]).approach.turn is None  # a single turn is taken to repeat


@pytest.mark.verify
def test_a_table_that_settles_is_held_against_the_steady_state(settled: pd.DataFrame, steady: Run, recorded: Recorded) -> None:
    run = recorded(settled)
    assert (run.status, run.approach.turn) == (Ending.SETTLED, None)
    result = held(run, steady)
    assert result.passed is True, result.missed
    assert result.accuracy_class("tool.csv") in ("0.1 %", "0.3 %")


def test_a_single_turn_is_taken_to_repeat(settled: pd.DataFrame, steady: Run, recorded: Recorded) -> None:
    last = settled[(settled["crank_angle"] > 61 * np.pi) & (settled["crank_angle"] < 63 * np.pi)]
    assert 0.0 < float(last["crank_angle"].iloc[0]) - 61 * np.pi < 0.06  # the turn lacks a little at both its ends
    run = recorded(last, "# origin = digitised\n", crank_angle=last["crank_angle"] - 60 * np.pi, time=last["time"] - last["time"].iloc[0])
    assert (run.status, run.approach.cycles) == (Ending.ASSUMED, 1)
    assert "one turn" in run.remark
    result = held(run, steady)
    assert result.passed is True, result.missed


def test_the_class_of_a_table_covers_every_column(transient: pd.DataFrame, in_turn_5: Run, recorded: Recorded) -> None:
    result = held(recorded(transient, tip_deflection=1.02 * transient["tip_deflection"]), in_turn_5)
    assert {check.channel for check in result.missed} == {"tip_deflection"}
    assert result.accuracy_class("tool.csv") == "3 %"


@pytest.mark.parametrize("zero", [3.0, 180.0, -37.0])
def test_an_encoder_whose_zero_is_off_is_told_by_its_angle(settled: pd.DataFrame, steady: Run, recorded: Recorded, zero: float) -> None:
    run = recorded(settled[-2000:], crank_angle=settled["crank_angle"][-2000:] + np.radians(zero))
    told = causes(run, steady).told(CASE.name)
    assert list(told) == ["crank_angle"]
    assert float(told["crank_angle"].split("crank_angle is ")[1].split(" deg")[0]) == pytest.approx(abs(zero), abs=0.1)
    if abs(zero) < 180.0:
        assert f"deg too {'large' if zero > 0.0 else 'small'}" in told["crank_angle"]
        assert f"HEADING = crank_angle [deg] {'+' if zero > 0.0 else '-'} " in told["crank_angle"]  # as the table has it
    assert not causes(run, steady).open


@pytest.mark.verify
def test_a_softer_arm_is_neither_late_nor_a_factor_and_a_quantity_is_looked_for(steady: Run, recorded: Recorded) -> None:
    softer = changed(CASE.mechanism, {"follower.bending_stiffness": 0.94 * CASE.mechanism.follower.bending_stiffness})
    found = simulate(engine("reference"), softer, standard_start(softer), 12.0, 1e-3, {"modes": "6"}, estimate=False)
    found_causes = causes(recorded(found.trajectory.table()), steady)
    assert found_causes.open
    assert set(found_causes.told(CASE.name)) == {UNEXPLAINED}
    told = found_causes.told(CASE.name, [Explanation("another stiffness", "a lead", 1e-3)])
    assert set(told) == {QUANTITIES}
    assert told[QUANTITIES].startswith("a lead (that leaves 0.1 % of a difference of ")


def test_the_place_of_the_largest_difference_is_told(settled: pd.DataFrame, steady: Run, recorded: Recorded) -> None:
    turned = np.degrees(settled["crank_angle"]) % 360.0
    run = recorded(settled, strain_2=settled["strain_2"] + 5e-4 * np.exp(-(((turned - 250.0) / 10.0) ** 2)))
    assert places(run, steady)["strain_2"] == pytest.approx(250.0, abs=1.5)


@pytest.mark.parametrize("noise", [0.0, 2e-6])
def test_a_gauge_that_drifts_is_named_and_a_straight_line_takes_it_off(
    settled: pd.DataFrame, recorded: Recorded, tmp_path: Path, noise: float
) -> None:
    """dsp.stackexchange 27468: 80 microstrain a second on a gauge with an offset; a column of g and one without unit beside it."""
    rows, chance = settled[-3000:], np.random.default_rng(3)
    drifting = rows["strain_2"] + 1.5e-4 + 8e-5 * rows["time"] + noise * chance.standard_normal(len(rows))
    run = recorded(rows, strain_2=drifting)
    assert (run.status, run.approach.turn) == (Ending.SETTLED, None)
    assert not {each.channel for each in run.measured.measures} & {"strain_2"}
    assert {each.channel for each in run.measured.measures} >= {"tip_deflection", "tip_acceleration"}
    found = re.search(
        r'strain_2 does not repeat: .* and is left out; add --column "(strain_2 = strain_2 \[1\] \+ ([^ ]+) \* time)"', run.remark
    )
    assert found
    assert float(found[2]) == pytest.approx(8e-5, rel=0.01)
    mended = read_table(tmp_path / "tool.csv", [found[1]])
    expected = rows["strain_2"] + 1.5e-4 + 8e-5 * rows["time"].iloc[0]
    assert np.std(mended.columns["strain_2"] - expected) < 1e-6 + 1.1 * noise
    assert {each.channel for each in recorded_run(mended, CASE).measured.measures} >= {"strain_2"}
    alone = recorded(rows[["time", "crank_angle"]], strain_2=drifting)
    assert alone.status == Ending.NOT_SETTLED
    assert "record longer" not in alone.remark
    assert "to take a straight line off" in alone.remark


def test_a_table_that_repeats_is_settled(steady: Run, recorded: Recorded) -> None:
    """Turns of one cycle, which differ by rounding alone."""
    cycle, turns = steady.cycle, range(7)
    period = cycle["time"][-1]
    columns = {name: np.concatenate([cycle[name][:-1] for _ in turns]) for name in COLUMNS[2:]}
    columns["time"] = np.concatenate([cycle["time"][:-1] + period * turn for turn in turns])
    columns["crank_angle"] = np.concatenate([cycle["crank_angle"][:-1] + 2.0 * np.pi * turn for turn in turns])
    run = recorded(pd.DataFrame(columns)[COLUMNS])
    assert (run.status, run.remark) == (Ending.SETTLED, "")


@pytest.mark.parametrize(("factor", "noise"), [(1.01, 0.0), (0.98, 0.01)])
def test_a_stiffness_that_is_a_percent_off_shows_in_the_vibration_of_a_table(
    transient: pd.DataFrame, in_turn_5: Run, recorded: Recorded, factor: float, noise: float
) -> None:
    """What the fits leave open is common to table and engine; the table of the right machine agrees, and few comparisons say nothing."""
    other = changed(CASE.mechanism, {"follower.bending_stiffness": factor * CASE.mechanism.follower.bending_stiffness})
    made = simulate(engine("reference"), other, standard_start(other), 2.0, 1e-3, {"modes": "6"}, estimate=False).trajectory.table()
    random = np.random.default_rng(5)
    found = {}
    for name, table in (("right", transient), ("wrong", made)):
        noisy = {each: table[each] + noise * table[each].std() * random.standard_normal(len(table)) for each in COLUMNS[3:]}
        checks = held(recorded(table, **noisy), in_turn_5).checks
        found[name] = [check for check in checks if check.quantity in ("first_mode_frequency", "first_mode_amplitude")]
    assert len(found["right"]) >= 6
    assert {check.verdict for check in found["right"]} == {"agrees"}
    assert "disagrees" in {check.verdict for check in found["wrong"]}


def test_strains_that_loads_leave_in_a_straight_beam_are_no_other_start(transient: pd.DataFrame, recorded: Recorded) -> None:
    share = 3e-3 * transient["strain_2"].abs().max() * np.exp(-20.0 * transient["time"])  # as gravity does
    run = recorded(transient, strain_2=transient["strain_2"] + share)
    assert (run.approach.turn, run.remark) == (5, "")


@pytest.mark.parametrize("first", [12.5, -0.25])
def test_the_time_of_the_start_may_be_any(transient: pd.DataFrame, in_turn_5: Run, recorded: Recorded, first: float) -> None:
    run = recorded(transient, time=transient["time"] + first)
    assert (run.status, run.approach.turn) == (Ending.TRANSIENT, 5)
    assert f"its time is counted from the first row, at {first:g} s" in run.remark
    assert held(run, in_turn_5).passed is True
    assert column_differences(run, in_turn_5)["strain_2"] < 1e-3


def test_where_the_phase_is_open_the_option_that_tells_it_is_named(transient: pd.DataFrame, recorded: Recorded, tmp_path: Path) -> None:
    angleless = transient[["time", "tip_deflection", "strain_2"]]
    run = recorded(angleless, time=transient["time"] + 12.5)
    option = "time = time [s] + 12.5"
    assert f'in the first row, at 12.5 s, add --column "{option}"' in run.remark
    table = read_table(str(tmp_path / "tool.csv"), option)
    assert recorded_run(table, CASE).approach.turn == recorded(angleless).approach.turn == 5


@pytest.mark.parametrize("missing", [(0.30, 0.33), (0.30, 1.40)])  # also longer than two turns
def test_turns_that_lack_rows_are_not_used_and_it_is_told(
    transient: pd.DataFrame, in_turn_5: Run, recorded: Recorded, missing: tuple[float, float]
) -> None:
    low, high = missing
    run = recorded(transient[(transient["time"] < low) | (transient["time"] > high)])
    assert run.approach.turn == 5
    assert f"a gap: {high - low + 0.002:.3g} s without a row after {low - 0.001:g} s" in run.remark
    assert "rows for more than" in run.remark
    assert held(run, in_turn_5).passed is True
    assert column_differences(run, in_turn_5)["strain_2"] < 1e-3


def test_a_wrapped_angle_does_not_tell_the_turns_in_a_gap(transient: pd.DataFrame, recorded: Recorded) -> None:
    some = transient[(transient["time"] < 0.30) | (transient["time"] > 1.20)]
    with pytest.raises(CaseError, match=r"no row for 0\.902 s after 0\.299 s, and the wrapped crank_angle does not tell its turns"):
        recorded(some, crank_angle=some["crank_angle"] % (2.0 * np.pi))


def test_a_table_on_its_way_from_elsewhere_is_not_judged(transient: pd.DataFrame, steady: Run, recorded: Recorded) -> None:
    later = table_of(4.0)
    later = later[later["time"] > 0.5]
    run = recorded(later)
    assert run.status == Ending.NOT_SETTLED
    assert "record longer" in run.remark
    result = held(run, steady)
    assert result.passed is None
    assert result.failures == (result.runs["tool.csv"],)


def test_without_a_crank_angle_the_crank_is_taken_to_turn_evenly(transient: pd.DataFrame, in_turn_5: Run, recorded: Recorded) -> None:
    run = recorded(transient[["time", "strain_2"]])
    assert "16.617" in run.remark
    assert run.approach.turn == 5
    alone, whole = (found.measure("post", "strain_2") for found in (run, in_turn_5))
    assert alone.first_mode_frequency == pytest.approx(whole.first_mode_frequency, rel=0.01)  # the crank's speed varies by 2.5 %


def test_a_right_table_with_an_encoder_is_not_accused(transient: pd.DataFrame, in_turn_5: Run, recorded: Recorded) -> None:
    step = np.radians(0.45)
    places = {name: transient[name] for name in ("follower_angle", "tip_y", "slider_force")}
    result = held(recorded(transient, **places, crank_angle=step * np.round(transient["crank_angle"] / step)), in_turn_5)
    assert result.passed is True, result.missed


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"time": lambda t: 1e3 * t["time"]}, ["378 s", "0.378 s", "units"]),
        ({"crank_angle": lambda t: np.degrees(t["crank_angle"])}, ["0.00", "0.378 s", "units"]),
        ({"time": lambda t: 7.0 * t["time"]}, ["2.65 s", "0.378 s", "thesis-24"]),
        ({"crank_angle": lambda t: t["crank_angle"] + 4.0 * (t["time"] > 1.0)}, ["crank_angle", "jumps", "run on"]),
        ({"crank_angle": lambda t: -t["crank_angle"]}, ["crank_angle", "the other way", "counter-clockwise"]),
        ({"crank_angle": lambda t: t["crank_angle"] - 0.2 * np.sin(50.0 * t["crank_angle"])}, ["turns back"]),
    ],
)
def test_tables_that_cannot_be_of_the_case(transient: pd.DataFrame, recorded: Recorded, changes: dict[str, Any], words: list[str]) -> None:
    with pytest.raises(CaseError) as told:
        recorded(transient, **changes)
    for word in words:
        assert word in str(told.value)


@pytest.mark.parametrize("least", [0.0, -1.5 * np.pi])
def test_a_wrapped_crank_angle_is_that_of_the_same_turn(transient: pd.DataFrame, recorded: Recorded, least: float) -> None:
    wrapped = recorded(transient, crank_angle=lambda t: (t["crank_angle"] - least) % (2.0 * np.pi) + least)
    plain = recorded(transient)
    assert wrapped.approach.turn == plain.approach.turn == 5
    np.testing.assert_allclose(wrapped.cycle["crank_angle"], plain.cycle["crank_angle"], rtol=1e-12)


def test_too_little_of_it(transient: pd.DataFrame, recorded: Recorded) -> None:
    with pytest.raises(CaseError, match=r"covers 0\.79\d* turns"):
        recorded(transient[:300])
    with pytest.raises(CaseError, match=r"without a row after 1\.789 s; at most 0\.00378 s"):
        recorded(transient[(transient["time"] < 1.79) | (transient["time"] > 1.8)])
    with pytest.raises(CaseError, match='case: "thesis-23" is not "thesis-24"'):
        recorded(transient, "# case = thesis-23\n")
