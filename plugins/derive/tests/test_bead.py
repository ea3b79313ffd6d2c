"""A bead on a rod and on a pendulum: closed forms and what is conserved."""

import numpy as np
import pytest

from quickreturn.derive import Model, natural_frequencies
from quickreturn.plugins.derive.statics import Statics
from quickreturn.plugins.derive.tests.descriptions import described

BEAD = described("bead")
#: A hundred times the integration's tolerance: errors add up over some hundred steps.
TIGHT, CONSERVED = 1e-12, 1e-10


@pytest.mark.parametrize("form", ["projection", "multipliers"])
def test_on_a_rod_at_prescribed_speed_it_follows_the_hyperbolic_cosine(form: str) -> None:
    found = Model(BEAD.bead_on_rod(prescribed=True), form, feedback=0.0).simulate({"r": 0.1}, 2.0, 0.1, tolerance=TIGHT)
    speed, mass, start = 2.0, 0.1, 0.1
    np.testing.assert_allclose(found["r"], start * np.cosh(speed * found["time"]), rtol=CONSERVED)
    torque = 2.0 * mass * speed * found["r"] * start * speed * np.sinh(speed * found["time"])
    np.testing.assert_allclose(found["motor_force"], torque, rtol=CONSERVED, atol=CONSERVED)
    np.testing.assert_allclose(found["work"], found["kinetic_energy"] - found["kinetic_energy"][0], rtol=CONSERVED, atol=CONSERVED)


def test_on_a_free_rod_angular_momentum_and_energy_stay() -> None:
    found = Model(BEAD.bead_on_rod()).simulate({"r": 0.1, "theta_rate": 2.0}, 3.0, 0.01, tolerance=TIGHT)
    assert np.ptp(found["r"]) > 1.0
    for name in ("angular_momentum", "kinetic_energy"):
        assert np.ptp(found[name]) < CONSERVED * found[name][0], name


def test_on_a_pendulum_energy_stays_and_equilibrium_and_frequencies_have_closed_forms() -> None:
    model = Model(BEAD.bead_on_pendulum())
    found = model.simulate({"theta": 1.0, "r": 0.6}, 5.0, 0.05, tolerance=TIGHT)
    assert np.ptp(found["potential_energy"]) > 0.5
    assert np.ptp(found["energy_balance"]) < CONSERVED * found["kinetic_energy"].max()

    stiff = model.simulate({"theta": 1.0, "r": 0.6}, 0.5, 0.05, method="Radau", tolerance=1e-8)
    np.testing.assert_allclose(stiff["theta"], found["theta"][: len(stiff)], rtol=1e-5)  # of order five: errors add up

    length, rod, bead, stiffness, g = 1.0, 0.3, 0.1, 20.0, 9.81
    hangs = length / 2 + bead * g / stiffness
    rest = Statics(model).equilibrium({"theta": 0.2, "r": 0.4})
    np.testing.assert_allclose([rest["theta"], rest["r"]], [0.0, hangs], atol=1e-12)
    swinging = (rod * length / 2 + bead * hangs) * g / (rod * length**2 / 3 + bead * hangs**2)
    expected = np.sqrt([swinging, stiffness / bead]) / (2 * np.pi)
    np.testing.assert_allclose(natural_frequencies(model, rest), np.sort(expected), rtol=1e-12)
    np.testing.assert_allclose(natural_frequencies(model, rest, hold=["theta"]), expected[1:], rtol=1e-12)
