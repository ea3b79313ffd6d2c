"""The slider's joint: the law of two rollers, one on either side of the follower, and the constraints by which methods treat the gap.

The law has equations 5.11 to 5.14 of DERIVATION.md; section 5 explains the constraints. The functions of the law are plain
arithmetic: each model compiles them, or calls them as they are.
"""

import math
from dataclasses import dataclass
from typing import Final

from quickreturn.reference_model.slider import Slider


@dataclass(frozen=True, kw_only=True)
class Rollers:
    """Constants of the law. A linear spring is two rollers of the same stiffness that both begin to push at zero gap.

    Attributes:
        plus: stiffness of the roller that pushes the follower along +n, N/m.
        minus: stiffness of the roller that pushes it along -n, N/m.
        plus_from: gap above which the plus roller pushes, m: half the clearance, or a negative gap with preload.
        minus_from: value of -gap above which the minus roller pushes, m.
        loss: contact damping, s/m.
        damping: coefficient of the damper parallel to the rollers, N s/m.
    """

    plus: float = 0.0
    minus: float = 0.0
    plus_from: float = 0.0
    minus_from: float = 0.0
    loss: float = 0.0
    damping: float = 0.0


def rollers(slider: Slider) -> Rollers:
    """Constants of the law for a slider whose joint is not rigid."""
    plus, minus = slider.sides
    plus_from, minus_from = (slider.clearance / 2.0 - slider.preload / stiffness for stiffness in (plus, minus))
    return Rollers(
        plus=plus, minus=minus, plus_from=plus_from, minus_from=minus_from, loss=slider.contact_damping, damping=slider.joint_damping
    )


def joint_force(
    gap: float, rate: float, plus: float, minus: float, plus_from: float, minus_from: float, loss: float, damping: float
) -> float:
    """Force of the joint on the follower along n, N; neither roller pulls (equations 5.11 and 5.12).

    Args:
        gap: distance of the crank tip from the centre line along n, m.
        rate: of the gap, m/s.
        plus: N/m, see `Rollers`.
        minus: N/m.
        plus_from: m.
        minus_from: m.
        loss: s/m.
        damping: N s/m.
    """
    along = plus * max(gap - plus_from, 0.0) * max(1.0 + loss * rate, 0.0)
    against = minus * max(-gap - minus_from, 0.0) * max(1.0 - loss * rate, 0.0)
    return along - against + damping * rate


def joint_energy(gap: float, plus: float, minus: float, plus_from: float, minus_from: float) -> float:
    """Energy stored in the rollers, J (equation 5.13). Arguments as of `joint_force`."""
    return 0.5 * plus * max(gap - plus_from, 0.0) ** 2 + 0.5 * minus * max(-gap - minus_from, 0.0) ** 2


def friction_share(speed: float, over: float) -> float:
    """Fraction of the friction that acts at a sliding speed, -1 to 1; its sign changes over the speed `over` (equation 5.14)."""
    return math.tanh(speed / over)


def joint_in_words(slider: Slider) -> str:
    """A line that describes a joint that is not rigid."""
    words = [f"{slider.joint_damping:g} N*s/m"] if slider.joint_damping > 0.0 or slider.is_linear else []
    plus, minus = slider.sides
    if slider.is_linear:
        words = [f"compliant joint, {plus:g} N/m", *words]
    else:
        # a side that no key makes soft is infinite in the scene
        given = (min(slider.joint_stiffness, side) for side in (slider.joint_stiffness_plus, slider.joint_stiffness_minus))
        of_plus, of_minus = (", as stiff as a contact" if math.isinf(stiffness) else "" for stiffness in given)
        words = [f"rollers of {plus:g} N/m (plus{of_plus}) and {minus:g} N/m (minus{of_minus})", *words]
    for key, unit in (("clearance", "m clearance"), ("preload", "N preload"), ("contact_damping", "s/m contact damping")):
        if (value := getattr(slider, key)) > 0.0:
            words.append(f"{value:g} {unit}")
    return ", ".join(words)


def friction_in_words(slider: Slider) -> str:
    """The end of a description of the joint: a clause on its friction, "" for a frictionless slider."""
    return ", with friction along the follower" if slider.has_friction else ""


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
    rollers: Rollers = Rollers()
    inertia: float = 0.0
    stabilization: float = 0.0
    bending_damping: float = 0.0


#: The follower's angle closes the gap, so that no force is unknown.
CLOSED: Final = SliderConstraint()
