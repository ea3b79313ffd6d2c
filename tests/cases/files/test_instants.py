"""Rows of a table: those at an event, time with too few digits, gaps, and noise of a known size."""

import math
from pathlib import Path

import numpy as np
import pytest

from quickreturn.cases.files.errors import CaseError
from quickreturn.cases.files.instants import DEVIATIONS, gaps, scatter
from quickreturn.cases.files.recorded import read_table, table_of

#: As Dymola writes an event at 0.02 s, at which the force jumps, and one at 0.05 s at which nothing does.
ROWS = [(0.01 * k, 0.1 * k, 5.0 + k) for k in range(12)]
EVENTS = [*ROWS[:2], (0.02, 0.2, -3.0), *ROWS[2:5], (0.05, 0.5 * (1.0 + 2e-6), 10.0), *ROWS[5:]]
NOTED = ("1 doubled row left out", "a jump at 0.02 s: of the rows at this time the last is kept")
#: A smooth course.
TIME = np.arange(1000) * 1e-3
SMOOTH = 3.0 * np.sin(2.0 * np.pi * 7.3 * TIME)


def columns(rows: list[tuple[float, float, float]]) -> dict[str, list[float]]:
    time, angle, force = (list(column) for column in zip(*rows, strict=True))
    return {"time": time, "crank_angle": angle, "slider_force": force}


def file_of(folder: Path, given: dict[str, list[float]]) -> str:
    lines = [",".join(given), "", *(",".join(map(repr, row)) for row in zip(*given.values(), strict=True))]
    (folder / "tool.csv").write_text("\n".join(lines))
    return str(folder / "tool.csv")


def test_of_rows_at_an_event_the_last_is_kept_and_it_is_told(tmp_path: Path) -> None:
    given = columns(EVENTS)
    for table in (read_table(file_of(tmp_path, given)), table_of(given)):
        assert table.noted == NOTED
        for name, values in columns(ROWS).items():
            np.testing.assert_allclose(table.columns[name], values, rtol=1e-15)
    assert read_table(file_of(tmp_path, given)).told == f"read as: {', '.join(NOTED)}, 12 rows"


@pytest.mark.parametrize("left_out", [(), ("crank_angle",)])  # an angle does not jump; without one, it is the number of such rows
def test_a_time_with_too_few_digits_is_no_series_of_events(tmp_path: Path, left_out: tuple[str, ...]) -> None:
    given = {name: values for name, values in columns(ROWS).items() if name not in left_out}
    given["time"] = [0.02 * (k // 2) for k in range(len(ROWS))]
    with pytest.raises(CaseError, match=r"line 4, time: 0 does not rise; .*more digits"):
        read_table(file_of(tmp_path, given))
    with pytest.raises(CaseError, match=r"row 1, time: 0 does not rise; .*more digits"):
        table_of(given)


def test_an_angle_that_jumps_within_an_instant_is_no_event(tmp_path: Path) -> None:
    with pytest.raises(CaseError, match=r"line 6, time: 0\.02 does not rise"):
        read_table(file_of(tmp_path, columns([*ROWS[:2], (0.02, 0.3, 7.0), *ROWS[2:]])))


@pytest.mark.parametrize(
    ("missing", "told"),
    [
        ((), ""),
        ((7,), "a gap: 0.02 s without a row after 0.06 s"),
        ((3, 20, 21, 22, 23, 24), "2 gaps, the largest 0.06 s without a row after 0.19 s"),
    ],
)
def test_gaps_in_evenly_sampled_rows_are_told(missing: tuple[int, ...], told: str) -> None:
    time = np.delete(0.01 * np.arange(40), list(missing))
    assert gaps(time) == told
    assert table_of({"time": time, "tip_x": time}).noted == ((told,) if told else ())


def test_noise_has_its_size() -> None:
    noise = 0.05 * np.random.default_rng(1).standard_normal(len(TIME))
    assert scatter(TIME, SMOOTH + noise) == pytest.approx(DEVIATIONS * 0.05, rel=0.1)


def test_rounding_has_the_size_of_uniform_noise() -> None:
    assert scatter(TIME, np.round(SMOOTH, 2)) == pytest.approx(DEVIATIONS * 0.01 / np.sqrt(12.0), rel=0.1)


def test_a_smooth_course_has_none_and_few_rows_show_none() -> None:
    assert scatter(TIME, SMOOTH) < 1e-4
    assert scatter(TIME[:4], SMOOTH[:4]) == math.inf
