"""Rows in lanes: the arithmetic, and rows of observables that do not depend on those beside them."""

import math
from typing import Any

import numpy as np
import pytest

from quickreturn.reference_model.model import BeamModel, ObservationFailed
from quickreturn.reference_model.motion.compiled_layout import parameters_at
from quickreturn.reference_model.motion.fields import interpolate_row
from quickreturn.reference_model.native.compilation import compiled
from quickreturn.reference_model.native.lane_records import MEMBERS_IN_LANES
from quickreturn.reference_model.native.lanes import lane_of, lanes_of, where_within, with_lane, zeros_like
from quickreturn.reference_model.native.memory import LANES, Placed, on_lines
from quickreturn.reference_model.native.pointers import array_at, numbers_at
from quickreturn.reference_model.shapes import hermite_elements
from quickreturn.reference_model.state import State
from tests.engines.scenes import run_24

in_lanes_at = array_at(MEMBERS_IN_LANES["Vector"])


@compiled
def _formulas(x: Any, y: Any, out: Any) -> bool:
    """Every operation, for numbers or for lanes."""
    z, turned = complex(x[0], y[0]), complex(y[0], -0.5)
    product, quotient = z * turned.conjugate() - 1j * x[0], 2.0 * z / y[0]
    out[0], out[1], out[2] = product.real, product.imag, quotient.imag
    out[3] = math.sqrt(x[0] ** 2 + abs(y[0])) - x[0] / 3 + math.copysign(2.0, y[0])
    out[4] = max(x[0], y[0]) if x[0] < 1e9 else 0.0
    out[5] = where_within(x[0], -0.5, y[0], x[0], 7.0)
    share = zeros_like(x[0])
    for lane in range(lanes_of(share)):
        share = with_lane(share, lane, math.tanh(lane_of(x[0], lane)))
    out[6] = -share
    return x[0] > y[0]


@compiled
def _of_number(x: int, y: int, out: int) -> bool:
    return _formulas(numbers_at(x, 1), numbers_at(y, 1), numbers_at(out, 7))


@compiled
def _of_lanes(x: int, y: int, out: int) -> bool:
    return _formulas(in_lanes_at(x, 1), in_lanes_at(y, 1), in_lanes_at(out, 7))


def test_lanes_compute_what_numbers_do() -> None:
    rng = np.random.default_rng(3)
    x, y, out = on_lines((1, LANES)), on_lines((1, LANES)), on_lines((7, LANES))
    x[:], y[:] = rng.normal(size=(2, 1, LANES))
    holds = _of_lanes(x.ctypes.data, y.ctypes.data, out.ctypes.data)
    alone = []
    for lane in range(LANES):
        one, other, found = x[:, lane].copy(), y[:, lane].copy(), np.empty(7)
        alone.append(_of_number(one.ctypes.data, other.ctypes.data, found.ctypes.data))
        np.testing.assert_allclose(out[:, lane], found, rtol=1e-14, atol=1e-15)
        z, turned = complex(one[0], other[0]), complex(other[0], -0.5)
        assert complex(*found[:2]) == pytest.approx(z * turned.conjugate() - 1j * one[0], rel=1e-14)
    assert any(alone)
    assert not holds  # a comparison holds where it holds in every lane
    y[:] = -np.abs(x) - 1.0
    assert _of_lanes(x.ctypes.data, y.ctypes.data, out.ctypes.data)


@compiled
def _table_row(address: int, s: int, out: int, size: int) -> int:
    return interpolate_row(parameters_at(address).tables, in_lanes_at(s, 1)[0], in_lanes_at(out, size))


@compiled
def _table_row_of_number(address: int, s: int, out: int, size: int) -> int:
    return interpolate_row(parameters_at(address).tables, numbers_at(s, 1)[0], numbers_at(out, size))


def test_each_lane_has_its_own_row_of_the_table() -> None:
    model = BeamModel.following(run_24(), 3)
    t = model.parameters.tables
    rng = np.random.default_rng(0)
    t = t._replace(coefficients=rng.uniform(-1.0, 1.0, t.coefficients.shape) / t.step ** np.arange(3, -1, -1)[:, None])
    placed, size = Placed(model.parameters._replace(tables=t)), t.coefficients.shape[2]
    intervals, parts = rng.integers(0, len(t.coefficients), LANES), rng.uniform(0.01, 0.99, LANES)
    s, rows, row = on_lines((1, LANES)), on_lines((size, LANES)), np.empty(size)
    s[0] = t.low + (intervals + parts) * t.step
    assert _table_row(placed.address, s.ctypes.data, rows.ctypes.data, size) == 0
    for lane, (interval, part) in enumerate(zip(intervals, parts, strict=True)):
        expected = np.polyval(t.coefficients[interval], part * t.step)
        np.testing.assert_allclose(rows[:, lane], expected, atol=1e-9)
        place = np.array([s[0, lane]])
        assert _table_row_of_number(placed.address, place.ctypes.data, row.ctypes.data, size) == 0
        np.testing.assert_allclose(row, expected, atol=1e-9)


def test_lanes_in_different_cells_are_refused() -> None:
    p = BeamModel.staying(run_24(), hermite_elements(run_24().follower.length, 6)).parameters
    cells = p.tables.slider_cell
    change = int(np.flatnonzero(np.diff(cells))[0])
    s = on_lines((1, LANES))
    s[0] = p.tables.low + (change + 0.5 + (np.arange(LANES) > 2)) * p.tables.step
    size = p.tables.coefficients.shape[2]
    assert _table_row(Placed(p).address, s.ctypes.data, on_lines((size, LANES)).ctypes.data, size) == -1


def _states(modes: int = 3) -> tuple[BeamModel, np.ndarray[Any, Any]]:
    model = BeamModel.following(run_24(), modes)
    return model, model.integrate(model.straight_state(1.0, 16.0), 1e-3, 3 * LANES, 1e-6).states


def test_a_row_does_not_depend_on_those_beside_it() -> None:
    model, states = _states()
    together = model.observe(states)
    for first in range(0, len(states), 7):
        for name, values in model.observe(states[first : first + 1]).items():
            size = float(np.sqrt(np.mean(together[name] ** 2))) or 1.0
            # round-off alone: the gap is the difference of two lengths, m
            allowed = 1e-15 if name == "constraint_gap" else 1e-12 * size
            assert abs(values[0] - together[name][first]) <= allowed, name


@pytest.mark.parametrize("bad", [0, 3, LANES, 2 * LANES + 1])
def test_the_rows_before_a_state_that_cannot_be_are_filled(bad: int) -> None:
    model, states = _states()
    good = model.observe(states[:bad]) if bad else {}
    State.of(states).s[bad] = 2.0 * model.parameters.L  # the slider's place
    with pytest.raises(ObservationFailed) as failed:
        model.observe(states)
    assert failed.value.row == bad
    for name, values in good.items():
        np.testing.assert_allclose(model.observe(states[:bad])[name], values, rtol=1e-13)
