"""Angle of a base that is spun up as prescribed (DERIVATION.md, section 11)."""

import math


def base_motion(speed: float, time: float, t: float) -> tuple[float, float, float]:
    """Angle (rad), rate (rad/s) and acceleration (rad/s^2) of the base, equation 11.1; each model compiles it.

    Args:
        speed: steady speed from `time` on, rad/s.
        time: duration of the spin-up, s.
        t: instant, s, not negative.
    """
    if t >= time:
        return speed * (t - 0.5 * time), speed, 0.0
    turn = 2.0 * math.pi / time
    # 1 - cos without cancellation: the start is straight and still
    small = 2.0 * math.sin(0.5 * turn * t) ** 2
    return speed / time * (0.5 * t * t - small / turn**2), speed / time * (t - math.sin(turn * t) / turn), speed / time * small
