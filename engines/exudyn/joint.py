"""The law of the slider's joint for Exudyn's connectors, with its stored energy and its losses."""

from dataclasses import astuple

import numpy as np
from numpy.typing import NDArray

from quickreturn.reference_model.joint import joint_energy, joint_force, rollers
from quickreturn.reference_model.slider import Slider

Array = NDArray[np.float64]


class JointLaw:
    """Force, energy and loss of a compliant joint.

    Attributes:
        along: stiffness (N/m) of the spring that holds the carriage at the foot of the crank tip, along the follower's tangent: between
            the rollers nothing else would hold it. The carriage has hardly any mass, so that the spring has no force. With a hundredth of
            the stiffness the tip deflection of run 24 with clearance changes by 2e-10, with a millionth by 1.8e-6.
    """

    def __init__(self, slider: Slider) -> None:
        self._law = astuple(rollers(slider))
        self._lossless = (*self._law[:4], 0.0, 0.0)
        self.along = max(slider.sides)

    def force(self, gap: float, rate: float) -> float:
        """Force on the follower along n, N, for a gap (m) and its rate (m/s)."""
        return joint_force(gap, rate, *self._law)

    def loss(self, gap: float, rate: float) -> float:
        """Power that the joint dissipates, W."""
        return rate * (self.force(gap, rate) - joint_force(gap, 0.0, *self._lossless))

    def energy(self, gaps: Array) -> Array:
        """Energy stored at the gaps (m), J."""
        return np.array([joint_energy(gap, *self._law[:4]) for gap in gaps.tolist()])
