"""A force and a mass that cross a beam, against the series and against the equations of the modes."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from quickreturn.derive import Model
from quickreturn.plugins.derive.tests.descriptions import described

LENGTH, MASS_PER_LENGTH, STIFFNESS, SPEED, FORCE = 10.0, 200.0, 2e6, 15.0, 5e3
SHAPES = 5
WAVES = np.pi * np.arange(1, SHAPES + 1) / LENGTH
CROSSING = LENGTH / SPEED


def test_a_force_gives_the_series_of_its_modes() -> None:
    """S. P. Timoshenko; L. Fryba, Vibration of Solids and Structures under Moving Loads, chapter 1."""
    found = Model(described("crossing_load").crossing_load(SHAPES)).simulate({}, CROSSING, CROSSING / 50, tolerance=1e-10)
    own, driving = WAVES**2 * np.sqrt(STIFFNESS / MASS_PER_LENGTH), WAVES * SPEED
    t = found["time"].to_numpy()[:, None]
    series = (np.sin(driving * t) - driving / own * np.sin(own * t)) / (own**2 - driving**2)
    eta = -2.0 * FORCE / (MASS_PER_LENGTH * LENGTH) * series
    for name, place in (("middle", np.full_like(t, LENGTH / 2)), ("under_load", SPEED * t)):
        expected = 1e3 * np.sum(eta * np.sin(WAVES * place), axis=1)
        np.testing.assert_allclose(found[name], expected, atol=1e-8 * np.max(np.abs(expected)))
    assert np.ptp(found["energy_balance"]) < 1e-8 * found["work"].max()


@pytest.mark.parametrize("form", ["projection", "multipliers"])
def test_a_mass_gives_the_equations_of_the_modes_with_its_inertia(form: str) -> None:
    """Of the point under the mass, (W(vt, t))'' = phi eta'' + 2 v phi' eta' + v^2 phi'' eta."""
    mass = 400.0
    model = Model(described("crossing_load").crossing_load(SHAPES), form)
    found = model.simulate({}, CROSSING, CROSSING / 50, tolerance=1e-10, parameters={"mass": mass})

    def rate(t: float, y: np.ndarray) -> np.ndarray:
        eta, speed, x = y[:SHAPES], y[SHAPES:], SPEED * t
        phi, slope, bend = np.sin(WAVES * x), WAVES * np.cos(WAVES * x), -(WAVES**2) * np.sin(WAVES * x)
        inertia = MASS_PER_LENGTH * LENGTH / 2 * np.eye(SHAPES) + mass * np.outer(phi, phi)
        bias = mass * (2 * SPEED * slope @ speed + SPEED**2 * bend @ eta)
        force = -STIFFNESS * WAVES**4 * LENGTH / 2 * eta - (FORCE + bias) * phi
        return np.concatenate([speed, np.linalg.solve(inertia, force)])

    expected = solve_ivp(rate, (0.0, CROSSING), np.zeros(2 * SHAPES), "DOP853", found["time"], rtol=1e-11, atol=1e-14).y[:SHAPES]
    np.testing.assert_allclose(found[[f"eta_{k + 1}" for k in range(SHAPES)]].T, expected, atol=1e-8 * np.max(np.abs(expected)))
    assert np.ptp(found["energy_balance"]) < 1e-8 * found["kinetic_energy"].max()
