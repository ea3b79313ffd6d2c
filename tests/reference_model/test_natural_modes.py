"""Frozen-crank modes against the transcendental determinant of the two-span beam."""

import dataclasses
import math

import numpy as np
import pytest
from numpy.polynomial import legendre
from scipy.optimize import brentq

from quickreturn.reference_model.mechanism import Mechanism
from quickreturn.reference_model.natural_modes import deflections, frozen_crank_modes, supported_modes
from quickreturn.reference_model.slider import Slider
from tests.engines.scenes import INCH, run_24
from tests.verification.ladder.overhung_beam import determinant

RUN_24 = run_24()


def with_tip(offset: float) -> Mechanism:
    assert RUN_24.tip is not None
    return dataclasses.replace(RUN_24, tip=dataclasses.replace(RUN_24.tip, center_of_mass=offset))


@pytest.mark.parametrize("offset", [0.0, 0.5 * INCH])
@pytest.mark.parametrize("crank_angle", [0.0, 40.0, 90.0, 180.0])
def test_frequencies_are_roots_of_the_transcendental_determinant(offset: float, crank_angle: float) -> None:
    mechanism = with_tip(offset)
    modes = frozen_crank_modes(mechanism, math.radians(crank_angle), 4)
    for frequency in modes.frequencies:
        near = 1e-4
        root = brentq(
            lambda f: determinant(mechanism, modes.slider_position, f), frequency * (1 - near), frequency * (1 + near), xtol=1e-10
        )
        # the shapes converge to 1e-11; the determinant's root is good to 1e-10 Hz and the cancellation in cos - cosh
        assert frequency == pytest.approx(root, rel=1e-9)


def test_no_frequency_is_missed() -> None:
    modes = frozen_crank_modes(RUN_24, math.pi / 2, 4)
    scan = np.linspace(1.0, 300.0, 3000)
    signs = np.sign([determinant(RUN_24, modes.slider_position, f) for f in scan])
    assert np.count_nonzero(np.diff(signs)) == 4


def test_modes_are_orthonormal_with_respect_to_all_masses_and_rest_at_the_slider() -> None:
    mechanism = with_tip(0.5 * INCH)
    tip = mechanism.tip
    modes = supported_modes(mechanism, 0.4, 4)
    gram = np.zeros((4, 4))
    for start, end in ((0.0, 0.4), (0.4, modes.length)):
        points, weights = legendre.leggauss(30)
        x = start + (end - start) * (points + 1) / 2
        w = modes.deflection(x)
        gram += mechanism.follower.mass_per_length * (w * weights) @ w.T * (end - start) / 2
    end_slope = modes.deflection(np.array([modes.length]), 1)[:, 0]
    base_slope = modes.deflection(np.array([0.0]), 1)[:, 0]
    center = modes.tip_displacement + tip.center_of_mass * end_slope
    gram += tip.mass * np.outer(center, center) + tip.inertia * np.outer(end_slope, end_slope)
    gram += mechanism.base.inertia * np.outer(base_slope, base_slope)
    assert gram == pytest.approx(np.eye(4), abs=1e-11)  # round-off of 30 shapes
    assert modes.deflection(np.array([0.0, 0.4])) == pytest.approx(np.zeros((4, 2)), abs=1e-12)


def test_first_moments_are_integrals_of_the_deflection_times_x() -> None:
    modes = supported_modes(with_tip(0.5 * INCH), 0.4, 4)
    expected = np.zeros(4)
    for start, end in modes.spans:
        points, weights = legendre.leggauss(30)
        x = start + (end - start) * (points + 1) / 2
        expected += modes.deflection(x) @ (weights * x) * (end - start) / 2
    assert modes.first_moments() == pytest.approx(expected, rel=1e-12)


def test_modes_on_two_spans_and_on_one_are_evaluated_together() -> None:
    """The slider inside, and at the end, beyond which there is no second span; each set at places of its own; by the slopes' series."""
    length = RUN_24.follower.length
    sets = [supported_modes(RUN_24, s, 3) for s in (0.4, length, 0.3)]
    x = np.array([[0.0, 0.4, length], [0.1, 0.45, length], [0.1, 0.3, 0.45]])
    found = [deflections(sets, x, derivative) for derivative in range(3)]
    for number, modes in enumerate(sets):
        for at, place in enumerate(x[number]):
            span = sum(start <= place for start, _ in modes.spans) - 1
            (start, end), slope = modes.spans[span], modes.slope_series()[span]
            h, xi = end - start, (2.0 * place - start - end) / (end - start)
            # both spans begin where the deflection is zero
            series = legendre.legint(slope, lbnd=-1) * h / 2.0, slope, legendre.legder(slope) * 2.0 / h
            for derivative, each in enumerate(series):
                largest = np.abs(found[derivative]).max()
                assert found[derivative][number, :, at] == pytest.approx(legendre.legval(xi, each), abs=1e-10 * largest)


def test_curvature_is_that_of_the_exact_shape() -> None:
    """At P the moment equals what turns the base block, at the tip what accelerates the body, for each mode."""
    mechanism = with_tip(0.5 * INCH)
    tip, EI = mechanism.tip, mechanism.follower.bending_stiffness
    modes = frozen_crank_modes(mechanism, 1.0, 3)
    omega2 = (2 * np.pi * modes.frequencies) ** 2
    ends = np.array([0.0, modes.length])
    slope, curvature = modes.deflection(ends, 1), modes.curvature(ends)
    center = modes.tip_displacement + tip.center_of_mass * slope[:, 1]
    moment = omega2 * (tip.inertia * slope[:, 1] + tip.mass * tip.center_of_mass * center)
    peak = np.abs(modes.curvature(np.linspace(0.0, modes.length, 50))).max()
    # a natural condition, met only in the limit: its residual measures the convergence of the curvature itself
    assert EI * curvature[:, 0] == pytest.approx(-omega2 * mechanism.base.inertia * slope[:, 0], abs=1e-6 * EI * peak)
    assert EI * curvature[:, 1] == pytest.approx(moment, abs=1e-6 * EI * peak)


def test_slider_at_the_tip_is_the_limit_of_a_vanishing_overhang() -> None:
    L = RUN_24.follower.length
    at_the_tip, just_inside = supported_modes(RUN_24, L, 4).frequencies, supported_modes(RUN_24, L * (1 - 1e-7), 4).frequencies
    assert just_inside == pytest.approx(at_the_tip, rel=1e-5)  # a lever of 1e-7 L changes the tip body's effect by as little


def test_softer_joint_lowers_frequencies_and_the_rigid_one_is_its_limit_at_first_order() -> None:
    rigid = supported_modes(RUN_24, 0.4, 3).frequencies
    lowered = []
    for stiffness in (1e7, 1e8):
        soft = dataclasses.replace(RUN_24, slider=Slider(joint_stiffness=stiffness))
        lowered.append(rigid - supported_modes(soft, 0.4, 3).frequencies)
    assert np.all(lowered[0] > 0.0)
    assert lowered[0] / lowered[1] == pytest.approx(np.full(3, 10.0), rel=0.01)  # second order: below 1 % from 1e7 N/m on


def test_turning_slider_lowers_frequencies_as_rayleighs_quotient_has_it() -> None:
    s, inertia = 0.4, 1e-9
    plain = supported_modes(RUN_24, s, 3)
    turning = supported_modes(dataclasses.replace(RUN_24, slider=Slider(inertia=inertia)), s, 3)
    slope = plain.deflection(np.array([s]), 1)[:, 0]
    # first-order perturbation of a mass-normalised mode; 1e-9 kg m² is 1e-5 of the beam's, so the second order is 1e-5 of it
    assert 1.0 - turning.frequencies / plain.frequencies == pytest.approx(inertia * slope**2 / 2, rel=1e-3)


def test_what_cannot_be_is_refused() -> None:
    with pytest.raises(ValueError, match="not on the follower"):
        supported_modes(RUN_24, 0.7, 1)
    with pytest.raises(ValueError, match="free to turn"):
        supported_modes(dataclasses.replace(RUN_24, slider=Slider(joint_stiffness=0.0)), 0.4, 1)
