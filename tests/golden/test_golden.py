"""The code reproduces its golden record within what is claimed; what differs is listed with its reason."""

import pytest

from quickreturn.cases.running.job import Executor, ThisProcess
from tests.golden.golden import KINDS, changes, differences, recorded, rows_of

#: Of every kind a few that are quick; the others belong to the long verification.
QUICK = {
    "trajectories": [("thesis-24", "reference"), ("thesis-17", "thesis")],
    "modes": [("thesis-24", "reference"), ("thesis-09", "mujoco")],
    "steady": [("thesis-24", "reference"), ("thesis-17", "reference")],
}
ENGINES = sorted({(kind, engine) for kind in KINDS for engine in recorded(kind)["engine"]})


def unexplained(kind: str, pairs: list[tuple[str, str]], executor: Executor | None = None) -> list[str]:
    """Clauses on what differs from the record without being listed in `changes.csv`."""
    then = {(row["case"], row["engine"]): row for row in recorded(kind).to_dict("records")}
    listed = [row for row in changes().to_dict("records") if row["kind"] == kind]
    found = []
    for now in rows_of(kind, pairs, executor).to_dict("records"):
        case, engine = now["case"], now["engine"]
        for clause in differences(then[case, engine], now):
            quantity = clause.partition(":")[0]
            fits = any(
                row["case"] in ("*", case) and row["engine"] in ("*", engine) and row["quantity"] in ("*", quantity) for row in listed
            )
            if not fits:
                found.append(f"{case}, {engine}, {clause}")
    return found


@pytest.mark.parametrize("kind", KINDS)
def test_a_few_numbers_are_as_recorded(kind: str) -> None:
    assert not unexplained(kind, QUICK[kind], ThisProcess())


@pytest.mark.verify
@pytest.mark.parametrize(("kind", "engine"), ENGINES)
def test_all_numbers_are_as_recorded(kind: str, engine: str) -> None:
    of_engine = recorded(kind)
    assert not unexplained(kind, [(case, engine) for case in of_engine[of_engine["engine"] == engine]["case"]])


@pytest.mark.parametrize("kind", KINDS)
def test_a_number_that_differs_is_told(kind: str) -> None:
    row = recorded(kind).to_dict("records")[0]
    numbers = (name for name, value in row.items() if isinstance(value, float) and value == value)
    quantity = next(name for name in numbers if name != "end" and not name.endswith("claim"))
    moved = row | {quantity: 1.5 * row[quantity]}
    assert [clause.partition(":")[0] for clause in differences(row, moved)] == [quantity]
    assert not differences(row, dict(row))


def test_every_listed_change_has_a_reason_and_belongs_to_the_record() -> None:
    for row in changes().to_dict("records"):
        assert len(row["reason"].split()) > 3
        table = recorded(row["kind"])
        assert row["case"] == "*" or row["case"] in set(table["case"])
        assert row["engine"] == "*" or row["engine"] in set(table["engine"])
        assert row["quantity"] in ("*", "status") or row["quantity"] in table.columns
