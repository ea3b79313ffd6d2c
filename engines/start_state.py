"""From a `Start` to positions and velocities: closes the loop for a bent follower and evaluates its centre line anywhere.

Engines with coordinates of their own (nodes, hinges) take their initial values from here, so that all begin in the same state.
Symbols: P = O + d n1, b1 the base tangent at angle q2, W(x) the deflection along b2 at arc length x. The follower is inextensible:
the point at x lies at p = (x - F, W) in frame B with F = ∫₀ˣ (1 - sqrt(1 - W'²)) dξ.
"""

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
import scipy

from quickreturn.engines.base import EngineFailure
from quickreturn.engines.start import Field, Start
from quickreturn.reference_model.arrays import Array
from quickreturn.reference_model.mechanism import Mechanism
from quickreturn.reference_model.rigid import follower_angle

_PANELS = 256  # of equal length, for integrals along the follower; knots of the fields split them further
_GAUSS_POINTS, _GAUSS_WEIGHTS = np.polynomial.legendre.leggauss(8)


@dataclass(frozen=True)
class FollowerState:
    """The follower's place and motion at the start, in the frame of O. Angles in rad, lengths in m, rates per second."""

    follower_angle: float  # q2, tangent at the base; the chord from P to a slider is at `rigid.follower_angle`
    follower_rate: float  # its rate
    _pivot_distance: float
    _shape: "_Shape"

    def position(self, x: Array) -> Array:
        """Places of the arc lengths `x` (m, shape (n,)), m, shape (n, 2)."""
        return np.array([self._pivot_distance, 0.0]) + self._shape.position(x) @ _rotation(self.follower_angle).T

    def velocity(self, x: Array) -> Array:
        """Velocities of the arc lengths `x` (m, shape (n,)), m/s, shape (n, 2)."""
        turning = self.follower_rate * _quarter_turn(self._shape.position(x))
        return (turning + self._shape.velocity(x)) @ _rotation(self.follower_angle).T

    def tangent(self, x: Array) -> Array:
        """Angle of the tangent from n1 at the arc lengths `x` (m, shape (n,)), rad, shape (n,)."""
        return self.follower_angle + np.arcsin(self._shape.slope(x))

    def tangent_rate(self, x: Array) -> Array:
        """Rate of the tangent's angle at fixed arc length `x` (m, shape (n,)), rad/s, shape (n,)."""
        return self.follower_rate + self._shape.slope_rate(x) / np.sqrt(1.0 - self._shape.slope(x) ** 2)


@dataclass(frozen=True)
class StartState(FollowerState):
    """The follower's place and motion at the start, with the slider's place and speed."""

    slider_position: float  # s, arc length from P
    slider_speed: float  # its rate


def at_rest(length: float) -> FollowerState:
    """A follower of this length (m) that lies still and straight along n1, its pivot at O."""
    return FollowerState(0.0, 0.0, 0.0, _Shape(None, None, length))


def reconstruct(mechanism: Mechanism, start: Start) -> StartState:
    """Close the vector loop of `mechanism` (thesis eq. 4.4) and its rate for the follower's shape in `start`.

    Raises:
        EngineFailure: at time 0, if the slope W' reaches 1 or the bent follower does not reach the crank tip.
    """
    length, d, LA = mechanism.follower.length, mechanism.pivot_distance, mechanism.crank.length
    shape = _Shape(start.deflection, start.deflection_rate, length)
    crank_arm = LA * np.array([math.cos(start.crank_angle), math.sin(start.crank_angle)])
    chord = crank_arm - [d, 0.0]  # from P to the slider
    distance = math.hypot(*chord)

    def excess(s: float) -> float:
        """Distance from P to the follower's point at s, less that from P to the slider, m."""
        return float(np.hypot(*shape.position(np.array([s]))[0])) - distance

    if excess(length) < 0.0:
        raise EngineFailure(
            0.0,
            f"the bent follower ends {-excess(length):.3g} m short of the crank tip, the loop cannot be closed",
            "start with a smaller deflection or at another crank angle",
        )
    # The chord is never longer than the arc, so the root lies at or beyond `distance`.
    s = distance if excess(distance) >= 0.0 else float(scipy.optimize.brentq(excess, distance, length, xtol=1e-15 * length, rtol=1e-15))
    at_slider = np.array([s])
    place, rate = shape.position(at_slider)[0], shape.velocity(at_slider)[0]
    q2 = float(follower_angle(mechanism, np.array(start.crank_angle))) - math.atan2(place[1], place[0])

    slope = float(shape.slope(at_slider)[0])
    tangent = np.array([math.sqrt(1.0 - slope**2), slope])
    crank_tip_speed = _rotation(q2).T @ (start.crank_speed * _quarter_turn(crank_arm))
    q2_rate, s_rate = np.linalg.solve(np.column_stack([_quarter_turn(place), tangent]), crank_tip_speed - rate)
    return StartState(q2, float(q2_rate), d, shape, s, float(s_rate))


class _Shape:
    """The bent centre line in frame B: p(x) and its rate (-Ḟ, Ẇ)."""

    def __init__(self, deflection: Field | None, deflection_rate: Field | None, length: float) -> None:
        self._deflection, self._deflection_rate = (_zero if field is None else field for field in (deflection, deflection_rate))
        # split at the knots of piecewise polynomials too, so that every integrand is smooth within a panel
        knots = [np.asarray(getattr(field, "x", ())) for field in (deflection, deflection_rate)]
        edges = np.array(sorted({*np.linspace(0.0, length, _PANELS + 1), *np.concatenate([[], *knots])}))
        self._edges = edges[(edges >= 0.0) & (edges <= length)]
        steepest = float(np.max(np.abs(self.slope(np.append(self._edges, _gauss_points(self._edges))))))
        if not steepest < 1.0:
            raise EngineFailure(0.0, f"the follower's slope W' reaches {steepest:.3g} at the start", "start with a slope below 1")
        self._foreshortening = _cumulative(self._foreshortening_density, self._edges)
        self._foreshortening_rate = _cumulative(self._foreshortening_rate_density, self._edges)

    def slope(self, x: Array) -> Array:
        return self._deflection(x, 1)

    def slope_rate(self, x: Array) -> Array:
        return self._deflection_rate(x, 1)

    def position(self, x: Array) -> Array:
        shortened = self._integral(self._foreshortening, self._foreshortening_density, x)
        return np.column_stack([x - shortened, self._deflection(x)])

    def velocity(self, x: Array) -> Array:
        shortened_rate = self._integral(self._foreshortening_rate, self._foreshortening_rate_density, x)
        return np.column_stack([-shortened_rate, self._deflection_rate(x)])

    def _foreshortening_density(self, x: Array) -> Array:
        slope_squared = self.slope(x) ** 2
        return slope_squared / (1.0 + np.sqrt(1.0 - slope_squared))  # 1 - sqrt(1 - W'²) without cancellation

    def _foreshortening_rate_density(self, x: Array) -> Array:
        slope = self.slope(x)
        return slope * self.slope_rate(x) / np.sqrt(1.0 - slope**2)

    def _integral(self, at_edges: Array, density: Callable[[Array], Array], x: Array) -> Array:
        panel = np.clip(np.searchsorted(self._edges, x, side="right") - 1, 0, len(self._edges) - 2)
        return at_edges[panel] + _integrals(density, self._edges[panel], x)


def _gauss_points(edges: Array) -> Array:
    """The Gauss points of all panels between the edges, shape (panels * 8,)."""
    middles, halves = (edges[1:] + edges[:-1]) / 2.0, np.diff(edges) / 2.0
    return np.ravel(middles[:, None] + halves[:, None] * _GAUSS_POINTS)


def _integrals(density: Callable[[Array], Array], low: Array, high: Array) -> Array:
    """The integral of `density` between each pair of limits, shape (n,)."""
    half = (high - low) / 2.0
    points = ((high + low) / 2.0)[:, None] + half[:, None] * _GAUSS_POINTS
    return half * (density(points.ravel()).reshape(points.shape) @ _GAUSS_WEIGHTS)


def _cumulative(density: Callable[[Array], Array], edges: Array) -> Array:
    return np.concatenate([[0.0], np.cumsum(_integrals(density, edges[:-1], edges[1:]))])


def _zero(x: Array, nu: int = 0, /) -> Array:
    return np.zeros_like(x)


def _rotation(angle: float) -> Array:
    c, s = math.cos(angle), math.sin(angle)
    return np.array([[c, -s], [s, c]])


def _quarter_turn(p: Array) -> Array:
    return np.stack([-p[..., 1], p[..., 0]], axis=-1)
