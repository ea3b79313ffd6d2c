"""Treatments of the slider: what a method does with the gap between crank tip and centre line (DERIVATION.md, section 5)."""

from dataclasses import dataclass
from typing import Final

#: What happens to the gap between crank tip and centre line along the follower's normal.
ELIMINATED: Final = 0  # it is closed by the follower's angle
MULTIPLIER: Final = 1  # it is closed by a force, a Lagrange multiplier
SPRING: Final = 2  # a spring and a damper hold it
LEVER: Final = 3  # as MULTIPLIER, but the force acts on the two nodes of the slider's element by the lever rule: not conjugate
CHORDS: Final = 4  # as LEVER, and the slider rides on the chords between the nodes: conjugate
BASE: Final = 5  # there is no slider; the follower's base turns as prescribed


@dataclass(frozen=True, kw_only=True)
class Treatment:
    """What happens to the gap between crank tip and centre line.

    Attributes:
        kind: one of ELIMINATED, MULTIPLIER, SPRING, LEVER and CHORDS of this module.
        stiffness: N/m, of SPRING.
        damping: N s/m, of SPRING.
        inertia: kg, of SPRING: a force in proportion to the gap's second derivative, which slows the vibration of a stiff joint.
        stabilization: 1/s, rate at which a gap decays that a force keeps closed.
        bending_damping: s, damping moment over elastic moment per curvature rate.
    """

    kind: int = ELIMINATED
    stiffness: float = 0.0
    damping: float = 0.0
    inertia: float = 0.0
    stabilization: float = 0.0
    bending_damping: float = 0.0


#: The gap is closed by the follower's angle: no force has to be found.
CLOSED: Final = Treatment()
