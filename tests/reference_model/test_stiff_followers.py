"""What keeps a stiff follower quiet: the scales that errors are measured against, and the ceiling of the step."""

import dataclasses
import math

import numpy as np
import pytest
from scipy.integrate import quad
from scipy.linalg import eigvalsh

from quickreturn.engines.error_parts import ESTIMATED
from quickreturn.engines.one_run import run_once
from quickreturn.engines.own.reference import ReferenceEngine, ReferenceSettings
from quickreturn.engines.start import standard_start
from quickreturn.reference_model.constants import unslowed
from quickreturn.reference_model.dop853_loop import CEILING
from quickreturn.reference_model.integrate import REACHED_END
from quickreturn.reference_model.mechanism import Mechanism, PrescribedSpeed
from quickreturn.reference_model.model import BeamModel
from quickreturn.reference_model.natural_modes import frozen_crank_modes, stiffness_ratio
from quickreturn.reference_model.rigid import deflection_scale, rigid_kinetostatics, rigid_motion, static_deflection
from tests.engines.scenes import run_24

SPEED = 16.6  # rad/s


def scene_of(stiffness: float, gravity: float = 0.0, *, driven: bool = False) -> Mechanism:
    """Run 24 with its bending stiffness times a factor, the tip's centre of mass beyond the end, on a prescribed speed or its motor."""
    original = run_24()
    changes = {} if driven else {"crank": {"drive": PrescribedSpeed(speed=SPEED)}}
    bending = stiffness * original.follower.bending_stiffness
    return run_24(follower={"bending_stiffness": bending}, tip={"center_of_mass": 0.02}, gravity=(0.0, -gravity), **changes)


@pytest.mark.parametrize("gravity", [0.0, 9.81])
def test_static_deflection_is_the_integral_of_the_bending_moment(gravity: float) -> None:
    scene, angles = scene_of(1.0, gravity), 6
    beam, tip, squares = scene.follower, scene.tip, []
    center = beam.length + tip.center_of_mass
    for angle in np.linspace(0.0, 2.0 * math.pi, angles, endpoint=False):
        motion, force = rigid_motion(scene, angle, SPEED), float(rigid_kinetostatics(scene, angle, SPEED)[0])
        s, alpha = float(motion.slider_position), float(motion.follower_acceleration)
        across = -gravity * math.cos(float(motion.follower_angle))

        def moment(x: float, s: float = s, alpha: float = alpha, across: float = across, force: float = force) -> float:
            of_beam = quad(lambda xi: beam.mass_per_length * (across - xi * alpha) * (xi - x), x, beam.length)[0]
            of_tip = tip.mass * (across - center * alpha) * (center - x) - tip.inertia * alpha
            return force * max(s - x, 0.0) + of_beam + of_tip

        at_tip = quad(lambda x, moment=moment: (beam.length - x) * moment(x), 0.0, beam.length, points=[s])[0]
        squares.append((at_tip / beam.bending_stiffness) ** 2)
    assert static_deflection(scene, SPEED, angles) == pytest.approx(math.sqrt(np.mean(squares)), rel=1e-8)


def test_a_stiff_follower_deflects_as_if_its_loads_stood_still() -> None:
    scene = scene_of(1000.0)
    settings = ReferenceSettings(modes=2, tolerance=1e-7)
    cycle = 2.0 * math.pi / SPEED
    motion = run_once(ReferenceEngine(), scene, standard_start(scene), cycle, cycle / 720.0, settings).trajectory
    size = float(np.sqrt(np.mean(motion["tip_deflection"][:-1] ** 2)))
    # vibrations and their share in the load are of the order of the ratio's inverse square; the straight start excites a few of them
    assert size == pytest.approx(static_deflection(scene, SPEED), rel=40.0 / stiffness_ratio(scene) ** 2)


def test_errors_are_measured_against_a_hundredth_of_the_length_or_what_the_scene_moves_if_that_is_less() -> None:
    usual = 0.01 * run_24().follower.length
    assert deflection_scale(run_24()) == usual
    scales = [deflection_scale(scene_of(factor)) for factor in (1e2, 1e4)]
    assert scales[0] < usual
    assert scales[1] == pytest.approx(scales[0] / 100.0)
    still = dataclasses.replace(scene_of(1.0), crank=dataclasses.replace(scene_of(1.0).crank, drive=PrescribedSpeed(speed=0.0)))
    assert deflection_scale(still) == usual  # nothing moves, and nothing asks for infinite precision


@pytest.mark.parametrize("driven", [True, False])
@pytest.mark.parametrize(("modes", "slowed"), [(1, False), (3, False), (6, False), (6, True)])
def test_the_highest_frequency_is_bounded_closely(modes: int, slowed: bool, driven: bool) -> None:
    scene = scene_of(1.0, driven=driven)
    model = BeamModel.following(scene, modes, slowed_to=unslowed(modes) if slowed else 0)
    w, first = model.workspace, 0 if driven else 1
    for angle in (2.0, 3.5, 6.0):
        y = model.straight_state(angle, SPEED)
        squares = (2.0 * math.pi * frozen_crank_modes(dataclasses.replace(scene), angle, modes).frequencies) ** 2
        mass = mass_matrix(model, y)[first:, first:]
        stiffness = np.diag([*([0.0] if driven else []), *squares])
        highest = math.sqrt(eigvalsh(stiffness, mass)[-1])
        assert model.can_move(y)
        # the tables keep six modes normalised to 2e-3; the ceiling leaves 4 % to the limit of stability
        assert highest * (1.0 - 2e-3) <= w.watched[1] < 1.1 * highest


@pytest.mark.parametrize(("modes", "middle"), [(4, 3), (5, 3), (7, 4)])
def test_an_added_inertia_slows_the_higher_half_of_the_modes_and_leaves_the_rest(modes: int, middle: int) -> None:
    """No mode is faster than the middle one at its fastest; up to there, and in what stands still, nothing changes."""
    scene = scene_of(1.0)
    slowed, plain = (BeamModel.following(scene, modes, slowed_to=each) for each in (unslowed(modes), 0))
    angles = np.linspace(0.0, math.pi, 61)
    fastest = max(frozen_crank_modes(scene, angle, middle).frequencies[-1] for angle in angles)
    for angle in angles[::6]:
        own, before = (each.natural_frequencies(angle, modes) for each in (slowed, plain))
        assert own[-1] < 1.02 * fastest < before[-1]
        # held still, the modes are independent of each other: each keeps its frequency or is slowed
        assert all(np.isclose(own, frequency, rtol=1e-6).any() for frequency in before[:middle])


def mass_matrix(model: BeamModel, y: np.ndarray) -> np.ndarray:
    """Of crank and modes, from the accelerations that unit torques and modal forces would cause: by kinetic energy, not by the solver."""
    size = model.parameters.n + 1
    speeds = np.eye(size)

    def energy(rates: np.ndarray) -> float:
        state = y.copy()
        state[model.parameters.n + 2 : 2 * model.parameters.n + 3] = rates
        return float(model.observe(state[None])["kinetic_energy"][0])

    single = [energy(rates) for rates in speeds]
    return np.array([[energy(speeds[i] + speeds[j]) - single[i] - single[j] for j in range(size)] for i in range(size)])


def test_a_step_ends_where_the_integrator_would_stop_damping_the_highest_mode() -> None:
    """Without the ceiling steps creep beyond the limit of stability and are rejected: half as many evaluations again, and noise."""
    scene = scene_of(100.0)
    model = BeamModel.following(scene, 4)
    y = model.straight_state(math.pi, SPEED)
    duration = 0.1
    result = model.integrate(y, duration, 1, 3e-7)
    assert result.status == REACHED_END
    model.can_move(result.states[-1])
    longest = CEILING / model.workspace.watched[1]
    # twelve evaluations a step, some more for the first ones, which are short, and for showing the end
    assert result.calls == pytest.approx(12.0 * duration / longest, rel=0.15)
    assert result.next_step <= 1.2 * longest  # the frequency changes a little with the slider's place


@pytest.mark.parametrize("stiffness", [10.0, 1000.0])
def test_acceleration_and_force_are_as_good_as_the_deflection(stiffness: float) -> None:
    scene, engine = scene_of(stiffness, driven=True), ReferenceEngine()
    start = standard_start(scene)
    coarse, fine = (
        run_once(engine, scene, start, 0.5, 1e-3, ReferenceSettings(modes=4, tolerance=each)).trajectory for each in (3e-7, 1e-10)
    )
    errors = {name: float(np.sqrt(np.mean((coarse[name] - fine[name]) ** 2) / np.mean(fine[name] ** 2))) for name in ESTIMATED}
    assert max(errors.values()) < 2e-4, errors
