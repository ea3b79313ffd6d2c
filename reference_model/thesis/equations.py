"""The right-hand sides of the thesis' model, compiled: for the mechanism, and for the follower alone on a base that turns as prescribed.

In the state of the follower alone time takes the place of q1.
"""

import math

from quickreturn.reference_model.arrays import Array
from quickreturn.reference_model.columns import ROW
from quickreturn.reference_model.compiled_state import state_of
from quickreturn.reference_model.mechanism import base_motion as motion_of_base
from quickreturn.reference_model.native.compilation import compiled, inlined, inner
from quickreturn.reference_model.state import BY_DRIVE, DISSIPATED, State
from quickreturn.reference_model.thesis.dynamics import assemble, dissipation, evaluate, factorize, reactions, substitute
from quickreturn.reference_model.thesis.kinematics import Contact, Slider, centre_line
from quickreturn.reference_model.thesis.observables import observe
from quickreturn.reference_model.thesis.parameters import ThesisParameters, ThesisWorkspace, parameters_at, workspace_at

base_motion = inner(motion_of_base)


@compiled
def right_hand_side(parameters: int, workspace: int, y: Array, rate: Array, row: Array) -> bool:
    """Write dy/dt of the state y to `rate`, and its observables to `row` (the numbers of a `ROW`) unless that is empty.

    False, and nan in `rate`, where the loop cannot close or the slope of the shapes reaches 1. Parameters and workspace are addresses.
    """
    p, w = parameters_at(parameters), workspace_at(workspace)
    state, state_rate = state_of(y, p.n), state_of(rate, p.n)
    good, c, k = evaluate(p, w, state)
    if not good:
        rate[:] = math.nan
        return False
    q1_rate, eta_rate = state.u[0], state.eta_rate
    _to_rate(w, state, state_rate)
    state_rate.work[DISSIPATED] = dissipation(p, q1_rate, k.q2_rate, eta_rate, w)
    force, drive = reactions(p, c, k, q1_rate, w)
    state_rate.work[BY_DRIVE] = drive * q1_rate + w.tool[1] * k.q2_rate
    for i in range(p.n):
        state_rate.work[BY_DRIVE] += w.tool[i + 2] * eta_rate[i]
    if len(row):
        observe(p, c, k, w, state, force, drive, row.view(ROW)[0])
    return True


@compiled
def base_right_hand_side(parameters: int, workspace: int, y: Array, rate: Array, row: Array) -> bool:
    """As `right_hand_side`, for the follower alone (equations 8.1 and 8.2): without crank and slider, with the torque on the base."""
    p, w = parameters_at(parameters), workspace_at(workspace)
    state, state_rate, n = state_of(y, p.n), state_of(rate, p.n), p.n
    eta, eta_rate = state.eta, state.eta_rate
    angle, turn, acceleration = base_motion(p.base_speed, p.base_time, state.q[0])
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
    _to_rate(w, state, state_rate)
    state_rate.work[DISSIPATED] = dissipation(p, 0.0, turn, eta_rate, w)
    state_rate.work[BY_DRIVE] = torque * turn
    if len(row):
        found = row.view(ROW)[0]
        observe(p, c, k, w, state, 0.0, torque, found)
        found.moment_base -= torque
    return True


@inlined
def _to_rate(w: ThesisWorkspace, state: State, rate: State) -> None:
    """To `rate`: the speeds, and the accelerations found."""
    rate.q[0], rate.u[0] = state.u[0], w.acceleration[0]
    for i in range(len(state.eta)):
        rate.eta[i], rate.eta_rate[i] = state.eta_rate[i], w.acceleration[i + 2]


@inner
def _no_slider(p: ThesisParameters, angle: float, rate: float) -> tuple[Slider, Contact]:
    """A slider without force at mid-length, in place of the missing one, for the base's angle (rad) and its rate (rad/s)."""
    c = Slider(True, 0.5 * p.L, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, angle, 1.0, 0.0)
    return c, Contact(True, rate, 0.0, 1.0, 0.0, 1.0, 0.0)
