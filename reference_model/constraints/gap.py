"""The gap between crank tip and centre line, its rate and its second derivative, the loop being open (RIVALS.md, section 1)."""

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from reference_model.compilation import inlined, inside
from reference_model.kinematics import (
    CLOSURE_STEPS,
    Slider,
    field_rates,
    loop_remainder,
    normal_row,
    place_at,
    slider_at,
    sliding_speed,
    tangent_angle,
)
from reference_model.parameters import Parameters, Workspace

Array = NDArray[np.float64]


class Speeds(NamedTuple):
    """Coordinates and speeds of the open loop; eta and its rate have shape (n,)."""

    q1: float  # rad
    q2: float  # rad
    eta: Array  # m (or what the shapes say)
    q1_rate: float  # rad/s
    q2_rate: float  # rad/s
    eta_rate: Array


class Gap(NamedTuple):
    """Distance of the crank tip from the centre line along the normal n (equation R1.2) and its derivatives."""

    exists: bool  # whether the crank tip lies beside the follower
    value: float  # m
    rate: float  # m/s, row . speeds (equation R1.3)
    remainder: float  # m/s^2, second derivative less row . accelerations (equation R1.5)
    s_rate: float  # m/s, rate of the slider's arc length


@inlined
def crank_tip(p: Parameters, q1: float, q2: float) -> tuple[float, float]:
    """Place of the crank tip relative to P in frame B, equation R1.1."""
    v1, v2 = p.LA * math.cos(q1) - p.d, p.LA * math.sin(q1)
    cosine, sine = math.cos(q2), math.sin(q2)
    return cosine * v1 + sine * v2, -sine * v1 + cosine * v2


@inside
def smooth_gap(p: Parameters, y: Speeds, w: Workspace, row: Array) -> tuple[Slider, Gap]:
    """The slider at the foot of the crank tip on the centre line, and the gap; fills `row` (n + 2,), equations R1.1 to R1.5."""
    C1, C2 = crank_tip(p, y.q1, y.q2)
    s = C1
    found = False
    for _ in range(CLOSURE_STEPS):
        x, W, slope, g = place_at(p, s, y.eta, w)
        correction = (1.0 - g) * (C1 - x) + slope * (C2 - W)
        s += correction
        if not (0.0 < s < 1.2 * p.L):
            break
        # the step neglects gap x curvature: what is left is that small ratio of the last correction
        if abs(correction) < 1e-13 * p.L:
            found = True
            break
    if not found:
        return Slider(False, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0), Gap(False, 0.0, 0.0, 0.0, 0.0)
    c = slider_at(p, s, y.q1, y.q2, y.eta, w)
    value = c.t1 * (C2 - c.W) - c.slope * (C1 - c.x)
    normal_row(p, c, w, row)
    rate = row[0] * y.q1_rate + row[1] * y.q2_rate
    for i in range(p.n):
        rate += row[i + 2] * y.eta_rate[i]
    r = field_rates(p, y.eta_rate, w)
    turn = y.q2_rate + tangent_angle(c.slope, True)[1] * r.slope  # of the tangent, its place held
    bend = tangent_angle(c.slope, True)[1] * c.curvature
    s_rate = (sliding_speed(p, c, r, y.q1_rate, y.q2_rate) + value * turn) / (1.0 - value * bend)
    b1, b2 = loop_remainder(p, c, r, y.q1_rate, y.q2_rate, s_rate, w)
    # loop_remainder is the crank tip's side less the follower's, with the sign of equation 3.8
    remainder = c.t1 * b2 - c.slope * b1 + value * (turn + bend * s_rate) ** 2
    return c, Gap(True, value, rate, remainder, s_rate)
