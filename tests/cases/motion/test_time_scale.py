"""The mechanism's time scale, the quasi-static slow part and the modes that a moving slider drags along, against other ways to them."""

import dataclasses
import math

import numpy as np
import pytest
from numpy.polynomial import legendre

from quickreturn.cases.motion.moving_mode import LARGEST, moving_mode
from quickreturn.cases.motion.time_scale import follower_acceleration, quasi_static_strain, quasi_static_tip_acceleration, time_scale
from quickreturn.engines.exudyn.engine import ExudynEngine
from quickreturn.engines.exudyn.settings import ExudynSettings
from quickreturn.reference_model.mechanism import Crank, Mechanism, PrescribedSpeed
from quickreturn.reference_model.natural_modes import frozen_crank_modes, supported_modes
from quickreturn.reference_model.spring import Spring
from tests.verification.measures_accuracy import thesis_scene

RUN_24: Mechanism = thesis_scene(24)[0]
ONES = np.ones((61, 4))  # the modes' signs: tip displacements positive, which is continuous on run 24


def test_frequencies_between_the_tabulated_angles() -> None:
    scale = time_scale(RUN_24)
    for angle in (0.123, 1.777, 3.0, 4.4, 100.0):
        exact = frozen_crank_modes(RUN_24, angle, 3).frequencies
        assert scale.frequencies(angle) == pytest.approx(exact, rel=1e-6)  # cubic interpolation over 1°


def test_scale_of_a_soft_joint_is_that_joints_own() -> None:
    """Against Exudyn's cable elements on a spring, which err by 6e-5 in the first two modes; the rigid joint's lie 2 and 20 % higher."""
    soft = dataclasses.replace(RUN_24, slider=dataclasses.replace(RUN_24.slider, joint_stiffness=2e4))
    scale, rigid = time_scale(soft), time_scale(RUN_24)
    for degrees in (180.0, 90.0, 30.0, 0.0):
        expected = ExudynEngine().natural_frequencies(soft, math.radians(degrees), 2, ExudynSettings(elements=24))
        assert scale.frequencies(math.radians(degrees))[:2] == pytest.approx(expected, rel=1.5e-4)
    assert np.all(rigid.frequencies(math.pi / 2.0)[:2] / scale.frequencies(math.pi / 2.0)[:2] > [1.02, 1.19])


def test_scale_is_symmetric_about_the_return_and_periodic() -> None:
    scale = time_scale(RUN_24)
    angles = np.linspace(0.0, np.pi, 50)
    for function in (scale.frequencies, *scale.templates.values()):
        assert function(-angles) == pytest.approx(function(angles), abs=1e-9)  # round-off
        assert function(angles + 6.0 * np.pi) == pytest.approx(function(angles), abs=1e-9)


def test_scale_with_a_spring_beside_the_line_is_that_of_the_whole_turn() -> None:
    """Against the modes at each angle; and the mirrored machine has the mirrored scale, with all that motion changes."""
    aside = Spring(stiffness=3e3, anchor=(0.05, -0.3), free_length=0.2)
    scale, mirrored = (
        time_scale(dataclasses.replace(RUN_24, spring=spring)) for spring in (aside, dataclasses.replace(aside, anchor=(0.05, 0.3)))
    )
    for angle in (0.7, 2.0, 2.0 * math.pi - 2.0, 2.0 * math.pi - 0.7):
        exact = frozen_crank_modes(dataclasses.replace(RUN_24, spring=aside), angle, 3).frequencies
        assert scale.frequencies(angle) == pytest.approx(exact, rel=1e-6)  # cubic interpolation over 1°
    assert abs(scale.frequencies(0.7)[0] / scale.frequencies(-0.7)[0] - 1.0) > 5e-3  # the halves of the turn differ
    angles = np.linspace(0.0, 2.0 * np.pi, 100)
    assert scale.frequencies(angles) == pytest.approx(mirrored.frequencies(-angles), rel=1e-9)  # round-off
    assert scale.motion(angles) == pytest.approx(mirrored.motion(-angles), abs=1e-8)
    for name, template in scale.templates.items():
        assert np.abs(template(angles)) == pytest.approx(np.abs(mirrored.templates[name](-angles)), abs=1e-8)


def test_templates_follow_the_mode_at_constant_action_without_jumping_sign() -> None:
    """At constant action the energy omega² a²/2 is proportional to omega; compare ratios between angles."""
    scale = time_scale(RUN_24)
    one, other = (frozen_crank_modes(RUN_24, angle, 3) for angle in (0.7, 2.4))
    gauge = np.array([RUN_24.follower.strain_gauges[1]])
    modal = [np.sqrt(2.0 / (2.0 * np.pi * modes.frequencies)) for modes in (one, other)]  # energy = omega
    accelerations = [a * (2 * np.pi * m.frequencies) ** 2 * m.tip_displacement for a, m in zip(modal, (one, other), strict=True)]
    strains = [a * m.curvature(gauge)[:, 0] for a, m in zip(modal, (one, other), strict=True)]
    for channel, (first, second) in {"tip_acceleration": accelerations, "strain_2": strains}.items():
        template = scale.templates[channel]
        assert np.abs(template(2.4) / template(0.7)) == pytest.approx(np.abs(second / first), rel=1e-5)  # interpolation
        jumps = np.abs(np.diff(template(np.linspace(0.0, 2.0 * np.pi, 721)), axis=0))
        assert jumps.max() < 0.1  # a sign lost on the way would jump by twice a value of order 1


def test_template_of_a_channel_that_keeps_its_sign_never_vanishes() -> None:
    for run in (6, 10, 17, 24):
        scale = time_scale(thesis_scene(run)[0])
        for template in scale.templates.values():
            values = template(np.linspace(0.0, 2.0 * np.pi, 721))
            assert np.abs(values[:-1]).mean(axis=0) == pytest.approx(np.ones(3), rel=0.01)  # different grids
            keeps = values.min(axis=0) * values.max(axis=0) > 0.0
            rms = np.sqrt(np.mean(values**2, axis=0))
            assert np.all(np.abs(values).min(axis=0)[keeps] > 0.14 * rms[keeps])  # floor 0.15 of the RMS before flooring


def test_gauges_that_see_nothing_are_left_out() -> None:
    follower = dataclasses.replace(RUN_24.follower, strain_gauges=(math.nan, 0.3, RUN_24.follower.length))
    scale = time_scale(dataclasses.replace(RUN_24, follower=follower, tip=None))
    assert scale.channels == ("tip_acceleration", "strain_2")


def test_rigid_follower_has_no_time_scale() -> None:
    assert time_scale(dataclasses.replace(RUN_24, follower=dataclasses.replace(RUN_24.follower, bending_stiffness=math.inf))) is None


def test_follower_acceleration_is_the_second_derivative_of_its_angle() -> None:
    step = 1e-4
    q1 = np.linspace(0.0, 2.0 * np.pi, 37) + 0.01
    d, r = RUN_24.pivot_distance, RUN_24.crank.length

    def angle(q: np.ndarray) -> np.ndarray:
        return np.asarray(np.angle(d - r * np.exp(1j * q)))  # half a turn from the follower's, without its jump

    numerical = (angle(q1 + step) - 2.0 * angle(q1) + angle(q1 - step)) / step**2
    acceleration, s = follower_acceleration(RUN_24, q1)
    assert acceleration == pytest.approx(numerical, abs=1e-6)  # round-off 1e-16/step², truncation step²
    assert s == pytest.approx(np.hypot(r * np.cos(q1) - d, r * np.sin(q1)), rel=1e-14)
    assert quasi_static_tip_acceleration(RUN_24, q1) == pytest.approx(RUN_24.follower.length * numerical, abs=1e-6)


@pytest.mark.parametrize("offset", [0.0, 0.0127])
@pytest.mark.parametrize("gauge", [0.1, 0.3175, 0.47625, 0.6])
def test_quasi_static_strain_from_the_inboard_side(offset: float, gauge: float) -> None:
    """The same bending moment from what lies between P and the gauge: pin reaction, base block, beam, slider force."""
    assert RUN_24.tip is not None
    mechanism = dataclasses.replace(RUN_24, tip=dataclasses.replace(RUN_24.tip, center_of_mass=offset))
    tip, beam = mechanism.tip, mechanism.follower
    q1 = np.linspace(0.0, 2.0 * np.pi, 41)
    alpha, s = follower_acceleration(mechanism, q1)
    L, mu, center = beam.length, beam.mass_per_length, beam.length + tip.center_of_mass
    inertia = mechanism.base.inertia + mu * L**3 / 3 + tip.inertia + tip.mass * center**2
    slider_force = inertia * alpha / s
    pin_force = (mu * L**2 / 2 + tip.mass * center) * alpha - slider_force
    # about the gauge, of the inboard part: pin and slider forces, less the inertia of base block and beam
    moment = (
        mechanism.base.inertia * alpha
        + pin_force * gauge
        + np.where(s < gauge, slider_force * (gauge - s), 0.0)
        - mu * alpha * gauge**3 / 6.0
    )
    strain = moment / beam.bending_stiffness * beam.thickness / 2.0
    found = quasi_static_strain(mechanism, gauge, q1)
    assert found == pytest.approx(strain, abs=1e-12 * np.abs(strain).max())  # round-off


def test_acceleration_lags_as_the_second_derivative_of_a_drifting_oscillation_does() -> None:
    """Tip motion A cos phi with A ~ omega^(-1/2) phi_L, derived twice by differences, beside what the other modes add to it."""
    scale = time_scale(RUN_24)
    speed = 0.5  # rad/s: slow, so that what is of second order in the rates of change drops out
    time = np.linspace(0.0, np.pi / speed, 40001)
    angles = np.pi + speed * time
    omega = 2.0 * np.pi * scale.frequencies(angles)[:, 0]
    phase = np.concatenate([[0.0], np.cumsum((omega[1:] + omega[:-1]) / 2.0 * np.diff(time))])
    template = scale.templates["tip_acceleration"](angles)[:, 0]
    motion = template / omega**2 * np.exp(1j * phase)
    acceleration = np.diff(motion, 2) / (time[1] - time[0]) ** 2
    lag = -np.angle(-acceleration / np.exp(1j * phase[1:-1]))
    places = angles[1:-1:400]
    modes = [frozen_crank_modes(RUN_24, angle, 4) for angle in places]
    moving = moving_mode(RUN_24, np.linspace(0.0, np.pi, 61), [frozen_crank_modes(RUN_24, a, 4) for a in np.linspace(0.0, np.pi, 61)], ONES)
    tips = np.array([mode.tip_displacement for mode in modes])
    dragged = np.array([np.interp(2.0 * np.pi - places, np.linspace(0.0, np.pi, 61), column) for column in moving.dragged.T]).T
    # beyond half a turn the slider goes the other way
    others = -speed * np.einsum("aj,aj->a", dragged, tips) / tips[:, 0]
    found = scale.quadratures["tip_acceleration"](angles)[1:-1:400] * speed / template[1:-1:400]
    assert np.abs(found).max() > 2e-3
    assert found - others == pytest.approx(lag[::400], abs=1e-4)  # second order in e, and differences over 1e-2 of a period


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
