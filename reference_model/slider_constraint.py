"""Slider constraints: what a method does with the gap between crank tip and centre line (DERIVATION.md, section 5)."""

from dataclasses import dataclass
from typing import Final

from quickreturn.reference_model.joint import Rollers

#: Kinds of constraint, by what happens to the gap between crank tip and centre line along the follower's normal.
ELIMINATED: Final = 0  # the follower's angle closes it
MULTIPLIER: Final = 1  # a force closes it, a Lagrange multiplier
ROLLERS: Final = 2  # two rollers, or one spring, act across it
LEVER: Final = 3  # as MULTIPLIER, but the force acts on the two nodes of the slider's element by the lever rule: not workless
CHORDS: Final = 4  # as LEVER, and the slider rides on the chords between the nodes: workless
BASE: Final = 5  # there is no slider; the follower's base turns as prescribed


@dataclass(frozen=True, kw_only=True)
class SliderConstraint:
    """A slider constraint and its constants.

    Attributes:
        kind: one of ELIMINATED, MULTIPLIER, ROLLERS, LEVER and CHORDS of this module.
        rollers: for ROLLERS.
        inertia: for ROLLERS, kg: force over the gap's second derivative, which slows the vibration of a stiff spring.
        stabilization: for MULTIPLIER, LEVER and CHORDS, 1/s: rate at which numerical errors of the gap decay.
        bending_damping: numerical damping, added to the material's: damping moment over EI, per rate of curvature, s.
    """

    kind: int = ELIMINATED
    rollers: Rollers = Rollers()  # noqa: RUF009 - frozen
    inertia: float = 0.0
    stabilization: float = 0.0
    bending_damping: float = 0.0


#: The follower's angle closes the gap, so that no force is unknown.
CLOSED: Final = SliderConstraint()
