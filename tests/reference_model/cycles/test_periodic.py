"""The periodic steady state found directly: against marching, conservation of phase volume, symmetry and the drive's own period."""

import math
from dataclasses import replace

import numpy as np
import pytest

from quickreturn.reference_model.arrays import Array
from quickreturn.reference_model.cycles.periodic import NoPeriodicOrbit, PeriodicOrbit, largest_multiplier, periodic_orbit
from quickreturn.reference_model.entries import KERNEL
from quickreturn.reference_model.mechanism import PrescribedSpeed, TorqueDrive
from quickreturn.reference_model.model import BeamModel
from tests.engines.scenes import INCH, POUND_FORCE, run_24
from tests.reference_model.multipliers import floquet_multipliers

SPEED = 10.0 / 0.60176535  # rad/s
INTEGRATION = 1e-9


def straight(model: BeamModel) -> Array:
    crank = model.scene.crank
    return model.straight_state(crank.initial_angle, crank.drive.initial_speed)


def distance(model: BeamModel, orbit: PeriodicOrbit, state: Array) -> float:
    """Largest difference of a state from the orbit's, in units of the largest values along the cycle; energies and turns do not count."""
    n = model.parameters.n
    along = model.integrate(orbit.state, orbit.period / 64, 64, INTEGRATION).states
    difference = np.abs(state - orbit.state)
    blocks = (slice(1, n + 1), slice(n + 1, n + 2), slice(n + 2, n + 3), slice(n + 3, 2 * n + 3))
    return max(float(np.max(difference[block]) / np.max(np.abs(along[:, block]))) for block in blocks)


@pytest.fixture(scope="module")
def model() -> BeamModel:
    return BeamModel.following(run_24(), 3)


@pytest.fixture(scope="module")
def orbit(model: BeamModel) -> PeriodicOrbit:
    return periodic_orbit(model, straight(model), 1e-7, INTEGRATION)


def test_the_orbit_repeats(model: BeamModel, orbit: PeriodicOrbit) -> None:
    after = model.integrate(orbit.state, orbit.period, 1, INTEGRATION).states[-1]
    assert after[0] - orbit.state[0] == pytest.approx(2.0 * math.pi, abs=1e-7)
    assert distance(model, orbit, after) < 1e-6  # ten times the tolerance of the search
    assert orbit.residual < 1e-7
    assert orbit.stable


def test_known_multipliers(model: BeamModel, orbit: PeriodicOrbit) -> None:
    """Of run 24, from another program with two modes and derivatives by the crank angle: 0.773, 0.750 twice, 0.18 twice."""
    assert orbit.period == pytest.approx(2.0 * math.pi / SPEED, rel=2e-3)  # the follower's damping costs 5e-4 of the speed
    whole = floquet_multipliers(model, orbit, INTEGRATION)
    np.testing.assert_allclose(np.abs(whole[:5]), [0.773, 0.750, 0.750, 0.18, 0.18], atol=8e-3)


def test_slow_multipliers_are_those_of_the_whole_model(model: BeamModel, orbit: PeriodicOrbit) -> None:
    whole = floquet_multipliers(model, orbit, INTEGRATION)
    assert len(whole) == 2 * model.parameters.n + 1
    # the model of the slow modes is off by some 1e-3 in the motion, and so are its leading multipliers
    np.testing.assert_allclose(np.abs(whole[:3]), np.abs(orbit.multipliers[:3]), atol=5e-3)
    assert np.all(np.abs(whole[5:]) < 0.05)


def test_the_largest_multiplier_of_the_whole_model_takes_one_derivative(model: BeamModel, orbit: PeriodicOrbit) -> None:
    """A model with more modes than the slow one: what the third mode adds is of second order, and difference quotients are good to 5e-4."""
    whole = floquet_multipliers(model, orbit, INTEGRATION)[0]
    assert largest_multiplier(model, orbit, INTEGRATION) == pytest.approx(whole, abs=5e-4)
    # an eigenvector that is 30 % off: a single quotient would be off by as much
    bent = orbit.slow_jacobian + 0.3 * np.diag(np.diag(orbit.slow_jacobian))
    assert largest_multiplier(model, replace(orbit, slow_jacobian=bent), INTEGRATION) == pytest.approx(whole, abs=0.05)


def test_a_multiplier_that_is_not_real_takes_two() -> None:
    slow = BeamModel.following(run_24(crank={"drive": PrescribedSpeed(speed=9.5)}), 3)
    found = periodic_orbit(slow, straight(slow), 1e-7, INTEGRATION)
    whole = floquet_multipliers(slow, found, INTEGRATION)[0]
    assert whole.imag > 0.1
    assert largest_multiplier(slow, found, INTEGRATION) == pytest.approx(whole, abs=2e-3)


def test_the_orbit_of_another_model_leads_to_the_same_orbit(orbit: PeriodicOrbit) -> None:
    finer = BeamModel.following(run_24(), 4)
    found = periodic_orbit(finer, orbit, 1e-7, INTEGRATION)
    assert distance(finer, periodic_orbit(finer, straight(finer), 1e-7, INTEGRATION), found.state) < 1e-6  # ten times the tolerance
    assert found.cycles[0] == 0
    single = BeamModel.following(run_24(), 1)  # its slow mode is another model's
    assert periodic_orbit(single, orbit, 1e-7, INTEGRATION).cycles[0] > 0


def test_phase_volume_shrinks_as_the_equations_say(model: BeamModel, orbit: PeriodicOrbit) -> None:
    """Liouville: the product of all multipliers is exp of the integral of the divergence along the orbit.

    The slider follows from the loop; its own feedback is kept out of the divergence by closing the loop anew for every disturbed state.
    """
    two = BeamModel.following(model.scene, 2)
    found = periodic_orbit(two, straight(two), 1e-7, INTEGRATION)
    states = two.integrate(found.state, found.period / 200, 200, INTEGRATION).states[:-1]
    mean = np.mean([divergence(two, state) for state in states])  # of a periodic function: converges at once
    product = np.prod(floquet_multipliers(two, found, INTEGRATION))
    assert abs(product.imag) < 1e-6
    # derivatives by finite differences of 1e-3: 1e-3 of each of five multipliers
    assert product.real == pytest.approx(math.exp(mean * found.period), rel=5e-3)


def divergence(model: BeamModel, state: Array) -> float:
    n, (p, w) = model.parameters.n, model._at
    total = 0.0
    for i in (0, *range(1, n + 1), *range(n + 2, 2 * n + 3)):
        rates = []
        for sign in (1.0, -1.0):
            moved = state.copy()
            moved[i] += sign * 1e-6
            for _ in range(20):  # what is missed falls at least fivefold each time: the follower is nearly straight
                rate = np.empty_like(moved)
                assert KERNEL(p.address, w.address, moved.ctypes.data, rate.ctypes.data)
                moved[n + 1] += model.workspace.facts.missed
            rates.append(rate[i])
        total += (rates[0] - rates[1]) / 2e-6
    return total


def test_reversed_rotation_is_the_mirror_image(model: BeamModel, orbit: PeriodicOrbit) -> None:
    torque = 10.0 * POUND_FORCE * INCH
    drive = TorqueDrive(torque=-torque, damping=torque / SPEED, initial_speed=-SPEED)
    mirrored = BeamModel.following(run_24(crank={"drive": drive}), model.parameters.n)
    found = periodic_orbit(mirrored, straight(mirrored), 1e-7, INTEGRATION)
    assert found.state[0] == pytest.approx(-math.pi) or found.state[0] % (2.0 * math.pi) == pytest.approx(math.pi)
    assert found.period == pytest.approx(orbit.period, rel=1e-7)
    n = model.parameters.n
    image = found.state.copy()
    image[1 : n + 1] *= -1.0
    image[n + 2 :] *= -1.0
    assert distance(model, orbit, image) < 1e-6


def test_a_prescribed_speed_gives_the_period(model: BeamModel) -> None:
    prescribed = BeamModel.following(run_24(crank={"drive": PrescribedSpeed(speed=SPEED)}), model.parameters.n)
    found = periodic_orbit(prescribed, straight(prescribed), 1e-7, INTEGRATION)
    assert found.period == pytest.approx(2.0 * math.pi / SPEED, rel=1e-12)
    assert len(found.multipliers) == 4  # two slow modes, no crank
    after = prescribed.integrate(found.state, found.period, 1, INTEGRATION).states[-1]
    assert distance(prescribed, found, after) < 1e-6


def test_the_search_may_begin_anywhere(model: BeamModel, orbit: PeriodicOrbit) -> None:
    elsewhere = periodic_orbit(model, model.straight_state(0.4, 0.7 * SPEED), 1e-7, INTEGRATION)
    assert distance(model, orbit, elsewhere.state) < 1e-6
    assert elsewhere.period == pytest.approx(orbit.period, rel=1e-7)


def test_no_steady_state_is_an_answer() -> None:
    """A tenth of the stiffness: the motion is chaotic, and no search finds it periodic; a crank at rest has no cycle."""
    soft = BeamModel.following(run_24(follower={"bending_stiffness": 0.1 * run_24().follower.bending_stiffness}), 3)
    with pytest.raises(NoPeriodicOrbit, match=r"search|cycle|loop|integration"):
        periodic_orbit(soft, straight(soft), 1e-4, 1e-7)
    with pytest.raises(NoPeriodicOrbit, match="stands still"):
        periodic_orbit(soft, soft.straight_state(math.pi, 0.0))


def test_fewer_modes_are_columns_of_the_same_tables(model: BeamModel) -> None:
    few, full = BeamModel.following(run_24(), 2), BeamModel.following(run_24(), 5).with_fewer_shapes(2)
    state = few.straight_state(2.0, SPEED)
    state[1:3], state[5:7] = [0.01, -0.002], [0.3, 0.8]
    rates = []
    for each in (few, full):
        rate = np.empty_like(state)
        p, w = each._at
        assert KERNEL(p.address, w.address, state.ctypes.data, rate.ctypes.data)
        rates.append(rate)
    # 8 Gauss points in place of 5 and tables twice as fine change the accelerations by up to 6e-4
    np.testing.assert_allclose(rates[1], rates[0], rtol=2e-3)
