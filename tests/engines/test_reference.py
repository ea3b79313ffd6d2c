"""The engine `reference` behind the engine interface: starts, pieces, failures, refusals, ladder."""

import math
from functools import cache

import numpy as np
import pytest
from scipy.interpolate import CubicSpline

from quickreturn.engines.accurate import simulate
from quickreturn.engines.base import EngineFailure
from quickreturn.engines.mujoco.engine import MujocoEngine
from quickreturn.engines.mujoco.settings import ChainSettings
from quickreturn.engines.own.beam_engine import EXPLICIT, IMPLICIT
from quickreturn.engines.own.reference import AS_THEY_ARE, SLOWED, ReferenceEngine, ReferenceSettings
from quickreturn.engines.start import Start, standard_start
from quickreturn.engines.start_state import reconstruct
from quickreturn.engines.trajectory import OPTIONAL, REQUIRED, Trajectory, relative_error
from quickreturn.reference_model.follower import Follower
from quickreturn.reference_model.mechanism import Base, Crank, Mechanism, PrescribedSpeed
from quickreturn.reference_model.model import BeamModel
from quickreturn.reference_model.slider import Slider
from quickreturn.reference_model.tip import Tip
from tests.engines.energy import imbalance
from tests.engines.scenes import INCH, POUND_FORCE, run_24, violent

ENGINE = ReferenceEngine()
CONVERGED = ReferenceSettings(modes=11, tolerance=1e-9)
#: What holds the plates alone (run 17 of the thesis).
NO_PLATES = Tip(mass=0.007180200245105532, inertia=3.1635752127732676e-07)
#: With a fifth of its stiffness modes are integrated implicitly, as they are.
SOFT = run_24(follower={"bending_stiffness": 0.2 * run_24().follower.bending_stiffness})
OFFSET_TIP = run_24(crank={"length": 5.0 * INCH}, tip={"center_of_mass": 0.0127})


@cache
def converged(mechanism: Mechanism) -> Trajectory:
    """Eleven modes over 2 s: within 2e-5 in run 24."""
    return ENGINE.prepare(mechanism, standard_start(mechanism), CONVERGED).advance(2.0, 1e-3)


@pytest.mark.parametrize(
    ("mechanism", "accuracy"),
    [
        pytest.param(run_24(), 1e-3, id="run 24, default"),
        pytest.param(OFFSET_TIP, 1e-2, id="crank 5 in, tip offset, coarse"),
        pytest.param(SOFT, 1e-2, id="soft, implicit"),
        pytest.param(run_24(), 1e-2, id="run 24, coarse", marks=pytest.mark.verify),
        pytest.param(OFFSET_TIP, 1e-3, id="crank 5 in, tip offset, default", marks=pytest.mark.verify),
    ],
)
def test_the_error_estimate_covers_the_error(mechanism: Mechanism, accuracy: float) -> None:
    result = simulate(ENGINE, mechanism, standard_start(mechanism), 2.0, 1e-3, accuracy=accuracy)
    true = relative_error(result.trajectory["tip_deflection"], converged(mechanism)["tip_deflection"])
    assert result.reached
    # the estimate rests on a measured ratio of errors, which is right to some ten percent
    assert true <= 1.2 * result.error_estimate
    assert result.error_estimate <= accuracy
    # an estimate that is never wrong because it is always huge would drive the ladder to its end
    assert result.error_estimate < 40.0 * true


def test_ladder_climbs_and_starts_at_the_measured_rung() -> None:
    """Modes that were slowed are tried as they are before more are taken."""
    for accuracy in (0.05, 1e-2, 1e-3, 1e-4):
        begun = ENGINE.settings_for(accuracy, run_24())
        assert SLOWED.claim(begun.modes) <= accuracy
        assert begun.slowed_to
        climbed = ENGINE.finer(begun, {}, 1e-3)
        assert (climbed.modes == begun.modes) == (begun.modes > 3)
        assert not climbed.slowed_to
    rung: ReferenceSettings | None = ENGINE.settings_for(0.05, run_24())
    visited = []
    while rung is not None:
        visited.append(rung.modes)
        (pair,) = ENGINE.comparisons(rung, run_24(), 1e-3)
        assert pair.other.modes > rung.modes
        assert pair.other.tolerance <= rung.tolerance
        assert 0.0 < pair.factor < 1.0
        rung = ENGINE.finer(rung, {}, 1e-3)
    assert visited == [rung.modes for rung, _ in AS_THEY_ARE.rungs]


@pytest.mark.parametrize("scene", [SOFT, run_24(base={"inertia": 0.0, "damping": 0.3})], ids=["soft follower", "moment at the base"])
def test_where_no_mode_is_slowed_the_ladder_is_implicit(scene: Mechanism) -> None:
    rung: ReferenceSettings | None = ENGINE.settings_for(0.05, scene)
    while rung is not None:
        assert (rung.slowed_to, rung.integrator) == (0, IMPLICIT)
        (pair,) = ENGINE.comparisons(rung, scene, 1e-3)
        assert pair.other.modes > rung.modes
        assert pair.other.tolerance <= 0.1 * rung.tolerance  # so that it shows the error of the integration, too
        rung = ENGINE.finer(rung, {}, 1e-3)
    assert ENGINE.settings_for(1e-3, scene).with_texts({"integrator": EXPLICIT}).tolerance <= 3e-7


def test_every_column_is_there_and_begins_as_the_rigid_mechanism() -> None:
    trajectory = converged(run_24())
    of_other_scenes = {"base_torque", "axial_stretch", "spring_force"}
    assert set(trajectory.columns) == {*REQUIRED, *OPTIONAL} - of_other_scenes
    start = reconstruct(run_24(), standard_start(run_24()))
    assert trajectory["slider_position"][0] == pytest.approx(start.slider_position, rel=1e-14)
    # recovered under the moment of the pivot's damping, 4e-6 N m, which bends by 1e-9
    assert trajectory["follower_angle"][0] == pytest.approx(start.follower_angle, abs=1e-8)
    assert abs(trajectory["tip_deflection"][0]) < 1e-8  # m
    assert np.all(trajectory["crank_torque"] == 10.0 * POUND_FORCE * INCH)


@pytest.mark.parametrize(
    "mechanism", [run_24(), run_24(slider=Slider(mass=0.1, inertia=1e-4), crank={"drive": PrescribedSpeed(speed=15.0)})]
)
def test_the_present_state_as_a_start_continues_the_motion(mechanism: Mechanism) -> None:
    settings = ReferenceSettings(modes=4)
    simulation = ENGINE.prepare(mechanism, standard_start(mechanism), settings)
    simulation.advance(0.2, 1e-3)
    start = simulation.present_start()
    again = ENGINE.prepare(mechanism, start, settings)
    n = settings.modes
    # deflection is handed over as a cubic spline on 121 points a span: 1e-8 of the amplitudes
    for part in (slice(1, n + 1), slice(n + 1, n + 2), slice(n + 3, 2 * n + 3)):
        np.testing.assert_allclose(again.state[part], simulation.state[part], atol=1e-6 * np.max(np.abs(simulation.state[part])))
    one, other = simulation.advance(0.2, 1e-3), again.advance(0.2, 1e-3)
    for name in ("tip_deflection", "follower_angle", "slider_position"):
        # step sizes differ: the integration error at tolerance 1e-7
        np.testing.assert_allclose(other[name], one[name], atol=3e-4 * np.ptp(one[name]), err_msg=name)


def bent(amplitude: float) -> CubicSpline:
    """A deflection and its rate as other engines would give them: no combination of modes."""
    length = run_24().follower.length
    x = np.linspace(0.0, length, 60)
    return CubicSpline(x, amplitude * (x / length) ** 2 * (1.5 - 0.5 * x / length), bc_type=((1, 0.0), (2, 0.0)))


def test_a_bent_start_is_met() -> None:
    start = Start(2.0, 10.0, bent(0.03), bent(-0.2))
    simulation = ENGINE.prepare(run_24(), start, ReferenceSettings(modes=12))
    back, expected = simulation.present_start(), reconstruct(run_24(), start)
    assert back.deflection is not None
    assert back.deflection_rate is not None
    x = np.linspace(0.0, run_24().follower.length, 40)
    # the boundary at the tip carries a moment in one and none in the other: a layer that 12 modes span to a few 1e-3
    assert np.max(np.abs(back.deflection(x) - bent(0.03)(x))) < 3e-3 * 0.03
    assert np.max(np.abs(back.deflection_rate(x) - bent(-0.2)(x))) < 1e-2 * 0.2
    closed = reconstruct(run_24(), back)
    assert closed.slider_position == pytest.approx(expected.slider_position, abs=1e-6)
    assert closed.slider_position == pytest.approx(simulation.state[13], abs=1e-9)  # the loop is closed for the projected shape
    assert closed.follower_angle == pytest.approx(expected.follower_angle, abs=2e-4)


def test_a_slider_that_leaves_the_follower_is_a_failure_at_its_time() -> None:
    mechanism, times = violent(), []
    for step in (1e-3, 1e-4):
        with pytest.raises(EngineFailure, match="left the follower") as caught:
            ENGINE.prepare(mechanism, standard_start(mechanism), ReferenceSettings(modes=3)).advance(0.5, step)
        failure, partial = caught.value, caught.value.partial
        times.append(failure.time)
        # the last row lies before the failure, which is less than one output step later
        assert 0.0 <= failure.time - partial["time"][-1] <= 1.001 * step
        s, length = partial["slider_position"], mechanism.follower.length
        assert np.all(s <= length + 1e-5)  # the recovered place differs from the model's by what recovery corrects
        assert 2.0 * s[-1] - s[-2] > length - 2e-3 * length  # one more row at this speed and it is gone
    assert times[0] == pytest.approx(times[1], abs=1e-6)  # does not depend on the output grid


def test_a_start_that_cannot_be_closed_is_refused() -> None:
    x = np.linspace(0.0, run_24().follower.length, 200)
    waves = 6.0 * math.pi / x[-1]  # slopes up to 0.95 shorten the follower by a quarter
    start = Start(math.pi, 10.0, CubicSpline(x, 0.95 / waves * (1.0 - np.cos(waves * x)), bc_type=((1, 0.0), (2, 0.0))))
    with pytest.raises(EngineFailure, match="cannot be closed") as caught:
        ENGINE.prepare(run_24(), start, ReferenceSettings(modes=3))
    assert caught.value.time == 0.0


def test_an_instant_without_a_determinant_of_the_loop_is_passed() -> None:
    """An arm of plastic, bent by half of its length: at 0.249 s the loop does not determine the slider's rate, and the motion goes on.

    `mujoco` says so, too, within the 1 % of its links.
    """
    scene = Mechanism(
        pivot_distance=0.3,
        gravity=(0.0, -9.80665),
        crank=Crank(length=0.08, mass=2.0, inertia=5e-3, drive=PrescribedSpeed(speed=20.94395102)),
        follower=Follower(
            length=0.46, mass_per_length=0.2538, bending_stiffness=1.512, thickness=6e-3, width=0.03, damping=0.3, material_damping=2e-5,
            strain_gauges=(0.1, 0.2, 0.3),
        ),
        base=Base(inertia=2e-4),
        tip=Tip(mass=0.25, inertia=1e-4, center_of_mass=0.02),
    )  # fmt: skip
    settings = ENGINE.settings_for(1e-3, scene)
    assert settings.integrator == IMPLICIT
    run, other = (
        engine.prepare(scene, standard_start(scene), of).advance(0.28, 5e-4)["tip_deflection"]
        for engine, of in ((ENGINE, settings), (MujocoEngine(), ChainSettings(links=30)))
    )
    assert relative_error(run, other) < 0.01


def test_one_mode_begins_in_a_far_bent_state_of_many() -> None:
    """Its closest shape closes the loop a long way, 2 % and more, from where the given one does."""
    scene = run_24(follower={"bending_stiffness": 0.1 * run_24().follower.bending_stiffness})
    simulation = ENGINE.prepare(scene, standard_start(scene), ENGINE.settings_for(1e-3, scene))
    simulation.advance(0.39, 0.39)
    start = simulation.present_start()
    assert start is not None
    one = ENGINE.prepare(scene, start, ReferenceSettings(modes=1)).advance(1e-4, 1e-4)
    given = float(reconstruct(scene, start).slider_position)
    assert abs(float(one["slider_position"][0]) / given - 1.0) > 0.02


def test_a_shape_whose_ends_are_too_near_cannot_move() -> None:
    scene = run_24()
    model, x = BeamModel.following(scene, 2), np.linspace(0.0, scene.follower.length, 50)
    for bend, closes in ((1.0, True), (2.0, False)):  # rad from base to tip; the chord is 0.96 and 0.84 of the arc
        assert model.can_move(model.bent_state(math.pi, 0.0, (0.55, 0.0), x, bend * x / x[-1], 0.0 * x)) == closes


def test_only_what_a_scene_needs_is_built() -> None:
    settings = ReferenceSettings(modes=3)
    bare = ENGINE.describe(run_24(tip=None, base={"inertia": 0.0}), settings)
    assert bare.bodies == ("crank", "follower beam (3 shapes that follow the slider)")
    assert bare.degrees_of_freedom == 4
    full = ENGINE.describe(run_24(slider=Slider(mass=0.1, inertia=1e-4), crank={"drive": PrescribedSpeed(speed=10.0)}), settings)
    assert full.bodies[2:] == ("base block", "tip body", "slider mass", "slider rotary inertia")
    assert "crank pivot (speed prescribed)" in full.joints
    assert full.degrees_of_freedom == 3
    rigid = run_24(follower={"bending_stiffness": math.inf})
    assert ENGINE.describe(rigid, settings).degrees_of_freedom == 1
    simulation = ENGINE.prepare(run_24(), standard_start(run_24()), settings)
    assert simulation.model.degrees_of_freedom == 4


def test_a_rigid_follower_does_not_bend() -> None:
    mechanism = run_24(follower={"bending_stiffness": math.inf})
    simulation = ENGINE.prepare(mechanism, standard_start(mechanism), ReferenceSettings())
    trajectory = simulation.advance(0.2, 1e-3)
    assert np.all(trajectory["tip_deflection"] == 0.0)
    start = simulation.present_start()
    assert start.deflection is not None
    assert np.all(start.deflection(np.linspace(0.0, mechanism.follower.length, 9)) == 0.0)


def test_the_slider_turns_back_just_before_the_end_and_leaves_a_cycle_later() -> None:
    """A crank of 6.95 in, no plates: MuJoCo's chain (18 and 40 links) turns back 6.0e-5 and 6.1e-5 of the length before the end."""
    scene = run_24(crank={"length": 6.95 * INCH}, tip=NO_PLATES)
    chain = MujocoEngine().prepare(scene, standard_start(scene), ChainSettings(links=18))
    with pytest.raises(EngineFailure, match="left the follower") as of_chain:
        chain.advance(1.3, 1e-4)
    simulation = ENGINE.prepare(scene, standard_start(scene), ReferenceSettings(modes=5, tolerance=1e-7))
    with pytest.raises(EngineFailure, match="left the follower") as left:
        simulation.advance(1.3, 1e-4)
    assert left.value.time == pytest.approx(of_chain.value.time, abs=2e-4)  # the chain's is that of a row
    nearest = 1.0 - left.value.partial["slider_position"][:10000].max() / scene.follower.length
    assert nearest == pytest.approx(6.1e-5, abs=2e-6)  # 4, 7 and 11 modes lie between 5.97e-5 and 6.17e-5


def test_energy_is_kept_near_the_end_of_the_follower() -> None:
    scene = run_24(crank={"length": 6.9 * INCH}, tip=NO_PLATES)
    simulation = ENGINE.prepare(scene, standard_start(scene), ReferenceSettings(modes=5, tolerance=1e-8))
    found = simulation.advance(0.5, 1e-3)
    assert found["slider_position"].max() > 0.996 * scene.follower.length
    # 1e-6 measured; tables as coarse as elsewhere lose 2e-3 there
    assert imbalance(found) < 1e-5
