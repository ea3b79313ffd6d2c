"""Any piecewise polynomial shapes, exact or second-order geometry, from places alone: an oracle of another kind.

Nothing is derived here. d'Alembert's principle is evaluated as it stands, in the free coordinates y = (q1, eta_1 .. eta_n): the loop is
closed by Newton's method wherever a place is asked for, the beam is a cloud of mass points at Gauss abscissae, and partial velocities
and accelerations are central differences of places in 60-digit arithmetic (error about 1e-24 of their size). The slider force
follows afterwards from opening the loop: virtual displacements in q2 and s that leave the crank where it is.

Deflection W(x) = sum of phi_i(x) eta_i; a point of the centre line stands at (x - F, W) in frame B with F the integral of g from 0 to x.

    exact         g = 1 - sqrt(1 - W'^2), tangent angle asin W', strain energy 1/2 EI integral of W''^2 / (1 - W'^2)
    second order  g = W'^2 / 2,           tangent angle W',      strain energy 1/2 EI integral of W''^2
"""

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cache
from typing import Any, Literal, TypedDict

import mpmath  # type: ignore[import-untyped]
import numpy as np
from mpmath.calculus.quadrature import GaussLegendre  # type: ignore[import-untyped]
from numpy.typing import ArrayLike, NDArray

DIGITS = 60
GAUSS_DEGREE = 3  # mpmath's count: 12 points
Array = NDArray[np.float64]
Objects = NDArray[np.object_]  # of mpmath numbers
Geometry = Literal["exact", "second order"]


class Evaluation(TypedDict):
    """Everything about one state, SI; free coordinates in the order (q1, eta_1 .. eta_n)."""

    follower_angle: float  # rad, q2
    slider_position: float  # m, s
    follower_speed: float  # rad/s
    slider_speed: float  # m/s, s'
    accelerations: Array  # (1 + n,)
    projected_mass_matrix: Array  # (1 + n, 1 + n)
    projected_force: Array  # (1 + n,) so that projected_mass_matrix @ accelerations = projected_force
    multiplier: Array  # (2,) force of the slider on the follower along n1 and n2, N
    slider_force: float  # N, its part along the follower's normal (-W', 1 - g)
    bearings: Array  # (4,) forces of the ground on the base at P and on the crank at O, along n1 and n2 each, N
    kinetic_energy: float  # J
    strain_energy: float  # J
    gravity_energy: float  # J, zero at O
    tip_position: Array  # (2,) x = L from O, along n1 and n2, m
    tip_acceleration: Array  # (2,) absolute acceleration of x = L along n1 and n2, m/s^2


def cubic_shapes(length: float, elements: int = 1) -> Array:
    """Hermite elements of equal length, clamped at the base: coefficients (2 elements, elements, 4) for `accelerations`.

    The amplitudes are deflection (m) and slope at the end of the first element, of the second, and so on to the tip.
    """
    h = length / elements
    left = np.array([[1, 0, -3 / h**2, 2 / h**3], [0, 1, -2 / h, 1 / h**2]])
    right = np.array([[0, 0, 3 / h**2, -2 / h**3], [0, 0, -1 / h, 1 / h**2]])
    shapes = np.zeros((elements, 2, elements, 4))
    for node in range(elements):
        shapes[node, :, node] = right
        if node + 1 < elements:
            shapes[node, :, node + 1] = left
    return shapes.reshape(2 * elements, elements, 4)


def accelerations(
    parameters: Mapping[str, float],
    shapes: ArrayLike,
    state: Mapping[str, float],
    amplitudes: ArrayLike,
    amplitude_rates: ArrayLike,
    *,
    geometry: Geometry = "exact",
) -> Evaluation:
    """Accelerations, slider force and energies of one state.

    Args:
        parameters: as for `symbolic_model.evaluate` (`symbolic_model.PARAMETERS` has names and units).
        shapes: (n, panels, m) coefficients over panels of equal length h: on panel j shape i is the sum over k of
            shapes[i, j, k] (x - j h)^k with x in m. W and W' must vanish at x = 0 and be continuous.
        state: `crank_angle` (rad) and `crank_speed` (rad/s); other names are ignored.
        amplitudes: (n,) eta, with |W'| < 1 along the beam.
        amplitude_rates: (n,) their time derivatives, 1/s.
        geometry: see the module's head.

    Raises:
        ValueError: the loop does not close.
    """
    with mpmath.workdps(DIGITS):
        numbers = {name: mpmath.mpf(float(value)) for name, value in parameters.items()}
        coefficients = _objects(np.asarray(shapes, dtype=float))
        y = _objects(np.r_[state["crank_angle"], np.asarray(amplitudes, dtype=float)])
        rate = _objects(np.r_[state["crank_speed"], np.asarray(amplitude_rates, dtype=float)])
        return _Mechanism(numbers, coefficients, geometry == "exact").evaluate(y, rate)


def _objects(values: Any) -> Objects:
    return np.frompyfunc(mpmath.mpf, 1, 1)(np.asarray(values))


_sqrt, _real, _imag = (np.frompyfunc(function, 1, 1) for function in (mpmath.sqrt, mpmath.re, mpmath.im))


@cache
def _unit_rule() -> tuple[Objects, Objects]:
    """Abscissae and weights on 0 .. 1."""
    pairs = GaussLegendre(mpmath.mp).calc_nodes(GAUSS_DEGREE, mpmath.mp.prec + 20)
    return np.array([(1 + x) / 2 for x, _ in pairs]), np.array([w / 2 for _, w in pairs])


def _slope(function: Any, at: Any, step: Any) -> Any:
    return (function(at + step) - function(at - step)) / (2 * step)


def _curvature(function: Any, step: Any) -> Any:
    return (function(step) - 2 * function(0 * step) + function(-step)) / step**2


@dataclass
class _Mechanism:
    numbers: dict[str, Any]
    shapes: Objects
    exact: bool

    def __post_init__(self) -> None:
        self.step = mpmath.mpf(10) ** -15
        self.panels = self.shapes.shape[1]
        self.panel_length = self.numbers["length"] / self.panels
        nodes, weights = _unit_rule()
        self.abscissae = (self.panel_length * np.add.outer(np.arange(self.panels), nodes)).ravel()
        self.weights = np.tile(self.panel_length * weights, self.panels)
        self.gravity = mpmath.mpc(self.numbers["gravity_1"], self.numbers["gravity_2"])

    def panel(self, x: Any) -> Any:
        """Number of the panel that holds x; the last one goes on beyond the end."""
        return np.minimum(np.asarray(x / self.panel_length, dtype=float).astype(int), self.panels - 1)

    def polynomial(self, xi: Any, panel: Any, eta: Objects, order: int) -> Any:
        """W or one of its derivatives at the distance xi from the panel's beginning."""
        coefficients = np.tensordot(eta, self.shapes, 1)[panel]
        for _ in range(order):
            coefficients = coefficients[..., 1:] * np.arange(1, coefficients.shape[-1])
        total = 0 * xi
        for power in reversed(range(coefficients.shape[-1])):
            total = total * xi + coefficients[..., power]
        return total

    def field(self, x: Any, eta: Objects, order: int) -> Any:
        """W or one of its derivatives at x."""
        panel = self.panel(x)
        return self.polynomial(x - self.panel_length * panel, panel, eta, order)

    def shortening_rate(self, slope: Any) -> Any:
        """The integrand g of the foreshortening F, from W'."""
        return 1 - _sqrt(1 - slope**2) if self.exact else slope**2 / 2

    def angle(self, x: Any, eta: Objects) -> Any:
        """Tangent angle relative to b1."""
        slope = self.field(x, eta, 1)
        return mpmath.asin(slope) if self.exact else slope

    def in_base(self, x: Any, eta: Objects) -> Any:
        """Place of the point at arc length x in frame B, as a complex number."""
        nodes, weights = _unit_rule()
        panel = self.panel(x)
        xi = x - self.panel_length * panel
        whole = self.shortening_rate(self.field(self.abscissae, eta, 1)) * self.weights
        before = np.r_[0, np.cumsum(whole.reshape(self.panels, -1).sum(axis=1))][panel]
        slopes = self.polynomial(np.multiply.outer(xi, nodes), panel[..., None], eta, 1)
        return x - before - xi * np.dot(self.shortening_rate(slopes), weights) + mpmath.j * self.field(x, eta, 0)

    def loop(self, q1: Any, eta: Objects) -> tuple[Any, Any]:
        """(q2, s) of the closed loop, q2 within 90 deg of 180 deg."""
        towards = self.numbers["crank_length"] * mpmath.expj(q1) - self.numbers["pivot_distance"]
        distance = abs(towards)
        s = distance
        for _ in range(100):
            place, slope = self.in_base(s, eta), self.field(s, eta, 1)
            error = abs(place) - distance
            if abs(error) < mpmath.mpf(10) ** (4 - DIGITS) * distance:
                return (mpmath.arg(towards) - mpmath.arg(place)) % (2 * mpmath.pi), s
            tangent = mpmath.mpc(1 - self.shortening_rate(slope), slope)
            s -= error * abs(place) / mpmath.re(mpmath.conj(place) * tangent)
        raise ValueError("the loop does not close")

    def places(self, q1: Any, q2: Any, s: Any, eta: Objects) -> Objects:
        """Generalized places (N,) in the order of `masses`; the last two are x = L itself, without mass."""
        p = self.numbers
        turn, length = mpmath.expj(q2), p["length"]
        end = p["pivot_distance"] + turn * self.in_base(length, eta)
        tip_angle = q2 + self.angle(length, eta)
        points = np.r_[
            p["pivot_distance"] + turn * self.in_base(self.abscissae, eta),
            end + p["tip_center_of_mass"] * mpmath.expj(tip_angle),
            p["crank_center_of_mass"] * mpmath.expj(q1),
            p["crank_length"] * mpmath.expj(q1),
        ]
        angles = [q1, q2, tip_angle, q2 + self.angle(s, eta)]
        return np.r_[_real(points), _imag(points), angles, end.real, end.imag]

    def masses(self) -> tuple[Objects, Objects]:
        """Masses and inertias (N,) and the weights of the bodies (N,) as forces on `places`."""
        p = self.numbers
        points = np.r_[p["mass_per_length"] * self.weights, p["tip_mass"], p["crank_mass"], p["slider_mass"]]
        inertias = [p["crank_inertia"], p["base_inertia"], p["tip_inertia"], p["slider_inertia"]]
        weight = np.r_[points * self.gravity.real, points * self.gravity.imag, np.zeros(6)]
        return np.r_[points, points, inertias, 0, 0], weight

    def strain_energy(self, eta: Objects) -> Any:
        """J."""
        slope, curvature = self.field(self.abscissae, eta, 1), self.field(self.abscissae, eta, 2)
        density = curvature**2 / (1 - slope**2) if self.exact else curvature**2
        return self.numbers["bending_stiffness"] / 2 * np.dot(self.weights, density)

    def elastic_and_damping_force(self, eta: Objects, rate: Objects) -> Objects:
        """Generalized forces (n,) on eta from strain energy and from damping relative to frame B."""
        directions = _objects(np.eye(len(eta)))
        elastic = np.array([-_slope(lambda h, d=d: self.strain_energy(eta + h * d), 0, self.step) for d in directions])
        partial = [_slope(lambda h, d=d: self.in_base(self.abscissae, eta + h * d), 0, self.step) for d in directions]
        velocity = sum(part * speed for part, speed in zip(partial, rate, strict=True))
        power = [np.dot(self.weights, _real(velocity) * _real(part) + _imag(velocity) * _imag(part)) for part in partial]
        return elastic - self.numbers["beam_damping"] * np.array(power)

    def evaluate(self, y: Objects, rate: Objects) -> Evaluation:
        """See `accelerations`."""
        p, step = self.numbers, self.step
        count = len(y)

        def closed(at: Objects) -> Objects:
            q2, s = self.loop(at[0], at[1:])
            return np.r_[self.places(at[0], q2, s, at[1:]), q2, s]

        jacobian = np.array([_slope(lambda h, d=d: closed(y + h * d), 0, step) for d in _objects(np.eye(count))]).T[:-2]
        speeds = _slope(lambda h: closed(y + h * rate), 0, step)
        convective = _curvature(lambda h: closed(y + h * rate), step)[:-2]
        mass, weight = self.masses()
        applied = weight.copy()
        applied[-6] += p["crank_torque"] - p["crank_damping"] * rate[0]
        applied[-5] -= p["base_damping"] * speeds[-2]
        applied[-2:] += np.array([p["force_1"], p["force_2"]])
        internal = np.r_[0, self.elastic_and_damping_force(y[1:], rate[1:])]

        matrix = jacobian.T @ (mass[:, None] * jacobian)
        force = jacobian.T @ (applied - mass * convective) + internal
        result = np.array(list(mpmath.lu_solve(mpmath.matrix(matrix.tolist()), mpmath.matrix(force.tolist()))))
        motion = jacobian @ result + convective

        (q2, s), q1, eta = self.loop(y[0], y[1:]), y[0], y[1:]
        lacking = mass * motion - applied
        opening = [
            np.dot(_slope(lambda h: self.places(q1, q2 + h, s, eta), 0, step), lacking),
            np.dot(_slope(lambda h: self.places(q1, q2, s + h, eta), 0, step), lacking),
        ]
        place, slope = self.in_base(s, eta), self.field(s, eta, 1)
        tangent = mpmath.mpc(1 - self.shortening_rate(slope), slope)
        moving = mpmath.matrix([[-place.imag, place.real], [tangent.real, tangent.imag]])
        slider = mpmath.mpc(*mpmath.lu_solve(moving, mpmath.matrix(opening)))
        normal = mpmath.j * tangent
        fixed, here = slider * mpmath.expj(q2), closed(y)
        points = len(self.weights) + 3  # the beam's, then the tip's, crank's and slider's
        lacks = lacking[:points] + mpmath.j * lacking[points : 2 * points]
        pivot = lacks[:-2].sum() - mpmath.mpc(p["force_1"], p["force_2"]) - fixed
        at_crank = lacks[-2:].sum() + fixed
        return Evaluation(
            follower_angle=float(q2),
            slider_position=float(s),
            follower_speed=float(speeds[-2]),
            slider_speed=float(speeds[-1]),
            accelerations=result.astype(float),
            projected_mass_matrix=matrix.astype(float),
            projected_force=force.astype(float),
            multiplier=np.array([float(fixed.real), float(fixed.imag)]),
            slider_force=float(mpmath.re(slider * mpmath.conj(normal)) / abs(normal)),
            bearings=np.array([pivot.real, pivot.imag, at_crank.real, at_crank.imag], dtype=float),
            kinetic_energy=float(np.dot(mass, speeds[:-2] ** 2) / 2),
            strain_energy=float(self.strain_energy(eta)),
            gravity_energy=float(-np.dot(weight, here[:-2])),
            tip_position=here[-4:-2].astype(float),
            tip_acceleration=motion[-2:].astype(float),
        )
