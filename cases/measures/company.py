"""What accompanies the first mode on a moving mechanism, a quarter period late.

The slider's place changes the modes. With W = sum of eta_i phi_i(x; s), mass-normalised at each s, Lagrange's equations in the rates'
first order are eta_j'' + omega_j^2 eta_j = -C_j1 s' eta_1', C_ij = 2 <phi_i, d phi_j/ds> + J phi_i' d(phi_j')/ds ... (below): a first mode
eta_1 = A cos phi drags the others along as eta_j = A C_j1 s' omega_1/(omega_j^2 - omega_1^2) sin phi.

C follows from the modes at one place. Let R_j be the support's force on mode j, and J the slider's rotary inertia, which sits where
the support is. Differentiating the eigenproblem, the orthogonality of the modes and the support's condition by s gives

    C_j1 (omega_j^2 - omega_1^2) = 2 (R_1 phi_j' + R_j phi_1') + J (omega_1^2 + omega_j^2) (phi_j'' phi_1' + phi_j' phi_1'')

at the support, rigid or compliant; R_j s = -omega_j^2 times the mode's moment of momentum about P.
"""

import numpy as np
from numpy.polynomial import legendre
from numpy.typing import NDArray

from reference_model.mechanism import Mechanism
from reference_model.natural_modes import FrozenModes

Array = NDArray[np.float64]

POINTS, WEIGHTS = legendre.leggauss(12)  # per span: exact for the shapes of six modes


def dragged_along(mechanism: Mechanism, modes: FrozenModes) -> Array:
    """Amplitudes of the modes that a first mode A cos(phi) drags along as A s' sin(phi), s/m, shape (count,); zero for itself.

    Args:
        mechanism: the scene.
        modes: with the crank held, mass-normalised.
    """
    squares = (2.0 * np.pi * modes.frequencies) ** 2
    at = np.array([modes.slider_position])
    slopes, curvatures = modes.deflection(at, 1)[:, 0], modes.curvature(at)[:, 0]
    forces = -squares * _moments_of_momentum(mechanism, modes) / modes.slider_position
    apart = squares[1:] - squares[0]
    turning = mechanism.slider.inertia * (curvatures[1:] * slopes[0] + slopes[1:] * curvatures[0])
    coupling = (2.0 * (forces[0] * slopes[1:] + forces[1:] * slopes[0]) + (squares[0] + squares[1:]) * turning) / apart
    return np.concatenate([[0.0], coupling * np.sqrt(squares[0]) / apart])


def _moments_of_momentum(mechanism: Mechanism, modes: FrozenModes) -> Array:
    """About P, for unit rates of the modes, kg^(1/2) m, shape (count,)."""
    follower, tip = mechanism.follower, mechanism.tip
    moments = np.zeros(len(modes))
    for start, end in modes.spans:
        x = 0.5 * (start + end) + 0.5 * (end - start) * POINTS
        moments += modes.deflection(x) @ (0.5 * (end - start) * WEIGHTS * x) * follower.mass_per_length
    slopes = modes.deflection(np.array([0.0, modes.slider_position, follower.length]), 1)
    moments += slopes @ [mechanism.base.inertia, mechanism.slider.inertia, tip.inertia if tip else 0.0]
    if tip:
        at_center = modes.tip_displacement + tip.center_of_mass * slopes[:, 2]
        moments += tip.mass * (follower.length + tip.center_of_mass) * at_center
    return moments
