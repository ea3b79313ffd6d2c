import math

import pytest

from quickreturn.cases.files.errors import CaseError
from quickreturn.cases.library import case_names, catalogue, load_case
from quickreturn.cases.library.hard import IMPOSSIBLE, SCENES, TAG
from quickreturn.reference_model.mechanism import Mechanism, TorqueDrive

RUN_24 = load_case("thesis-24").mechanism
INCH = 0.0254
POSSIBLE = [name for name in SCENES if name not in IMPOSSIBLE]


def drive_of(mechanism: Mechanism) -> TorqueDrive:
    assert isinstance(mechanism.crank.drive, TorqueDrive)
    return mechanism.crank.drive


def test_the_hard_scenes_are_listed_under_their_tag() -> None:
    from_run_24 = [entry.name for entry in catalogue(TAG) if entry.title.startswith("Run 24, ")]
    assert from_run_24 == POSSIBLE
    assert {entry.name for entry in catalogue(TAG)} - set(POSSIBLE) == {"hard-shaper-steel", "hard-shaper-aluminium"}
    assert len({load_case(name).mechanism for name in POSSIBLE}) == len(POSSIBLE)
    assert RUN_24 not in {load_case(name).mechanism for name in POSSIBLE if name != "hard-undamped"}


@pytest.mark.parametrize("name", sorted(IMPOSSIBLE))
def test_a_scene_that_cannot_be_is_refused_with_its_sentence(name: str) -> None:
    assert name not in case_names()
    with pytest.raises(CaseError) as refused:
        load_case(name)
    assert str(refused.value) == IMPOSSIBLE[name]


@pytest.mark.parametrize(("name", "factor"), [("hard-speed-x2", 2.0), ("hard-speed-x3", 3.0), ("hard-reversed", -1.0)])
def test_other_speeds_are_in_equilibrium_with_torque_and_damping(name: str, factor: float) -> None:
    drive = drive_of(load_case(name).mechanism)
    assert drive.initial_speed == pytest.approx(factor * 16.617773, rel=1e-8)
    assert drive.torque / drive.damping == pytest.approx(drive.initial_speed, rel=1e-15)
    assert abs(drive.torque) == drive_of(RUN_24).torque
    assert drive.damping > 0.0


def test_the_balanced_crank_has_the_same_inertia_about_its_pivot() -> None:
    scene = load_case("hard-gravity").mechanism
    assert scene.gravity == (0.0, -9.81)
    assert scene.crank.center_of_mass == 0.0
    assert scene.crank.inertia_about_pivot == pytest.approx(RUN_24.crank.inertia_about_pivot, rel=1e-12)


def test_the_undamped_scene_has_neither_drive_nor_loss_and_lasts_100_cycles() -> None:
    case = load_case("hard-undamped")
    scene, drive = case.mechanism, drive_of(case.mechanism)
    assert (drive.torque, drive.damping, scene.base.damping, scene.follower.damping) == (0.0, 0.0, 0.0, 0.0)
    assert case.duration * drive.initial_speed / (2.0 * math.pi) == pytest.approx(100.5, abs=0.5)
