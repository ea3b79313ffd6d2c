"""What happens in a turn: each sentence where it is true, and where another must stand in its place."""

import dataclasses
import math
import re
from typing import Any

import numpy as np
import pytest
from scipy.integrate import quad

from quickreturn.cases.case import Case
from quickreturn.cases.case_file import load_case
from quickreturn.cases.measures.quasi_static import quasi_static_strain
from quickreturn.cases.runs.comparison import compare
from quickreturn.cases.runs.endings import Ending
from quickreturn.cases.runs.request import PeriodicOrbit
from quickreturn.reference_model.natural_modes import frozen_crank_modes
from quickreturn.reports.results.turn import SENTENCES, Turn, leading_statements, statements
from tests.changed_run import changed_run
from tests.reports.pages import one_run, plain, text_of
from tests.reports.plotted_results import made_up_run

#: 90 rpm, without gravity and force on the tip; its crank is square to the arm HALF degrees from the middle of the quick return.
CASE = load_case("example", {"crank.prescribed_speed": "90 rpm", "mechanism.gravity": '["0 m/s^2", "0 m/s^2"]'})
HALF = math.degrees(math.acos(CASE.mechanism.crank.length / CASE.mechanism.pivot_distance))
SPEED = 3.0 * math.pi


def turn(case: Case = CASE, turning: int = 1, columns: dict[str, Any] | None = None, **changes: Any) -> Turn:
    """A turn with made-up columns: constants, or functions of the crank angle."""
    run = made_up_run(case, "reference", turning=turning, samples=2001)
    angle = run.cycle["crank_angle"]
    cycle = run.cycle | {
        name: values(angle) if callable(values) else np.full_like(angle, values) for name, values in (columns or {}).items()
    }
    return Turn(case, changed_run(run, **{"cycle": cycle, "error_estimate": 1e-3, **changes}))


def said(topic: str, found: Turn) -> str:
    """The sentence, "" if nothing is said."""
    told = SENTENCES[topic](found)
    return "" if told is None else plain(told[0])


def bump(degrees: float, height: float) -> Any:
    """A peak at a crank angle, in whichever turn."""
    return lambda angle: height * np.exp(-((np.remainder(angle - math.radians(degrees) + math.pi, 2.0 * math.pi) - math.pi) ** 2) / 0.02)


@pytest.mark.parametrize(
    ("at", "turning", "where"),
    [
        (350.0, 1, "with the crank at 350°, in the quick return, 10° before its middle"),
        (20.0, 1, "with the crank at 20°, in the quick return, 20° after its middle"),
        (20.0, -1, "with the crank at 20°, in the quick return, 20° before its middle"),
        (240.0, 1, f"with the crank at 240°, {120.0 - HALF:.0f}° before the quick return begins"),
        (140.0, 1, f"with the crank at 140°, {140.0 - HALF:.0f}° after the quick return has ended"),
    ],
)
def test_when_the_tip_whips(at: float, turning: int, where: str) -> None:
    found = turn(turning=turning, columns={"tip_acceleration": bump(at, -80.0)}, extreme_estimates=claims("tip_acceleration", 0.8))
    assert said("whip", found).startswith(f"The tip is accelerated most {where}: 80.00 m/s² (± 1")
    loose = claims("tip_acceleration", 80.0)
    assert said("whip", turn(columns={"tip_acceleration": bump(at, 80.0)}, extreme_estimates=loose)) == ""


def test_two_peaks_that_are_alike_within_the_error_are_both_told() -> None:
    both = {"tip_acceleration": lambda angle: bump(350.0, 80.0)(angle) - bump(60.0, 79.9)(angle)}
    alike = said("whip", turn(columns=both, extreme_estimates=claims("tip_acceleration", 0.8)))
    assert alike.endswith("; as large the other way, within the error, at 60°.")
    sharp = said("whip", turn(columns=both, extreme_estimates=claims("tip_acceleration", 0.001), settling_error=0.0, settling_errors={}))
    assert sharp.endswith("%).")
    quiet = {"crank_torque": lambda angle: 10.0 * np.sin(angle), "crank_speed": SPEED}
    assert "as large the other way, within the error, at " in said(
        "drive", turn(columns=quiet, extreme_estimates=claims("crank_torque", 0.1))
    )


def claims(column: str, error: float) -> dict[str, dict[str, float]]:
    return {column: {"pre": error, "post": error}}


def test_how_long_the_strokes_take() -> None:
    half, period = math.radians(HALF), 2.0 / 3.0
    work, back = (period * angle / math.pi for angle in (math.pi - half, half))
    assert said("strokes", turn()) == (
        f"The working stroke takes {work / back:.2f} times as long as the return: {work:.4f} s and {back:.4f} s."
    )
    short = load_case("example", {"crank.prescribed_speed": "90 rpm", "crank.length": "1 mm"})
    assert said("strokes", turn(short)).startswith("The working stroke and the return take the same time to 1 %: 0.33")


def test_the_halves_of_an_arm_that_turns_fully() -> None:
    """It is square to the line of the pivots with the crank at acos(50 mm / 120 mm) = 65.38 deg on either side of 0."""
    fully = load_case("whitworth", {"crank.prescribed_speed": "90 rpm"})
    assert said("strokes", turn(fully)) == (
        "The arm turns fully, and the slow half of its turn takes 1.75 times as long as the fast one, the return: 0.4245 s and 0.2421 s."
    )


def test_where_the_force_changes_sign() -> None:
    claimed = {"extreme_estimates": claims("slider_force", 0.05)}
    found = said("sides", turn(columns={"slider_force": lambda angle: 10.0 * np.cos(2.0 * angle)}, **claimed))
    assert found.startswith("The slider's force changes sign four times, with the crank at 45°, 135°, 225° and 315°: ")
    found = said("sides", turn(columns={"slider_force": lambda angle: 10.0 * np.sin(angle + 0.2)}, **claimed))
    assert found.startswith("The slider's force changes sign twice, with the crank at 169° and 349°: ")  # 0.2 rad are 11.5°
    found = said("sides", turn(columns={"slider_force": lambda angle: 10.0 * np.sin(9.0 * angle)}, **claimed))
    assert "changes sign 18 times, first with the crank at " in found
    one_side = {"slider_force": lambda angle: 7.0 + 4.0 * np.cos(angle)}
    assert said("sides", turn(columns=one_side, **claimed)) == (
        "The slider presses on the same side of the arm throughout the turn, with 3.000 N or more."
    )
    touching = {"slider_force": lambda angle: 4.0 + 4.01 * np.cos(angle)}  # below zero by less than is claimed
    assert said("sides", turn(columns=touching, **claimed)) == "The slider presses on the same side of the arm throughout the turn."
    assert said("sides", turn(columns={"slider_force": 0.01}, **claimed)) == ""


def test_where_the_arm_is_stressed_most() -> None:
    found = turn()
    largest = found.motion.loads.stress.largest  # type: ignore[union-attr]
    share = largest.place / CASE.mechanism.follower.length
    told = f"The arm is stressed most {1e3 * largest.place:.0f} mm from P, at {100.0 * share:.0f} % of its length, with the crank at "
    value = f"{1e-6 * largest.value:.4g}"
    either = f"{told}{math.degrees(largest.crank_angle):.0f}° (bent the other way as much, within the error): {value}"
    assert said("stress", found).startswith(either)  # a rigid motion at constant speed is antisymmetric
    more = {name: values + 0.05 * np.max(values) for name, values in found.run.cycle.items() if name.startswith("moment_")}
    assert " within the error" not in said("stress", Turn(CASE, changed_run(found.run, cycle=found.run.cycle | more)))
    moments = {f"moment_{k:02d}": {"pre": 1e6, "post": 1e6} for k in range(1, 12)} | {"moment_slider": {"pre": 1e6, "post": 1e6}}
    loose = found.run.measured.extreme_estimates | moments | {"moment_inboard": {"pre": 1e6, "post": 1e6}}
    assert said("stress", turn(extreme_estimates=loose)) == ""


def test_what_rings() -> None:
    found = turn()
    measures = [dataclasses.replace(each, first_mode_amplitude=3.0 if each.half == "post" else 2.0) for each in found.run.measured.measures]
    mean = np.mean(
        [frozen_crank_modes(CASE.mechanism, float(q), 1).frequencies[0] for q in np.linspace(0.0, 2.0 * math.pi, 48, endpoint=False)]
    )
    near = round(float(mean) / 1.5)
    text = said("ringing", turn(measures=tuple(measures)))
    assert text.startswith("The first mode rings most after the return, with 3.000 m/s² (±")
    assert f"{near} times the crank's speed is nearest to its mean frequency, {mean:.2f} Hz with the crank held: " in text
    away = float(re.search(r"held: ([\d.]+) % off", text)[1])  # type: ignore[index]
    assert away == pytest.approx(100.0 * abs(mean / 1.5 / near - 1.0), rel=0.06)
    silent = [dataclasses.replace(each, first_mode_amplitude=None) for each in measures]
    assert said("ringing", turn(measures=tuple(silent))).startswith(
        "The size of the first mode's ringing cannot be fitted, which is neither good nor bad; "
    )
    rigid = load_case("rigid")
    assert said("ringing", turn(rigid)) == "Nothing rings: the arm is rigid."
    assert said("limit", turn(rigid)) == ""


def test_what_the_drive_must_give() -> None:
    def torque(angle: Any) -> Any:
        return 3.0 + 10.0 * np.cos(angle)

    known = {"turn.driven_energy": {"number": 0.05}, "turn.returned_energy": {"number": 0.05}}
    changes: dict[str, Any] = {"extreme_estimates": claims("crank_torque", 0.1), "turn_estimates": known}
    given = quad(lambda q: max(torque(q), 0.0), 0.0, 2.0 * math.pi, limit=200)[0]
    back = quad(lambda q: max(-torque(q), 0.0), 0.0, 2.0 * math.pi, limit=200)[0]
    columns = {"crank_torque": torque, "crank_speed": SPEED}
    text = said("drive", turn(columns=columns, **changes))
    assert text.startswith("The torque of the drive is largest with the crank at 0°: 13.00 N m (±")
    energies = [float(each) for each in re.findall(r"([\d.]+) J", text)]
    assert energies == pytest.approx([given, back], rel=1e-3)
    columns["crank_torque"] = lambda angle: 20.0 + 10.0 * np.cos(angle)
    assert said("drive", turn(columns=columns, **changes)).endswith("in a turn, none of it comes back.")
    assert said("drive", turn(load_case("rigid"), columns={"crank_torque": 1.5})).startswith("The drive gives a constant torque, 1.500 N m")
    loaded = said("drive", turn(load_case("rigid"), columns={"crank_torque": 1.5, "crank_speed": SPEED}))
    assert re.search("less crank.damping times the speed, .* N m .* and .* W .* in the mean reach the shaft.$", loaded)


def test_what_the_bearings_carry() -> None:
    names = ("pivot_force_x", "pivot_force_y", "crank_force_x", "crank_force_y")
    columns = dict(zip(names, (bump(60.0, 30.0), bump(60.0, 40.0), bump(200.0, -5.0), 0.0), strict=True))
    errors = {name: {"pre": 0.1, "post": 0.1} for name in names}
    text = said("bearings", turn(columns=columns, extreme_estimates=errors))
    assert re.fullmatch(r"The bearings must bear up to: P of the arm 50\.00 N \(± .*\) and O of the crank 5\.000 N \(± .*\)\.", text)
    numbers = SENTENCES["bearings"](turn(columns=columns, extreme_estimates=errors))[1]  # type: ignore[index]
    assert (numbers["P_force"], numbers["O_force"]) == pytest.approx((50.0, 5.0), rel=1e-4)
    assert said("bearings", turn(columns=columns, extreme_estimates={name: {"pre": 99.0, "post": 99.0} for name in names})) == ""


SLOW = "a disturbance of the two lowest modes is left after a turn"


@pytest.mark.parametrize(
    ("multiplier", "error", "text"),
    [
        (0.5, 0.001, f"50 % of {SLOW} (± 0.2 %), less than 1 % after 7 turns."),
        (1.2, 0.001, "A disturbance grows 1.2-fold in a turn: the machine leaves this motion."),
        (1.0, 0.01, "A disturbance neither grows nor dies away within the error."),
        (0.001, 0.0105, "A disturbance dies away within a turn, to less than 1.15 %."),
    ],
)  # fmt: skip
def test_how_fast_a_disturbance_dies_away(multiplier: float, error: float, text: str) -> None:
    orbit = PeriodicOrbit(2.0 / 3.0, ((0.0, multiplier), (0.0, -multiplier)), multiplier < 1.0, 3, error, error)
    assert said("decay", turn(periodic_orbit=orbit)).startswith(text)  # 0.501^7 is 0.8 %, 0.501^6 is 1.6 %
    assert said("decay", turn(periodic_orbit=None)) == ""


def test_what_limits_the_speed() -> None:
    def strain(part: float) -> Any:
        def of(angle: Any) -> Any:
            rigid = quasi_static_strain(CASE.mechanism, CASE.mechanism.follower.strain_gauges[1], angle) * SPEED**2
            return rigid + part * np.sqrt(2.0 * np.mean(rigid**2)) * np.sin(9.0 * angle)

        return {"strain_2": of, "crank_speed": SPEED}

    still, shaking = said("limit", turn(columns=strain(0.02))), said("limit", turn(columns=strain(0.5)))
    mean = np.mean(
        [frozen_crank_modes(CASE.mechanism, float(q), 1).frequencies[0] for q in np.linspace(0.0, 2.0 * math.pi, 48, endpoint=False)]
    )
    order = math.floor(mean / 1.5)
    assert still.startswith(f"No resonance is near at higher speeds: at {60.0 * mean / order:.2f} rpm, ")
    assert ", but hardly drives it: harmonics 9 to 13 make 0.00" in still
    driven = {"tip_acceleration": lambda angle: np.sin(angle) + 0.1 * np.sin(order * angle)}
    assert f"; here harmonics {order - 2} to {order + 2} make 10 % of the tip's acceleration; " in said("limit", turn(columns=driven))
    assert "between resonances the stress grows about as the square of the speed, for the strain at mid-arm differs by 2.0 %" in still
    assert "the stress does not simply grow as the square of the speed, for the strain at mid-arm differs by 50 %" in shaking
    heavy = load_case("example", {"crank.prescribed_speed": "90 rpm"})
    assert "gravity or the force on the tip bends the arm at any speed" in said("limit", turn(heavy, columns=strain(0.02)))
    fast = load_case("example", {"crank.prescribed_speed": "3000 rpm"})
    assert said("limit", turn(fast)) == "At higher speeds no multiple of the crank's speed meets the first mode."


def test_how_far_it_is_to_be_trusted() -> None:
    assert said("trust", turn()).startswith(
        "The numbers are those of reference, which estimates its error at 0.1 % of the tip's deflection; "
    )
    assert "does not know its error" in said("trust", turn(error_estimate=None))
    assert ", which misses the accuracy asked; " in said("trust", turn(status=Ending.INACCURATE))
    assert "by its integration alone, not its model" in said("trust", turn(estimate_of="integration"))


def test_a_run_without_a_settled_turn_says_nothing_and_its_page_has_no_such_chapter() -> None:
    failed = made_up_run(CASE, "reference", "failed")
    assert statements(CASE, failed) == []
    other = made_up_run(CASE, "mujoco")
    both = compare(CASE, {"reference": failed, "mujoco": other})
    assert leading_statements(both) == statements(CASE, other)
    assert "What happens in a turn" not in text_of(one_run(compare(CASE, {"reference": failed})))


def test_the_page_says_it_all_and_that_of_the_thesis_does_not() -> None:
    result = compare(CASE, {name: made_up_run(CASE, name) for name in ("mujoco", "reference")})
    told = statements(CASE, result.runs["reference"])
    assert {"whip", "strokes", "sides", "stress", "drive", "bearings", "limit", "trust"} <= {each.topic for each in told}
    page = text_of(one_run(result))
    for each in told:
        assert plain(each.sentence) in page
    assert "What happens in a turn" not in text_of(one_run())
