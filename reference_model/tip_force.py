"""When the force on the tip acts: over a part of the crank's turn, coming and going smoothly (DERIVATION.md, equation 4.9)."""

import math
from typing import Final

import numpy as np
from numpy.typing import NDArray

from quickreturn.reference_model.mechanism import ROUNDING, Tip

#: Angle (rad) from which on a part counts as the whole turn, in which the force never comes or goes.
WHOLE: Final = 2.0 * math.pi - ROUNDING


def share(crank_angle: float, begin: float, span: float, ramp: float) -> float:
    """Share of the force that acts at a crank angle, 0 to 1, twice continuously differentiable; compiled by those who compute with it.

    Args:
        crank_angle: rad.
        begin: angle at which the force begins, rad.
        span: angle over which it acts, rad.
        ramp: angle over which it comes, and goes, rad.
    """
    if span >= WHOLE:
        return 1.0
    turned = (crank_angle - begin) % (2.0 * math.pi)
    u = min(turned, span - turned) / ramp
    if u >= 1.0:
        return 1.0
    return u * u * u * (10.0 + u * (6.0 * u - 15.0)) if u > 0.0 else 0.0


def constants(tip: Tip) -> dict[str, float]:
    """What the equations of motion need to know of the force."""
    return {
        "force_1": tip.force[0],
        "force_2": tip.force[1],
        "force_begin": tip.force_from,
        "force_span": tip.force_to - tip.force_from,
        "force_ramp": tip.force_ramp,
    }


def tip_force(tip: Tip, crank_angle: NDArray[np.float64]) -> NDArray[np.float64]:
    """The force (N) along n1 and n2 at crank angles (rad) of any shape; shape (2, *that)."""
    angles = np.asarray(crank_angle, dtype=float)
    span = tip.force_to - tip.force_from
    acting = np.array([share(angle, tip.force_from, span, tip.force_ramp) for angle in angles.ravel()]).reshape(angles.shape)
    return np.multiply.outer(np.array(tip.force), acting)
