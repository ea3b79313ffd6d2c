"""What is measured of a method in a class, what is kept of one that was stopped, and what a map says of known numbers."""

import math
import time
from pathlib import Path

import pytest

from quickreturn.cases.running.isolation import STOPPED
from quickreturn.cases.running.job import Outcome
from quickreturn.cases.running.store import Store
from quickreturn.cases.running.workshop import Workshop
from quickreturn.plugins.methods.classes import measurement
from quickreturn.plugins.methods.classes.grid import CENTRE, case_of, name_of
from quickreturn.plugins.methods.classes.groups import Groups
from quickreturn.plugins.methods.classes.map import TIMES
from quickreturn.plugins.methods.classes.measurement import LEVELS, NOT_REACHED, REACHED, REFUSED, TOO_SLOW, measured
from quickreturn.plugins.methods.classes.study import _job, _kept, study
from quickreturn.plugins.methods.tests.made_up_map import BY_SPEED, made_up_map
from quickreturn.plugins.methods.trials.trial import Trial
from quickreturn.plugins.methods.trials.truth import truth_of

SOLVING, WAITING = TIMES


def at(groups: Groups, name: str) -> list[Trial]:
    return measured(groups, name, truth_of(case_of(groups)))


@pytest.mark.verify
def test_a_method_that_gets_there_has_both_times_and_a_model_that_does_not_has_its_distance() -> None:
    for level, reach in zip(LEVELS, at(CENTRE, "reference"), strict=True):
        assert (reach.scene, reach.level, reach.status) == (name_of(CENTRE), level, REACHED)
        assert reach.error is not None
        assert reach.error <= level
        assert reach.solve_seconds is not None
        assert reach.waited_seconds is not None
        assert reach.waited_seconds > reach.solve_seconds  # the estimate takes at least another run
    for reach in at(CENTRE, "thesis"):
        assert (reach.status, reach.solve_seconds, reach.waited_seconds) == (NOT_REACHED, None, None)
        assert reach.error is not None
        assert reach.error > 0.1  # one cubic is tens of percents off where the arm whips


def test_a_joint_that_a_method_does_not_have_is_a_refusal() -> None:
    soft = Groups(speed=0.05, tip=0.5, crank=0.25, damping=0.003, joint=100.0)
    reaches = measured(soft, "nodal-load", None)  # type: ignore[arg-type]  # nothing runs
    assert {reach.status for reach in reaches} == {REFUSED}
    assert "slider.joint_stiffness" in reaches[0].remark


def test_no_run_begins_that_would_end_too_late(monkeypatch: pytest.MonkeyPatch) -> None:
    now = 0.0
    monkeypatch.setattr(time, "process_time", lambda: now)
    clock = measurement._Clock()
    assert not clock.late
    now = 0.4 * measurement.LIMIT
    assert not clock.late  # another such run would end at 0.8
    now = 0.8 * measurement.LIMIT
    assert clock.late
    assert clock.ran_out


def test_a_method_that_was_stopped_is_stored_as_such_and_one_that_crashed_is_tried_again(tmp_path: Path) -> None:
    workshop, true = Workshop(Store(tmp_path)), truth_of(case_of(CENTRE))
    for name, failure, status in (("mujoco", f"{STOPPED} of 120 s", TOO_SLOW), ("exudyn", "killed by SIGSEGV", "failed")):
        kept = _kept(workshop, Outcome(_job(CENTRE, name, true), failure=failure))
        assert (workshop.stored(_job(CENTRE, name, true)) is not None) == (name == "mujoco")
        assert kept.value is not None
        assert [reach.status for reach in kept.value] == [status] * len(LEVELS)
        assert failure in kept.value[0].remark


def test_what_is_not_stored_is_left_out(tmp_path: Path) -> None:
    assert study(Workshop(Store(tmp_path)).as_it_is, [CENTRE]) == ([], [])


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
    assert known.outside(BY_SPEED[0.1]) == {}
    assert known.outside(Groups(speed=0.6, tip=0.5, crank=0.25, damping=0.003, joint=math.inf)) == {"speed": (0.05, 0.5)}
