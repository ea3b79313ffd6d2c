import numpy as np

from quickreturn.reference_model import columns


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
