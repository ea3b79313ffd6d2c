"""Observables of the model whose shapes follow the slider, compiled (DERIVATION.md, section 12).

Curvature, and with it base angle, deflection, slider and tip place, are recovered from equilibrium as in `observables`: with few
modes this decides the accuracy. The spans end at the slider, so that the kink of the moment needs no care here.
"""

import math

import numpy as np
from numpy.typing import NDArray

from reference_model.compilation import borrowing, inlined
from reference_model.moving_dynamics import cumulate, directions, moving_motion, slider_force
from reference_model.moving_parameters import (
    COS_Q2,
    CURVATURE,
    EXCESS,
    KINDS,
    Q2_RATE,
    S_RATE,
    SIN_Q2,
    TIP_1,
    TIP_2,
    TIP_TURN,
    MovingParameters,
    MovingWorkspace,
    SpanTables,
)

Array = NDArray[np.float64]


@borrowing
def observe_moving(p: MovingParameters, v: MovingWorkspace, states: Array, out: Array) -> int:
    """Fill `out` (k, 19), columns as in `observables.COLUMNS`, from `states` (k, 2 n + 5); `v` is a workspace of `p.tables`.

    Returns:
        Number of rows filled; less than k where a state cannot be evaluated.
    """
    t, n = p.tables, p.n
    for row in range(len(states)):
        y, o = states[row], out[row]
        if not moving_motion(p, t, v, y):
            return row
        normal, tangential, slider_moment, torque = slider_force(p, t, v, y)  # leaves accelerations less gravity in v.A
        o[0], o[1] = y[0], y[n + 2]
        o[7] = _tip_acceleration(p, t, v)
        o[11], o[12] = normal, torque
        _energies(p, t, v, y, o)
        o[15], o[18] = y[2 * n + 3], y[2 * n + 4]
        _recover(p, t, v, y, normal, tangential, slider_moment, o)
    return len(states)


@borrowing
def _tip_acceleration(p: MovingParameters, t: SpanTables, v: MovingWorkspace) -> float:
    """Absolute acceleration of x = L along the normal there (equation 12.1)."""
    N, end = 2 * t.S, t.S + t.G
    g1 = v.facts[COS_Q2] * p.gravity_1 + v.facts[SIN_Q2] * p.gravity_2
    g2 = -v.facts[SIN_Q2] * p.gravity_1 + v.facts[COS_Q2] * p.gravity_2
    return -v.e[N + end] * (v.A[end] + g1) + v.e[end] * (v.A[N + end] + g2)


@borrowing
def _energies(p: MovingParameters, t: SpanTables, v: MovingWorkspace, y: Array, o: Array) -> None:
    """Kinetic, strain and gravity energy (equations 12.2 to 12.4)."""
    n, G, N = p.n, t.G, 2 * t.S
    end = t.S + G
    q2_rate, q1_rate = v.facts[Q2_RATE], y[n + 2]
    kinetic = 0.5 * p.crank_inertia * q1_rate * q1_rate + 0.5 * p.base_inertia * q2_rate * q2_rate
    for j in range(N):
        v1, v2 = v.relative[j] - q2_rate * v.z[N + j], v.relative[N + j] + q2_rate * v.z[j]
        kinetic += 0.5 * v.mass[j] * (v1 * v1 + v2 * v2)
    ec, es = p.tip_offset * v.e[end], p.tip_offset * v.e[N + end]
    v1 = v.relative[end] - q2_rate * v.z[N + end] - es * v.turn[end]
    v2 = v.relative[N + end] + q2_rate * v.z[end] + ec * v.turn[end]
    kinetic += 0.5 * p.tip_mass * (v1 * v1 + v2 * v2) + 0.5 * p.tip_inertia * v.turn[end] ** 2
    kinetic += 0.5 * p.slider_inertia * (v.turn[G] + v.facts[CURVATURE] * v.facts[S_RATE]) ** 2
    strain = 0.0
    for i in range(n):
        strain += 0.5 * v.row[KINDS * N * n + i] * y[1 + i] ** 2
    gravity = 0.0
    if p.has_gravity:
        moment_1, moment_2 = p.tip_mass * (v.z[end] + ec), p.tip_mass * (v.z[N + end] + es)
        for j in range(N):
            moment_1 += v.mass[j] * v.z[j]
            moment_2 += v.mass[j] * v.z[N + j]
        cosine, sine = v.facts[COS_Q2], v.facts[SIN_Q2]
        mass = p.rhoA * p.L + p.tip_mass
        gravity -= p.gravity_1 * (mass * p.d + cosine * moment_1 - sine * moment_2 + p.crank_moment * math.cos(y[0]))
        gravity -= p.gravity_2 * (sine * moment_1 + cosine * moment_2 + p.crank_moment * math.sin(y[0]))
    o[13], o[14], o[17] = kinetic, strain, gravity


@borrowing
def _bending_moment(
    p: MovingParameters, t: SpanTables, v: MovingWorkspace, s: float, normal: float, tangential: float, slider_moment: float
) -> None:
    """Curvature at the points, in `v.gamma`: moment of the outboard forces over EI (equations 12.5 and 12.6)."""
    G, S, N = t.G, t.S, 2 * t.S
    end, bodies = S + G, 2 * N
    force, moment = v.integrand, v.e  # e is read for the last time before the moments are laid there
    ec, es = p.tip_offset * v.e[end], p.tip_offset * v.e[N + end]
    s1, s2 = -normal * v.e[N + G] + tangential * v.e[G], normal * v.e[G] + tangential * v.e[N + G]
    for j in range(2 * N):
        force[j] = -p.rhoA * v.A[j] - p.beam_damping * v.relative[j]
    for j in range(N):
        moment[j] = v.z[j] * force[N + j] - v.z[N + j] * force[j]
    for j in range(N):
        moment[N + j] = 0.0
    cumulate(t.to_points, s, p.L - s, force, v.relative)  # inboard force
    cumulate(t.to_points, s, p.L - s, moment, v.Y)  # and its moment about P
    # the tip body's, and with it everything outboard of P
    f1, f2 = -p.tip_mass * v.A[bodies + TIP_1], -p.tip_mass * v.A[bodies + TIP_2]
    total_m = (v.z[end] + ec) * f2 - (v.z[N + end] + es) * f1 - p.tip_inertia * v.A[bodies + TIP_TURN] + v.Y[end]
    total_1, total_2 = f1 + v.relative[end], f2 + v.relative[N + end]
    for j in range(N):
        v.gamma[j] = total_m - v.Y[j] - v.z[j] * (total_2 - v.relative[N + j]) + v.z[N + j] * (total_1 - v.relative[j])
    # at the slider itself the moment jumps by the slider's; the outboard side is shown
    for j in range(G if slider_moment != 0.0 else G + 1):
        v.gamma[j] += (v.z[G] - v.z[j]) * s2 - (v.z[N + G] - v.z[N + j]) * s1 + slider_moment
    for j in range(N):
        v.gamma[j] /= p.EI


@borrowing
def _recover(
    p: MovingParameters,
    t: SpanTables,
    v: MovingWorkspace,
    y: Array,
    normal: float,
    tangential: float,
    slider_moment: float,
    o: Array,
) -> None:
    """Curvature from equilibrium, then shape, base angle, slider and tip place (equations 12.5 to 12.9)."""
    G, N, s = t.G, 2 * t.S, y[p.n + 1]
    end = t.S + G
    _bending_moment(p, t, v, s, normal, tangential, slider_moment)
    for gauge in range(3):
        o[8 + gauge] = 0.5 * p.thickness * _curvature_at(t, v, s, p.L, p.gauges[gauge])
    for j in range(N):
        v.integrand[j], v.integrand[N + j] = v.gamma[j], 0.0
    cumulate(t.to_points, s, p.L - s, v.integrand, v.z)
    directions(v.z[:N], v.integrand)
    c1, c2 = v.integrand[G], v.integrand[N + G]
    cumulate(t.to_points, s, p.L - s, v.integrand, v.relative)
    P1, P2 = p.LA * math.cos(y[0]) - p.d, p.LA * math.sin(y[0])
    Z1, Z2 = v.relative[G], v.relative[N + G]
    ds = 0.5 * (P1 * P1 + P2 * P2 - Z1 * Z1 - Z2 * Z2) / (Z1 * c1 + Z2 * c2)
    Z1, Z2 = Z1 + ds * c1, Z2 + ds * c2
    # exp(i q2) has the direction of P / Z; both -P and Z point forwards
    cosine, sine = P1 * Z1 + P2 * Z2, P2 * Z1 - P1 * Z2
    tip_1, tip_2 = v.relative[end], v.relative[N + end]
    o[2], o[3] = math.pi + math.atan2(-sine, -cosine), s + ds
    scale = 1.0 / math.sqrt(cosine * cosine + sine * sine)
    o[4] = p.d + scale * (cosine * tip_1 - sine * tip_2)
    o[5] = scale * (sine * tip_1 + cosine * tip_2)
    o[6] = tip_2
    o[16] = abs(v.facts[EXCESS])


@inlined
def _curvature_at(t: SpanTables, v: MovingWorkspace, s: float, L: float, x: float) -> float:
    """Curvature at x by the polynomial through the points of its span (Lagrange's form, barycentric)."""
    first = 0 if x <= s else t.S
    u = x / s if x <= s else (x - s) / (L - s)
    total = weight = 0.0
    for j in range(t.G):
        if u == t.u[j]:
            return v.gamma[first + j]
        share = t.barycentric[j] / (u - t.u[j])
        total += share * v.gamma[first + j]
        weight += share
    return total / weight
