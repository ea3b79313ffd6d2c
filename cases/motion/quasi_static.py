"""The slow part of each channel to first approximation: the rigid mechanism's motion and the strain of its inertia loads.

Closed form, from the rigid loop d n1 + s b1 = LA a1 with the crank at unit constant speed; values scale with the square of the
crank speed.
"""

import numpy as np
from numpy.typing import NDArray

from quickreturn.reference_model.mechanism import Mechanism

Array = NDArray[np.float64]


def follower_acceleration(mechanism: Mechanism, crank_angle: Array) -> tuple[Array, Array]:
    """Angular acceleration of the rigid follower at unit crank speed, and the slider's arc length.

    Args:
        mechanism: the scene.
        crank_angle: rad, shape (n,).

    Returns:
        d^2 q2 / d q1^2 (1/rad, shape (n,)), and s in m, shape (n,).
    """
    z = mechanism.crank.length * np.exp(1j * crank_angle)
    u = z - mechanism.pivot_distance  # s e^(i q2): q2' = Re(z/u), derived once more
    return mechanism.pivot_distance * np.imag(z / u**2), np.abs(u)


def quasi_static_tip_acceleration(mechanism: Mechanism, crank_angle: Array) -> Array:
    """Tip acceleration of the rigid mechanism along the follower's normal at unit crank speed, m/rad^2, shape (n,)."""
    angular, _ = follower_acceleration(mechanism, crank_angle)
    return mechanism.follower.length * angular


def quasi_static_strain(mechanism: Mechanism, arc_length: float, crank_angle: Array) -> Array:
    """Surface strain under the inertia loads of the rigid motion at unit crank speed, s^2, shape (n,).

    EI W'' is the moment of the outboard inertia forces (beam, tip body) and of the slider force where the slider is outboard.

    Args:
        mechanism: the scene, with a flexible follower.
        arc_length: m, the gauge's place.
        crank_angle: rad, shape (n,).
    """
    follower, tip, x = mechanism.follower, mechanism.tip_body, arc_length
    angular, s = follower_acceleration(mechanism, crank_angle)
    L, rho_a = follower.length, follower.mass_per_length
    moment_of_inertia = mechanism.base.inertia + rho_a * L**3 / 3.0
    outboard = rho_a * (L**3 / 3.0 - x * L**2 / 2.0 + x**3 / 6.0)  # integral of rho A xi (xi - x) from x to L
    center = L + tip.center_of_mass
    moment_of_inertia += tip.inertia + tip.mass * center**2
    outboard += tip.inertia + tip.mass * center * (center - x)
    slider_force = moment_of_inertia * angular / s
    moment = -outboard * angular + slider_force * np.maximum(s - x, 0.0)
    return moment / follower.bending_stiffness * follower.extreme_fibre
