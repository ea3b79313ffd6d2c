"""Equations of motion of the open loop with any constraint treatment, compiled (RIVALS.md, section 2).

State vector y, length 2 n + 7: q1, q2, eta (n), q1dot, q2dot, etadot (n), dissipated energy, work of the drive, work of the joint
on the parts that it joins. The last is zero for an ideal joint; a spring gives what it has stored back.
"""

import math
from typing import Any

import numpy as np
from numba import types
from numba.extending import overload
from numpy.typing import NDArray

from reference_model.compilation import OVERLOADED, compiled, embedded
from reference_model.constraints.gap import Gap, Speeds
from reference_model.constraints.joint import Joint
from reference_model.constraints.multiplier import multiplier_force
from reference_model.constraints.nodal_load import meet
from reference_model.constraints.solve import drive_torque
from reference_model.constraints.stiff_spring import spring_force
from reference_model.constraints.workspace import OpenWorkspace
from reference_model.dynamics import dissipation
from reference_model.equations import right_hand_side
from reference_model.kinematics import Contact, Slider, constraint_row, place_slider
from reference_model.observables import observe_row
from reference_model.outlined import assemble_open, fill_fields
from reference_model.parameters import Parameters, Workspace
from reference_model.tables import Tables

Array = NDArray[np.float64]
OpenParameters = tuple[Parameters, Joint]


@compiled
def close_loop(p: Parameters, w: Workspace, y: Speeds) -> tuple[bool, float, float]:
    """q2 and its rate that close the loop for given crank and shape; False where none do. Those of `y` are not read."""
    if not fill_fields(p, y.eta, y.eta_rate, w):
        return False, 0.0, 0.0
    c = place_slider(p, y.q1, y.eta, w)
    if not (c.closes and abs(c.slope) < 1.0):
        return False, 0.0, 0.0
    k = constraint_row(p, c, y.q1_rate, y.eta, y.eta_rate, w)
    return k.regular, c.q2, k.q2_rate


@embedded
def evaluate_open(p: Parameters, joint: Joint, w: OpenWorkspace, y: Array) -> tuple[bool, Slider, Gap, float]:
    """Slider force (N) and accelerations at the state y; leaves everything in `w`."""
    n = p.n
    eta, eta_rate = y[2 : n + 2], y[n + 4 : 2 * n + 4]
    none = Slider(False, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0)
    speeds = Speeds(y[0], y[1], eta, y[n + 2], y[n + 3], eta_rate)
    if not fill_fields(p, eta, eta_rate, w.beam):
        return False, none, Gap(False, 0.0, 0.0, 0.0, 0.0), 0.0
    c, gap = meet(joint, p, speeds, w)
    w.slider[0] = c.s
    if not (gap.exists and abs(c.slope) < 1.0 and abs(w.beam.end[0]) < 1.0):
        return False, c, gap, 0.0
    assemble_open(p, c, Contact(True, y[n + 3], gap.s_rate, -w.row[1], 0.0, 1.0, 0.0), speeds.q1_rate, eta, eta_rate, w.beam)
    if joint.bending_damping > 0.0:
        for i in range(n):
            for j in range(n):
                w.beam.Q[i + 2] -= joint.bending_damping * p.stiffness[i, j] * eta_rate[j]
    good, force = spring_force(joint, p, gap, w) if joint.is_spring else multiplier_force(joint, p, gap, w)
    return good, c, gap, force


@compiled
def open_right_hand_side(p: Parameters, joint: Joint, w: OpenWorkspace, y: Array, rate: Array) -> bool:
    """dy/dt at the state y, written to `rate`.

    Returns:
        False, and `rate` all nan, where the crank tip is not beside the follower or the shapes give out: a rejected step.
    """
    n = p.n
    good, _, _, force = evaluate_open(p, joint, w, y)
    if not good:
        rate[:] = math.nan
        return False
    joint_power = 0.0
    for a in range(n + 2):
        rate[a] = y[n + 2 + a]
        rate[n + 2 + a] = w.acceleration[a]
        joint_power -= force * w.spread[a] * y[n + 2 + a]
    rate[2 * n + 4] = dissipation(p, y[n + 2], y[n + 3], y[n + 4 : 2 * n + 4], w.beam)
    if joint.bending_damping > 0.0:
        for i in range(n):
            for j in range(n):
                rate[2 * n + 4] += joint.bending_damping * y[n + 4 + i] * p.stiffness[i, j] * y[n + 4 + j]
    rate[2 * n + 5] = drive_torque(p, w, force) * y[n + 2]
    rate[2 * n + 6] = joint_power
    return True


def open_equations(p: OpenParameters, w: OpenWorkspace, y: Array, rate: Array) -> bool:
    """`open_right_hand_side` with parameters and joint in one, as the time loop takes it."""
    return open_right_hand_side(p[0], p[1], w, y, rate)


@overload(right_hand_side, jit_options=OVERLOADED)
def _compiled_open_right_hand_side(p: Any, w: Any, y: Any, rate: Any) -> Any:
    """The pair (parameters, joint) is a plain tuple, the parameters of the other models are named ones."""
    if not isinstance(p, types.Tuple):
        return None

    def implementation(p: Any, w: Any, y: Any, rate: Any) -> Any:
        return open_right_hand_side(p[0], p[1], w, y, rate)

    return implementation


@compiled
def observe_open(
    p: Parameters, joint: Joint, w: OpenWorkspace, mesh: Tables, v: Workspace, states: Array, recover: bool, out: Array, joint_out: Array
) -> int:
    """Fill `out` (k, 19) with the observables of `states` (k, 2 n + 7) and `joint_out` (k, 2) with gap rate and joint power.

    Arguments and result as in `reference_model.observables.observe`; gap rate in m/s, power in W.
    """
    n = p.n
    for row in range(len(states)):
        y = states[row]
        good, c, gap, force = evaluate_open(p, joint, w, y)
        if not good:
            return row
        w.beam.acceleration[:] = w.acceleration
        w.closed[0], w.closed[n + 1] = y[0], y[n + 2]
        w.closed[1 : n + 1], w.closed[n + 2 : 2 * n + 2] = y[2 : n + 2], y[n + 4 : 2 * n + 4]
        w.closed[2 * n + 2], w.closed[2 * n + 3] = y[2 * n + 4], y[2 * n + 5]
        k = Contact(True, y[n + 3], gap.s_rate, -w.row[1], 0.0, 1.0, 0.0)
        observe_row(p, w.beam, mesh, v, c, k, w.closed, force, drive_torque(p, w, force), gap.value, recover, out[row])
        out[row, 16] = abs(gap.value)
        joint_out[row, 0], joint_out[row, 1] = gap.rate, 0.0
        for a in range(n + 2):
            joint_out[row, 1] -= force * w.spread[a] * y[n + 2 + a]
    return len(states)
