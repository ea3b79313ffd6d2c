"""The start's reconstruction against the rigid mechanism in closed form, a circular arc and finite differences."""

import math

import numpy as np
import pytest
from scipy.interpolate import CubicSpline, PPoly

from quickreturn.engines.base import EngineFailure
from quickreturn.engines.start import Start, standard_start
from quickreturn.engines.start_state import reconstruct
from tests.engines.scenes import INCH, run_24

MECHANISM = run_24()
LENGTH = MECHANISM.follower.length
X = np.linspace(0.0, LENGTH, 23)


class Arc:
    """W of a circular arc of curvature k: W' = sin(k x), so W = (1 - cos(k x)) / k."""

    def __init__(self, k: float, scale: float = 1.0) -> None:
        self.k, self.scale = k, scale

    def __call__(self, x, nu=0, /):
        k = self.k
        return self.scale * ((1 - np.cos(k * x)) / k, np.sin(k * x), k * np.cos(k * x))[nu]


def wavy(amplitude: float) -> CubicSpline:
    """W of a spline with coarse knots, clamped at the base."""
    x = np.linspace(0.0, LENGTH, 6)
    return CubicSpline(x, amplitude * (x / LENGTH) ** 2 * np.cos(5.0 * x / LENGTH), bc_type=((1, 0.0), (2, 0.0)))


@pytest.mark.parametrize("crank_angle", [math.pi, 0.5 * math.pi, 0.0, 4.0, 29.0])
def test_straight_follower_is_the_rigid_mechanism(crank_angle):
    speed, LA, d = 7.0, MECHANISM.crank.length, MECHANISM.pivot_distance
    state = reconstruct(MECHANISM, Start(crank_angle, speed))
    distance = math.sqrt(LA**2 + d**2 - 2 * LA * d * math.cos(crank_angle))
    # cosine rule and its rate; the angle of P -> C from components; 1e-14: a few roundings
    assert state.slider_position == pytest.approx(distance, abs=1e-14)
    assert state.slider_speed == pytest.approx(LA * d * math.sin(crank_angle) * speed / distance, abs=1e-13)
    assert math.tan(state.follower_angle) == pytest.approx(LA * math.sin(crank_angle) / (LA * math.cos(crank_angle) - d), abs=1e-14)
    assert abs(state.follower_angle - math.pi) < math.pi / 2
    assert state.follower_rate == pytest.approx(speed * LA * (LA - d * math.cos(crank_angle)) / distance**2, abs=1e-13)


def test_circular_arc_in_closed_form():
    k = 0.8
    state = reconstruct(MECHANISM, Start(math.pi / 3, 5.0, Arc(k)))
    # a chord of an arc: 2/k sin(k s / 2), turned from the base tangent by k s / 2
    LA, d = MECHANISM.crank.length, MECHANISM.pivot_distance
    distance = math.sqrt(LA**2 + d**2 - LA * d)
    assert state.slider_position == pytest.approx(2 / k * math.asin(k * distance / 2), abs=1e-12)
    place = state.position(X) - [d, 0.0]
    assert np.hypot(*place.T) == pytest.approx(2 / k * np.sin(k * X / 2), abs=1e-12)
    assert state.tangent(X) - state.follower_angle == pytest.approx(k * X, abs=1e-12)


@pytest.mark.parametrize("bend", [0.03, 0.12])
def test_loop_is_closed_and_arc_length_kept(bend):
    state = reconstruct(MECHANISM, Start(2.0, 5.0, wavy(bend), wavy(1.0)))
    slider = state.position(np.array([state.slider_position]))[0]
    # 1e-12: quadrature exact to round-off with panels split at the spline's knots
    assert slider == pytest.approx(MECHANISM.crank.length * np.array([math.cos(2.0), math.sin(2.0)]), abs=1e-12)
    h = 1e-5
    tangents = (state.position(X[1:-1] + h) - state.position(X[1:-1] - h)) / (2 * h)
    # central difference: h² W''' / 6 < 1e-8, and half a jump of W''' at a knot
    assert tangents == pytest.approx(np.column_stack([np.cos(state.tangent(X[1:-1])), np.sin(state.tangent(X[1:-1]))]), abs=1e-7)


def test_rates_are_time_derivatives():
    """Move crank and shape by ±h and difference the states."""
    angle, speed, h = 2.0, 5.0, 1e-6
    shape, rate = wavy(0.08), wavy(1.0)
    state = reconstruct(MECHANISM, Start(angle, speed, shape, rate))
    before, after = (
        reconstruct(MECHANISM, Start(angle + sign * h * speed, speed, PPoly(shape.c + sign * h * rate.c, shape.x))) for sign in (-1, 1)
    )
    # error of the central difference: h² times third derivatives (1e3), plus round-off 1e-14 / h: about 1e-8
    tolerance = 1e-7
    assert (after.slider_position - before.slider_position) / (2 * h) == pytest.approx(state.slider_speed, abs=tolerance)
    assert (after.follower_angle - before.follower_angle) / (2 * h) == pytest.approx(state.follower_rate, abs=tolerance)
    assert (after.position(X) - before.position(X)) / (2 * h) == pytest.approx(state.velocity(X), abs=tolerance)
    assert (after.tangent(X) - before.tangent(X)) / (2 * h) == pytest.approx(state.tangent_rate(X), abs=tolerance)


def test_standard_start_is_straight():
    state = reconstruct(MECHANISM, standard_start(MECHANISM))
    assert state.follower_angle == pytest.approx(math.pi, abs=1e-15)
    assert state.position(np.array([LENGTH]))[0] == pytest.approx([MECHANISM.pivot_distance - LENGTH, 0.0], abs=1e-15)


def test_a_follower_that_does_not_reach_is_a_failure():
    with pytest.raises(EngineFailure, match="short of the crank tip") as failure:
        reconstruct(run_24(crank={"length": 6 * INCH}), Start(math.pi, 5.0, Arc(2.2)))  # chord to the end 23.0 in, crank tip at 24 in
    assert failure.value.time == 0.0


def test_a_slope_of_one_is_a_failure():
    with pytest.raises(EngineFailure, match="slope"):
        reconstruct(MECHANISM, Start(0.0, 5.0, Arc(1.0, scale=2.0)))
