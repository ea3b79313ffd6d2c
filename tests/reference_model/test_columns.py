from quickreturn.reference_model import columns


def test_places_in_a_row_are_those_of_the_names() -> None:
    row = columns.OBSERVED[: columns.FIRST_OF_SHAPE]
    assert [getattr(columns, name.upper()) for name in row] == list(range(columns.FIRST_OF_SHAPE))
    assert columns.OBSERVED[columns.FIRST_OF_SHAPE : columns.FIRST_OF_MOMENTS] == tuple(f"shape_{k:02d}" for k in range(1, 12))
    assert columns.OBSERVED[columns.FIRST_OF_MOMENTS :] == tuple(f"moment_{k:02d}" for k in range(1, 12))
    assert (*columns.OBSERVED, *columns.JOINT_COLUMNS).index("joint_power") == columns.JOINT_POWER


def test_every_column_has_a_unit_and_a_meaning_and_those_of_the_contract_come_first() -> None:
    assert all(column.unit and column.meaning for column in columns.COLUMNS.values())
    required = [name for name, column in columns.COLUMNS.items() if column.required]
    assert list(columns.COLUMNS)[:13] == required
    assert list(columns.COLUMNS)[13:18] == ["crank_torque", "kinetic_energy", "strain_energy", "dissipated_energy", "constraint_gap"]


def test_a_follower_alone_has_the_torque_on_its_base_and_nothing_of_a_crank() -> None:
    kept = columns.of_follower_alone(dict.fromkeys(columns.OBSERVED, 1.0) | {"crank_torque": 2.0})
    assert kept["base_torque"] == 2.0
    assert not {"crank_torque", "crank_angle", "slider_force", "constraint_gap", "moment_slider", "crank_force_x"} & set(kept)
    assert {"tip_deflection", "drive_work", "shape_11", "moment_11", "pivot_force_y"} <= set(kept)
