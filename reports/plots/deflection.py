"""The follower's deflection curve out of what a trajectory holds: base angle, slider place, tip deflection and three strains.

Between the base and the tip the bending moment is smooth but for the slider, where the slider force N lets the shear force jump.
So W(x) = N/EI max(x - s, 0)³/6 + sum of c_k (x/L)^k, k = 2 .. 8, which has W(0) = W'(0) = 0. Seven conditions fix the seven
coefficients: the curvature 2 strain/thickness at the three gauges, no curvature at the base and at the tip (block and tip body are
small: next to no moment passes there), the tip deflection, and at the slider the deflection that closes the vector loop. Slopes are
taken as small (W'' for the curvature).

Measured on run 24, against strains of the converged model at other places: curvature within 0.4 % (of its RMS there) between the
gauges, 3 % at 0.1 L and 0.85 L, more only where it vanishes; slope at the slider so well that the torque of the slider force on
the crank agrees to 1e-5 with the one that the crank's acceleration shows (reference, runs 10 and 24, steady state).
"""

import numpy as np
from numpy.typing import NDArray

from reference_model.mechanism import Mechanism
from reference_model.rigid import rigid_motion

Array = NDArray[np.float64]

POWERS = np.arange(2, 9)
ROUND_OFF = 1e-10  # of the largest singular value: a slider at the tip or at a gauge states one thing twice


class Deflection:
    """W(x) along b2 over the arc length, at n instants of a trajectory.

    Args:
        mechanism: the scene; its follower may be rigid (then W = 0).
        columns: crank_angle, follower_angle, slider_position, tip_deflection, strain_1 to strain_3, slider_force, each of shape (n,).
    """

    def __init__(self, mechanism: Mechanism, columns: dict[str, Array]) -> None:
        follower = mechanism.follower
        self._length = follower.length
        self._slider = columns["slider_position"]
        self._kink = columns["slider_force"] / follower.bending_stiffness  # jump of W''' at the slider, 1/m^2
        self._coefficients = np.zeros((self._slider.size, POWERS.size))
        if follower.is_rigid:
            return
        instants = self._slider.size
        bent = np.tile([*follower.strain_gauges, 0.0, follower.length], (instants, 1))
        placed = np.stack([self._slider, np.full(instants, follower.length)], axis=1)
        curvatures = np.zeros_like(bent)
        for gauge in (1, 2, 3):
            curvatures[:, gauge - 1] = 2.0 / follower.thickness * columns[f"strain_{gauge}"]
        places = np.stack([_deflection_at_slider(mechanism, columns), columns["tip_deflection"]], axis=1)
        L2 = follower.length**2  # so that all rows are lengths
        rows = np.concatenate([L2 * self._powers(bent, 2), self._powers(placed, 0)], axis=1)
        wanted = np.concatenate([L2 * (curvatures - self._kinks(bent, 2)), places - self._kinks(placed, 0)], axis=1)
        self._coefficients = np.einsum("nkr,nr->nk", np.linalg.pinv(rows, rcond=ROUND_OFF), wanted)

    def _powers(self, x: Array, derivative: int) -> Array:
        """Derivative of the powers at x, shape (*x.shape, 7)."""
        factors = np.ones(POWERS.size)
        for step in range(derivative):
            factors = factors * (POWERS - step)
        return factors / self._length**derivative * (x[..., None] / self._length) ** (POWERS - derivative)

    def _kinks(self, x: Array, derivative: int) -> Array:
        """Derivative of the term of the slider force at x of shape (n, m)."""
        beyond = np.maximum(x - self._slider[:, None], 0.0)
        return self._kink[:, None] * beyond ** (3 - derivative) / (6.0, 2.0, 1.0)[derivative]

    def at(self, x: Array, derivative: int = 0) -> Array:
        """W, W' or W'' (m, 1, 1/m) at arc lengths x (m, shape (m,)) at every instant, shape (n, m)."""
        everywhere = np.broadcast_to(x, (self._slider.size, x.size))
        return np.einsum("nmk,nk->nm", self._powers(everywhere, derivative), self._coefficients) + self._kinks(everywhere, derivative)

    def slope_at_slider(self) -> Array:
        """W' at the slider at every instant, shape (n,)."""
        return np.einsum("nk,nk->n", self._powers(self._slider, 1), self._coefficients)


def _deflection_at_slider(mechanism: Mechanism, columns: dict[str, Array]) -> Array:
    """W at the slider, m, from the loop: the crank tip's distance from the base tangent, less the give of the joint."""
    chord = rigid_motion(mechanism, columns["crank_angle"], 0.0)
    offset = chord.slider_position * np.sin(chord.follower_angle - columns["follower_angle"])
    return offset - columns["slider_force"] / mechanism.slider.joint_stiffness
