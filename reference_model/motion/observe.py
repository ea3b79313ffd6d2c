"""Observables of a state, recovered from equilibrium (DERIVATION.md, section 6).

Curvature, and with it base angle, deflection, slider and tip place, follow from the loads outboard: with few shapes this decides the
accuracy. The cells end at the slider, so that the kink of the moment needs no care.
"""

import math
from typing import Final

import numpy as np
from numpy.typing import NDArray

from quickreturn.reference_model import columns as c
from quickreturn.reference_model.compilation import inlined, stage
from quickreturn.reference_model.joint import joint_energy as energy_of_joint
from quickreturn.reference_model.motion.fields import cumulate, directions
from quickreturn.reference_model.motion.lanes import load, plus_product, spread, total
from quickreturn.reference_model.motion.layout import (
    ACROSS,
    ALONG,
    AT,
    COS_Q2,
    CURVATURE,
    EXCESS,
    GAP,
    GAP_RATE,
    NORMAL,
    Q2_RATE,
    S_RATE,
    SIN_Q2,
    SLIDER_MOMENT,
    TANGENT_1,
    TANGENT_2,
    TANGENTIAL,
    TIP_1,
    TIP_2,
    TIP_TURN,
    TOOL_1,
    TOOL_2,
    TORQUE,
    Parameters,
    Tables,
    Workspace,
)
from quickreturn.reference_model.motion.loop import joint_power
from quickreturn.reference_model.spin_up import base_motion as motion_of_base
from quickreturn.reference_model.treatment import BASE

Array = NDArray[np.float64]

base_motion, joint_energy = stage(motion_of_base), stage(energy_of_joint)

#: Numbers in a row: those of `columns.OBSERVED`, then those of `columns.JOINT_COLUMNS`.
WIDTH: Final = len(c.OBSERVED) + len(c.JOINT_COLUMNS)


@inlined
def observe(p: Parameters, t: Tables, w: Workspace, y: Array, o: Array) -> bool:
    """Fill the row `o` (WIDTH,) for the state evaluated last, with its forces; spoils the workspace's fields.

    False where the recovered line is bent too far.
    """
    m, f = p.speeds, w.facts
    at = int(f[AT])
    o[c.CRANK_ANGLE], o[c.CRANK_SPEED], o[c.TIP_ACCELERATION] = y[0], y[m + 1], _tip_acceleration(p, t, w)
    o[c.SLIDER_FORCE], o[c.CRANK_TORQUE], o[c.DISSIPATED_ENERGY], o[c.DRIVE_WORK] = f[NORMAL], f[TORQUE], y[2 * m + 1], y[2 * m + 2]
    o[c.CONSTRAINT_GAP], o[c.GAP_RATE], o[c.JOINT_POWER] = f[EXCESS], f[GAP_RATE], 0.0
    if m > p.n + 1:
        o[c.JOINT_POWER] = joint_power(p, w, y)
    _energies(p, t, w, y, at, o)
    _bearing_forces(p, t, w, y, o)
    _bending_moment(p, t, w, at)
    return _recover(p, t, w, y, at, o)


@stage
def _tip_acceleration(p: Parameters, t: Tables, w: Workspace) -> float:
    """Absolute acceleration of x = L along the normal there (equation 6.1)."""
    N, f = t.cells * t.S, w.facts
    end = N - t.S + t.G
    g1 = f[COS_Q2] * p.gravity_1 + f[SIN_Q2] * p.gravity_2
    g2 = -f[SIN_Q2] * p.gravity_1 + f[COS_Q2] * p.gravity_2
    return -w.e[N + end] * (w.A[end] + g1) + w.e[end] * (w.A[N + end] + g2)


@stage
def _energies(p: Parameters, t: Tables, w: Workspace, y: Array, at: int, o: Array) -> None:
    """Kinetic, strain and gravity energy (equations 6.2 to 6.4)."""
    n, m, N, f = p.n, p.speeds, t.cells * t.S, w.facts
    end = N - t.S + t.G
    q2_rate, q1_rate = f[Q2_RATE], y[m + 1]
    kinetic = 0.5 * p.crank_inertia * q1_rate * q1_rate + 0.5 * p.base_inertia * q2_rate * q2_rate
    for j in range(N):
        v1, v2 = w.relative[j] - q2_rate * w.z[N + j], w.relative[N + j] + q2_rate * w.z[j]
        kinetic += 0.5 * w.mass[j] * (v1 * v1 + v2 * v2)
    ec, es = p.tip_offset * w.e[end], p.tip_offset * w.e[N + end]
    v1 = w.relative[end] - q2_rate * w.z[N + end] - es * w.turn[end]
    v2 = w.relative[N + end] + q2_rate * w.z[end] + ec * w.turn[end]
    kinetic += 0.5 * p.tip_mass * (v1 * v1 + v2 * v2) + 0.5 * p.tip_inertia * w.turn[end] ** 2
    kinetic += 0.5 * p.slider_inertia * (w.turn[at] + f[CURVATURE] * f[S_RATE]) ** 2
    kinetic += 0.5 * p.joint_inertia * f[GAP_RATE] ** 2
    strain = joint_energy(f[GAP], p.plus, p.minus, p.plus_from, p.minus_from)
    for i in range(n):
        strain += 0.5 * w.row[t.kinds * N * n + i] * y[1 + i] ** 2
    moment_1, moment_2 = p.tip_mass * (w.z[end] + ec), p.tip_mass * (w.z[N + end] + es)
    for j in range(N):
        moment_1 += w.mass[j] * w.z[j]
        moment_2 += w.mass[j] * w.z[N + j]
    cosine, sine = f[COS_Q2], f[SIN_Q2]
    mass = p.rhoA * p.L + p.tip_mass
    gravity = -p.gravity_1 * (mass * p.d + cosine * moment_1 - sine * moment_2 + p.crank_moment * math.cos(y[0]))
    gravity -= p.gravity_2 * (sine * moment_1 + cosine * moment_2 + p.crank_moment * math.sin(y[0]))
    o[c.KINETIC_ENERGY], o[c.STRAIN_ENERGY], o[c.GRAVITY_ENERGY] = kinetic, strain, gravity


@inlined
def _slider_on_follower(w: Workspace) -> tuple[float, float]:
    """The slider's force on the follower in frame B, N (equation 5.6)."""
    f = w.facts
    t1, t2 = f[TANGENT_1], f[TANGENT_2]
    return -f[NORMAL] * t2 + f[TANGENTIAL] * t1, f[NORMAL] * t1 + f[TANGENTIAL] * t2


@stage
def _bearing_forces(p: Parameters, t: Tables, w: Workspace, y: Array, o: Array) -> None:
    """Forces of the ground on base and crank in frame N, by Newton's law for follower and crank (equations 6.10 and 6.11)."""
    N, f = t.cells * t.S, w.facts
    bodies = 2 * N
    s1 = s2 = 0.0
    if p.treatment != BASE:
        s1, s2 = _slider_on_follower(w)
    beam_1 = beam_2 = spread(0.0)
    for j in range(0, N, 4):
        beam_1 = plus_product(beam_1, load(w.mass, j), load(w.A, j))
        beam_2 = plus_product(beam_2, load(w.mass, N + j), load(w.A, N + j))
    p1 = total(beam_1) + p.tip_mass * w.A[bodies + TIP_1] - f[TOOL_1] - s1
    p2 = total(beam_2) + p.tip_mass * w.A[bodies + TIP_2] - f[TOOL_2] - s2
    turning, centripetal = p.crank_moment * w.acceleration[0], p.crank_moment * y[p.speeds + 1] ** 2
    c1 = s1 - turning * f[ACROSS] - centripetal * f[ALONG]
    c2 = s2 + turning * f[ALONG] - centripetal * f[ACROSS]
    cosine, sine = f[COS_Q2], f[SIN_Q2]
    o[c.PIVOT_FORCE_X], o[c.PIVOT_FORCE_Y] = cosine * p1 - sine * p2, sine * p1 + cosine * p2
    o[c.CRANK_FORCE_X] = cosine * c1 - sine * c2 - p.crank_mass * p.gravity_1
    o[c.CRANK_FORCE_Y] = sine * c1 + cosine * c2 - p.crank_mass * p.gravity_2


@stage
def _bending_moment(p: Parameters, t: Tables, w: Workspace, at: int) -> None:
    """Moment of the outboard forces at the points, N m, in `w.psi` (equations 6.5 and 6.6)."""
    N, f = t.cells * t.S, w.facts
    end, bodies = N - t.S + t.G, 2 * N
    force, moment = w.integrand, w.e  # e is read for the last time before the moments are laid there
    ec, es = p.tip_offset * w.e[end], p.tip_offset * w.e[N + end]
    s1, s2 = _slider_on_follower(w)
    for j in range(N):
        force[j] = -p.rhoA * w.A[j] - p.beam_damping * p.damps_along * w.relative[j]
        force[N + j] = -p.rhoA * w.A[N + j] - p.beam_damping * w.relative[N + j]
    for j in range(N):
        moment[j] = w.z[j] * force[N + j] - w.z[N + j] * force[j]
    for j in range(N):
        moment[N + j] = 0.0
    cumulate(t, w.length, force, w.relative)  # inboard force
    cumulate(t, w.length, moment, w.weighted)  # and its moment about P
    # the tip body's and the tool's, and with them everything outboard of P
    f1, f2 = -p.tip_mass * w.A[bodies + TIP_1], -p.tip_mass * w.A[bodies + TIP_2]
    total_m = (w.z[end] + ec) * f2 - (w.z[N + end] + es) * f1 - p.tip_inertia * w.A[bodies + TIP_TURN] + w.weighted[end]
    total_m += w.z[end] * f[TOOL_2] - w.z[N + end] * f[TOOL_1]
    total_1, total_2 = f1 + w.relative[end] + f[TOOL_1], f2 + w.relative[N + end] + f[TOOL_2]
    for j in range(N):
        w.psi[j] = total_m - w.weighted[j] - w.z[j] * (total_2 - w.relative[N + j]) + w.z[N + j] * (total_1 - w.relative[j])
    if p.treatment != BASE:
        # at the slider itself the moment jumps by the slider's; the outboard side is shown
        for j in range(at if f[SLIDER_MOMENT] != 0.0 else at + 1):
            w.psi[j] += (w.z[at] - w.z[j]) * s2 - (w.z[N + at] - w.z[N + j]) * s1 + f[SLIDER_MOMENT]


@stage
def _recover(p: Parameters, t: Tables, w: Workspace, y: Array, at: int, o: Array) -> bool:
    """Moments and strains; shape, base angle, slider and tip place of the recovered curvature (equations 6.7 to 6.9)."""
    N, s, f = t.cells * t.S, w.slider[0], w.facts
    end, flexibility = N - t.S + t.G, 1.0 / p.EI
    for j in range(N):
        w.curvature[j] = flexibility * w.psi[j]
    if p.bending_damping > 0.0:
        for j in range(N):
            w.curvature[j] -= p.bending_damping * w.curvature_rate[j]
    for j in range(N):
        w.integrand[j], w.integrand[N + j] = w.curvature[j], 0.0
    cumulate(t, w.length, w.integrand, w.z)
    if not directions(w.z[:N], w.integrand):
        return False
    cumulate(t, w.length, w.integrand, w.relative)
    tip_1, tip_2 = w.relative[end], w.relative[N + end]
    o[c.MOMENT_SLIDER] = w.psi[at]
    for place in range(c.PLACES):
        x = (place + 1) * p.L / (c.PLACES + 1)
        o[c.FIRST_OF_MOMENTS + place], o[c.FIRST_OF_SHAPE + place] = _at_place(t, w, w.psi, x)
    for gauge in range(3):
        o[c.STRAIN_1 + gauge] = 0.5 * p.thickness * _at_place(t, w, w.curvature, p.gauges[gauge])[0]
    cosine, sine, ds = f[COS_Q2], f[SIN_Q2], 0.0
    if p.treatment == BASE:
        o[c.FOLLOWER_ANGLE] = base_motion(p.base_speed, p.base_time, y[0])[0]
    else:
        # the crank tip is beside the line, by the gap along its normal
        c1, c2 = w.integrand[at], w.integrand[N + at]
        Z1, Z2 = w.relative[at] - f[GAP] * c2, w.relative[N + at] + f[GAP] * c1
        P1, P2 = p.LA * math.cos(y[0]) - p.d, p.LA * math.sin(y[0])
        ds = 0.5 * (P1 * P1 + P2 * P2 - Z1 * Z1 - Z2 * Z2) / (Z1 * c1 + Z2 * c2)
        Z1, Z2 = Z1 + ds * c1, Z2 + ds * c2
        # exp(i q2) has the direction of P / Z; both -P and Z point forwards
        cosine, sine = P1 * Z1 + P2 * Z2, P2 * Z1 - P1 * Z2
        scale = 1.0 / math.sqrt(cosine * cosine + sine * sine)
        cosine, sine = scale * cosine, scale * sine
        o[c.FOLLOWER_ANGLE] = math.pi + math.atan2(-sine, -cosine)
    o[c.SLIDER_POSITION], o[c.TIP_DEFLECTION] = s + ds, tip_2
    o[c.TIP_X], o[c.TIP_Y] = p.d + cosine * tip_1 - sine * tip_2, sine * tip_1 + cosine * tip_2
    return True


@stage
def _at_place(t: Tables, w: Workspace, field: Array, x: float) -> tuple[float, float]:
    """A field (moment or curvature) and the deflection at x, by the polynomials through the points of its cell (Lagrange's form)."""
    cell, begin = 0, 0.0
    while cell < t.cells - 1 and x > begin + w.length[cell] * (1.0 + 1e-12) and w.length[cell + 1] > 0.0:
        begin += w.length[cell]
        cell += 1
    first, across, u = cell * t.S, (t.cells + cell) * t.S, (x - begin) / w.length[cell]
    value, deflection, before = 0.0, 0.0, 1.0  # before: product of the distances from the points passed
    for j in range(t.G):
        away, share = u - t.u[j], t.lagrange[j] * before
        value = value * away + share * field[first + j]
        deflection = deflection * away + share * w.relative[across + j]
        before *= away
    return value, deflection
