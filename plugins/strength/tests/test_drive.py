"""What motor, flywheel and bearings are chosen by: closed forms, virtual work, a crank that is let free, and claims of engines."""

import dataclasses
import itertools
import math
from functools import cache
from typing import Final

import numpy as np
import pytest
from scipy.special import gamma

from quickreturn.cases.files.case import written_document
from quickreturn.cases.files.written import as_toml
from quickreturn.cases.library import library_case, load_case
from quickreturn.cases.motion.catalogue import MEASURES, numbers
from quickreturn.cases.motion.endings import Ending
from quickreturn.cases.motion.number import Number
from quickreturn.cases.motion.of_turn import by_spacing, declared
from quickreturn.cases.motion.request import Run
from quickreturn.cases.running.key import hash_of
from quickreturn.engines.own.reference import ReferenceEngine, ReferenceSettings
from quickreturn.engines.start import standard_start
from quickreturn.plugins.strength.measures import EXPONENTS, HARMONICS, equivalent_load
from quickreturn.plugins.studies.sweep.rows import MeasureRequest, row
from quickreturn.reference_model.arrays import Array
from quickreturn.reference_model.mechanism import Base, Drive, Mechanism, MotorCurve, PrescribedSpeed, TorqueDrive
from quickreturn.reference_model.scene_values import changed
from quickreturn.reference_model.table import Table
from quickreturn.reference_model.tip import Tip
from tests.engines.scenes import run_24
from tests.verification.random_machines import sensible_machines
from tests.witnesses import WITNESSES

SPEED: Final = 12.0  # rad/s
WANTED: Final = 0.02
NAMES: Final = (
    *(
        name
        for name in MEASURES
        if (name.startswith(("torque.", "flywheel.", "equivalent.")) or name.endswith(("_power", ".crank_torque")))
        and name != "equivalent.stress"  # of the arm
    ),
    *("turn.driven_energy", "turn.returned_energy", "turn.pivot_angle"),
)


def turn_of(torque: Array, angle: Array, **columns: Array) -> dict[str, Array]:
    """A turn at `SPEED` in either direction."""
    speed = np.full(angle.size, math.copysign(SPEED, angle[-1] - angle[0]))
    return {"time": (angle - angle[0]) / speed[0], "crank_angle": angle, "crank_speed": speed, "crank_torque": torque, **columns}


def of_turn(turn: dict[str, Array], wanted: float | None = WANTED) -> dict[str, Number]:
    """The numbers of a turn of run 24's crank at a prescribed speed, without an engine's estimate."""
    mechanism = changed(run_24(crank={"drive": PrescribedSpeed(speed=SPEED)}), {"crank.wanted_fluctuation": wanted})
    return numbers(mechanism, Run(engine="made up", estimate_of="total", status=Ending.SETTLED, cycle=turn))


@pytest.mark.parametrize("rows", [61, 400, 2001])
@pytest.mark.parametrize("turning", [1.0, -1.0])
def test_a_torque_of_sines_has_its_numbers(rows: int, turning: float) -> None:
    mean, amplitude, phase, third = 1.5, 4.0, 0.7, 0.9
    angle = np.pi + turning * np.linspace(0.0, math.tau, rows)
    torque = mean + amplitude * np.cos(angle - phase) + third * np.sin(3.0 * angle)
    found = of_turn(turn_of(turning * torque, angle))
    exact = {
        "mean.crank_torque": turning * mean,
        "mean.drive_power": SPEED * mean,
        "rms.crank_torque": math.sqrt(mean**2 + (amplitude**2 + third**2) / 2.0),
        "torque.harmonic_1": amplitude,
        "torque.harmonic_2": 0.0,
        "torque.harmonic_3": third,
        "torque.harmonic_1.phase": phase if turning > 0.0 else phase - math.pi,
        "torque.harmonic_3.phase": turning * math.pi / 2.0,
    }
    exact["rms.drive_power"] = SPEED * exact["rms.crank_torque"]
    assert {name: found[name].value for name in exact} == pytest.approx(exact, abs=1e-12)  # evenly spaced rows sum sines exactly


@pytest.mark.parametrize("rows", [60, 61, 400, 401, 2001])
def test_a_torque_of_one_sine_drives_and_returns_as_the_closed_form_says(rows: int) -> None:
    mean, amplitude = 1.5, 4.0
    angle = np.pi + 0.3 + np.linspace(0.0, math.tau, rows)
    found = of_turn(turn_of(mean + amplitude * np.cos(angle), angle))
    half = math.acos(mean / amplitude)  # half the angle over which the machine drives the motor
    returned = 2.0 * (amplitude * math.sin(half) - mean * half)
    exact = {
        "turn.returned_energy": returned,
        "turn.driven_energy": math.tau * mean + returned,
        "peak.drive_power": SPEED * (mean + amplitude),
        "peak.returned_power": SPEED * (amplitude - mean),
        "flywheel.energy": 2.0 * amplitude,
        "flywheel.inertia": 2.0 * amplitude / (WANTED * SPEED**2),
    }
    for name, value in exact.items():
        assert abs(found[name].value - value) <= found[name].measurement, name
        assert found[name].measurement < 20.0 * value / rows**2, name


def test_what_a_turn_does_not_have_is_no_number() -> None:
    angle = np.pi + np.linspace(0.0, math.tau, 15)  # seven harmonics
    found = of_turn(turn_of(2.0 + np.cos(angle), angle), None)
    assert [order for order in range(1, HARMONICS + 1) if math.isnan(found[f"torque.harmonic_{order}"].value)] == [8]
    assert math.isnan(found["flywheel.inertia"].value)  # no fluctuation is wanted
    constant = of_turn(turn_of(np.full(15, 2.0), angle))
    assert constant["torque.harmonic_1"].value == constant["flywheel.energy"].value == constant["turn.returned_energy"].value == 0.0
    assert math.isnan(constant["torque.harmonic_1.phase"].value)
    free = Run(engine="made up", estimate_of="total", status=Ending.SETTLED, cycle=turn_of(np.full(15, 2.0), angle))
    of_free = numbers(run_24(), free)
    assert all(math.isnan(of_free[name].value) for name in NAMES if name.startswith(("torque.", "flywheel.")))
    assert of_free["mean.drive_power"].value == pytest.approx((2.0 - run_24().crank.drive.damping * SPEED) * SPEED)  # type: ignore[union-attr]


STRAIGHT: Final = Table(("crank_speed", "crank_torque"), (0.0, 0.9 / 0.0277232), ((0.9, 0.0),))
LINEAR: Final = TorqueDrive(torque=0.9, damping=0.0277232, initial_speed=32.4)


@pytest.mark.parametrize("motor", [LINEAR, MotorCurve(torque_table=STRAIGHT, initial_speed=32.4)], ids=["linear", "curve"])
def test_the_shaft_of_a_machine_driven_by_a_torque_carries_what_its_parts_lose(motor: Drive) -> None:
    """Torque and damping as of a motor at nearly its no-load speed: 0.9 N m and 29 W by the torque alone, of which 0.1 % do work."""
    parts = {"base": Base(inertia=1e-4, damping=1e-3), "tip": None, "gravity": (0.0, 0.0)}
    arm = dataclasses.replace(run_24().follower, bending_stiffness=20.0, damping=0.0)
    scene = dataclasses.replace(RIGID, crank=dataclasses.replace(RIGID.crank, drive=motor, inertia=5e-3), follower=arm, **parts)
    names = ("mean.drive_power", "mean.crank_torque", "mean.crank_speed", "rms.follower_rate", "turn.driven_energy", "turn.returned_energy")
    extremes = ("min.crank_torque", "max.crank_torque", "min.crank_speed", "max.crank_speed", "turn.drive_work")
    found = row([scene], MeasureRequest(measures=(*names, "period", *extremes)))
    power, torque, speed, rate, given, back, period, least, most, slowest, fastest, work = found.values[0]
    assert found.statuses == ("settled",)
    assert power == pytest.approx(1e-3 * rate**2, rel=1e-3)  # of the brake in P
    assert torque == pytest.approx(0.9 - 0.0277232 * speed, rel=1e-6)
    assert given - back == pytest.approx(power * period, rel=1e-3)
    assert work == pytest.approx(power * period, rel=1e-3)
    assert (least, most) == pytest.approx((0.9 - 0.0277232 * fastest, 0.9 - 0.0277232 * slowest), rel=1e-4)
    assert np.all(found.errors[0][:2] < 0.1 * found.values[0][:2])


def bearings(force: Array, angle: Array) -> dict[str, float]:
    """Equivalent loads of the bearing P by kind."""
    columns = {"pivot_force_x": 0.6 * force, "pivot_force_y": -0.8 * force, "follower_angle": angle}
    return {kind: equivalent_load("pivot_force", exponent, columns) for kind, exponent in EXPONENTS.items()}


def test_equivalent_loads_have_their_closed_forms() -> None:
    t = np.linspace(0.0, math.tau, 4001)
    swinging = np.pi + 0.4 * np.sin(t)
    for kind, p in EXPONENTS.items():
        mean = gamma((p + 1.0) / 2.0) / (gamma(p / 2.0 + 1.0) * math.sqrt(math.pi))  # of |sin|^p over a turn
        for angle in (t, swinging):
            assert bearings(np.full(t.size, 7.0), angle)[kind] == pytest.approx(7.0, rel=1e-12)
        assert bearings(np.sin(t), t)[kind] == pytest.approx(mean ** (1.0 / p), rel=1e-6)
        # the load is largest where the swing is fastest: the mean of |cos|^(p + 1) over that of |cos|
        faster = gamma(p / 2.0 + 1.0) / (gamma((p + 3.0) / 2.0) * math.sqrt(math.pi)) / (2.0 / math.pi)
        assert bearings(np.cos(t), swinging)[kind] == pytest.approx(faster ** (1.0 / p), rel=1e-5)
    assert all(math.isnan(load) for load in bearings(np.sin(t), np.zeros(t.size)).values())  # it does not turn


def test_the_slider_s_pin_turns_by_the_angle_between_crank_and_follower() -> None:
    t = np.linspace(0.0, math.tau, 2001)
    columns = {"slider_force": -np.exp(np.cos(t)), "crank_angle": np.pi + t, "follower_angle": np.pi - 0.4 * np.sin(t)}
    turned = 1.0 + 0.4 * np.cos(t)  # rate of the angle
    exact = (np.mean(np.exp(3.0 * np.cos(t[:-1])) * turned[:-1])) ** (1.0 / 3.0)
    assert equivalent_load("slider_force", 3.0, columns) == pytest.approx(exact, rel=1e-6)


@pytest.mark.parametrize("rows", [100, 137, 1001])
@pytest.mark.parametrize("name", [name for name in NAMES if name in {each.name for each in declared()}])
def test_rows_change_no_number_beyond_its_claim(rows: int, name: str) -> None:
    """A torque and forces with a ringing of 17 times the crank's turn, and a kink."""
    one = next(each for each in declared() if each.name == name)
    turn = ringing(rows)
    value, claim, right = one.of(turn), by_spacing(one.of, turn, one.columns), one.of(ringing(100_001))
    assert abs(value - right) <= claim + 1e-12
    assert rows < 1000 or claim <= 0.02 * max(abs(right), 0.1)


@cache
def ringing(rows: int) -> dict[str, Array]:
    """A turn whose rows do not begin with the slider's period, as those of a cycle: the last step is shorter."""
    turned = np.append(np.arange(rows - 1) / (rows - 1.4), 1.0) * math.tau
    angle = np.pi + turned
    wave = np.cos(17.0 * angle - 0.4)
    torque = 0.4 + 2.0 * np.sin(angle) + 0.7 * np.sin(2.0 * angle) + 0.5 * np.abs(np.cos(angle / 2.0)) + 0.2 * wave
    forces = {
        name: 3.0 * np.cos(k * angle) + wave for k, name in enumerate(("pivot_force_x", "pivot_force_y", "crank_force_x", "crank_force_y"))
    }
    return turn_of(
        torque, angle, **forces, slider_force=np.sin(angle) + 0.3 * wave, follower_angle=np.pi + 0.4 * np.sin(angle) + 0.1 * np.cos(angle)
    )


#: A machine whose every part does work: masses in a field, a brake in the pivot, and a tool.
RIGID: Final = run_24(
    crank={"drive": PrescribedSpeed(speed=SPEED)},
    base=Base(inertia=2e-3, damping=0.05),
    tip=Tip(mass=0.4, inertia=3e-3, center_of_mass=0.03),
    gravity=(1.0, -9.80665),
    follower={"bending_stiffness": math.inf},
)


def virtual_work(mechanism: Mechanism, angle: Array, speed: float) -> Array:
    """Torque of the drive, N m: what the inertia, the weights and the brake do, over the crank angle; kinematics by complex numbers."""
    beam, tip, crank = mechanism.follower, mechanism.tip_body, mechanism.crank
    arm, reach = crank.length * np.exp(1j * angle), beam.length + tip.center_of_mass
    ratio = 1j * arm / (arm - mechanism.pivot_distance)
    q2, first, second = np.angle(mechanism.pivot_distance - arm) + np.pi, ratio.imag, (1j * ratio - ratio**2).imag
    inertia = mechanism.base.inertia + beam.mass * beam.length**2 / 3.0 + tip.inertia + tip.mass * reach**2
    lever, (g1, g2) = beam.mass * beam.length / 2.0 + tip.mass * reach, mechanism.gravity
    weight = lever * (g2 * np.cos(q2) - g1 * np.sin(q2))
    of_crank = crank.mass * crank.center_of_mass * (g2 * np.cos(angle) - g1 * np.sin(angle))
    return (inertia * speed**2 * second + mechanism.base.damping * speed * first - weight) * first - of_crank


def test_the_drive_of_a_rigid_machine_does_the_virtual_work() -> None:
    angle = np.pi + np.linspace(0.0, math.tau, 20_001)
    torque = virtual_work(RIGID, angle, SPEED)
    exact = {name: found.value for name, found in of_turn(turn_of(torque, angle)).items()}
    names = [name for name in NAMES if name in exact and not name.startswith(("equivalent.", "turn.pivot"))]
    for order in range(1, HARMONICS + 1):
        parts = [2.0 * np.mean(torque[:-1] * wave(order * angle[:-1])) for wave in (np.cos, np.sin)]
        assert [exact[f"torque.harmonic_{order}.{part}"] for part in ("cos", "sin")] == pytest.approx(parts, abs=1e-12)
    scene = changed(RIGID, {"crank.wanted_fluctuation": WANTED})
    found = row([scene], MeasureRequest(measures=tuple(names)))
    for name, value, error in zip(names, found.values[0], found.errors[0], strict=True):
        assert abs(value - exact[name]) <= error + 1e-12, name
        if not name.endswith(".phase"):
            size = exact["rms.crank_torque"] if name.startswith(("torque.", "mean.")) else abs(exact[name])
            assert abs(value - exact[name]) <= (1e-6 if name.startswith("torque.") else WITNESSES["measure", name].largest) * size, name


@pytest.mark.parametrize("wanted", [0.02, 0.005])
def test_a_crank_with_the_flywheel_fluctuates_as_wanted(wanted: float) -> None:
    """A motor of constant torque, the mean of what the prescribed speed takes, turns a crank that is free and has that inertia."""
    angle = np.pi + np.linspace(0.0, math.tau, 4001)
    torque = virtual_work(RIGID, angle, SPEED)
    exact = of_turn(turn_of(torque, angle), wanted)
    drive = TorqueDrive(torque=exact["mean.crank_torque"].value, damping=0.0, initial_speed=SPEED)
    crank = dataclasses.replace(
        RIGID.crank, drive=drive, inertia=exact["flywheel.inertia"].value - RIGID.crank.mass * RIGID.crank.center_of_mass**2
    )
    free = dataclasses.replace(RIGID, crank=crank)
    simulation = ReferenceEngine().prepare(free, standard_start(free), ReferenceSettings(tolerance=1e-9))
    speed = simulation.advance(1.05 * math.tau / SPEED, 1.05 * math.tau / SPEED / 2000).columns["crank_speed"]
    # a speed that varies by so much changes the loads of inertia by twice that, in the second order of what it changes here
    assert np.ptp(speed) / speed.mean() == pytest.approx(wanted, rel=WITNESSES["measure", "flywheel.inertia"].largest)


def test_a_stored_measure_belongs_to_the_wanted_fluctuation() -> None:
    """It moves nothing, but a row of a sweep holds the flywheel's inertia."""
    case = load_case("shaper-cutting", {"crank.wanted_fluctuation": "0.01"})
    assert case.mechanism.crank.wanted_fluctuation == 0.01
    assert hash_of(case.mechanism) != hash_of(load_case("shaper-cutting").mechanism)
    assert '# wanted_fluctuation = "..."' in as_toml(written_document(load_case("example")))


def beyond_claims(scene: Mechanism, engine: str) -> dict[str, tuple[float, float]]:
    """Error and claim of each number whose error exceeds its claim, against `reference` at 1e-4."""
    truth, found = (row([scene], MeasureRequest(measures=NAMES, **asked)) for asked in ({"accuracy": 1e-4}, {"engine": engine}))
    assert (found.statuses, truth.statuses) == (("settled",), ("settled",))
    apart = found.values[0] - truth.values[0]
    assert np.array_equal(np.isnan(found.values[0]), np.isnan(truth.values[0]))
    assert np.isfinite(found.errors[0][np.isfinite(apart)]).all()
    turned = np.array([name.endswith(".phase") for name in NAMES])
    apart = np.abs(np.where(turned, np.angle(np.exp(1j * apart)), apart))
    claims = found.errors[0] + 1e-12
    return {name: (error, claim) for name, error, claim in zip(NAMES, apart, claims, strict=True) if error > claim}


@pytest.mark.parametrize("engine", ["reference", *(pytest.param(name, marks=pytest.mark.verify) for name in ("mujoco", "exudyn"))])
def test_claims_hold_against_a_run_at_a_finer_accuracy(engine: str) -> None:
    assert beyond_claims(library_case("example").mechanism, engine) == {}


@pytest.mark.verify
@pytest.mark.parametrize("number", [0, 1, 2, 3, 4, 5, 7])
def test_claims_hold_on_machines_drawn_at_random(number: int) -> None:
    """Every other machine turns at a prescribed speed. `mujoco` does not settle on number 6, and number 8 stands still."""
    scene = next(itertools.islice(sensible_machines(77), number, None)).mechanism
    if number % 2 and scene.crank_is_free:
        scene = changed(scene, {"crank.prescribed_speed": scene.crank.drive.initial_speed})
    assert [beyond_claims(scene, engine) for engine in ("reference", "mujoco")] == [{}, {}]
