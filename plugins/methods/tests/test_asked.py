"""An engine that is asked for an error: sound engines reach it, and engines that are wrong on purpose are called so."""

import math
from dataclasses import replace

import pytest

from quickreturn.cases.files.case import Case
from quickreturn.cases.library import load_case
from quickreturn.engines.registry import engine
from quickreturn.engines.trajectory import Trajectory
from quickreturn.plugins.methods.asked import asked
from quickreturn.plugins.methods.row import ENDED, NOT_REACHED, OWN_EQUATIONS, REACHED, REFUSED, TOO_SLOW, WRONG
from quickreturn.plugins.methods.truth import KNOWN, Truth, run_of, settings_of, truth_of
from tests.engines.wrong_engines import Disguised, Restarting, Stiffer

CASE = replace(load_case("thesis-24"), duration=0.4)


@pytest.fixture(scope="module")
def truth() -> Truth:
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("quickreturn.plugins.methods.truth.CONFIRMING", ("mujoco", ({"links": "40"},)))  # a fifth of the usual time
        return truth_of(CASE)


def test_a_sound_engine_reaches_it_disguised_or_not(truth: Truth) -> None:
    for chosen in (engine("reference"), Disguised(engine("reference")), engine("exudyn")):
        row = asked(chosen, CASE, 0.01, truth)
        assert row.status == REACHED, row
        assert (row.error or 1.0) <= (row.claim or 0.0) + truth.uncertainty


def test_a_stiffness_3_percent_off_is_silently_wrong(truth: Truth) -> None:
    row = asked(Stiffer(engine("reference")), CASE, 0.01, truth)  # it converges, to another scene
    assert row.status == WRONG
    assert (row.claim or 1.0) <= 0.01 < (row.error or 0.0)


def test_a_reset_to_the_start_does_not_count_as_reached(truth: Truth) -> None:
    assert asked(Restarting(engine("reference")), CASE, 0.01, truth).status in (WRONG, NOT_REACHED)


def test_the_claim_of_a_model_is_about_its_own_equations(truth: Truth) -> None:
    row = asked(engine("thesis"), CASE, 0.01, truth)
    assert row.status == OWN_EQUATIONS
    assert (row.claim or 1.0) <= 0.01 < (row.error or 0.0)
    # it claims nothing of the scene, so that a model that is near enough reaches the error
    assert asked(engine("thesis"), CASE, 0.01, replace(truth, trajectory=_of("thesis", CASE))).status == REACHED


def _of(name: str, case: Case) -> Trajectory:
    return run_of(engine(name), case, settings_of(name, {}, case)).trajectory


def test_a_feature_that_an_engine_lacks_is_refused(truth: Truth) -> None:
    row = asked(engine("mujoco"), replace(load_case("hard-slider-inertia"), duration=0.4), 0.01, truth)
    assert row.status == REFUSED
    assert "slider.inertia" in row.remark


def test_no_run_begins_that_would_end_too_late(truth: Truth) -> None:
    assert asked(engine("exudyn"), CASE, 1e-4, truth, 0.02).remark == "its first run takes too long"
    assert asked(engine("thesis"), CASE, 1e-2, truth, 1e-3).status == TOO_SLOW


@pytest.mark.verify
def test_engines_agree_when_the_slider_leaves_the_follower(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("quickreturn.plugins.methods.truth.CONFIRMING", ("mujoco", ({"links": "40"},)))  # a fifth of the usual time
    case = replace(load_case("hard-speed-x3"), duration=0.3)
    truth = truth_of(case)
    # 7 to 11 modes agree on 0.2524 to 0.2526 s, and so does a chain of links, which confirms the solution up to then
    assert truth.end == pytest.approx(0.2525, abs=2e-3)
    assert truth.confirmation.time == pytest.approx(0.2525, abs=2e-3)
    assert (truth.confirmation.error or 0.0) <= KNOWN
    for name in ("reference", "mujoco"):
        row = asked(engine(name), case, 0.01, truth)
        assert row.status == ENDED, row
        assert (row.error or 1.0) <= 0.01
        assert "left the follower" in row.remark
    assert row.time == pytest.approx(truth.end, abs=2e-3)  # of mujoco; two modes of the reference do not end, but those of its estimate do


def test_a_scene_counts_as_known_up_to_where_two_formulations_part(monkeypatch: pytest.MonkeyPatch) -> None:
    """A chain of twelve links is coarse: it parts from the solution early, and the errors are those up to then."""
    monkeypatch.setattr("quickreturn.plugins.methods.truth.CONFIRMING", ("mujoco", ({"links": "12"},)))
    found = truth_of(CASE)
    assert 0.0 < found.until < CASE.duration
    assert found.uncertainty <= KNOWN
    row = asked(engine("reference"), CASE, 0.01, found)
    assert row.status == REACHED
    assert math.isfinite(row.error or math.inf)
