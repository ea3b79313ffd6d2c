"""The equations of motion: slider constraints, solution, and the one compiled kernel (DERIVATION.md, section 5).

With the speeds u, the amplitudes eta and the slider's place s, the energies and the equations are (4.5, 4.6)

    T = 1/2 u.M u                             M_kl = sum m V_k.V_l over beam and bodies, V their partial velocities
    U = 1/2 sum_i omega_i(s)^2 eta_i^2        the shapes make 1/2 EI int psi'^2 dx diagonal; `squares` is omega^2
    M du/dt = Q - F B                         Q_k = -sum m V_k.A_0 - omega_k^2 eta_k - 1/2 sigma_k sum_i d(omega_i^2)/ds eta_i^2
                                              + damping, weight, drive and tool

A_0 is the bias of the accelerations, sigma_k the part of u_k in ds/dt, F the slider's force where the loop is open and B its spread.

The slider's arc length is a state of its own (`state.State`, equation 5.8), which saves an iteration in every evaluation; a weak feedback
keeps the loop closed. Where the base's motion is prescribed, time takes the place of q1 (equation 11.4).
"""

import math

from quickreturn.reference_model.arrays import Array
from quickreturn.reference_model.compiled_drive import given_torque, prescribed_acceleration
from quickreturn.reference_model.compiled_state import state_at
from quickreturn.reference_model.joint import BASE, ELIMINATED, ROLLERS
from quickreturn.reference_model.motion.fields import place
from quickreturn.reference_model.motion.inertia import (
    assemble,
    bias_accelerations,
    dissipation,
    find_forces,
    friction_share,
    highest_frequency,
    joint_force,
    partial_velocities,
    power_of_tool,
    relative_velocities,
)
from quickreturn.reference_model.motion.layout import FACTS, BeamParameters, BeamTables, BeamWorkspace
from quickreturn.reference_model.motion.loop import bias_of_loop, bias_of_places, joint_power, motion_of_base, move_loop, share_force
from quickreturn.reference_model.motion.plane import direction, dot
from quickreturn.reference_model.motion.spring import hang
from quickreturn.reference_model.native.compilation import inlined, inner
from quickreturn.reference_model.native.pointers import reader
from quickreturn.reference_model.state import BY_DRIVE, BY_JOINT, DISSIPATED, State

parameters_at, workspace_at = reader(BeamParameters), reader(BeamWorkspace, facts=FACTS)


@inlined
def motion(p: BeamParameters, t: BeamTables, w: BeamWorkspace, y: State) -> bool:
    """To `w`: partial velocities, bias accelerations, and the accelerations of the speeds (equations 2.1 to 5.3).

    False for an impossible state: outside the tables, bent too far, or with a singular loop.
    """
    s, q1 = y.s[0], y.q[0]
    if p.n == 0 and p.constraint == ELIMINATED:  # on a straight follower the slider's place is known exactly
        tip = p.LA * direction(q1) - p.d
        s = math.sqrt(dot(tip, tip))
    if not (t.low <= s <= t.high and abs(q1) < 1e9):
        return False
    w.facts.s = w.watched[0] = s
    slider_point = place(p, t, w, y, s)
    if slider_point < 0:
        return False
    w.facts.slider_point = slider_point
    if p.constraint == BASE:
        _turn_base(p, t, w, y)
    elif move_loop(p, t, w, y, slider_point):
        bias_of_loop(p, t, w, y, slider_point)
    else:
        return False
    relative_velocities(p, t, w, y)
    if p.is_held > 0:
        hang(p, t, w)
    partial_velocities(p, t, w, slider_point)
    bias_accelerations(p, t, w, y)
    assemble(p, t, w, y)
    w.watched[1] = highest_frequency(p, t, w)
    return _solve(p, t, w, slider_point, prescribed_acceleration(p, q1, y.u[0]))


@inlined
def _turn_base(p: BeamParameters, t: BeamTables, w: BeamWorkspace, y: State) -> None:
    """The base's prescribed motion in place of the loop (equation 11.3)."""
    f = w.facts
    angle, f.q2_rate, f.q2_bias = motion_of_base(p, y.q[0])
    f.frame, f.arm = direction(angle), 0j
    f.s_rate = f.s_bias = f.missed = 0.0
    bias_of_places(p, t, w, y)


@inlined
def _solve(p: BeamParameters, t: BeamTables, w: BeamWorkspace, slider_point: int, prescribed: float) -> bool:
    """Accelerations and, where the loop is open, the slider's force (equations 5.1 to 5.3); that of the crank may be `prescribed`."""
    m, first, f = p.speeds, p.first, w.facts
    if not _factor(w.M, w.factor, first, m):
        return False
    f.friction = 0.0
    for k in range(m):
        w.acceleration[k] = w.Q[k] if k >= first else prescribed
    if prescribed != 0.0:
        for k in range(first, m):
            w.acceleration[k] -= prescribed * w.M[k, 0]
    if p.constraint in (ELIMINATED, BASE):
        _substitute(w.factor, w.acceleration, first, m)
        return True
    share_force(p, t, w, slider_point)
    sliding = 0.0  # fraction of the friction that acts, with the sign of the sliding speed
    if p.friction > 0.0 or p.friction_force > 0.0:
        sliding = friction_share(f.s_rate, p.friction_speed)
        for k in range(first, m):
            w.acceleration[k] -= p.friction_force * sliding * w.sigma[k]
    _substitute(w.factor, w.acceleration, first, m)
    # the gap's second derivative without the slider's force
    free = f.gap_bias + w.row_of_gap[0] * prescribed
    for k in range(first, m):
        free += w.row_of_gap[k] * w.acceleration[k]
    if p.constraint == ROLLERS:
        rollers = joint_force(f.gap, f.gap_rate, p.plus, p.minus, p.plus_from, p.minus_from, p.contact_loss, p.joint_damping)
        asked = rollers + p.joint_inertia * free
    else:
        asked = free + p.stabilization * (2.0 * f.gap_rate + p.stabilization * f.gap)
    # response to a unit of the slider's force and the friction with it; the force will have the sign of `asked`
    rubbing = math.copysign(p.friction, asked) * sliding
    for k in range(m):
        w.response[k] = w.spread[k] + rubbing * w.sigma[k]
    _substitute(w.factor, w.response, first, m)
    compliance = 0.0
    for k in range(first, m):
        compliance += w.row_of_gap[k] * w.response[k]
    # not positive where a force on the nodes cannot move the gap, or friction jams; where B = G this is a sum of squares
    hold = 1.0 + p.joint_inertia * compliance if p.constraint == ROLLERS else compliance
    if not hold > 0.0:
        return False
    f.force = asked / hold
    f.friction = p.friction_force * sliding + rubbing * f.force
    for k in range(first, m):
        w.acceleration[k] -= f.force * w.response[k]
    return True


@inner
def _factor(M: Array, A: Array, first: int, size: int) -> bool:
    """To `A`: the factors of M = L D L^T for rows and columns from `first` on; False if M (lower triangle) is not positive definite.

    The diagonal of `A` holds the reciprocals of D, the rest L D.
    """
    for i in range(first, size):
        for j in range(first, i):
            total = M[i, j]
            for m in range(first, j):
                total -= A[i, m] * A[j, m] * A[m, m]
            A[i, j] = total
        pivot = M[i, i]
        for m in range(first, i):
            pivot -= A[i, m] * A[i, m] * A[m, m]
        if not pivot > 0.0:
            return False
        A[i, i] = 1.0 / pivot
    return True


@inner
def _substitute(A: Array, b: Array, first: int, size: int) -> None:
    """Solve M x = b in place of `b`, with the factors `A` of `_factor`.

    A number that is known is taken from all others at once, which do not wait for each other, unlike the terms of a sum.
    """
    for k in range(first, size):
        b[k] *= A[k, k]
        for i in range(k + 1, size):
            b[i] -= A[i, k] * b[k]
    for k in range(size - 1, first, -1):
        for i in range(first, k):
            b[i] -= A[k, i] * A[i, i] * b[k]


@inlined
def evaluate(p: BeamParameters, t: BeamTables, w: BeamWorkspace, y: State, y_rate: State) -> bool:
    """Write dy/dt of the state `y`, and to the facts, where the crank's speed or the base is prescribed, its forces.

    False for an impossible state.
    """
    f = w.facts
    if not motion(p, t, w, y):
        return False
    for k in range(p.speeds):
        y_rate.q[k], y_rate.u[k] = y.u[k], w.acceleration[k]
    y_rate.s[0] = f.s_rate + p.feedback * (f.missed + f.s - y.s[0])
    y_rate.work[DISSIPATED] = dissipation(p, t, w, y)
    if len(y.work) > BY_JOINT:
        y_rate.work[BY_JOINT] = joint_power(p, w, y)
    torque, speed = given_torque(p, y.u[0])[0], f.q2_rate if p.constraint == BASE else y.u[0]
    if p.first == 1:
        find_forces(p, t, w, y)
        torque = f.torque
    y_rate.work[BY_DRIVE] = torque * speed + power_of_tool(p, t, w)
    return True


def kernel(parameters: int, workspace: int, state: int, rate: int) -> int:
    """Write dy/dt of a state to `rate`; the arguments are addresses.

    Returns:
        1; or 0 for an impossible state, so that the integrator rejects the step.
    """
    p, w = parameters_at(parameters), workspace_at(workspace)
    return 1 if evaluate(p, p.tables, w, state_at(state, p.n, p.speeds), state_at(rate, p.n, p.speeds)) else 0
