"""The modes that a moving slider drags along, against the modes' own change from one place to the next."""

import dataclasses

import numpy as np
import pytest
from numpy.polynomial import legendre

from quickreturn.cases.motion.moving_mode import LARGEST, moving_mode
from quickreturn.reference_model.mechanism import Crank, Mechanism, PrescribedSpeed
from quickreturn.reference_model.natural_modes import frozen_crank_modes, supported_modes
from tests.verification.measures_accuracy import thesis_scene

RUN_24: Mechanism = thesis_scene(24)[0]
ANGLES = np.linspace(0.0, np.pi, 61)
SIGNS = np.ones((61, 4))  # tip displacements positive, which is continuous on run 24


def coupling(mechanism: Mechanism, s: float) -> np.ndarray:
    """<phi_j, d phi_1/ds> by central differences and quadrature between the kinks, shape (3,)."""
    step = 1e-5
    here, ahead, behind = (supported_modes(mechanism, place, 4) for place in (s, s + step, s - step))
    points, weights = legendre.leggauss(30)
    spans = [(0.0, s - step), (s - step, s), (s, s + step), (s + step, mechanism.follower.length)]
    x = np.concatenate([0.5 * (a + b) + 0.5 * (b - a) * points for a, b in spans])
    w = np.concatenate([0.5 * (b - a) * weights for a, b in spans])
    ends = np.array([0.0, mechanism.follower.length])
    change, turn, tip_change = (
        (ahead.deflection(places, nu)[0] - behind.deflection(places, nu)[0]) / (2.0 * step) for places, nu in ((x, 0), (ends, 1), (ends, 0))
    )
    slopes, tip = here.deflection(ends, 1), mechanism.tip
    found = mechanism.follower.mass_per_length * here.deflection(x) @ (w * change)
    found += mechanism.base.inertia * slopes[:, 0] * turn[0] + tip.inertia * slopes[:, 1] * turn[1]
    found += tip.mass * (here.tip_displacement + tip.center_of_mass * slopes[:, 1]) * (tip_change[1] + tip.center_of_mass * turn[1])
    return np.asarray(found[1:])


@pytest.mark.parametrize("stiffness", [np.inf, 5e3])
@pytest.mark.parametrize("place", [12, 25, 44])
def test_modes_dragged_along_follow_from_how_the_modes_change(stiffness: float, place: int) -> None:
    mechanism = dataclasses.replace(RUN_24, slider=dataclasses.replace(RUN_24.slider, joint_stiffness=stiffness))
    modes = [frozen_crank_modes(mechanism, angle, 4) for angle in ANGLES]
    dragged = moving_mode(mechanism, ANGLES, modes, SIGNS).dragged[place]
    here, angle = modes[place], ANGLES[place]
    s = here.slider_position
    squares = (2.0 * np.pi * here.frequencies) ** 2
    rate = mechanism.pivot_distance * mechanism.crank.length * np.sin(angle) / s
    expected = 2.0 * coupling(mechanism, s) * rate * np.sqrt(squares[0]) / (squares[1:] - squares[0])
    assert dragged[1:] == pytest.approx(expected, rel=1e-5, abs=1e-8)  # differences over 1e-5 m
    assert dragged[0] == 0.0


def test_a_driven_crank_gives_way_and_a_prescribed_one_does_not() -> None:
    modes = [frozen_crank_modes(RUN_24, angle, 4) for angle in ANGLES]
    driven = moving_mode(RUN_24, ANGLES, modes, SIGNS).free_crank
    assert 0.01 < driven.max() < 0.02  # 1.4 % at the return
    prescribed = dataclasses.replace(RUN_24, crank=Crank(length=RUN_24.crank.length, drive=PrescribedSpeed(speed=16.0)))
    assert not moving_mode(prescribed, ANGLES, modes, SIGNS).free_crank.any()
    massless = dataclasses.replace(RUN_24, crank=dataclasses.replace(RUN_24.crank, mass=0.0, inertia=0.0))
    assert moving_mode(massless, ANGLES, modes, SIGNS).free_crank.max() == pytest.approx(LARGEST)
