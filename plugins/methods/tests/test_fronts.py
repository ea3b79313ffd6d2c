"""Fronts, levels and times of rows with known numbers."""

from collections.abc import Sequence

import pytest
from hypothesis import given
from hypothesis import strategies as st

from quickreturn.plugins.methods.fronts import DEFLECTION, front, paced, standings
from quickreturn.plugins.methods.row import LEVELS, TIP, Row
from quickreturn.plugins.methods.studies import recorded_rows


def row(seconds: float, error: float | None, engine: str = "a", worst: float | None = None, calls: float | None = None) -> Row:
    if error is None:
        return Row(scene="one", engine=engine, status="failed")
    errors = {TIP: error, "slider_force": error if worst is None else worst, "strain_3": None}
    return Row(scene="one", engine=engine, errors=errors, solve_seconds=seconds, calls=calls)


def places(rows: Sequence[Row]) -> list[tuple[float, float | None]]:
    return [(each.seconds, each.error) for each in rows if each.completed]


positive = st.floats(1e-6, 1e3)


@given(st.lists(st.tuples(positive, st.none() | positive), max_size=12))
def test_the_front_is_what_no_row_beats(values: list[tuple[float, float | None]]) -> None:
    rows = [row(*value) for value in values]
    of_front = places(front(rows))
    assert of_front == sorted(of_front)
    for seconds, error in places(rows):
        beaten = any(
            s <= seconds and e <= error and (s, e) != (seconds, error) for s, e in places(rows) if e is not None and error is not None
        )
        assert beaten != ((seconds, error) in of_front)


@given(st.floats(0.2, 5.0), st.floats(1e-3, 1e3), st.floats(1.1e-4, 0.9e-1))
def test_between_the_runs_of_a_power_law_the_time_is_that_of_the_law(order: float, size: float, level: float) -> None:
    """Time = size error^(-1/order), and as many calls as a thousand a second."""
    errors = [10.0**-power for power in (1, 2, 3, 4)]
    rows = [row(size * error ** (-1.0 / order), error, calls=1e3 * size * error ** (-1.0 / order)) for error in errors]
    (found,) = standings(rows, level).values()
    assert found.seconds == pytest.approx(size * level ** (-1.0 / order), rel=1e-9)
    assert found.calls == pytest.approx(1e3 * found.seconds, rel=1e-9)
    assert found.row.error == max(error for error in errors if error <= level)
    assert standings(rows, 1e-5) == {}
    assert standings(rows, 0.5)["a"].seconds == rows[0].seconds


@given(st.lists(st.tuples(positive, st.floats(1e-6, 1.0)), max_size=30))
def test_rows_around_the_levels_give_the_times_of_the_whole_front(values: list[tuple[float, float]]) -> None:
    whole = front([row(*value) for value in values])
    kept = recorded_rows(whole, whole=False)
    assert len(kept) <= 2 * len(LEVELS) + 1
    assert [standings(kept, level) for level in LEVELS] == [standings(whole, level) for level in LEVELS]
    assert kept[-1:] == whole[-1:]


def test_the_worst_column_or_the_deflection_alone_decides() -> None:
    rows = [row(1.0, 1e-3, worst=5e-2), row(3.0, 1e-3, worst=2e-3), row(1.5, 4e-3, "b", worst=4e-3), row(0.1, None, "c")]
    assert list(standings(rows, 1e-2, DEFLECTION)) == ["a", "b"]
    worst = standings(rows, 1e-2)
    assert list(worst) == ["b", "a"]
    assert worst["a"].row is rows[1]
    assert 1.0 < worst["a"].seconds < 3.0


def test_times_follow_from_calls_and_the_least_time_of_one_of_the_same_size() -> None:
    """Other work of the machine doubled the time of the second run; one with other elements has a time of its own."""

    def counted(calls: float, each: float, elements: int) -> Row:
        settings = {"elements": elements, "tolerance": 0.1 / calls, "family": "x"}
        times = {"calls": calls, "call_seconds": each, "rows_seconds": 0.5, "solve_seconds": calls * each + 0.5}
        return Row(scene="one", engine="a", settings=settings, errors={TIP: 1.0 / calls}, **times)  # type: ignore[arg-type]

    quick, disturbed, larger, package = counted(100, 1e-2, 4), counted(200, 2e-2, 4), counted(100, 3e-2, 8), row(7.0, 0.1)
    found = paced([quick, disturbed, larger, package])
    assert [each.seconds for each in found] == pytest.approx([1.5, 2.5, 3.5, 7.0])
