"""Functions by points: values against scipy, and motors and prescribed motions with closed forms."""

import casadi as ca
import numpy as np
import pytest
from scipy.interpolate import CubicSpline, PchipInterpolator

from quickreturn.derive import Model, System, turned, vector
from quickreturn.plugins.derive.machine_code import MachineCode


@pytest.mark.parametrize("smooth", [False, True])
@pytest.mark.parametrize("count", [2, 3, 12])
def test_values_and_slopes_are_those_of_scipy_and_outside_constant(count: int, smooth: bool) -> None:
    random, u = np.random.default_rng(count), ca.SX.sym("u")
    places, values = np.cumsum(random.uniform(0.1, 2.0, count)), random.normal(size=count)
    system, right = System("curve"), (CubicSpline if smooth else PchipInterpolator)(places, values)
    value = system.table("curve", (places, "1"), (values, "1"), smooth)(u)
    value = ca.substitute(value, ca.vertcat(*(symbol for symbol, _, _ in system.parameters.values())), ca.DM([1.0, 1.0]))
    code = MachineCode(u, ca.vertcat(value, ca.jacobian(value, u)), ["value", "slope"])
    for at in (*places, *random.uniform(places[0] - 1.0, places[-1] + 1.0, 50)):
        held = np.clip(at, places[0], places[-1])
        np.testing.assert_allclose(code(np.array([at])), [right(held), right(held, 1) * (held == at)], rtol=1e-12, atol=1e-12)


@pytest.mark.parametrize("times", [1.0, 1.5])
def test_a_motor_runs_up_to_its_speed_without_load(times: float) -> None:
    """Stall torque 0.9 N m, no load 310 rpm; beyond the last point the torque is the last one: zero."""
    system, idle = System("rotor"), 310 * np.pi / 30
    angle, inertia = system.coordinate("angle", "rad"), system.constants(inertia=(1, "g*m^2")).inertia
    system.body("rotor", inertia=inertia, angle=angle)
    system.load("motor", angle, system.table("motor", ([0, 310], "rpm"), ([0.9, 0.0], "N*m"))(system.rate(angle)))
    model = Model(system)
    found = model.simulate({}, 0.4, 0.02, parameters={"motor_y": times})
    np.testing.assert_allclose(found["angle_rate"] / idle, 1 - np.exp(-times * 0.9 / idle / 1e-3 * found["time"]), atol=1e-8)
    assert model.simulate({"angle_rate": 40.0}, 0.4, 0.1)["angle_rate"].iloc[-1] == 40.0


@pytest.mark.parametrize("smooth", [False, True])
def test_a_prescribed_motion_keeps_the_balance_of_energy_where_its_acceleration_jumps(smooth: bool) -> None:
    """A recorded motion with noise; `simulate` refuses a balance that changes."""
    system, times = System("press"), np.linspace(0.0, 2.0, 41)
    u = system.constants(m=(1, "m"), kg=(1, "kg"))
    angle, rod, block = system.coordinate("angle", "rad"), system.coordinate("rod", "rad"), system.coordinate("block", "m", guess=0.4)
    system.body("crank", inertia=1e-3 * u.kg * u.m**2, angle=angle)
    system.body("block", 0.1 * u.kg, vector(block, 0))
    system.loop("pin", turned(angle, 0.1 * u.m) + turned(rod, 0.3 * u.m) - vector(block, 0), gives=[rod, block])
    noisy = np.sin(3.0 * times) + 1e-3 * np.random.default_rng(0).normal(size=41)
    motion = system.table("motion", (times, "s"), (np.degrees(noisy), "deg"), smooth)
    system.loop("drive", angle - motion(system.time), "rad", gives=[angle])
    np.testing.assert_allclose(Model(system).simulate({}, 2.0, 0.05)["angle"], noisy, atol=1e-9)
