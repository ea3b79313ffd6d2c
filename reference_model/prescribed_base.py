"""The follower alone in fixed shapes on a base that turns as prescribed, compiled (DERIVATION.md, section 14).

The beam is that of the closed mechanism before its loop is closed (`dynamics.assemble`). State vector as in `clamped_dynamics`, length
2 n + 4: t, eta (n), 1, etadot (n), dissipated energy, work of the drive.
"""

import math
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from reference_model.compilation import compiled
from reference_model.dynamics import dissipation, factorize, substitute
from reference_model.kinematics import Contact, Slider
from reference_model.observables import curvature_of_shape, energies, recover_shape, tip_acceleration
from reference_model.outlined import assemble_open, fill_fields
from reference_model.parameters import Parameters, Workspace
from reference_model.spin_up import base_motion
from reference_model.tables import Tables

Array = NDArray[np.float64]


class OnBase(NamedTuple):
    """The beam's constants and the motion of its base."""

    beam: Parameters  # those of crank and slider are zero
    speed: float  # rad/s, of the base from `time` on
    time: float  # s, of the spin-up

    def __getattr__(self, name: str) -> Any:
        """What the integrator asks of the constants of any model is the beam's."""
        return getattr(self.beam, name)


@compiled
def _motion(p: OnBase, w: Workspace, y: Array) -> tuple[bool, float, float]:
    """Solve for the accelerations of (-, q2, eta), left in `w.acceleration` (equation 14.10); also the base's angle and rate."""
    b = p.beam
    n, eta, eta_rate = b.n, y[1 : b.n + 1], y[b.n + 2 : 2 * b.n + 2]
    angle, rate, acceleration = base_motion(p.speed, p.time, y[0])
    if not (fill_fields(b, eta, eta_rate, w) and abs(w.end[0]) < 1.0):
        return False, angle, rate
    c, k = _no_slider(p, angle, rate)
    assemble_open(b, c, k, 0.0, eta, eta_rate, w)
    for i in range(n):
        w.rhs[i] = w.Q[i + 2] - w.M[i + 2, 1] * acceleration
        for j in range(i + 1):
            w.reduced[i, j] = w.M[i + 2, j + 2]
    if not factorize(w.reduced, n):
        return False, angle, rate
    substitute(w.reduced, w.rhs, n)
    w.acceleration[0], w.acceleration[1] = 0.0, acceleration
    for i in range(n):
        w.acceleration[i + 2] = w.rhs[i]
    return True, angle, rate


@compiled
def _no_slider(p: OnBase, angle: float, rate: float) -> tuple[Slider, Contact]:
    """What stands in for a slider that is not there: it carries no force; the middle of the follower splits the mesh of the recovery."""
    c = Slider(True, 0.5 * p.beam.L, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, angle, 1.0, 0.0)
    return c, Contact(True, rate, 0.0, 1.0, 0.0, 1.0, 0.0)


@compiled
def _base_torque(p: OnBase, w: Workspace) -> float:
    """Torque that turns the base as prescribed, N m (equation 14.11)."""
    torque = -w.Q[1]
    for a in range(p.beam.n + 2):
        torque += w.M[1, a] * w.acceleration[a]
    return torque


@compiled
def base_right_hand_side(p: OnBase, w: Workspace, y: Array, rate: Array) -> bool:
    """dy/dt, written to `rate`; False and all nan where the shapes give out (a rejected step)."""
    n = p.beam.n
    good, _, turn = _motion(p, w, y)
    if not good:
        rate[:] = math.nan
        return False
    rate[0], rate[n + 1] = y[n + 1], 0.0
    for i in range(n):
        rate[1 + i], rate[n + 2 + i] = y[n + 2 + i], w.acceleration[i + 2]
    rate[2 * n + 2] = dissipation(p.beam, 0.0, turn, y[n + 2 : 2 * n + 2], w)
    rate[2 * n + 3] = _base_torque(p, w) * turn
    return True


@compiled
def observe_on_base(p: OnBase, w: Workspace, mesh: Tables, v: Workspace, states: Array, recover: bool, out: Array) -> int:
    """Fill `out` (k, 14), columns as in `clamped_observables.FOLLOWER_COLUMNS`, from `states` (k, 2 n + 4).

    Arguments and result as in `observables.observe`.
    """
    b = p.beam
    full = np.zeros(19)  # as the observables of the closed mechanism are laid out
    for row in range(len(states)):
        y, o = states[row], out[row]
        good, angle, rate = _motion(p, w, y)
        if not good:
            return row
        c, k = _no_slider(p, angle, rate)
        energies(b, c, k, w, y, full)
        o[0], o[4], o[8] = angle, tip_acceleration(b, k, w, y[b.n + 2 : 2 * b.n + 2]), _base_torque(p, w)
        o[9], o[10], o[11], o[12], o[13] = full[13], full[14], full[15], full[17], full[18]
        end = len(b.tables.edges) - 1
        tip_1, tip_2 = b.L - w.F_edges[end], w.end[1]
        if recover:
            recover_shape(b, c, k, w, mesh, v, y, 0.0, full)
            tip_1, tip_2 = v.F1_edges[len(mesh.edges) - 1], v.F2_edges[len(mesh.edges) - 1]
            o[5], o[6], o[7] = full[8], full[9], full[10]
        else:
            for gauge in range(3):
                o[5 + gauge] = 0.0
                for i in range(b.n):
                    o[5 + gauge] += 0.5 * b.thickness * curvature_of_shape(b, i, b.gauges[gauge]) * y[1 + i]
        o[1], o[2] = math.cos(angle) * tip_1 - math.sin(angle) * tip_2, math.sin(angle) * tip_1 + math.cos(angle) * tip_2
        o[3] = tip_2
    return len(states)
