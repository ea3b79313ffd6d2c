"""Sensitivities by differentiation against differences of simulations, and against a closed form."""

from collections.abc import Callable

import numpy as np
import pytest

from quickreturn.derive import Model, System, sensitivities
from quickreturn.plugins.derive.tests.descriptions import described


def test_on_a_rod_at_prescribed_speed_they_have_a_closed_form() -> None:
    """Of r = r0 cosh(w t): dr/dw = r0 t sinh(w t)."""
    found = sensitivities(Model(described("bead").bead_on_rod(prescribed=True)), ["speed"], {"r": 0.1}, 1.0, 0.1, tolerance=1e-11)
    t = found["time"]
    np.testing.assert_allclose(found["r by speed"], 0.1 * t * np.sinh(2.0 * t), atol=1e-9)
    assert found.attrs["units"]["r by speed"] == "m/(rad/s)"


SYSTEMS: dict[str, Callable[[], System]] = {
    "four-bar": lambda: described("four_bar").four_bar(1),
    "bead": described("bead").bead_on_pendulum,
    "quick-return": lambda: described("quick_return").quick_return(described("quick_return").one_cubic),
}


@pytest.mark.parametrize(
    ("name", "to", "start"),
    [
        ("bead", ["length", "stiffness"], {"theta": 1.0, "r": 0.6}),
        pytest.param("four-bar", ["rocker", "bending_stiffness"], {"crank_angle": 0.3, "crank_angle_rate": 20.0}, marks=pytest.mark.verify),
        pytest.param("quick-return", ["length", "crank_damping"], {"crank_angle": 3.0, "crank_speed": 16.6}, marks=pytest.mark.verify),
    ],
)
def test_they_are_differences_of_simulations(name: str, to: list[str], start: dict[str, float]) -> None:
    model = Model(SYSTEMS[name]())
    duration, tolerance = 0.1, 1e-11
    found = sensitivities(model, to, start, duration, duration / 2, tolerance=tolerance)
    for name in to:
        step = 1e-4 * (abs(model.parameters[name]) or 1.0)
        values = [
            model.simulate(start, duration, duration / 2, tolerance=tolerance, parameters={name: model.parameters[name] + k * step})
            for k in (-2, -1, 1, 2)
        ]
        difference = (values[0] - 8 * values[1] + 8 * values[2] - values[3]) / (12 * step)
        energy = np.max(values[0]["kinetic_energy"])
        for output, unit in model.units.items():  # differences of fourth order, and the simulations' tolerance over the step
            if output == "time":
                continue
            size = max(np.max(np.abs(values[0][output])), energy if unit == "J" else 0.0)
            ours, rounding = found[f"{output} by {name}"], 100 * tolerance * size / step
            assert np.max(np.abs(ours - difference[output])) <= 1e-6 * np.max(np.abs(ours)) + rounding, (name, output)
