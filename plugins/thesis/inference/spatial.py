"""Spatial compliance of the joint (section 5.5): the strip's twist under a roller that does not meet its middle.

A roller that pushes at the distance e from the middle of the strip's width twists it by F e s / (G J) where the slider holds it, for the
base holds the twist at P alone. The point of contact moves by e times this twist, so it has the compliance

    c = e^2 s / (G J),   J = b t^3 / 3 (1 - 0.63 t / b),   G = E / (2 (1 + nu))

(Timoshenko and Goodier, "Theory of Elasticity", 1970, sections 108 and 109). It is the same for both directions of the force.
"""

import math
from dataclasses import dataclass
from typing import Final

from quickreturn.cases.library.thesis.runs import run_case
from quickreturn.reference_model.mechanism import Mechanism

#: Poisson's ratio of aluminium.
POISSON: Final = 0.33


@dataclass(frozen=True)
class Twist:
    """The strip's twist at the slider's mean place."""

    stiffness: float  # N/m, with the contact at the edge of the strip: the least that is possible
    eccentricity: float  # m, the distance from the middle that a compliance of `wanted` takes
    half_width: float  # m, the greatest distance that the strip has


def torsional_stiffness(scene: Mechanism) -> float:
    """G J of the follower's rectangular section, N m^2."""
    follower = scene.follower
    width, thickness = follower.width or math.nan, follower.thickness or math.nan
    torsion = width * thickness**3 / 3.0 * (1.0 - 0.63 * thickness / width)
    return follower.elastic_modulus / (2.0 * (1.0 + POISSON)) * torsion


def twist(wanted: float, run: int = 24) -> Twist:
    """The twist in a run of the thesis; `wanted`: stiffness of one roller, N/m, that would explain the difference between the halves."""
    scene = run_case(run).mechanism
    torsional, half = torsional_stiffness(scene) / scene.pivot_distance, 0.5 * (scene.follower.width or math.nan)
    return Twist(torsional / half**2, math.sqrt(torsional / wanted), half)
