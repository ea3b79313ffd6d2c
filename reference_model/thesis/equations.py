"""The right-hand sides of the thesis' model, compiled: for the mechanism, and for the follower alone on a base that turns as prescribed.

State vector of the mechanism (equation 6.7), length 2 n + 4: q1, eta (n), q1dot, etadot (n), dissipated energy, work of the drive; of
the follower alone time takes the place of q1.
"""

import math

import numpy as np
from numpy.typing import NDArray

from quickreturn.reference_model.columns import ROW
from quickreturn.reference_model.machine.compilation import compiled, stage
from quickreturn.reference_model.spin_up import base_motion as motion_of_base
from quickreturn.reference_model.thesis.dynamics import assemble, dissipation, evaluate, factorize, reactions, substitute
from quickreturn.reference_model.thesis.kinematics import Contact, Slider, centre_line
from quickreturn.reference_model.thesis.observables import observe
from quickreturn.reference_model.thesis.parameters import Parameters, parameters_at, workspace_at

Array = NDArray[np.float64]

base_motion = stage(motion_of_base)


@compiled
def right_hand_side(parameters: int, workspace: int, y: Array, rate: Array, row: Array) -> bool:
    """Write dy/dt of the state y to `rate`, and its observables to `row` (the numbers of a `ROW`) unless that is empty.

    False, and nan in `rate`, where the loop cannot close or the slope of the shapes reaches 1. Parameters and workspace are addresses.
    """
    p, w = parameters_at(parameters), workspace_at(workspace)
    n = p.n
    good, c, k = evaluate(p, w, y)
    if not good:
        rate[:] = math.nan
        return False
    rate[0], rate[n + 1] = y[n + 1], w.acceleration[0]
    for i in range(n):
        rate[i + 1], rate[n + 2 + i] = y[n + 2 + i], w.acceleration[i + 2]
    rate[2 * n + 2] = dissipation(p, y[n + 1], k.q2_rate, y[n + 2 : 2 * n + 2], w)
    force, drive = reactions(p, c, k, w)
    rate[2 * n + 3] = drive * y[n + 1] + w.tool[1] * k.q2_rate
    for i in range(n):
        rate[2 * n + 3] += w.tool[i + 2] * y[n + 2 + i]
    if len(row):
        observe(p, c, k, w, y, force, drive, row.view(ROW)[0])
    return True


@compiled
def base_right_hand_side(parameters: int, workspace: int, y: Array, rate: Array, row: Array) -> bool:
    """As `right_hand_side`, for the follower alone (equations 8.1 and 8.2): without crank and slider, with the torque on the base."""
    p, w = parameters_at(parameters), workspace_at(workspace)
    n, eta, eta_rate = p.n, y[1 : p.n + 1], y[p.n + 2 : 2 * p.n + 2]
    angle, turn, acceleration = base_motion(p.base_speed, p.base_time, y[0])
    if not (centre_line(p.tables, p.exact_geometry, eta, eta_rate, w) and abs(w.end[0]) < 1.0):
        rate[:] = math.nan
        return False
    c, k = _no_slider(p, angle, turn)
    assemble(p, c, k, 0.0, 0.0, eta, eta_rate, w)
    for i in range(n):
        w.rhs[i] = w.Q[i + 2] - w.M[i + 2, 1] * acceleration
        for j in range(i + 1):
            w.reduced[i, j] = w.M[i + 2, j + 2]
    if not factorize(w.reduced, n):
        rate[:] = math.nan
        return False
    substitute(w.reduced, w.rhs, n)
    w.acceleration[0], w.acceleration[1] = 0.0, acceleration
    for i in range(n):
        w.acceleration[i + 2] = w.rhs[i]
    torque = -w.Q[1]
    for a in range(n + 2):
        torque += w.M[1, a] * w.acceleration[a]
    rate[0], rate[n + 1] = y[n + 1], 0.0
    for i in range(n):
        rate[1 + i], rate[n + 2 + i] = y[n + 2 + i], w.acceleration[i + 2]
    rate[2 * n + 2] = dissipation(p, 0.0, turn, eta_rate, w)
    rate[2 * n + 3] = torque * turn
    if len(row):
        found = row.view(ROW)[0]
        observe(p, c, k, w, y, 0.0, torque, found)
        found.moment_base -= torque
    return True


@stage
def _no_slider(p: Parameters, angle: float, rate: float) -> tuple[Slider, Contact]:
    """A slider without force at mid-length, in place of the missing one, for the base's angle (rad) and its rate (rad/s)."""
    c = Slider(True, 0.5 * p.L, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, angle, 1.0, 0.0)
    return c, Contact(True, rate, 0.0, 1.0, 0.0, 1.0, 0.0)
