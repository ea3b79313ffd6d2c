"""The follower alone in every engine that has a model of it, with every part of the scene on."""

from dataclasses import replace

import pytest

from quickreturn.engines.accurate import describe_scene, simulate
from quickreturn.engines.base import Refusal
from quickreturn.engines.registry import engine
from quickreturn.engines.settings import Settings
from quickreturn.engines.start import standard_start
from quickreturn.engines.trajectory import FollowerTrajectory, relative_error
from quickreturn.plugins.methods.rivals import RIVALS
from quickreturn.reference_model.columns import COLUMNS, SHAPE
from quickreturn.reference_model.follower import Follower
from quickreturn.reference_model.mechanism import Base, FollowerAlone, SpinUp, base_motion
from tests.engines.scenes import FOLLOWER_ALONE

SCENE = replace(FOLLOWER_ALONE, spin_up=SpinUp(speed=7.0, time=1.0), gravity=(0.2, -0.5))
DURATION, STEP = 1.2, 0.01


def run(name: str, **settings: str) -> FollowerTrajectory:
    trajectory = simulate(engine(name), SCENE, standard_start(SCENE), DURATION, STEP, settings, estimate=False).trajectory
    assert isinstance(trajectory, FollowerTrajectory)
    return trajectory


@pytest.fixture(scope="module")
def truth() -> FollowerTrajectory:
    return run("reference", modes="6", tolerance="1e-9")


def test_columns_of_crank_and_slider_are_absent(truth: FollowerTrajectory) -> None:
    assert not any(COLUMNS[name].of_slider for name in truth.columns)
    assert set(SHAPE) <= set(truth.columns)
    assert {"follower_angle", "tip_deflection", "strain_3", "base_torque"} <= set(truth.table().columns)
    angles = [base_motion(SCENE.spin_up.speed, SCENE.spin_up.time, t)[0] for t in truth["time"]]
    assert truth["follower_angle"] == pytest.approx(angles, abs=1e-12)


@pytest.mark.parametrize(
    ("name", "settings", "deflection", "strain"),
    [
        ("exudyn", {"elements": "16", "step": "1e-3"}, 2e-3, 1e-2),  # three times the error that halving the step shows
        ("mujoco", {"links": "24"}, 5e-3, 1e-2),  # as with the mechanism (its ladder), but for the clamp of order h^2
    ],
)
def test_engines_agree_with_everything_on(
    truth: FollowerTrajectory, name: str, settings: dict[str, str], deflection: float, strain: float
) -> None:
    found = run(name, **settings)
    for column, bound in (("tip_deflection", deflection), ("strain_1", strain), ("tip_x", 1e-3), ("tip_y", 1e-3)):
        assert relative_error(found[column], truth[column]) < bound, column
    # the torque and with it the drive's work answer for inertia, weight and all dampings together
    assert found["drive_work"][-1] == pytest.approx(truth["drive_work"][-1], rel=5e-3)
    assert found["dissipated_energy"][-1] == pytest.approx(truth["dissipated_energy"][-1], rel=1e-2)


@pytest.mark.parametrize("name", ["reference", "exudyn", "mujoco"])
def test_a_run_in_pieces_is_the_run_in_one(name: str) -> None:
    follower = engine(name)
    settings: Settings = follower.settings_for(3e-2, SCENE)
    whole = follower.prepare(SCENE, None, settings).advance(0.4, STEP)
    simulation = follower.prepare(SCENE, None, settings)
    simulation.advance(0.2, STEP)
    rest = simulation.advance(0.2, STEP)
    for column in ("tip_deflection", "follower_angle", "time"):
        assert rest[column][-1] == pytest.approx(whole[column][-1], rel=1e-6)


def test_every_engine_says_what_it_builds_or_why_not() -> None:
    beam, base, tip = describe_scene(engine("reference"), SCENE).bodies
    assert (base, tip) == ("base block", "tip body")
    assert "clamped modes" in beam
    assert describe_scene(engine("thesis"), SCENE).degrees_of_freedom == 2
    assert "prescribed base angle" in describe_scene(engine("exudyn"), SCENE).joints
    for name in (rival for rival in RIVALS if rival != "fixed-shapes"):
        refused = rf"base\.spin_up_speed: 7.0 rad/s is not modelled by engine {name}; accepted: a scene with \[crank\]"
        with pytest.raises(Refusal, match=refused):
            describe_scene(engine(name), SCENE)


@pytest.mark.verify
def test_the_stretch_of_the_cable_is_in_the_claim() -> None:
    """A titanium arm spun up to 2800 rpm in 32 ms: the cable that stretches as its section does is 2.5e-4 off."""
    follower = Follower(
        length=0.23852, mass_per_length=0.9602, bending_stiffness=87.511, thickness=6.6366e-3, width=32.66e-3, damping=8.4801,
        strain_gauges=(0.06, 0.12, 0.18),
    )  # fmt: skip
    scene = FollowerAlone(spin_up=SpinUp(speed=293.19, time=0.032094), base=Base(inertia=0.0), follower=follower)
    duration, step = 0.0514, 2e-4
    truth = simulate(
        engine("reference"), scene, standard_start(scene), duration, step, {"modes": "11", "tolerance": "1e-10"}, estimate=False
    ).trajectory
    for accuracy in (1e-2, 1e-3):
        found = simulate(engine("exudyn"), scene, standard_start(scene), duration, step, accuracy=accuracy)
        error = relative_error(found.trajectory["tip_deflection"], truth["tip_deflection"])
        assert 1e-4 < error < found.error_estimate < accuracy
        assert "stretch" in {part.of for part in found.error_parts["tip"]}
