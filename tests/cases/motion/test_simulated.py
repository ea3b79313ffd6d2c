"""The first mode's frequency in simulated steady motion, against a truth that does not pass through the fit.

The truth: a model in shapes that stay where they are once more from the same instant with a small first-mode deflection added and
subtracted. The difference of the two motions is a free vibration on the moving mechanism, without a slow part; its phase in the plane of
modal coordinate and rate advances by 2 pi times the mean frequency times the time.
"""

import itertools
from functools import cache

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.interpolate import CubicSpline

from quickreturn.cases.files.case_file import load_case
from quickreturn.cases.motion.cycle import measure_cycle
from quickreturn.cases.motion.settling import cut_cycles
from quickreturn.cases.motion.time_scale import CHANNELS, time_scale
from quickreturn.reference_model.mechanism import Mechanism
from quickreturn.reference_model.model import BeamModel
from quickreturn.reference_model.natural_modes import frozen_crank_modes
from quickreturn.reference_model.shapes import ShapeSet, clamped_free_modes, decoupled
from tests.cases.motion.vibration_truth import LAUNCHES, SteadyVibration, steady_vibration
from tests.engines.scenes import run_24
from tests.verification.random_scenes import random_scenes

Array = NDArray[np.float64]

STEP = 5e-4  # s
CYCLES = 12  # before the one that is measured: its measures need not be the steady state's, only those of a real motion
PERTURBATION = 2e-5  # kg^(1/2) m: a tip deflection of a tenth of a millimetre


@pytest.fixture(scope="module")
def mechanism() -> Mechanism:
    return run_24()


@pytest.fixture(scope="module")
def shapes(mechanism: Mechanism) -> ShapeSet:
    """Deflections that belong to the model's amplitudes."""
    follower = mechanism.follower
    return decoupled(clamped_free_modes(follower.length, 6), follower.mass_per_length, follower.bending_stiffness)[0]


@pytest.fixture(scope="module")
def model(mechanism: Mechanism) -> BeamModel:
    return BeamModel.staying(mechanism, clamped_free_modes(mechanism.follower.length, 6))


@pytest.fixture(scope="module")
def states(mechanism: Mechanism, model: BeamModel) -> Array:
    speed = mechanism.crank.drive.initial_speed
    start = model.straight_state(np.pi, speed)
    intervals = round(2.0 * np.pi * (CYCLES + 1.2) / speed / STEP)
    return model.integrate(start, STEP, intervals, 1e-8).states


def base_angles(model: BeamModel, states: Array) -> Array:
    """Tangent's angle at the base, within 90 deg of 180 deg, of the model's own shapes rather than of what is recovered."""
    angles, facts = np.empty(len(states)), model.workspace.facts
    for row, state in enumerate(states):
        assert model.can_move(state)
        angles[row] = np.pi + np.angle(-facts.frame)
    return angles


def pushed(model: BeamModel, state: Array, push: Array) -> Array:
    """The state with amplitudes changed and the loop closed again."""
    moved, n = state.copy(), model.shapes
    moved[1 : n + 1] += push
    for _ in range(40):  # what is missed falls fivefold each time at least
        assert model.can_move(moved)
        moved[n + 1] += model.workspace.facts.missed
    return moved


def modal_coordinate(mechanism: Mechanism, model: BeamModel, shapes: ShapeSet, plus: Array, minus: Array) -> tuple[Array, Array]:
    """First modal coordinate of the difference of two motions, and the mode's angular frequency, each of shape (rows,)."""
    tip, count = mechanism.tip, shapes.count
    x, weights = np.linspace(0.0, mechanism.follower.length, 201), np.full(201, mechanism.follower.length / 200)
    weights[[0, -1]] /= 2.0
    deflections, end_slopes = shapes.evaluate(x), shapes.evaluate(x[-1:], 1)[0]
    change = plus - minus
    turn = base_angles(model, plus) - base_angles(model, minus)
    d, r = mechanism.pivot_distance, mechanism.crank.length
    # the part of the difference that is the rigid mechanism at another crank angle is no vibration
    turn -= np.real(r * np.exp(1j * plus[:, 0]) / (r * np.exp(1j * plus[:, 0]) - d)) * change[:, 0]
    coordinate, frequency = np.empty(len(plus)), np.empty(len(plus))
    for row in range(len(plus)):
        mode = frozen_crank_modes(mechanism, plus[row, 0], 1)
        eta = change[row, 1 : count + 1]
        w = deflections @ eta + x * turn[row]
        phi, phi_slope = mode.deflection(x)[0], mode.deflection(x[[0, -1]], 1)[0]
        coordinate[row] = (
            mechanism.follower.mass_per_length * (weights * phi) @ w
            + tip.mass * phi[-1] * w[-1]
            + tip.inertia * phi_slope[1] * (end_slopes @ eta + turn[row])
            + mechanism.base.inertia * phi_slope[0] * turn[row]
        )
        frequency[row] = 2.0 * np.pi * mode.frequencies[0]
    return coordinate, frequency


@pytest.mark.verify
def test_consensus_is_the_frequency_of_a_small_free_vibration(
    mechanism: Mechanism, model: BeamModel, shapes: ShapeSet, states: Array
) -> None:
    observed = model.observe(states)
    time = STEP * np.arange(len(states), dtype=np.float64)
    cycle = cut_cycles(time, observed["crank_angle"], {name: observed[name] for name in CHANNELS})[CYCLES]
    scale = time_scale(mechanism)
    measures = measure_cycle(scale, cycle.time, cycle.crank_angle, cycle.channels)

    start = int(np.searchsorted(time, cycle.time[0]))
    rows = int(np.searchsorted(time, cycle.time[-1])) - start
    mode = frozen_crank_modes(mechanism, states[start, 0], 1)
    x = np.linspace(0.0, mechanism.follower.length, 81)
    # relative to the base's tangent, as the model's shapes are
    slope = mode.deflection(x, 1)[0] - mode.deflection(x[:1], 1)[0, 0]
    push = PERTURBATION * np.linalg.lstsq(shapes.evaluate(x, 1), slope, rcond=None)[0]
    motions = [model.integrate(pushed(model, states[start], sign * push), STEP, rows, 1e-10).states for sign in (1.0, -1.0)]
    coordinate, omega = modal_coordinate(mechanism, model, shapes, *motions)
    at = STEP * np.arange(rows + 1) + time[start]
    phase = np.unwrap(np.arctan2(-CubicSpline(at, coordinate)(at, 1) / omega, coordinate))
    middle = float(CubicSpline(cycle.crank_angle, cycle.time)(cycle.crank_angle[0] + np.pi))
    edges = CubicSpline(at, phase)(np.clip([cycle.time[0], middle, cycle.time[-1]], at[0], at[-1]))
    truth = np.diff(edges) / (2.0 * np.pi) / np.diff([cycle.time[0], middle, cycle.time[-1]])
    steady = steady_vibration(mechanism)
    for agreed, frequency, other in zip(measures.consensus, truth, steady.truth, strict=True):
        assert abs(agreed.first_mode_frequency - frequency) <= 2.0 * agreed.uncertainty
        assert agreed.uncertainty < 0.015 * frequency
        # both truths, from models of unlike shapes, one motion settled, the other nearly: one launch phase scatters by 0.04 %
        assert frequency == pytest.approx(other, rel=2e-3)


#: Driven hard and mildly, with the greatest and the least crank, and the two where only the amplitude is uncertain.
SHORT = (2, 4, 8, 10, 17, 24)


@cache
def run(number: int) -> SteadyVibration:
    found = steady_vibration(load_case(f"thesis-{number:02d}").mechanism)
    assert found is not None
    return found


@pytest.fixture(scope="module")
def vibrations() -> dict[int, SteadyVibration]:
    return {number: run(number) for number in SHORT}


def assert_claims_hold(found: list[SteadyVibration]) -> None:
    """At least 95 % of the frequencies lie within two of their standard deviations."""
    for z in (np.concatenate(parts) for parts in zip(*(each.z() for each in found), strict=True)):
        assert np.mean(np.abs(z) <= 2.0) >= 0.95
    for each in found:
        if not any(part.size for part in each.z()):
            continue  # nothing is claimed: of a vibration that dies within the half the truth, too, depends on how it is launched (1 %)
        assert np.all(np.array(each.scatter) / np.sqrt(LAUNCHES) < 1e-3 * np.array(each.truth))  # half of the 0.2 % it must be good to


@pytest.mark.verify
def test_frequencies_of_steady_states_lie_within_their_claims(vibrations: dict[int, SteadyVibration]) -> None:
    assert_claims_hold(list(vibrations.values()))
    errors = [
        agreed.first_mode_frequency / truth - 1.0
        for number in (4, 8, 10, 24)
        for agreed, truth in zip(vibrations[number].measures.consensus, vibrations[number].truth, strict=True)
        if agreed.first_mode_frequency is not None
    ]
    assert len(errors) == 8
    # -0.36 % in the mean, -0.8 % at worst; on the path of the crank held still, and without the modes dragged along, -0.64 and -1.04 %
    assert abs(np.mean(errors)) < 0.005
    assert np.abs(errors).max() < 0.01


@pytest.mark.verify
def test_time_scale_of_the_moving_mechanism_is_that_of_a_small_vibration(vibrations: dict[int, SteadyVibration]) -> None:
    for number in (4, 8, 10, 24):
        steady = vibrations[number]
        scale = time_scale(load_case(f"thesis-{number:02d}").mechanism)
        angle = CubicSpline(steady.cycle.time, steady.cycle.crank_angle)
        middle = float(CubicSpline(steady.cycle.crank_angle, steady.cycle.time)(steady.cycle.crank_angle[0] + np.pi))
        for start, end, truth in zip((steady.cycle.time[0], middle), (middle, steady.cycle.time[-1]), steady.truth, strict=True):
            instants = np.linspace(start, end, 400)
            running = scale.running_frequencies(angle(instants), angle(instants, 1))[:, 0].mean()
            assert running == pytest.approx(truth, rel=4e-3)  # what the slow deflection and the vibration's own size do is left out


@pytest.mark.parametrize(("number", "half"), [(2, "pre"), (17, "pre"), (17, "post")])
def test_frequency_is_there_where_only_the_amplitude_is_uncertain(number: int, half: str) -> None:
    steady = run(number)
    (measure,) = [m for m in steady.measures.measures if m.half == half and m.channel == "tip_acceleration"]
    assert measure.first_mode_frequency is not None
    assert measure.first_mode_frequency == pytest.approx(steady.truth[half == "post"], rel=0.02)  # found: 1.0, 1.8 and 0.7 %
    assert measure.first_mode_amplitude is None
    assert measure.first_mode_amplitude_uncertainty is None
    assert "amplitude" in measure.reason
    assert "frequency" not in measure.reason


@pytest.mark.verify
def test_frequencies_of_all_runs_lie_within_their_claims() -> None:
    assert_claims_hold([run(number) for number in range(1, 25)])


@pytest.mark.verify
def test_frequencies_of_random_scenes_lie_within_their_claims() -> None:
    """Scenes of a seed that nothing was tuned to; of some, no steady state is found directly."""
    found = [steady_vibration(scene.mechanism) for scene in itertools.islice(random_scenes(4711), 40)]
    resolved = [each for each in found if each is not None]
    assert len(resolved) >= 20
    assert_claims_hold(resolved)
