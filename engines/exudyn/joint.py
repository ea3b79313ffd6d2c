"""The law of the slider's joint as Exudyn's connectors ask for it, and what it stores and takes."""

from dataclasses import astuple

import numpy as np
from numpy.typing import NDArray

from quickreturn.reference_model.joint import joint_energy, joint_force, rollers
from quickreturn.reference_model.mechanism import Slider

Array = NDArray[np.float64]


class JointLaw:
    """Force, energy and loss of a joint that gives way.

    Attributes:
        along: stiffness (N/m) of the spring that holds the carriage at the foot of the crank tip, along the follower's tangent. It has no
            force there, for the carriage has hardly any mass; in free flight between the rollers nothing else would hold the carriage. A
            hundredth of it changes run 24 with clearance by 2e-10 of the tip deflection, a millionth by 1.8e-6.
    """

    def __init__(self, slider: Slider) -> None:
        self._law = astuple(rollers(slider))
        self._lossless = (*self._law[:4], 0.0, 0.0)
        self.along = max(slider.sides)

    def force(self, gap: float, rate: float) -> float:
        """Force on the follower along n, N, of a gap (m) and its rate (m/s)."""
        return joint_force(gap, rate, *self._law)

    def loss(self, gap: float, rate: float) -> float:
        """Power that the joint takes, W."""
        return rate * (self.force(gap, rate) - joint_force(gap, 0.0, *self._lossless))

    def energy(self, gaps: Array) -> Array:
        """Energy stored at the gaps (m), J."""
        return np.array([joint_energy(gap, *self._law[:4]) for gap in gaps.tolist()])
