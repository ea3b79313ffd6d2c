"""The groups of a machine are what their words say, make the scene again, and tell all that the motion depends on."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from quickreturn.cases.library.thesis import run_case
from quickreturn.engines.one_run import run_once
from quickreturn.engines.registry import engine
from quickreturn.engines.start import standard_start
from quickreturn.plugins.methods.groups import Groups, groups_of, scene_of
from quickreturn.reference_model.mechanism import Mechanism
from quickreturn.reference_model.scene_values import changed


def test_the_groups_of_run_24_follow_from_what_is_published() -> None:
    found = groups_of(run_case(24).mechanism)
    assert found is not None
    # its lowest frequency is 10.925 Hz with the slider nearest to the pivot, by an independent solution of five digits; of its torque over
    # its damping, 16.617773 rad/s, the pivot's damping and the fluctuation take 0.48e-3 rad/s
    assert found.speed == pytest.approx((16.617773 - 0.48e-3) / (2.0 * math.pi * 10.925), rel=5e-5)
    assert found.tip == pytest.approx(2.90e-4 / (4.75987e-5 * 25.0), rel=1e-9)
    assert found.crank == pytest.approx(4.0 / 18.0, rel=1e-9)
    # the pivot's damping adds 2e-4 of it
    assert found.damping == pytest.approx(2e-5 / 4.75987e-5 / (4.0 * math.pi * 10.925), rel=3e-4)
    assert found.joint == math.inf


@given(
    st.builds(
        Groups,
        speed=st.floats(0.01, 1.0),
        tip=st.floats(0.0, 3.0),
        crank=st.floats(0.1, 0.38),
        damping=st.floats(0.0, 0.1),
        joint=st.floats(50.0, 1e5) | st.just(math.inf),
    )
)
@settings(max_examples=20, deadline=None)
def test_groups_make_a_scene_that_has_these_groups(groups: Groups) -> None:
    found = groups_of(scene_of(groups))
    assert found is not None
    assert vars(found) == pytest.approx(vars(groups), rel=1e-9)


def test_a_chain_of_links_has_the_frequency_that_the_speed_is_relative_to() -> None:
    groups = Groups(speed=0.2, tip=0.5, crank=0.25, damping=0.0, joint=1000.0)
    scene, mujoco = scene_of(groups), engine("mujoco")
    chosen = mujoco.settings_for(1e-3, scene)
    lowest = mujoco.natural_frequencies(scene, 0.0, 1, chosen)[0]  # with the slider nearest to the pivot
    # 1 %: a chain of some twenty links, and the lowest of the angles at which the groups look for it
    assert scene.crank.drive.initial_speed / (2.0 * math.pi * lowest) == pytest.approx(0.2, rel=1e-2)


def test_machines_with_the_same_groups_move_alike() -> None:
    """Lengths 3 times, times 2 times, masses 5 times as large: as mass M, length L and time T enter each quantity."""
    small = scene_of(Groups(speed=0.3, tip=0.5, crank=0.3, damping=0.01, joint=500.0))
    length, time, mass = 3.0, 2.0, 5.0
    assert small.tip is not None
    large = changed(
        small,
        {
            "mechanism.pivot_distance": small.pivot_distance * length,
            "crank.length": small.crank.length * length,
            "crank.prescribed_speed": small.crank.drive.initial_speed / time,
            "base.inertia": small.base.inertia * mass * length**2,
            "follower.length": small.follower.length * length,
            "follower.mass_per_length": small.follower.mass_per_length * mass / length,
            "follower.bending_stiffness": small.follower.bending_stiffness * mass * length**3 / time**2,
            "follower.damping": small.follower.damping * mass / length / time,
            "follower.strain_gauges": tuple(length * place for place in small.follower.strain_gauges),
            "tip.mass": small.tip.mass * mass,
            "tip.inertia": small.tip.inertia * mass * length**2,
            "slider.joint_stiffness": small.slider.joint_stiffness * mass / time**2,
        },
    )
    of_small, of_large = groups_of(small), groups_of(large)
    assert of_small is not None
    assert of_large is not None
    assert vars(of_large) == pytest.approx(vars(of_small), rel=1e-9)
    turn = 2.0 * math.pi / small.crank.drive.initial_speed
    one, other = deflection(small, turn), deflection(large, turn * time) / length
    # the integration's tolerance is 1e-9, and rounding tells the two apart
    assert np.max(np.abs(one - other)) < 1e-6 * np.max(np.abs(one))


def deflection(scene: Mechanism, duration: float) -> np.ndarray:
    reference = engine("reference")
    chosen = reference.settings_for(1e-3, scene).with_texts({"modes": "2", "tolerance": "1e-9"})
    return run_once(reference, scene, standard_start(scene), duration, duration / 200, chosen).trajectory["tip_deflection"]


def test_a_machine_that_cannot_bend_or_does_not_turn_has_no_groups() -> None:
    scene = run_case(24).mechanism
    assert groups_of(changed(scene, {"follower.bending_stiffness": math.inf})) is None
    assert groups_of(changed(scene, {"crank.prescribed_speed": 0.0})) is None
