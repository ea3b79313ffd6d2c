"""A crank whose drive is a table: a motor's curve, and speeds over the turn or over time.

By scipy's `pchip`, by a rigid machine of mass points in its own coordinates, in closed form, and from engine to engine.
"""

import dataclasses
import math
from typing import Any, Final

import numpy as np
import pytest
from scipy.integrate import quad, solve_ivp
from scipy.interpolate import PchipInterpolator

from quickreturn.cases.motion.of_turn import at_shaft
from quickreturn.engines.registry import engine
from quickreturn.engines.start import standard_start
from quickreturn.engines.trajectory import Columns
from quickreturn.reference_model.arrays import Array
from quickreturn.reference_model.mechanism import Drive, Mechanism, MotorCurve, PrescribedMotion, PrescribedSpeed, TorqueDrive
from quickreturn.reference_model.rigid import mean_crank_speed
from quickreturn.reference_model.table import Table
from tests.engines.scenes import run_24

ENGINES: Final = ("reference", "thesis", "exudyn", "mujoco")
#: A motor that run 24's crank takes through all of its pieces but the first and the last, whose slopes at the ends are not scipy's.
MOTOR: Final = Table(("crank_speed", "crank_torque"), (0.0, 4.0, 8.0, 12.0, 15.0, 20.0, 26.0), ((2.0, 2.2, 2.1, 1.2, 0.3, -0.6, -1.0),))
ANGLES: Final = np.radians([20.0, 70.0, 130.0, 200.0, 240.0, 310.0])
SPEEDS: Final = Table(("crank_angle", "crank_speed"), tuple(ANGLES), ((9.0, 10.5, 12.0, 11.0, 8.0, 8.5),))
TURNS: Final = np.concatenate([ANGLES + turn * 2.0 * np.pi for turn in (-1, 0, 1)])
TURNED: Final = PrescribedMotion(speed_table=SPEEDS, begins_at=math.pi)
BY_SCIPY: Final = PchipInterpolator(TURNS, np.tile(SPEEDS.values[0], 3))


def machine(drive: Drive, *, rigid: bool = False) -> Mechanism:
    """Run 24 with a light crank, so that the drive shows."""
    crank = {"drive": drive, "mass": 1.0, "center_of_mass": 0.0, "inertia": 5e-3}
    return run_24(crank=crank, base={"damping": 0.02}, **({"follower": {"bending_stiffness": math.inf}} if rigid else {}))


def run(name: str, scene: Mechanism, duration: float = 0.5, **settings: Any) -> Columns:
    tool = engine(name)
    chosen = dataclasses.replace(tool.settings_for(tool.default_accuracy, scene), **settings)
    return tool.prepare(scene, standard_start(scene), chosen).advance(duration, 1e-3).columns


def rms(values: Array) -> float:
    return float(np.sqrt(np.mean(np.square(values))))


@pytest.mark.parametrize("name", ENGINES)
@pytest.mark.parametrize("way", [1.0, -1.0])
def test_a_straight_curve_is_torque_and_damping(name: str, way: float) -> None:
    """To the rounding of formulas; `thesis`, whose integrator chooses its steps by it, to its tolerance. Torque and work at the shaft."""
    torque, damping = way * 1.3, 0.08
    free = torque / damping
    points = sorted((0.0, free))
    curve = Table(("crank_speed", "crank_torque"), tuple(points), (tuple(torque - damping * speed for speed in points),))
    drives = TorqueDrive(torque=torque, damping=damping, initial_speed=0.7 * free), MotorCurve(torque_table=curve, initial_speed=0.7 * free)
    assert drives[0].balanced_speed == pytest.approx(drives[1].balanced_speed, rel=1e-15)
    assert mean_crank_speed(machine(drives[0])) == pytest.approx(mean_crank_speed(machine(drives[1])), rel=1e-9)
    straight, tabled = (run(name, machine(drive)) for drive in drives)
    shaft = at_shaft(straight, damping)
    for column in ("crank_angle", "crank_speed", "tip_deflection", "slider_force", "crank_torque"):
        assert rms(shaft[column] - tabled[column]) < (1e-5 if name == "thesis" else 1e-8) * rms(tabled[column]), column
    # the trapezoidal rule over rows of 1 ms takes what the damping takes to a part in 1e5
    for column in ("drive_work", "dissipated_energy"):
        assert np.max(np.abs(shaft[column] - tabled[column])) < 1e-5 * np.max(straight["drive_work"]), column


@pytest.mark.parametrize(("name", "error"), [("reference", 2e-5), ("thesis", 1e-6), ("mujoco", 1e-4), ("exudyn", 1e-4)])
def test_a_motor_turns_a_rigid_machine(name: str, error: float) -> None:
    """(J + I g²) q'' + I g g' q'² = T - c g² q' with g = dq2/dq1; rows of `reference` within a step across a point are off by 1e-6."""
    scene = machine(MotorCurve(torque_table=MOTOR, initial_speed=6.0), rigid=True)
    r, d, follower, tip, base = scene.crank.length, scene.pivot_distance, scene.follower, scene.tip_body, scene.base
    about_P = base.inertia + follower.mass_per_length * follower.length**3 / 3.0 + tip.inertia + tip.mass * follower.length**2
    curve = PchipInterpolator(MOTOR.points, MOTOR.values[0])

    def rate(_: float, y: Array) -> list[float]:
        g = 1j * r * np.exp(1j * y[0]) / (r * np.exp(1j * y[0]) - d)
        ratio, slope = g.imag, (1j * g - g * g).imag
        torque = float(curve(y[1])) - base.damping * ratio**2 * y[1] - about_P * ratio * slope * y[1] ** 2
        return [y[1], torque / (scene.crank_inertia + about_P * ratio**2)]

    found = run(name, scene)
    right = solve_ivp(rate, (0.0, 0.5), [math.pi, 6.0], rtol=1e-11, atol=1e-12, t_eval=found["time"])
    assert 4.0 < right.y[1].min() < 8.0
    assert 15.0 < right.y[1].max() < 20.0
    for column, values in (("crank_angle", right.y[0]), ("crank_speed", right.y[1]), ("crank_torque", curve(right.y[1]))):
        assert rms(found[column] - values) < error * rms(values), column


@pytest.mark.parametrize("name", ENGINES)
def test_constant_rows_are_a_constant_speed(name: str) -> None:
    flat = Table(SPEEDS.names, SPEEDS.points, ((9.0,) * len(ANGLES),))
    later = Table(("time", "crank_speed"), (0.0, 0.2), ((9.0, 9.0),))
    constant, *tabled = (
        run(name, machine(drive), 0.2)
        for drive in (PrescribedSpeed(speed=9.0), *(PrescribedMotion(speed_table=table, begins_at=math.pi) for table in (flat, later)))
    )
    for column in ("crank_angle", "tip_deflection", "slider_force", "crank_torque", "drive_work"):
        for one in tabled:
            assert rms(one[column] - constant[column]) < 1e-8 * rms(constant[column]), column


@pytest.mark.parametrize("name", ENGINES)
@pytest.mark.parametrize("way", [1.0, -1.0])
def test_a_speed_over_the_turn_is_kept_and_its_work_balances(name: str, way: float) -> None:
    table = dataclasses.replace(SPEEDS, values=(tuple(way * speed for speed in SPEEDS.values[0]),))
    scene = machine(PrescribedMotion(speed_table=table, begins_at=math.pi))
    period = quad(lambda angle: 1.0 / BY_SCIPY(angle), 0.0, 2.0 * np.pi, limit=200, epsabs=1e-12)[0]
    assert mean_crank_speed(scene) == pytest.approx(way * 2.0 * np.pi / period, rel=1e-7)
    found = run(name, scene, 1.0)
    expected = way * BY_SCIPY(found["crank_angle"] % (2.0 * np.pi))
    # steps of `reference` and `exudyn` pass points, where the acceleration has a kink
    assert np.max(np.abs(found["crank_speed"] - expected)) < (1e-5 if name in ("thesis", "mujoco") else 1e-4) * 12.0
    turned = np.interp(2.0 * np.pi, way * (found["crank_angle"] - math.pi), found["time"])
    assert turned == pytest.approx(period, abs=1e-5)
    energy = found["kinetic_energy"] + found["strain_energy"] + found["dissipated_energy"] - found["drive_work"]
    assert np.ptp(energy) < 3e-4 * np.max(found["kinetic_energy"])  # the second order of powers over rows or steps


@pytest.mark.parametrize("name", ENGINES)
@pytest.mark.parametrize("way", [1.0, -1.0])
def test_a_speed_over_time_runs_up_as_its_cubic_and_stays(name: str, way: float) -> None:
    table = Table(("time", "crank_speed"), (0.1, 0.4), ((way * 4.0, way * 10.0),))
    found = run(name, machine(PrescribedMotion(speed_table=table, begins_at=math.pi)))
    u = np.clip((found["time"] - 0.1) / 0.3, 0.0, 1.0)
    speed = 4.0 + 6.0 * u**2 * (3.0 - 2.0 * u)
    angle = 4.0 * found["time"] + 6.0 * (0.3 * u**3 * (1.0 - 0.5 * u) + np.maximum(found["time"] - 0.4, 0.0))
    assert np.max(np.abs(way * found["crank_speed"] - speed)) < 1e-4 * 10.0  # as above
    assert np.max(np.abs(way * (found["crank_angle"] - math.pi) - angle)) < 1e-5


@pytest.mark.parametrize("drive", [MotorCurve(torque_table=MOTOR, initial_speed=8.0), TURNED], ids=["motor", "speeds"])
def test_engines_agree(drive: Drive) -> None:
    """To 2 %: `mujoco`'s usual error in the deflection is 0.7 %, and that of a start that makes the arm ring is larger."""
    scene = machine(drive)
    right = run("reference", scene)
    for name in ("mujoco", "exudyn"):
        found = run(name, scene)
        for column in ("tip_deflection", "drive_work"):
            assert rms(found[column] - right[column]) < 0.02 * rms(right[column]), (name, column)
