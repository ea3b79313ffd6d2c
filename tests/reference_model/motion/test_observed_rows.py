"""Rows of observables: what they interpolate, that each stands for its own state, and conservation and balance over them."""

from typing import Any

import numpy as np
import pytest

from quickreturn.reference_model.mechanism import PrescribedSpeed
from quickreturn.reference_model.model import BeamModel, ObservationFailed
from quickreturn.reference_model.motion.equations import parameters_at
from quickreturn.reference_model.motion.fields import interpolate_row
from quickreturn.reference_model.native.compilation import compiled
from quickreturn.reference_model.native.memory import Placed
from quickreturn.reference_model.native.pointers import numbers_at
from quickreturn.reference_model.state import State
from tests.engines.scenes import run_24
from tests.reference_model.motion.beam_runs import balance, follower_energy, run
from tests.reference_model.thesis.thesis_runs import period, undriven


@compiled
def _table_row(address: int, s: float, out: int, size: int) -> int:
    return interpolate_row(parameters_at(address).tables, s, numbers_at(out, size))


def test_a_row_of_the_table_is_its_cubic() -> None:
    model = BeamModel.following(run_24(), 3)
    t = model.parameters.tables
    rng = np.random.default_rng(0)
    t = t._replace(coefficients=rng.uniform(-1.0, 1.0, t.coefficients.shape) / t.step ** np.arange(3, -1, -1)[:, None])
    placed, row = Placed(model.parameters._replace(tables=t)), np.empty(t.coefficients.shape[2])
    for interval in (0, 1, len(t.coefficients) - 1):
        part = rng.uniform(0.01, 0.99)
        assert _table_row(placed.address, t.low + (interval + part) * t.step, row.ctypes.data, len(row)) == t.slider_cell[interval]
        np.testing.assert_allclose(row, np.polyval(t.coefficients[interval], part * t.step), atol=1e-9)


def _states() -> tuple[BeamModel, np.ndarray[Any, Any]]:
    model = BeamModel.following(run_24(), 3)
    return model, model.integrate(model.straight_state(1.0, 16.0), 1e-3, 24, 1e-6).states


def test_a_row_does_not_depend_on_those_beside_it() -> None:
    model, states = _states()
    together = model.observe(states)
    for row in (0, 7, 24):
        for name, values in model.observe(states[row : row + 1]).items():
            assert values[0] == together[name][row], name


@pytest.mark.parametrize("bad", [0, 3, 24])
def test_the_rows_before_a_state_that_cannot_be_are_filled(bad: int) -> None:
    model, states = _states()
    State.of(states).s[bad] = 2.0 * model.parameters.L  # the slider's place
    with pytest.raises(ObservationFailed) as failed:
        model.observe(states)
    assert failed.value.row == bad


@pytest.mark.parametrize("modes", [3, 5])
def test_energy_is_conserved_over_twenty_cycles(modes: int) -> None:
    """The cubic tables in s limit it: the tabulated derivative is not the derivative of the table. Found: 2.4e-9 and 4.5e-10."""
    mechanism = undriven()
    model = BeamModel.following(mechanism, modes)
    _, columns = run(model, 20 * period(mechanism), 1000, 1e-10)
    assert np.ptp(balance(columns)) < 1e-8 * follower_energy(model, columns)
    # it depends on the place alone and does not add up: the last cycle is not worse than the first
    energy = np.abs(balance(columns) - balance(columns)[0])
    assert np.max(energy[-50:]) < 2.0 * np.max(energy[:50])


def test_work_of_a_prescribed_speed_balances_to_the_modes_truncation() -> None:
    """The torque is that of the slider force, which meets the projected equations only as well as the modes describe the follower."""
    mechanism, errors = run_24(crank={"drive": PrescribedSpeed(speed=17.0)}, gravity=(0.0, -9.81)), []
    for modes in (2, 4, 7):
        _, columns = run(BeamModel.following(mechanism, modes), 1.0, 2000, 1e-9)
        errors.append(np.ptp(balance(columns)) / np.ptp(columns["drive_work"]))
        torque = columns["crank_torque"]
        work = np.concatenate([[0.0], np.cumsum(0.5 * (torque[1:] + torque[:-1])) * 17.0 / 2000])
        # the torque shown is the one that does the work: trapezoidal rule on 2000 points, second order
        assert np.max(np.abs(work - columns["drive_work"])) < 2e-3 * np.ptp(columns["drive_work"])
    # found 5e-6 and 5e-8 with 2 and 7 modes
    assert errors[0] > 3.0 * errors[1] > 9.0 * errors[2]
    assert errors[2] < 2e-7
