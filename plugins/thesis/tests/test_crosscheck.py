"""Planted errors and other starts: what the chapter makes of them, and what a planted error does to a cycle."""

import numpy as np
import pytest

from quickreturn.cases.library.thesis import RUNS
from quickreturn.cases.motion.time_scale import CHANNELS
from quickreturn.cases.running.job import ThisProcess
from quickreturn.cases.running.store import Store
from quickreturn.cases.running.workshop import Workshop
from quickreturn.plugins.thesis.sharpness import ENGINES, GAIN, SIZES, Planted, _delay, _gain, _of_machine, from_size, planted, smallest
from quickreturn.plugins.thesis.starts import starts

ANGLE = np.linspace(0.0, 2.0 * np.pi, 401)
CYCLE = {"time": 5.0 + ANGLE / 20.0, "crank_angle": np.pi + ANGLE, **{name: np.sin(k * ANGLE) for k, name in enumerate(CHANNELS, 1)}}


def planted_rows(size: float | None = 0.002, missed: int = 2) -> list[Planted]:
    """A gain that is found from this size on in all of twenty runs but some, in which none is."""
    found = (size,) * (20 - missed) + (None,) * missed
    return [Planted(engine=engine, error=GAIN, runs=tuple(range(1, 21)), found=found) for engine in ENGINES]


def test_an_error_is_found_from_the_size_on_beyond_which_no_size_is_missed() -> None:
    assert from_size({size: size == 0.0005 or size > 0.001 for size in SIZES}) == 0.002
    assert from_size(dict.fromkeys(SIZES, True)) == SIZES[0]
    assert from_size(dict.fromkeys(SIZES, False)) is None


@pytest.mark.parametrize(("missed", "expected"), [(0, 0.002), (2, 0.002), (3, None)])
def test_the_smallest_error_is_that_of_nine_of_ten_runs_by_every_engine(missed: int, expected: float | None) -> None:
    assert smallest(planted_rows(missed=missed), GAIN) == expected


def test_plants_are_what_they_are_called() -> None:
    """A gain, a delay of a cycle that repeats, and a change of the machine in proportion to its size."""
    for k, name in enumerate(CHANNELS, 1):
        assert _gain(CYCLE)(0.01)[name] == pytest.approx(1.01 * CYCLE[name])
        late = np.sin(k * (ANGLE - 20.0 * 2e-3))
        assert _delay(CYCLE)(2.0)[name] == pytest.approx(late, abs=1e-6)
        changed = {**CYCLE, **{each: 1.02 * CYCLE[each] for each in CHANNELS}}
        assert _of_machine(CYCLE, CYCLE, changed)(0.005)[name] == pytest.approx(1.01 * CYCLE[name], abs=1e-12)


@pytest.mark.verify
def test_half_a_per_cent_of_stiffness_shows_in_a_run_and_no_start_matters(tmp_path: object) -> None:
    run = min(RUNS, key=lambda number: RUNS[number].steady_speed)
    workshop = Workshop(Store(tmp_path), ThisProcess())  # type: ignore[arg-type]
    found = {row.engine: row.found[0] for row in planted(workshop, [run]) if row.error == "bending stiffness"}
    assert all((found[engine] or 1.0) <= 0.005 for engine in ENGINES)
    again = starts(workshop, [run])
    assert [row.runs for row in again] == [(run,)] * 4
    assert sum(row.within for row in again) == 4, again
