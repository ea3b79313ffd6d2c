"""An independent picture of the model with shapes that follow the slider: places in plain numpy, differentiated numerically.

Nothing of `reference_model.beam` or `reference_model.motion` is used. The follower's shapes come from an eigenvalue problem solved anew for
every place of the slider, the loop is closed by iteration, the dynamics are d'Alembert's principle for mass points whose partial
velocities and accelerations are differences of places.
"""

import cmath
import dataclasses
import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.polynomial import legendre
from numpy.typing import NDArray
from scipy.optimize import newton

from reference_model.mechanism import Mechanism, PrescribedSpeed, Slider, Tip
from reference_model.natural_modes import supported_modes

Array = NDArray[np.float64]
Complex = NDArray[np.complex128]

#: Gauss points a span: integrals of exp(i psi) and of products of modes up to the eighth to rounding.
POINTS = 24
_XI, _WEIGHTS = legendre.leggauss(POINTS)
#: Coefficients of the Legendre series through values at the Gauss points.
_TO_SERIES = (np.arange(POINTS)[:, None] + 0.5) * (legendre.legvander(_XI, POINTS - 1) * _WEIGHTS[:, None]).T

#: Central differences of order eight.
_STEPS = np.arange(-4, 5)
_FIRST = np.array([1 / 280, -4 / 105, 1 / 5, -4 / 5, 0, 4 / 5, -1 / 5, 4 / 105, -1 / 280])
_SECOND = np.array([-1 / 560, 8 / 315, -1 / 5, 8 / 5, -205 / 72, 8 / 5, -1 / 5, 8 / 315, -1 / 560])


def derivative(function: Callable[[float], NDArray[Any]], step: float, order: int = 1) -> NDArray[Any]:
    """First or second derivative at 0."""
    weights = (_FIRST, _SECOND)[order - 1]
    return np.tensordot(weights, np.array([function(step * k) for k in _STEPS]), axes=1) / step**order


@dataclass(frozen=True)
class Configuration:
    """The follower in one position: per span the Legendre series of psi and of the place relative to P in frame B."""

    s: float
    q2: float
    spans: tuple[tuple[float, float], tuple[float, float]]
    angle_series: tuple[Array, Array]
    place_series: tuple[Complex, Complex]
    strain_energy: float

    def angle(self, x: Array, span: int) -> Array:
        """Psi of the arc lengths, by the series of `span` (continued beyond its ends)."""
        return np.asarray(legendre.legval(self._xi(x, span), self.angle_series[span]), dtype=np.float64)

    def place(self, x: Array, span: int) -> Complex:
        return np.asarray(legendre.legval(self._xi(x, span), self.place_series[span]), dtype=np.complex128)

    def _xi(self, x: Array, span: int) -> Array:
        start, end = self.spans[span]
        return (2.0 * x - start - end) / (end - start)


class SupportedBeam:
    """Places of the mechanism's parts as functions of q1 and the amplitudes of `modes` modes."""

    def __init__(self, mechanism: Mechanism, modes: int) -> None:
        self.mechanism, self.modes = mechanism, modes
        self._bare = dataclasses.replace(mechanism, slider=Slider())
        self._signs = np.ones(modes)

    def shapes(self, s: float) -> tuple[Array, Array]:
        """psi_i at the Gauss points of both spans (2, POINTS, n), signs as continued from where `orient` was called; omega_i^2 (n,)."""
        length = self.mechanism.follower.length
        modes = supported_modes(self._bare, s, self.modes)
        x = np.concatenate([0.5 * s * (_XI + 1.0), s + 0.5 * (length - s) * (_XI + 1.0)])
        angles = (modes.deflection(x, 1) - modes.deflection(np.zeros(1), 1)).T
        return angles.reshape(2, POINTS, self.modes) * self._signs, (2.0 * math.pi * modes.frequencies) ** 2

    def orient(self, s: float, x: Array, angles: Array) -> None:
        """Choose the signs of the modes at s so that they are those of given shapes `angles` (k, n) at `x` (k,)."""
        self._signs = np.ones(self.modes)
        modes = supported_modes(self._bare, s, self.modes)
        own = (modes.deflection(x, 1) - modes.deflection(np.zeros(1), 1)).T
        self._signs = np.sign(np.sum(own * angles, axis=0))

    def at_place(self, s: float, eta: Array) -> Configuration:
        """The follower with the slider at s, not yet hung into the loop."""
        length = self.mechanism.follower.length
        angles, squares = self.shapes(s)
        spans, start = ((0.0, s), (s, length)), 0.0 + 0.0j
        psi_series: list[Array] = []
        place_series: list[Complex] = []
        for span in range(2):
            psi = angles[span] @ eta
            psi_series.append(_TO_SERIES @ psi)
            place = np.asarray(legendre.legint(_TO_SERIES @ np.exp(1j * psi), lbnd=-1), dtype=np.complex128)
            place *= 0.5 * (spans[span][1] - spans[span][0])
            place[0] += start
            start = complex(legendre.legval(1.0, place))
            place_series.append(place)
        energy = 0.5 * float(squares @ eta**2)
        return Configuration(s, 0.0, spans, (psi_series[0], psi_series[1]), (place_series[0], place_series[1]), energy)

    def close(self, q1: float, eta: Array) -> Configuration:
        """The follower with the slider on the crank tip."""
        crank = self.mechanism.crank.length * cmath.exp(1j * q1) - self.mechanism.pivot_distance

        def excess(s: float) -> float:
            return abs(complex(legendre.legval(1.0, self.at_place(s, eta).place_series[0]))) - abs(crank)

        s = float(newton(excess, abs(crank), x1=abs(crank) * 1.001, tol=1e-15, rtol=1e-15, maxiter=20, disp=False))
        found = self.at_place(s, eta)
        return dataclasses.replace(found, q2=cmath.phase(-crank / complex(legendre.legval(1.0, found.place_series[0]))) + math.pi)


@dataclass(frozen=True)
class Motion:
    """What differences of places say about a state: free speeds u = (q1', eta')."""

    configuration: Configuration
    s_rate: float
    partial_q2: Array  # (n + 1,)
    partial_s: Array  # (n + 1,)
    q2_remainder: float  # q2'' where u' = 0
    s_remainder: float
    points: Array  # m, arc lengths: Gauss points of both spans
    partial_angle: Array  # (n + 1, 2 POINTS) of the tangent's angle
    partial_velocity: Complex  # (n + 1, 2 POINTS), frame B
    angle_remainder: Array  # (2 POINTS,)
    acceleration_remainder: Complex  # (2 POINTS,), frame B
    mass_matrix: Array
    force: Array  # everything but M u', so that M u' = force for a free crank
    acceleration: Array  # u'
    slider_force: float  # normal
    torque: float  # of the drive
    tip_acceleration: float
    kinetic_energy: float
    strain_energy: float
    gravity_energy: float
    dissipated_power: float


def motion(beam: SupportedBeam, q: Array, u: Array) -> Motion:
    """The state q = (q1, eta), u = (q1', eta') of the mechanism of `beam`."""
    m, n = beam.mechanism, beam.modes
    follower, crank, slider = m.follower, m.crank, m.slider
    tip = m.tip or Tip(mass=0.0, inertia=0.0)
    here = beam.close(q[0], q[1:])
    x = [0.5 * (a + b) + 0.5 * (b - a) * _XI for a, b in here.spans]
    dx = np.concatenate([0.5 * (b - a) * _WEIGHTS for a, b in here.spans])
    end = np.array([follower.length])
    N = 2 * POINTS

    def picture(at: Array) -> Complex:
        """Places from O (N), tip centre and end; places in frame B (N); angles (N), of the end, of the slider; q2, s; energies."""
        c = beam.close(at[0], at[1:])
        z = np.concatenate([c.place(x[0], 0), c.place(x[1], 1)])
        alpha = np.concatenate([c.angle(x[0], 0), c.angle(x[1], 1)]) + c.q2
        alpha_end, z_end = c.angle(end, 1) + c.q2, c.place(end, 1)
        turn = cmath.exp(1j * c.q2)
        centre = turn * z_end + tip.center_of_mass * np.exp(1j * alpha_end)
        at_slider = c.angle(np.array([c.s]), 0) + c.q2
        potential = -(follower.mass_per_length * dx) @ np.real(np.conj(complex(*m.gravity)) * (turn * z))
        potential -= tip.mass * np.real(np.conj(complex(*m.gravity)) * centre[0])
        crank_moment = crank.mass * crank.center_of_mass + slider.mass * crank.length
        potential -= crank_moment * np.real(np.conj(complex(*m.gravity)) * cmath.exp(1j * at[0]))
        tail = np.concatenate([alpha, alpha_end, at_slider, [c.q2, c.s, c.strain_energy, potential]])
        return np.concatenate([turn * z, centre, turn * z_end, z, tail])

    # steps: places change by about a hundredth of their size
    angles, _ = beam.shapes(here.s)
    sizes = np.concatenate([[6e-3], 0.01 / np.max(np.abs(angles), axis=(0, 1))])

    def along(direction: Array) -> Callable[[float], Complex]:
        return lambda e: picture(q + e * direction)

    partial = np.array([derivative(along(one), size) for one, size in zip(np.eye(n + 1), sizes, strict=True)])
    remainder = derivative(along(u), 1.0 / np.max(np.abs(u) / sizes), 2)
    present = picture(q)
    rate = u @ partial

    places, relative = slice(0, N), slice(N + 2, 2 * N + 2)
    alphas, alpha_end, at_slider = slice(2 * N + 2, 3 * N + 2), 3 * N + 2, 3 * N + 3
    q2_at, s_at, strain_at, gravity_at = 3 * N + 4, 3 * N + 5, 3 * N + 6, 3 * N + 7
    mass = np.concatenate([follower.mass_per_length * dx, [tip.mass]])
    points = slice(0, N + 1)
    turning = ((alpha_end, tip.inertia), (at_slider, slider.inertia), (q2_at, m.base.inertia))
    crank_inertia = crank.inertia_about_pivot + slider.mass * crank.length**2
    M = np.real(np.conj(partial[:, points]) * mass @ partial[:, points].T)
    inertia_force = np.real(np.conj(partial[:, points]) @ (mass * remainder[points]))
    for which, J in turning:
        M += J * np.outer(partial[:, which].real, partial[:, which].real)
        inertia_force += J * partial[:, which].real * remainder[which].real
    M[0, 0] += crank_inertia
    prescribed = isinstance(crank.drive, PrescribedSpeed)
    force = -inertia_force - partial[:, strain_at].real - partial[:, gravity_at].real
    force -= m.base.damping * partial[:, q2_at].real * rate[q2_at].real
    force -= follower.damping * np.real(np.conj(partial[:, relative]) @ (dx * rate[relative]))
    if not isinstance(crank.drive, PrescribedSpeed):
        force[0] += crank.drive.torque - crank.drive.damping * u[0]
    acceleration = np.zeros(n + 1)
    if prescribed:
        acceleration[1:] = np.linalg.solve(M[1:, 1:], force[1:])
    else:
        acceleration = np.linalg.solve(M, force)

    # virtual turn of the follower about P, shape and place of contact kept: the slider force and its moment balance the rest
    total = acceleration @ partial + remainder
    lever = present[points]
    moment = float(mass @ np.imag(np.conj(lever) * (total[points] - complex(*m.gravity))))
    moment += tip.inertia * total[alpha_end].real + m.base.inertia * total[q2_at].real + m.base.damping * rate[q2_at].real
    slider_moment = -slider.inertia * total[at_slider].real
    turn = cmath.exp(1j * here.q2)
    Z = turn * complex(here.place(np.array([here.s]), 0)[0])
    tangent = cmath.exp(1j * present[at_slider].real)
    h = here.s / 2.0
    curvature = float(legendre.legval(1.0, legendre.legder(here.angle_series[0]))) / h
    tangential = -slider_moment * curvature
    contact = (moment - slider_moment - tangential * (Z.conjugate() * tangent).imag) / (Z.conjugate() * 1j * tangent).imag
    torque = 0.0
    crank_direction = cmath.exp(1j * q[0])
    if isinstance(crank.drive, PrescribedSpeed):
        pull = (contact * 1j + tangential) * tangent
        crank_moment = crank.mass * crank.center_of_mass + slider.mass * crank.length
        torque = float(np.real(np.conj(1j * crank_direction) * (crank.length * pull - crank_moment * complex(*m.gravity))))
    else:
        torque = crank.drive.torque
    damping = 0.0 if isinstance(crank.drive, PrescribedSpeed) else crank.drive.damping
    tip_normal = 1j * cmath.exp(1j * present[alpha_end].real)
    return Motion(
        configuration=here,
        s_rate=float(rate[s_at].real),
        partial_q2=partial[:, q2_at].real,
        partial_s=partial[:, s_at].real,
        q2_remainder=float(remainder[q2_at].real),
        s_remainder=float(remainder[s_at].real),
        points=np.concatenate(x),
        partial_angle=partial[:, alphas].real,
        partial_velocity=partial[:, places] / turn,
        angle_remainder=remainder[alphas].real,
        acceleration_remainder=remainder[places] / turn,
        mass_matrix=M,
        force=force,
        acceleration=acceleration,
        slider_force=contact,
        torque=torque,
        tip_acceleration=float(np.real(np.conj(tip_normal) * total[N + 1])),
        kinetic_energy=0.5 * float(u @ M @ u),
        strain_energy=here.strain_energy,
        gravity_energy=float(present[gravity_at].real)
        - (follower.mass_per_length * follower.length + tip.mass) * m.gravity[0] * m.pivot_distance,
        dissipated_power=damping * u[0] ** 2
        + m.base.damping * rate[q2_at].real ** 2
        + follower.damping * float(dx @ np.abs(rate[relative]) ** 2),
    )
