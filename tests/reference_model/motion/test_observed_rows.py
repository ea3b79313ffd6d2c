"""Rows of observables: what they interpolate, and that each stands for its own state."""

from typing import Any

import numpy as np
import pytest

from quickreturn.reference_model.model import BeamModel, ObservationFailed
from quickreturn.reference_model.motion.equations import parameters_at
from quickreturn.reference_model.motion.fields import interpolate_row
from quickreturn.reference_model.native.compilation import compiled
from quickreturn.reference_model.native.memory import Placed
from quickreturn.reference_model.native.pointers import numbers_at
from quickreturn.reference_model.state import State
from tests.engines.scenes import run_24


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
