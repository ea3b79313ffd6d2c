import math
from dataclasses import replace

import pytest

from quickreturn.cases.files.errors import CaseError
from quickreturn.cases.library import case_names, catalogue, load_case
from quickreturn.cases.library.hard import IMPOSSIBLE, SCENES, TAG
from quickreturn.reference_model.mechanism import Mechanism, PrescribedSpeed, TorqueDrive
from quickreturn.reference_model.rigid import rigid_motion

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


@pytest.mark.parametrize(("name", "factor"), [("hard-ei-x0.1", 0.1), ("hard-ei-x10", 10.0), ("hard-ei-x1000", 1000.0)])
def test_the_follower_bends_more_or_less(name: str, factor: float) -> None:
    scene = load_case(name).mechanism
    assert scene.follower.bending_stiffness == pytest.approx(factor * RUN_24.follower.bending_stiffness, rel=1e-14)
    assert replace(scene, follower=RUN_24.follower) == RUN_24


@pytest.mark.parametrize(("name", "factor"), [("hard-speed-x2", 2.0), ("hard-speed-x3", 3.0), ("hard-reversed", -1.0)])
def test_other_speeds_are_in_equilibrium_with_torque_and_damping(name: str, factor: float) -> None:
    drive = drive_of(load_case(name).mechanism)
    assert drive.initial_speed == pytest.approx(factor * 16.617773, rel=1e-8)
    assert drive.torque / drive.damping == pytest.approx(drive.initial_speed, rel=1e-15)
    assert abs(drive.torque) == drive_of(RUN_24).torque
    assert drive.damping > 0.0


@pytest.mark.parametrize(("name", "inches"), [("hard-crank-6in", 6.0), ("hard-crank-6.9in", 6.9), ("hard-crank-6.95in", 6.95)])
def test_long_cranks_reach_the_end_of_a_follower_without_plates(name: str, inches: float) -> None:
    scene = load_case(name).mechanism
    assert scene.crank.length == pytest.approx(inches * INCH, rel=1e-15)
    assert scene.tip.mass == pytest.approx(4.1e-5 * 175.126835, rel=1e-8)  # table 5.1, lbf s²/in
    assert float(rigid_motion(scene, math.pi, 0.0).slider_position) == pytest.approx((18.0 + inches) * INCH, rel=1e-12)


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


def test_the_remaining_scenes_change_what_their_titles_say() -> None:
    prescribed = load_case("hard-prescribed-speed").mechanism
    assert prescribed.crank.drive == PrescribedSpeed(speed=drive_of(RUN_24).initial_speed)
    assert load_case("hard-no-tip").mechanism == replace(RUN_24, tip=None)
    heavy = load_case("hard-tip-x10").mechanism.tip
    assert (heavy.mass, heavy.inertia) == pytest.approx((10.0 * RUN_24.tip.mass, 10.0 * RUN_24.tip.inertia), rel=1e-14)
    light = load_case("hard-mass-x0.1").mechanism.follower
    assert light.mass_per_length == pytest.approx(0.1 * RUN_24.follower.mass_per_length, rel=1e-14)
    assert load_case("hard-start-at-0deg").mechanism.crank.initial_angle == 0.0
    assert load_case("hard-slider-mass").mechanism.slider.mass == 0.5
    assert load_case("hard-slider-inertia").mechanism.slider.inertia == 2e-5
    assert [load_case(f"hard-joint-1e{power}").mechanism.slider.joint_stiffness for power in (3, 5, 7, 9)] == [1e3, 1e5, 1e7, 1e9]
