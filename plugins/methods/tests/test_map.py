"""What a map says of known numbers, and how a race is condensed to its rows."""

import math

import pytest

from quickreturn.plugins.methods.advice import beyond
from quickreturn.plugins.methods.groups import Groups
from quickreturn.plugins.methods.map import LEVELS, TIMES, condensed
from quickreturn.plugins.methods.row import NOT_REACHED, REACHED
from quickreturn.plugins.methods.tests.made_up_map import BY_SPEED, made_up_map
from quickreturn.plugins.methods.tests.made_up_races import made_up_race

SOLVING, WAITING = TIMES


def test_the_first_the_next_and_the_factor_are_those_of_the_times() -> None:
    known = made_up_map()
    slow, fast, lost = known.scenes
    assert list(known.ranked(slow, LEVELS[0], SOLVING).items()) == [("reference", 2e-3), ("fixed-shapes", 7e-3)]
    assert list(known.ranked(slow, LEVELS[0], WAITING)) == ["fixed-shapes", "reference"]
    assert list(known.ranked(fast, LEVELS[1], SOLVING)) == ["mujoco", "reference", "exudyn"]
    assert list(known.ranked(fast, LEVELS[1], WAITING)) == ["mujoco", "reference"]
    assert known.ranked(lost, LEVELS[0], SOLVING) == {}
    assert known.factors(LEVELS[0], SOLVING) == {"reference": [pytest.approx(3.5)], "mujoco": [pytest.approx(2.0)]}


def test_a_machine_is_near_the_scene_of_its_groups_and_outside_where_no_scene_is() -> None:
    known = made_up_map()
    scene, steps = known.nearest(BY_SPEED[0.2])
    assert (scene.groups, steps) == (BY_SPEED[0.2], 0.0)
    assert list(beyond(known, BY_SPEED[0.1])) == []
    (told,) = beyond(known, Groups(speed=0.6, tip=0.5, crank=0.25, damping=0.003, joint=math.inf))
    assert told.endswith("is 0.6, the map has 0.05 to 0.5")


def test_an_engine_has_the_time_of_its_fastest_combination_and_of_its_own_answer() -> None:
    rows = {(row.engine, row.level): row for row in condensed(made_up_race())}
    # errors n^-3 with 10 ms n: 1 % at 100^(1/3) unknowns; elements of fourth order are slower
    found = rows["multiplier", LEVELS[0]]
    assert (found.status, found.variant, found.answer_seconds) == (REACHED, "", 0.5)
    assert found.solve_seconds == pytest.approx(1e-2 * 100.0 ** (1.0 / 3.0), rel=1e-9)
    assert found.calls == pytest.approx(1e3 * 100.0 ** (1.0 / 3.0), rel=1e-9)
    assert rows["reference", LEVELS[1]].answer_seconds is None  # it was not asked for that
    thesis = rows["thesis", LEVELS[0]]
    assert (thesis.status, thesis.solve_seconds, thesis.error) == (NOT_REACHED, None, 0.8)
