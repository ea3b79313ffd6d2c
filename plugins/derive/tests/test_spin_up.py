"""The spin-up of a cantilever against its published lag and the linear theory of the rotating cantilever."""

import numpy as np
import pytest

from quickreturn.derive import Model
from quickreturn.plugins.derive.tests.descriptions import described
from tests.verification.literature.rotating_cantilever import frequencies, time_unit
from tests.verification.literature.spin_up import LITERATURE, fitted_vibration, linear_lag, scene


@pytest.mark.verify
def test_it_lags_as_published_and_swings_as_the_linear_theory_says() -> None:
    found = Model(described("spin_up").spin_up()).simulate({}, 30.0, 0.02, tolerance=1e-9)
    assert found["base_angle"].iloc[-1] == np.float64(6.0 * (30.0 - 7.5))
    lag, alone = -found["tip_deflection"].min(), scene()
    (published,) = (each for each in LITERATURE["number"] if each["quantity"] == "largest tip lag")
    assert abs(lag - published["value"]) < published["digits"]
    # linear theory leaves out the square of the lag over the length
    assert abs(lag / linear_lag(alone) - 1) < (lag / 10.0) ** 2
    steady = found[found["time"] >= 15.0]
    unit = time_unit(alone.follower)
    expected = frequencies(6.0 * unit, 1)[0] / unit / (2 * np.pi)
    swing = fitted_vibration(steady["time"].to_numpy(), steady["tip_deflection"].to_numpy(), expected)
    # five powers of x/L: from above, by Ritz's principle, by 6e-6 (four: 3e-4, six: 2e-7); the fit of one sinusoid leaves 1e-6
    assert -1e-6 < swing.frequency / expected - 1 < 1e-5
    assert np.ptp(found["energy_balance"]) < 1e-9 * found["kinetic_energy"].max()
