"""A crank longer than the distance of the pivots turns the follower fully: closed forms, engines beside each other, turns and measures."""

import math
from dataclasses import replace
from functools import cache
from itertools import islice, pairwise

import numpy as np
import pytest
from scipy.integrate import quad

from quickreturn.cases.files.recorded import table_of
from quickreturn.cases.library import load_case
from quickreturn.cases.motion.catalogue import MEASURES
from quickreturn.cases.motion.measure import SettledMotion
from quickreturn.cases.motion.request import RunRequest
from quickreturn.cases.motion.steady_state import steady_state
from quickreturn.engines.accurate import simulate
from quickreturn.engines.base import EngineFailure
from quickreturn.engines.one_run import run_once
from quickreturn.engines.own.reference import ReferenceEngine
from quickreturn.engines.registry import usable_engine
from quickreturn.engines.start import standard_start
from quickreturn.engines.trajectory import Columns, rms
from quickreturn.plugins.conform.tests.mutants import column
from quickreturn.plugins.studies.uncertainty.table_model import TableModel
from quickreturn.reference_model.errors import ImpossibleMechanism
from quickreturn.reference_model.mechanism import Mechanism, PrescribedSpeed, TorqueDrive
from quickreturn.reference_model.rigid import follower_inertia, rigid_motion
from quickreturn.reference_model.scene_values import changed
from quickreturn.reference_model.spring import Spring
from tests.verification.random_machines import turning_machines
from tests.verification.random_scenes import OUTPUT_STEP

MAIN = ("reference", "thesis", "exudyn", "mujoco")
CASE = load_case("whitworth")
FLEXIBLE = CASE.mechanism
D, LA, OMEGA = FLEXIBLE.pivot_distance, FLEXIBLE.crank.length, FLEXIBLE.crank.drive.initial_speed
CLAIMED = ("tip_deflection", "tip_acceleration", "strain_1", "slider_force", "follower_rate", "follower_acceleration")
RIGID = changed(FLEXIBLE, {"follower.bending_stiffness": math.inf, "base.damping": 0.0})


def with_crank(mechanism: Mechanism, **values: object) -> Mechanism:
    return replace(mechanism, crank=replace(mechanism.crank, **values))


def columns(engine: str, scene: Mechanism, duration: float = 0.5, accuracy: float | None = None) -> Columns:
    solver = usable_engine(engine)
    settings = solver.settings_for(accuracy or solver.default_accuracy, scene)
    return run_once(solver, scene, standard_start(scene), duration, 1e-3, settings).trajectory.columns


@cache
def flexible(engine: str) -> Columns:
    return columns(engine, FLEXIBLE)


def turned_to(q1: float) -> float:
    """The angle q2 of the rigid follower from 180 deg on: the integral of dq2/dq1 = LA (LA - d cos q1) / s^2."""
    return math.pi + quad(lambda q: LA * (LA - D * math.cos(q)) / (LA**2 + D**2 - 2.0 * LA * D * math.cos(q)), math.pi, q1, epsabs=1e-13)[0]


@pytest.mark.parametrize("q1", [-7.3, 0.0, 1.0, math.pi, 4.0, 2.0 * math.pi, 11.0, 5.0 * math.pi])
def test_the_angle_runs_on_as_the_integral_of_its_rate(q1: float) -> None:
    found = rigid_motion(RIGID, np.array(q1), OMEGA)
    assert float(found.follower_angle) == pytest.approx(turned_to(q1), abs=1e-12)
    assert float(found.slider_position) == pytest.approx(math.sqrt(LA**2 + D**2 - 2.0 * LA * D * math.cos(q1)), rel=1e-14)


def test_the_follower_is_fastest_in_the_return_which_its_squareness_to_the_pivots_bounds() -> None:
    """Textbook ratio of the two halves: (360 deg - 2 alpha) / 2 alpha with cos alpha = d / LA."""
    alpha = FLEXIBLE.half_return
    assert alpha == pytest.approx(math.acos(D / LA))
    ends = rigid_motion(RIGID, np.array([-alpha, alpha]), OMEGA)
    np.testing.assert_allclose(ends.follower_angle, [-math.pi / 2.0, math.pi / 2.0], atol=1e-14)
    np.testing.assert_allclose(ends.follower_speed, OMEGA, rtol=1e-14)
    fast, slow = rigid_motion(RIGID, np.array([0.0, math.pi]), OMEGA).follower_speed
    assert fast == pytest.approx(OMEGA * LA / (LA - D))
    assert slow == pytest.approx(OMEGA * LA / (LA + D))
    assert FLEXIBLE.nearest == pytest.approx(LA - D)


@pytest.mark.parametrize("speed", [OMEGA, -OMEGA])
@pytest.mark.parametrize("engine", MAIN)
def test_a_rigid_follower_moves_as_the_closed_form_over_two_turns(engine: str, speed: float) -> None:
    scene = with_crank(RIGID, drive=PrescribedSpeed(speed=speed))
    found = columns(engine, scene)
    right = rigid_motion(scene, found["crank_angle"], speed)
    # Exudyn's steps leave 1e-3 of the acceleration, and with it of the torque
    acceleration = 3e-3 if engine == "exudyn" else 1e-6
    for name, expected, within in (
        ("follower_angle", right.follower_angle, 1e-6),
        ("follower_rate", right.follower_speed, 1e-4),
        ("follower_acceleration", right.follower_acceleration, acceleration),
        ("slider_position", right.slider_position, 1e-6),
    ):
        assert rms(found[name] - expected) < within * rms(expected), name
    assert np.ptp(found["follower_angle"]) > 4.0 * math.pi
    # the power of the drive is the rate of the follower's energy: P = T w = d/dt (I q2'^2 / 2 - S g sin q2), and the slider's weight
    inertia, moment = follower_inertia(scene)
    g, mass = scene.gravity[1], scene.crank_moment
    power = inertia * right.follower_speed * right.follower_acceleration - moment * g * np.cos(right.follower_angle) * right.follower_speed
    torque = power / speed - mass * g * np.cos(found["crank_angle"])
    assert rms(found["crank_torque"] - torque) < acceleration * rms(torque)


@pytest.mark.parametrize(
    ("engine", "within"), [("mujoco", 1e-2), ("exudyn", 6e-2), pytest.param("derived", 1e-3, marks=pytest.mark.verify)]
)
def test_engines_agree_about_a_flexible_follower_that_turns(engine: str, within: float) -> None:
    """Within some of their default accuracies in the deflection; angle and slider's place follow the crank."""
    ours, theirs = flexible("reference"), flexible(engine)
    assert np.ptp(ours["follower_angle"]) > 4.0 * math.pi
    for name in ("tip_deflection", "tip_acceleration", "strain_2", "slider_force", "crank_torque"):
        assert rms(theirs[name] - ours[name]) < within * rms(ours[name]), name
    for name in ("follower_angle", "slider_position", "tip_x", "tip_y"):
        assert rms(theirs[name] - ours[name]) < 1e-3 * rms(ours[name]), name


@pytest.mark.parametrize("engine", MAIN)
def test_pieces_go_on_from_turn_to_turn(engine: str) -> None:
    solver = usable_engine(engine)
    simulation = solver.prepare(FLEXIBLE, standard_start(FLEXIBLE), solver.settings_for(solver.default_accuracy, FLEXIBLE))
    pieces = [simulation.advance(0.1, 1e-3)["follower_angle"] for _ in range(5)]
    for before, after in pairwise(pieces):
        assert after[0] == pytest.approx(before[-1], abs=1e-9)
    assert pieces[-1][-1] - pieces[0][0] > 3.9 * math.pi


@pytest.mark.parametrize("speed", [OMEGA, pytest.param(-OMEGA, marks=pytest.mark.verify)])
@pytest.mark.verify
def test_every_settled_turn_begins_near_half_a_turn_and_says_what_it_means(speed: float) -> None:
    scene = with_crank(FLEXIBLE, drive=PrescribedSpeed(speed=speed), initial_angle=0.3)
    run = steady_state(RunRequest(mechanism=scene, duration=0.5, engine="reference", estimated=False))
    q2 = run.cycle["follower_angle"]
    assert q2[0] == pytest.approx(math.pi, abs=0.1)
    assert q2[-1] - q2[0] == pytest.approx(math.copysign(2.0 * math.pi, speed), abs=1e-6)
    motion = SettledMotion(scene, run)
    assert MEASURES["turn.pivot_angle"].of(motion).value == pytest.approx(2.0 * math.pi, rel=1e-6)
    assert math.isnan(MEASURES["max.follower_angle"].of(motion).value)
    assert MEASURES["peak.slider_position"].of(motion).value == pytest.approx(LA + D, rel=1e-3)


@pytest.mark.parametrize("speed", [OMEGA, -OMEGA])
def test_a_recorded_angle_of_later_turns_is_compared_with_the_same_turn(speed: float) -> None:
    scene = with_crank(FLEXIBLE, drive=PrescribedSpeed(speed=speed))
    found = columns("reference", scene, 2.0)
    table = table_of({name: found[name][1200:] for name in ("time", "crank_angle", "follower_angle", "tip_deflection")})
    model = TableModel(replace(CASE, scene=scene), table)
    assert not model.begins
    right = model.simulated(scene, ReferenceEngine().settings_for(1e-3, scene), model.rows)
    assert np.max(np.abs(right - model.values)) < 1e-3  # rad and m


def test_a_soft_joint_and_a_torque_turn_it_too() -> None:
    drive = TorqueDrive(torque=2.0, damping=2.0 / 26.0, initial_speed=26.0)
    scene = changed(with_crank(FLEXIBLE, drive=drive), {"slider.joint_stiffness": 2e5, "slider.joint_damping": 20.0})
    ours, theirs = (columns(engine, scene, 0.3) for engine in ("reference", "mujoco"))
    for name in ("follower_angle", "crank_speed", "tip_deflection", "slider_force"):
        assert rms(theirs[name] - ours[name]) < 5e-3 * rms(ours[name]), name
    balance = ours["kinetic_energy"] + ours["strain_energy"] + ours["gravity_energy"] + ours["dissipated_energy"] - ours["drive_work"]
    assert np.ptp(balance) < 1e-4 * np.max(ours["strain_energy"])


def test_an_engine_that_wraps_the_angle_is_told() -> None:
    wrapped = column("follower_angle", lambda angle: angle % (2.0 * math.pi))()
    with pytest.raises(EngineFailure, match=r"follower_angle jumps by a turn behind row \d+, .*numpy.unwrap"):
        run_once(wrapped, FLEXIBLE, standard_start(FLEXIBLE), 0.5, 1e-3, wrapped.settings_for(1e-2, FLEXIBLE))


def test_what_cannot_be_is_refused() -> None:
    with pytest.raises(ImpossibleMechanism, match="brings the slider to the follower's pivot"):
        with_crank(FLEXIBLE, length=D)
    with pytest.raises(ImpossibleMechanism, match="the slider leaves the follower"):
        with_crank(FLEXIBLE, length=0.26)
    with pytest.raises(ImpossibleMechanism, match="lets the spring become"):  # a turning arm passes a point that a swinging one would not
        replace(FLEXIBLE, spring=Spring(stiffness=100.0, anchor=(D + 0.2, 0.0), place=0.2, free_length=0.1))


@pytest.mark.verify
def test_claims_hold_on_random_machines_that_turn() -> None:
    """But for claims that are larger than the column, which say nothing: the acceleration of a light base rings in a cable."""
    for scene in islice(turning_machines(2026), 6):
        asked = standard_start(scene.mechanism), scene.duration, OUTPUT_STEP
        reference, *others = (simulate(usable_engine(each), scene.mechanism, *asked) for each in ("reference", "mujoco", "exudyn"))
        for name in CLAIMED:
            size, ours = rms(reference.trajectory[name]), reference.error_estimates[name]
            for other in others:
                theirs, apart = other.error_estimates[name], rms(other.trajectory[name] - reference.trajectory[name])
                assert ours + theirs > 1.0 or apart <= (ours + theirs) * size + 1e-12, (scene.name, name, other.settings)
