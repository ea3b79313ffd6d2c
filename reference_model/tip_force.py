"""The force on the tip, which acts over a part of the crank's turn and begins and ends smoothly (DERIVATION.md, equation 4.9)."""

import math
from typing import Final

import numpy as np
from numpy.typing import NDArray

from quickreturn.reference_model.mechanism import ROUNDING, Tip

#: Smallest part of the turn (rad) that counts as the whole turn, over which the force is constant.
WHOLE: Final = 2.0 * math.pi - ROUNDING


def share_of_force(crank_angle: float, begin: float, span: float, ramp: float) -> float:
    """Fraction of the force that acts at a crank angle, 0 to 1, twice continuously differentiable; each model compiles it.

    Args:
        crank_angle: rad.
        begin: crank angle at which the force begins, rad.
        span: crank angle over which it acts, rad.
        ramp: crank angle over which it rises, and over which it falls, rad.
    """
    if span >= WHOLE:
        return 1.0
    turned = (crank_angle - begin) % (2.0 * math.pi)
    u = min(turned, span - turned) / ramp
    if u >= 1.0:
        return 1.0
    return u * u * u * (10.0 + u * (6.0 * u - 15.0)) if u > 0.0 else 0.0


def constants(tip: Tip) -> dict[str, float]:
    """The constants of the force for the equations of motion, by their symbols: N and rad."""
    return {
        "force_1": tip.force[0],
        "force_2": tip.force[1],
        "force_begin": tip.force_from,
        "force_span": tip.force_to - tip.force_from,
        "force_ramp": tip.force_ramp,
    }


def tip_force(tip: Tip, crank_angle: NDArray[np.float64]) -> NDArray[np.float64]:
    """The force (N) along n1 and n2 at crank angles (rad); shape (2, *that of the angles)."""
    angles = np.asarray(crank_angle, dtype=float)
    if not tip.is_forced:
        return np.zeros((2, *angles.shape))
    span = tip.force_to - tip.force_from
    acting = np.array([share_of_force(angle, tip.force_from, span, tip.force_ramp) for angle in angles.ravel()]).reshape(angles.shape)
    return np.multiply.outer(np.array(tip.force), acting)
