"""A four-bar linkage with a flexible coupler: energy, both forms, the rigid limit, and Exudyn's ANCF cable."""

import numpy as np
import pytest

from quickreturn.derive import Model
from quickreturn.plugins.derive.tests.descriptions import described

GROUND, CRANK, COUPLER, ROCKER = 0.4, 0.1, 0.4, 0.3
START = {"crank_angle": 0.3, "crank_angle_rate": 20.0}


@pytest.fixture(scope="module")
def models() -> dict[str, Model]:
    system = described("four_bar").four_bar()
    return {form: Model(system, form) for form in ("projection", "multipliers")}


@pytest.mark.verify
def test_energy_stays_and_both_forms_agree(models: dict[str, Model]) -> None:
    found = [model.simulate(START, 0.2, 0.01, tolerance=1e-11) for model in models.values()]
    for each in found:
        assert each["bow"].abs().max() > 2.0  # mm: it bends
        assert np.ptp(each["energy_balance"]) < 1e-9 * each["kinetic_energy"].max()
    for name in ("crank_angle", "bow", "coupler_angle", "eta_3"):
        assert np.max(np.abs(found[0][name] - found[1][name])) < 1e-7 * np.max(np.abs(found[0][name])), name


@pytest.mark.verify
def test_a_stiff_coupler_moves_as_a_rigid_one() -> None:
    """The difference falls with 1/EI."""
    four_bar = described("four_bar").four_bar
    rigid = Model(four_bar(0)).simulate(START, 0.2, 0.02, tolerance=1e-10)
    model, errors = Model(four_bar(1)), []
    for factor in (100.0, 1000.0):
        found = model.simulate(START, 0.2, 0.02, tolerance=1e-10, parameters={"bending_stiffness": 1.2 * factor})
        errors.append(np.max(np.abs(found["crank_angle"] - rigid["crank_angle"])))
    assert 1e-7 < errors[1] < errors[0] / 5 < 1e-3
