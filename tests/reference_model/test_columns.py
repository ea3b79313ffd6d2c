"""Columns of a row and the parts of a state vector, in Python and in compiled code."""

import numpy as np
import pytest

from quickreturn.reference_model import columns
from quickreturn.reference_model.arrays import Array
from quickreturn.reference_model.compiled_state import state_at, state_without_slider_at
from quickreturn.reference_model.native.compilation import compiled
from quickreturn.reference_model.state import State


def _row() -> columns.Rows:
    """A row in which each field of one number has its place, and each numbered one counts from 1."""
    rows = np.zeros(1, columns.ROW)
    for k, name in enumerate(columns.ROW.names or ()):
        rows[0][name] = k if rows[0][name].shape == () else np.arange(1, rows[0][name].size + 1)
    return rows


def test_what_compiled_code_lays_down_in_a_field_is_found_under_the_name_of_the_column() -> None:
    found = columns.recorded_columns(columns.by_column(_row()), joint=True, spring=True)
    assert set(found) == {*columns.COLUMNS, *columns.JOINT_COLUMNS} - {"time", "base_torque", "axial_stretch"}
    for prefix, count in (("strain_", 3), ("shape_", 11), ("moment_", 11)):
        numbered = [name for name in found if name.startswith(prefix) and name[-1].isdigit()]
        assert [(int(name.removeprefix(prefix)), found[name][0]) for name in numbered] == [(k, k) for k in range(1, count + 1)]
    row = _row()[0]
    for name in ("crank_angle", "moment_slider", "crank_force_y", "joint_power"):
        assert found[name] == getattr(row, name)


def test_every_column_has_a_unit_and_a_meaning_and_those_of_the_contract_come_first() -> None:
    assert all(column.unit and column.meaning for column in columns.COLUMNS.values())
    required = [name for name, column in columns.COLUMNS.items() if column.required]
    assert list(columns.COLUMNS)[:13] == required
    assert list(columns.COLUMNS)[13:18] == ["crank_torque", "kinetic_energy", "strain_energy", "dissipated_energy", "constraint_gap"]


def test_a_follower_alone_has_the_torque_on_its_base_and_nothing_of_a_crank() -> None:
    kept = columns.recorded_columns(columns.by_column(_row()), alone=True)
    assert kept["base_torque"] == _row()[0].crank_torque
    assert not {"crank_torque", "crank_angle", "slider_force", "constraint_gap", "moment_slider", "crank_force_x"} & set(kept)
    assert {"tip_deflection", "drive_work", "shape_11", "moment_11", "pivot_force_y"} <= set(kept)


def test_a_model_that_knows_moments_by_curvature_has_none_of_a_rigid_follower() -> None:
    table = columns.by_column(_row())
    assert set(columns.recorded_columns(table)) - set(columns.recorded_columns(table, bends=False)) == set(columns.BENDING)


@compiled
def _begin_and_size(y: Array, n: int, m: int, slider: bool, found: Array) -> None:
    """To `found`: where the parts begin, and their sizes."""
    if slider:
        state = state_at(y.ctypes.data, n, m)
        for k, part in enumerate((state.q, state.eta, state.s, state.u, state.eta_rate, state.work)):
            found[k, 0], found[k, 1] = len(part), part.ctypes.data - y.ctypes.data
    else:
        other = state_without_slider_at(y.ctypes.data, n, m)
        for k, part in enumerate((other.q, other.eta, other.s, other.u, other.eta_rate, other.work)):
            found[k, 0], found[k, 1] = len(part), part.ctypes.data - y.ctypes.data


@pytest.mark.parametrize("n", [0, 1, 4])
@pytest.mark.parametrize("kind", ["closed", "open", "without slider"])
def test_compiled_code_finds_the_parts_where_python_does(n: int, kind: str) -> None:
    m, slider = n + 1 + (kind == "open"), kind != "without slider"
    y, found = np.arange(2.0 * m + 2 + slider + (kind == "open")), np.empty((6, 2))
    _begin_and_size(y, n, m, slider, found)
    parts = State.of(y, slider=slider)
    for (size, begin), part in zip(found, parts, strict=True):
        assert size == len(part)
        assert size == 0 or begin == part.ctypes.data - y.ctypes.data
    assert np.concatenate([parts.q, parts.s, parts.u, parts.work]).tolist() == y.tolist()
    assert (parts.eta.tolist(), parts.eta_rate.tolist()) == (parts.q[1 : n + 1].tolist(), parts.u[1 : n + 1].tolist())
