"""The joint's law a second time: two rollers that push one by one, and friction by the exponential function."""

import math

from quickreturn.reference_model.joint import Rollers


def force_of_rollers(rollers: Rollers, gap: float, rate: float) -> tuple[float, float, float]:
    """Force of the joint on the follower along its normal (N), energy stored in it (J) and power that it turns into heat (W).

    Each roller is compressed, pushes, stores and loses on its own.
    """
    force, energy, heat = rollers.damping * rate, 0.0, rollers.damping * rate**2
    for stiffness, begin, side in ((rollers.plus, rollers.plus_from, 1.0), (rollers.minus, rollers.minus_from, -1.0)):
        compression, closing = side * gap - begin, side * rate
        if compression > 0.0:
            elastic = stiffness * compression
            push = elastic * (1.0 + rollers.loss * closing) if rollers.loss * closing > -1.0 else 0.0
            force += side * push
            energy += 0.5 * stiffness * compression**2
            heat += (push - elastic) * closing
    return force, energy, heat


def sliding_share(speed: float, over: float) -> float:
    """From -1 to 1, by the exponential function."""
    return 1.0 - 2.0 / (1.0 + math.exp(2.0 * speed / over))
