"""A moment at the base: the shape for it, where it is used, and the order of convergence that it brings back."""

import dataclasses
import math

import numpy as np
import pytest

from quickreturn.reference_model.beam.modes import needs_base_shape
from quickreturn.reference_model.beam.tables import following
from quickreturn.reference_model.mechanism import Base, Mechanism
from quickreturn.reference_model.model import BeamModel
from quickreturn.reference_model.natural_modes import compliance_beyond, modes_and_base_shape, supported_modes
from tests.engines.scenes import run_24
from tests.reference_model.motion.beam_runs import run, staying
from tests.reference_model.thesis.thesis_runs import error

LIGHT, HEAVY = 0.0, 1.5e-5  # kg m^2; the latter is run 24's
BRAKED = Base(damping=0.3)


def braked(base: Base) -> Mechanism:
    return run_24(base=base)


@pytest.mark.parametrize("inertia", [LIGHT, HEAVY])
@pytest.mark.parametrize("place", [0.35, 0.6])
def test_the_family_has_the_static_deflection_under_a_moment_at_the_base(inertia: float, place: float) -> None:
    """Closed form of a beam on two supports: a cubic inboard of the slider, straight outboard; the base turns by s / (3 EI)."""
    mechanism, count = braked(Base(inertia=inertia, damping=0.3)), 5
    stiffness, length = mechanism.follower.bending_stiffness, mechanism.follower.length
    shapes = modes_and_base_shape(mechanism, place, count)
    x = np.linspace(0.0, length, 41)
    amplitudes = shapes.deflection(np.zeros(1), 1)[:, 0] / (2.0 * np.pi * shapes.frequencies) ** 2
    expected = np.where(x < place, 2.0 * place * x - 3.0 * x**2 + x**3 / place, place * (place - x)) / (6.0 * stiffness)
    np.testing.assert_allclose(amplitudes @ shapes.deflection(x), expected, atol=1e-9 * np.abs(expected).max())
    angle = place / (3.0 * stiffness)
    assert amplitudes @ shapes.deflection(np.zeros(1), 1)[:, 0] == pytest.approx(angle, rel=1e-9)
    modes = supported_modes(mechanism, place, count)
    slopes = modes.deflection(np.zeros(1), 1)[:, 0]
    missing = compliance_beyond(mechanism, place, count)
    assert missing == pytest.approx(angle - np.sum((slopes / (2.0 * np.pi * modes.frequencies)) ** 2), rel=1e-9)
    assert 0.0 < missing < angle
    np.testing.assert_allclose(shapes.frequencies[:-1], modes.frequencies[:-1], rtol=1e-9)
    assert shapes.frequencies[-1] > modes.frequencies[-1]


def test_what_the_modes_leave_out_falls_with_their_number() -> None:
    """At first order without base inertia (the reason for the shape), far faster with much of it."""
    light, heavy = (
        [compliance_beyond(braked(Base(inertia=inertia)), 0.5, modes) for modes in (6, 12)] for inertia in (LIGHT, 100.0 * HEAVY)
    )
    assert light[0] / light[1] == pytest.approx(2.0, rel=0.1)
    assert heavy[0] / heavy[1] > 50.0


def test_the_shape_is_used_where_a_torque_in_the_pivot_bends_the_follower() -> None:
    assert not needs_base_shape(run_24())
    assert needs_base_shape(braked(BRAKED))
    assert needs_base_shape(braked(Base(friction_torque=0.5)))
    assert not needs_base_shape(braked(Base(inertia=1e4 * HEAVY, damping=0.3))), "a heavy base block gives the modes a moment"
    stiff = dataclasses.replace(braked(BRAKED).follower, bending_stiffness=math.inf)
    assert not needs_base_shape(dataclasses.replace(braked(BRAKED), follower=stiff))
    family, natural = (following(braked(BRAKED), 3, natural=natural).family for natural in (False, True))
    place = np.array([0.5])
    assert family.squares_at(place)[0, 2] > 1.5 * natural.squares_at(place)[0, 2]
    np.testing.assert_allclose(family.squares_at(place)[0, :2], natural.squares_at(place)[0, :2], rtol=1e-5)


def test_few_shapes_agree_with_shapes_that_stay() -> None:
    """Clamped-free modes have a moment at the base of their own. Found: 2.2e-4 with the shape; 7 natural modes are 2.7e-2 off."""
    mechanism = braked(BRAKED)
    witness = run(staying(mechanism, 10), 0.2, 200, 1e-7)[1]["tip_deflection"]
    few, more = (run(BeamModel.following(mechanism, modes), 0.2, 200, 1e-7)[1]["tip_deflection"] for modes in (3, 5))
    assert error(few, witness) < 8e-3
    assert error(more, witness) < 1.5e-3


@pytest.mark.parametrize("base", [BRAKED, Base(friction_torque=0.5), Base(inertia=0.1 * HEAVY, damping=0.3)])
def test_the_order_of_convergence_is_four(base: Base) -> None:
    """From a start in which the follower stands still, so that the pivot's torque begins at zero. Natural modes have the order one."""
    mechanism = braked(base)
    crank = dataclasses.replace(mechanism.crank, initial_angle=math.acos(mechanism.crank.length / mechanism.pivot_distance))
    mechanism = dataclasses.replace(mechanism, crank=crank)
    two, five, limit = (run(BeamModel.following(mechanism, modes), 0.2, 200, 1e-8)[1]["tip_deflection"] for modes in (2, 5, 8))
    assert math.log(error(two, limit) / error(five, limit)) / math.log(5.0 / 2.0) > 4.0
