"""The first mode on a moving mechanism: the other modes that it excites, and its change of frequency from that with the crank held.

W = sum of eta_i phi_i(x; s) with the modes of the crank held still, mass-normalised at each place s of the slider. Where s moves,
Lagrange's equations couple them: with G_ji = <phi_j, d phi_i/ds>, skew-symmetric,

    eta_j'' + 2 s' sum of G_ji eta_i' + s'^2 <phi_j, d^2 phi_j/ds^2> eta_j + omega_j^2 eta_j = 0

(coupling through s'^2 and s'' between different modes is of higher order). A first mode A cos(phi) drags the others along as
eta_j = 2 A G_j1 s' omega_1/(omega_j^2 - omega_1^2) sin(phi), and its own omega_1^2 changes by

- -s'^2 |d phi_1/ds|^2, the inertia of the changing shape (<phi_1, d^2 phi_1/ds^2> is minus that), and
  -s'^2 sum of 4 G_j1^2 omega_1^2/(omega_j^2 - omega_1^2), the modes dragged along;
- q2'^2 (integral of N phi_1'^2 - <phi_1, phi_1>), N(x) the moment of mass outboard of x: the follower's rotation tightens and softens it;
- R_1^2/(omega_1^2 m), if the crank is free: the support moves in antiphase, with the inertia m = I/(s dq2/dq1)^2 of crank and slider mass
  and with the force R_1;

and a frequency that itself changes within a period shifts the rate of the phase by 3/8 omega'^2/omega^3 - omega''/(4 omega^2) (second
order of the WKB approximation: Bender and Orszag, Advanced Mathematical Methods, 1978, section 10.1). Together these change the frequency
by -0.6 % where the slider is fastest and by +1.1 % at the return in run 24, and by +4.7 % at the return in run 8. For small vibrations
about the nonlinear model's motion the mean frequency over a half is right to 0.4 %; at single angles it is up to 1 % off (run 8, 20 degrees
from the return). Neglected: the slider's own rotary inertia in the coupling, and the effect of the slow deflection.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.interpolate import CubicSpline

from quickreturn.reference_model.arrays import Array
from quickreturn.reference_model.mechanism import Mechanism
from quickreturn.reference_model.natural_modes import FrozenModes, deflections

LARGEST = 0.1  # largest change for which perturbation holds; a crank as light as the follower yields completely
TINY = np.finfo(np.float64).tiny


@dataclass(frozen=True)
class MovingMode:
    """Changes of the first mode, at the angles of the given modes."""

    # with A cos(phi) in the first mode the others have this times A q1' sin(phi), s/rad, shape (angles, modes); zero for the first itself
    dragged: Array
    free_crank: Array  # relative change of the frequency because the crank is free, shape (angles,)
    motion: Array  # the same because the crank turns, per square of its speed, s^2/rad^2, shape (angles,)


def moving_mode(mechanism: Mechanism, angles: Array, modes: Sequence[FrozenModes], signs: Array) -> MovingMode:
    """Follow the first mode over half a turn, or a turn (`natural_modes.turn_angles`).

    Args:
        mechanism: the scene.
        angles: of the crank, rad, evenly spaced over 0 .. pi or 0 .. 2 pi, shape (angles,).
        modes: with the crank held at each of them, at least two.
        signs: that make the modes continuous over the angles, shape (angles, modes).
    """
    d, r = mechanism.pivot_distance, mechanism.crank.length
    arm = r * np.exp(1j * angles)
    s, turned = np.abs(arm - d), np.real(arm / (arm - d))  # and d q2/d q1
    along = d * r * np.sin(angles) / s  # d s/d q1
    omega = 2.0 * np.pi * np.array([mode.frequencies for mode in modes])
    first, apart = omega[:, 0], omega[:, 1:] ** 2 - omega[:, :1] ** 2

    places = np.array([[0.0, mode.slider_position, mechanism.follower.length] for mode in modes])
    at_base, slopes, at_tip = np.moveaxis(deflections(modes, places, 1), 2, 0)
    forces = -(omega**2) * _moments_of_momentum(mechanism, modes, at_base, slopes, at_tip) / s[:, None]
    # differentiating the eigenproblem, the modes' orthogonality and the support's condition by s gives G from one place alone
    coupling = (forces[:, :1] * slopes[:, 1:] + forces[:, 1:] * slopes[:, :1]) / apart
    dragged = 2.0 * coupling * (along * first)[:, None] / apart

    inertia, tension = _changing_shape(mechanism, angles, modes, signs[:, 0])
    squares = turned**2 * tension - inertia - np.sum((2.0 * coupling * along[:, None]) ** 2 / apart, axis=1) * first**2
    even = periodic(angles, first)
    changing = 0.375 * even(angles, 1) ** 2 / first**4 - 0.25 * even(angles, 2) / first**3
    yielding = (forces[:, 0] * s * turned) ** 2
    resisting = np.maximum(2.0 * mechanism.crank_inertia * first**4, yielding / LARGEST + TINY)
    return MovingMode(
        dragged=np.column_stack([np.zeros(angles.size), signs[:, :1] * signs[:, 1:] * dragged]),
        free_crank=yielding / resisting if mechanism.crank_is_free else np.zeros(angles.size),
        motion=squares / (2.0 * first**2) + changing,
    )


def periodic(angles: Array, values: Array, sign: float = 1.0) -> CubicSpline:
    """Periodic spline through values over a turn, or over half a turn that the other half mirrors with the same or the other sign."""
    if angles[-1] < 1.5 * np.pi:
        angles = np.concatenate([angles, 2.0 * np.pi - angles[-2::-1]])
        values = np.concatenate([values, sign * values[-2::-1]])
    return CubicSpline(angles, np.concatenate([values[:-1], values[:1]]), bc_type="periodic")


def _moments_of_momentum(mechanism: Mechanism, modes: Sequence[FrozenModes], at_base: Array, at_slider: Array, at_tip: Array) -> Array:
    """Moment of momentum about P of each mode at unit rate, kg^(1/2) m; the support's force balances its change.

    Slopes and result have the shape (angles, modes).
    """
    tip = mechanism.tip_body
    moments = mechanism.follower.mass_per_length * np.array([mode.first_moments() for mode in modes])
    moments += mechanism.base.inertia * at_base + mechanism.slider.inertia * at_slider + tip.inertia * at_tip
    at_center = np.array([mode.tip_displacement for mode in modes]) + tip.center_of_mass * at_tip
    return np.asarray(moments + tip.mass * (mechanism.follower.length + tip.center_of_mass) * at_center)


def _changing_shape(mechanism: Mechanism, angles: Array, modes: Sequence[FrozenModes], signs: Array) -> tuple[Array, Array]:
    """|d phi_1/d q1|^2 and the integral of N phi_1'^2 less <phi_1, phi_1> without rotary inertia, each of shape (angles,)."""
    follower, tip = mechanism.follower, mechanism.tip_body
    length, density = follower.length, follower.mass_per_length
    x = np.linspace(0.0, length, 61)
    weights = np.full(x.size, x[1])
    weights[[0, -1]] *= 0.5
    shape, slope = (signs[:, None] * deflections(modes, x, derivative)[:, 0] for derivative in (0, 1))

    def carried(deflection: Array, end_slope: Array) -> Array:
        return np.asarray(density * deflection**2 @ weights + tip.mass * (deflection[:, -1] + tip.center_of_mass * end_slope) ** 2)

    change, turn = (np.gradient(values, angles, axis=0, edge_order=2) for values in (shape, slope))
    changing = carried(change, turn[:, -1]) + tip.inertia * turn[:, -1] ** 2 + mechanism.base.inertia * turn[:, 0] ** 2
    outboard = 0.5 * density * (length**2 - x**2) + tip.mass * (length + tip.center_of_mass)
    return changing, np.asarray(slope**2 @ (weights * outboard) - carried(shape, slope[:, -1]))
