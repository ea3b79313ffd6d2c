"""Slider constraints: what a method does with the gap between crank tip and centre line (DERIVATION.md, section 5)."""

from dataclasses import dataclass
from typing import Final

from quickreturn.reference_model.joint import Rollers

#: What happens to the gap between crank tip and centre line along the follower's normal.
ELIMINATED: Final = 0  # it is closed by the follower's angle
MULTIPLIER: Final = 1  # it is closed by a force, a Lagrange multiplier
ROLLERS: Final = 2  # two rollers hold it, or one spring
LEVER: Final = 3  # as MULTIPLIER, but the force acts on the two nodes of the slider's element by the lever rule: not workless
CHORDS: Final = 4  # as LEVER, and the slider rides on the chords between the nodes: workless
BASE: Final = 5  # there is no slider; the follower's base turns as prescribed


@dataclass(frozen=True, kw_only=True)
class SliderConstraint:
    """What happens to the gap between crank tip and centre line.

    Attributes:
        kind: one of ELIMINATED, MULTIPLIER, ROLLERS, LEVER and CHORDS of this module.
        rollers: of ROLLERS.
        inertia: kg, of ROLLERS: a force in proportion to the gap's second derivative, which slows the vibration of a stiff spring.
        stabilization: 1/s, rate at which a gap decays that a force keeps closed.
        bending_damping: s, damping moment over elastic moment per curvature rate.
    """

    kind: int = ELIMINATED
    rollers: Rollers = Rollers()  # noqa: RUF009 - frozen
    inertia: float = 0.0
    stabilization: float = 0.0
    bending_damping: float = 0.0


#: The gap is closed by the follower's angle: no force has to be found.
CLOSED: Final = SliderConstraint()
