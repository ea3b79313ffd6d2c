"""What happens in a turn: the numbers of each sentence, and the words that depend on them."""

import dataclasses
import math
from collections.abc import Mapping
from typing import Any

import numpy as np
import pytest
from scipy.integrate import quad

from quickreturn.cases.files.case import Case
from quickreturn.cases.library import load_case
from quickreturn.cases.motion.request import PeriodicOrbit
from quickreturn.cases.motion.time_scale import quasi_static_strain
from quickreturn.plugins.strength.loads import loads_in
from quickreturn.plugins.strength.turn import SENTENCES, Turn, statements
from quickreturn.reference_model.natural_modes import frozen_crank_modes
from tests.changed_run import changed_run
from tests.reports.pages import plain
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


def numbers(topic: str, found: Turn) -> Mapping[str, float]:
    """The numbers in the sentence."""
    told = SENTENCES[topic](found)
    assert told is not None
    return told[1]


def bump(degrees: float, height: float) -> Any:
    """A peak at a crank angle, in whichever turn."""
    return lambda angle: height * np.exp(-((np.remainder(angle - math.radians(degrees) + math.pi, 2.0 * math.pi) - math.pi) ** 2) / 0.02)


@pytest.mark.parametrize(
    ("at", "turning", "after", "words"),
    [
        (350.0, 1, -10.0, "10° before its middle"),
        (20.0, 1, 20.0, "20° after its middle"),
        (20.0, -1, -20.0, "20° before its middle"),
        (240.0, 1, -120.0, "before the quick return begins"),
        (140.0, 1, 140.0, "after the quick return has ended"),
    ],
)
def test_when_the_tip_whips(at: float, turning: int, after: float, words: str) -> None:
    found = turn(turning=turning, columns={"tip_acceleration": bump(at, -80.0)}, extreme_estimates=claims("tip_acceleration", 0.8))
    known = numbers("whip", found)
    assert known["tip_acceleration"] == pytest.approx(80.0, rel=1e-3)
    assert math.degrees(known["from_middle_of_return"]) == pytest.approx(after, abs=0.5)
    assert words in said("whip", found)
    loose = claims("tip_acceleration", 80.0)
    assert said("whip", turn(columns={"tip_acceleration": bump(at, 80.0)}, extreme_estimates=loose)) == ""


def claims(column: str, error: float) -> dict[str, dict[str, float]]:
    return {column: {"pre": error, "post": error}}


def test_how_long_the_strokes_take() -> None:
    """The arm of `whitworth` is square to the line of pivots with the crank at acos(50 mm / 120 mm) = 65.38 deg on either side of 0."""
    half, period = math.radians(HALF), 2.0 / 3.0
    known = numbers("strokes", turn())
    assert (known["working_time"], known["return_time"]) == pytest.approx([period * q / math.pi for q in (math.pi - half, half)], rel=1e-3)
    fully = turn(load_case("whitworth", {"crank.prescribed_speed": "90 rpm"}))
    assert numbers("strokes", fully)["return_time"] == pytest.approx(period * 65.38 / 180.0, rel=1e-3)
    assert "turns fully" in said("strokes", fully)
    short = load_case("example", {"crank.prescribed_speed": "90 rpm", "crank.length": "1 mm"})
    assert "the same time to 1 %" in said("strokes", turn(short))


@pytest.mark.parametrize(
    ("force", "angles"),
    [
        (lambda angle: 10.0 * np.cos(2.0 * angle), [45.0, 135.0, 225.0, 315.0]),
        (lambda angle: 10.0 * np.sin(angle + 0.2), [168.5, 348.5]),  # 0.2 rad are 11.5°
        (lambda angle: 7.0 + 4.0 * np.cos(angle), []),
        (lambda angle: 4.0 + 4.01 * np.cos(angle), []),  # below zero by less than is claimed
    ],
)
def test_where_the_force_changes_sign(force: Any, angles: list[float]) -> None:
    known = numbers("sides", turn(columns={"slider_force": force}, extreme_estimates=claims("slider_force", 0.05)))
    assert known["changes"] == len(angles)
    assert [math.degrees(known[f"at_{k}"]) for k in range(1, len(angles) + 1)] == pytest.approx(angles, abs=0.3)


def test_where_the_arm_is_stressed_most() -> None:
    found = turn()
    largest, known = found.motion.of(loads_in).stress.largest, numbers("stress", found)  # type: ignore[union-attr]
    assert (known["stress"], known["place"], known["crank_angle"]) == (largest.value, largest.place, largest.crank_angle)
    assert "the other way as much" in said("stress", found)  # a rigid motion at constant speed is antisymmetric
    more = {name: values + 0.05 * np.max(values) for name, values in found.run.cycle.items() if name.startswith("moment_")}
    assert "the other way as much" not in said("stress", Turn(CASE, changed_run(found.run, cycle=found.run.cycle | more)))
    moments = {f"moment_{k:02d}": {"pre": 1e6, "post": 1e6} for k in range(1, 12)} | {"moment_slider": {"pre": 1e6, "post": 1e6}}
    loose = found.run.measured.extreme_estimates | moments | {"moment_inboard": {"pre": 1e6, "post": 1e6}}
    assert said("stress", turn(extreme_estimates=loose)) == ""


def test_what_rings() -> None:
    found = turn()
    measures = [dataclasses.replace(each, first_mode_amplitude=3.0 if each.half == "post" else 2.0) for each in found.run.measured.measures]
    mean = np.mean(
        [frozen_crank_modes(CASE.mechanism, float(q), 1).frequencies[0] for q in np.linspace(0.0, 2.0 * math.pi, 48, endpoint=False)]
    )
    near, known = round(float(mean) / 1.5), numbers("ringing", turn(measures=tuple(measures)))
    assert (known["harmonic"], known["amplitude"], known["first_mode"]) == pytest.approx((near, 3.0, mean), rel=1e-3)
    assert abs(known["detuning"]) == pytest.approx(abs(mean / 1.5 / near - 1.0), rel=0.06)
    silent = [dataclasses.replace(each, first_mode_amplitude=None) for each in measures]
    assert "amplitude" not in numbers("ringing", turn(measures=tuple(silent)))
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
    known = numbers("drive", turn(columns=columns, **changes))
    assert (known["torque"], known["energy_given"], known["energy_back"]) == pytest.approx((13.0, given, back), rel=1e-3)
    columns["crank_torque"] = lambda angle: 20.0 + 10.0 * np.cos(angle)
    assert "energy_back" not in numbers("drive", turn(columns=columns, **changes))
    motor = load_case("rigid")
    told = turn(motor, columns={"crank_torque": 1.5, "crank_speed": SPEED}, extreme_estimates=claims("crank_torque", 0.01))
    assert numbers("drive", told)["torque"] == pytest.approx(1.5 - motor.mechanism.crank.drive.damping * SPEED)  # at the shaft


def test_what_the_bearings_carry() -> None:
    names = ("pivot_force_x", "pivot_force_y", "crank_force_x", "crank_force_y")
    columns = dict(zip(names, (bump(60.0, 30.0), bump(60.0, 40.0), bump(200.0, -5.0), 0.0), strict=True))
    errors = {name: {"pre": 0.1, "post": 0.1} for name in names}
    known = numbers("bearings", turn(columns=columns, extreme_estimates=errors))
    assert (known["P_force"], known["O_force"]) == pytest.approx((50.0, 5.0), rel=1e-4)
    assert said("bearings", turn(columns=columns, extreme_estimates={name: {"pre": 99.0, "post": 99.0} for name in names})) == ""


@pytest.mark.parametrize(
    ("multiplier", "error", "words"),
    [
        (0.5, 0.001, "after 7 turns"),  # 0.501^7 is 0.8 %, 0.501^6 is 1.6 %
        (1.2, 0.001, "grows 1.2-fold"),
        (1.0, 0.01, "neither grows nor dies away"),
        (0.001, 0.0105, "less than 1.15 %"),
    ],
)
def test_how_fast_a_disturbance_dies_away(multiplier: float, error: float, words: str) -> None:
    orbit = PeriodicOrbit(2.0 / 3.0, ((0.0, multiplier), (0.0, -multiplier)), multiplier < 1.0, 3, error, error)
    assert words in said("decay", turn(periodic_orbit=orbit))
    assert numbers("decay", turn(periodic_orbit=orbit))["multiplier"] == pytest.approx(multiplier)
    assert said("decay", turn(periodic_orbit=None)) == ""


def test_what_limits_the_speed() -> None:
    def strain(part: float) -> Any:
        def of(angle: Any) -> Any:
            rigid = quasi_static_strain(CASE.mechanism, CASE.mechanism.follower.strain_gauges[1], angle) * SPEED**2
            return rigid + part * np.sqrt(2.0 * np.mean(rigid**2)) * np.sin(9.0 * angle)

        return {"strain_2": of, "crank_speed": SPEED}

    mean = np.mean(
        [frozen_crank_modes(CASE.mechanism, float(q), 1).frequencies[0] for q in np.linspace(0.0, 2.0 * math.pi, 48, endpoint=False)]
    )
    order = math.floor(mean / 1.5)
    for part, verb in ((0.02, "grows about"), (0.5, "does not simply grow")):
        found = turn(columns=strain(part))
        known = numbers("limit", found)
        assert known["vibration"] == pytest.approx(part, rel=0.02)
        assert (known["order"], known["resonant_speed"]) == pytest.approx((order, 2.0 * math.pi * mean / order), rel=1e-3)
        assert verb in said("limit", found)
        assert "hardly drives it" in said("limit", found)
    driven = {"tip_acceleration": lambda angle: np.sin(angle) + 0.1 * np.sin(order * angle)}
    assert numbers("limit", turn(columns=driven))["share"] == pytest.approx(0.1, rel=0.02)
    heavy = load_case("example", {"crank.prescribed_speed": "90 rpm"})
    assert "gravity or the force on the tip bends the arm at any speed" in said("limit", turn(heavy, columns=strain(0.02)))
    fast = load_case("example", {"crank.prescribed_speed": "3000 rpm"})
    assert "order" not in numbers("limit", turn(fast))


def test_a_run_without_a_settled_turn_says_nothing() -> None:
    failed = made_up_run(CASE, "reference", "failed")
    assert statements(CASE, failed) == []
