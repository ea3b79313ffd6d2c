"""The law of the slider's joint: what two rollers, one on either side of the follower, do across the gap (DERIVATION.md, 5.11 to 5.14).

The functions are plain arithmetic: each model compiles them, or calls them as they are.
"""

import math
from dataclasses import dataclass
from typing import Final

from quickreturn.reference_model.mechanism import Slider

#: Rate (rad/s) of the follower's angle over which the friction of its pivot changes its sign.
PIVOT_FRICTION_RATE: Final = 0.1


@dataclass(frozen=True, kw_only=True)
class Rollers:
    """Constants of the law. A linear spring is two rollers of the same stiffness that both begin to push at no gap.

    Attributes:
        plus: stiffness of the roller that pushes the follower along +n, N/m.
        minus: of the other one, N/m.
        plus_from: gap above which the plus roller pushes, m: half the clearance, or less than none with preload.
        minus_from: the same below minus the gap, m.
        loss: contact damping, s/m.
        damping: of the damper beside the rollers, N s/m.
    """

    plus: float = 0.0
    minus: float = 0.0
    plus_from: float = 0.0
    minus_from: float = 0.0
    loss: float = 0.0
    damping: float = 0.0


def rollers(slider: Slider) -> Rollers:
    """Those of a joint that gives way."""
    plus, minus = slider.sides
    begin = [slider.clearance / 2.0 - slider.preload / stiffness for stiffness in (plus, minus)]
    return Rollers(
        plus=plus, minus=minus, plus_from=begin[0], minus_from=begin[1], loss=slider.contact_damping, damping=slider.joint_damping
    )


def joint_force(
    gap: float, rate: float, plus: float, minus: float, plus_from: float, minus_from: float, loss: float, damping: float
) -> float:
    """Force of the joint on the follower along n, N; neither roller pulls (equations 5.11 and 5.12).

    Args:
        gap: m.
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
    """Energy stored in the rollers, J (equation 5.13)."""
    return 0.5 * plus * max(gap - plus_from, 0.0) ** 2 + 0.5 * minus * max(-gap - minus_from, 0.0) ** 2


def friction_share(speed: float, over: float) -> float:
    """Share of the friction that acts at a sliding speed, -1 to 1; `over`: the speed over which it changes its sign (equation 5.14)."""
    return math.tanh(speed / over)


def in_words(slider: Slider) -> str:
    """The joint that gives way, in a line."""
    told = [f"{slider.joint_damping:g} N*s/m"] if slider.joint_damping > 0.0 or slider.is_linear else []
    plus, minus = slider.sides
    if slider.is_linear:
        told = [f"compliant joint, {plus:g} N/m", *told]
    else:
        # a side that no key makes soft is infinite in the scene
        given = (min(slider.joint_stiffness, own) for own in (slider.joint_stiffness_plus, slider.joint_stiffness_minus))
        of_plus, of_minus = (", as stiff as a contact" if math.isinf(stiffness) else "" for stiffness in given)
        told = [f"rollers of {plus:g} N/m (plus{of_plus}) and {minus:g} N/m (minus{of_minus})", *told]
    for key, unit in (("clearance", "m clearance"), ("preload", "N preload"), ("contact_damping", "s/m contact damping")):
        if (value := getattr(slider, key)) > 0.0:
            told.append(f"{value:g} {unit}")
    return ", ".join(told)


def friction_in_words(slider: Slider) -> str:
    """What a description of the joint ends with: nothing where the slider does not rub."""
    return ", with friction along the follower" if slider.has_friction else ""
