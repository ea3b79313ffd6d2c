"""Scenes at the ends of what shapes that follow the slider describe: near the pivot, at the end, loose joints, braked pivots."""

import math

import pytest

from quickreturn.engines.base import EngineFailure
from quickreturn.engines.mujoco.engine import MujocoEngine
from quickreturn.engines.mujoco.settings import ChainSettings
from quickreturn.engines.own.reference import ReferenceEngine, ReferenceSettings
from quickreturn.engines.start import standard_start
from quickreturn.engines.trajectory import Trajectory, rms
from quickreturn.reference_model.errors import ImpossibleMechanism
from quickreturn.reference_model.follower import Follower
from quickreturn.reference_model.mechanism import LEAST_STUB, Base, Crank, Mechanism, PrescribedSpeed
from quickreturn.reference_model.slider import Slider
from tests.engines.scenes import run_24

FOLLOWER = 0.3  # m


def long_crank(length: float) -> Mechanism:
    """A crank almost as long as the distance of the pivots, 100 mm; aluminium strip of 5 by 20 mm, 60 rpm."""
    return Mechanism(
        pivot_distance=0.1,
        crank=Crank(length=length, drive=PrescribedSpeed(speed=6.0)),
        base=Base(inertia=1e-5),
        follower=Follower(
            length=FOLLOWER,
            mass_per_length=0.27,
            bending_stiffness=14.6,
            thickness=5e-3,
            width=20e-3,
            damping=0.5,
            strain_gauges=(0.06, 0.12, 0.18),
        ),
    )


def motion(scene: Mechanism, duration: float, modes: int = 4) -> Trajectory:
    settings = ReferenceSettings(modes=modes, tolerance=1e-7)
    return ReferenceEngine().prepare(scene, standard_start(scene), settings).advance(duration, 1e-3)


@pytest.mark.verify
def test_a_slider_near_the_pivot_is_followed() -> None:
    """It comes within 1.7 % of the follower's length of the pivot. Found: 4 and 7 modes differ by 9.5e-5."""
    few, more = (motion(long_crank(0.095), 0.7, modes) for modes in (4, 7))
    assert few["slider_position"].min() < 0.0167 * FOLLOWER
    assert rms(few["tip_deflection"] - more["tip_deflection"]) < 3e-4 * rms(more["tip_deflection"])


def test_a_slider_nearer_to_the_pivot_than_shapes_go_names_the_crank() -> None:
    with pytest.raises(
        EngineFailure, match=r"within 0\.0003 m of the follower's pivot, where the shapes end; try a crank\.length \(0\.0999 m\)"
    ):
        motion(long_crank(0.0999), 0.7)


def test_a_joint_that_lets_the_follower_fall_is_followed_to_the_pivot() -> None:
    """Run 24 on a spring of 1 N/m: the slider passes the pivot at 0.571 s, in MuJoCo's chain too."""
    scene = run_24(slider=Slider(joint_stiffness=1.0))
    with pytest.raises(EngineFailure, match=r"of the follower's pivot, where the shapes end; try a stiffer joint") as found:
        motion(scene, 0.6)
    assert found.value.time == pytest.approx(0.571, abs=1e-3)
    chain = MujocoEngine().prepare(scene, standard_start(scene), ChainSettings(links=12))
    with pytest.raises(EngineFailure, match="left the follower") as of_chain:
        chain.advance(0.6, 1e-3)
    assert of_chain.value.time == pytest.approx(0.571, abs=1e-3)
    own, other = found.value.partial, of_chain.value.partial
    rows = 560
    for column, size in (("slider_position", 1e-3), ("tip_x", 1e-3), ("tip_y", 1e-3)):
        assert rms(own[column][:rows] - other[column][:rows]) < size * scene.follower.length, column


@pytest.mark.parametrize("joint", [math.inf, 1e5])
def test_a_flexible_follower_that_ends_at_the_slider_cannot_be(joint: float) -> None:
    """It could not bend without leaving the slider. A rigid one can be."""
    d, L = run_24().pivot_distance, run_24().follower.length
    for stub in (0.0, 1e-9, 0.9 * LEAST_STUB):
        with pytest.raises(ImpossibleMechanism, match=r"the slider reaches the follower's end.* must not exceed 0\.99998 follower\.length"):
            run_24(crank={"length": (1.0 - stub) * L - d}, slider=Slider(joint_stiffness=joint))
    near = run_24(crank={"length": (1.0 - 1.1 * LEAST_STUB) * L - d}, slider=Slider(joint_stiffness=joint))
    assert motion(near, 0.05)["slider_position"][0] > (1.0 - 1.2 * LEAST_STUB) * L
    rigid = run_24(follower={"bending_stiffness": math.inf}, crank={"length": L - d})
    assert motion(rigid, 0.05)["slider_position"][0] == pytest.approx(L)
