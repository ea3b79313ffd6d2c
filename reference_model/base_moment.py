"""Whether damping and friction of the base need a shape of their own in the follower's deflection (DERIVATION.md, equation 2.11)."""

import math
from dataclasses import replace
from functools import lru_cache
from typing import Final

import numpy as np

from quickreturn.reference_model.mechanism import Mechanism
from quickreturn.reference_model.natural_modes import compliance_beyond
from quickreturn.reference_model.rigid import crank_pace, pivot_torque, rigid_motion, static_deflection
from quickreturn.reference_model.slider import Slider

#: Angle by which the base turns too little without the shape, over the static deflection per length, above which it is used. A machine with
#: 500 times as much has an error of 2e-2 in the deflection with four modes (`engines/LADDERS.md`, section 1).
NEEDED_FROM: Final = 5e-4
#: Number of modes in which this angle is missing: those of the coarsest run of a follower as soft as run 24's.
MODES: Final = 4
ANGLES: Final = 48  # of the crank, in a turn


@lru_cache(maxsize=64)
def needs_base_shape(mechanism: Mechanism) -> bool:
    """Whether the torque of damping and friction in the pivot P bends the follower by more than natural modes describe.

    Their moment at the base is that of the base block's inertia alone. The slower the crank, the more they count beside the forces of
    inertia; so the speed of the start decides, not the one that a torque would reach in the end.
    """
    base, follower = mechanism.base, mechanism.follower
    pace = abs(mechanism.crank.drive.initial_speed) or crank_pace(mechanism)
    if follower.is_rigid or pace == 0.0 or (base.damping == 0.0 and base.friction_torque == 0.0):
        return False
    motion = rigid_motion(mechanism, np.linspace(0.0, 2.0 * math.pi, ANGLES, endpoint=False), pace)
    torque = float(np.sqrt(np.mean(pivot_torque(base, motion.follower_speed) ** 2)))
    farthest = min(float(np.max(motion.slider_position)), (1.0 - 1e-6) * follower.length)
    allowed = NEEDED_FROM * static_deflection(mechanism, pace) / follower.length
    if torque * farthest / (3.0 * follower.bending_stiffness) <= allowed:  # of all modes, without an eigenproblem
        return False
    return torque * compliance_beyond(replace(mechanism, slider=Slider()), farthest, MODES) > allowed
