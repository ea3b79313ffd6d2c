"""Observables of the model whose shapes follow the slider, compiled (DERIVATION.md, section 12).

Curvature, and with it base angle, deflection, slider and tip place, are recovered from equilibrium as in `observables`: with few
modes this decides the accuracy. The spans end at the slider, so that the kink of the moment needs no care here.
"""

import math

import numpy as np
from numpy.typing import NDArray

from reference_model.compilation import compiled, inlined
from reference_model.moving_dynamics import _cumulate_spans, moving_motion, slider_force
from reference_model.moving_parameters import KINDS, MovingParameters, MovingWorkspace, SpanTables


@compiled
def observe_moving(p: MovingParameters, v: MovingWorkspace, states: NDArray[np.float64], out: NDArray[np.float64]) -> int:
    """Fill `out` (k, 19), columns as in `observables.COLUMNS`, from `states` (k, 2 n + 5); `v` is a workspace of `p.output`.

    Returns:
        Number of rows filled; less than k where a state cannot be evaluated.
    """
    t, n = p.output, p.n
    G = t.G
    N = 2 * G + 2
    for row in range(len(states)):
        y = states[row]
        if not moving_motion(p, t, v, y):
            return row
        o = out[row]
        normal, tangential, slider_moment, torque = slider_force(p, t, v, y)  # leaves accelerations less gravity in v.integrand
        o[0], o[1] = y[0], y[n + 2]
        o[7] = _tip_acceleration(p, v, N - 1)
        o[11], o[12] = normal, torque
        _energies(p, t, v, y, o)
        o[15], o[18] = y[2 * n + 3], y[2 * n + 4]
        _recover(p, t, v, y, normal, tangential, slider_moment, o)
    return len(states)


@inlined
def _tip_acceleration(p: MovingParameters, v: MovingWorkspace, end: int) -> float:
    """Absolute acceleration of x = L along the normal there (equation 12.1)."""
    g1 = g2 = 0.0
    if p.has_gravity:
        g1 = math.cos(v.facts[0]) * p.gravity_1 + math.sin(v.facts[0]) * p.gravity_2
        g2 = -math.sin(v.facts[0]) * p.gravity_1 + math.cos(v.facts[0]) * p.gravity_2
    return -v.e[end, 1] * (v.integrand[end, 0] + g1) + v.e[end, 0] * (v.integrand[end, 1] + g2)


@inlined
def _energies(p: MovingParameters, t: SpanTables, v: MovingWorkspace, y: NDArray[np.float64], o: NDArray[np.float64]) -> None:
    """Kinetic, strain and gravity energy (equations 12.2 to 12.4)."""
    n, G, s = p.n, t.G, y[p.n + 1]
    N = 2 * G + 2
    q2, q2_rate = v.facts[0], v.facts[1]
    kinetic = 0.5 * p.crank_inertia * y[n + 2] ** 2 + 0.5 * p.base_inertia * q2_rate**2
    moment_1 = moment_2 = 0.0
    for j in range(N):
        if j in (G, N - 1):
            continue
        dm = p.rhoA * (s if j < G else p.L - s) * t.weights[j if j < G else j - G - 1]
        v1, v2 = v.relative[j, 0] - q2_rate * v.z[j, 1], v.relative[j, 1] + q2_rate * v.z[j, 0]
        kinetic += 0.5 * dm * (v1 * v1 + v2 * v2)
        moment_1 += dm * v.z[j, 0]
        moment_2 += dm * v.z[j, 1]
    end = N - 1
    ec, es = p.tip_offset * v.e[end, 0], p.tip_offset * v.e[end, 1]
    v1 = v.relative[end, 0] - q2_rate * v.z[end, 1] - es * v.turn[end]
    v2 = v.relative[end, 1] + q2_rate * v.z[end, 0] + ec * v.turn[end]
    kinetic += 0.5 * p.tip_mass * (v1 * v1 + v2 * v2) + 0.5 * p.tip_inertia * v.turn[end] ** 2
    kinetic += 0.5 * p.slider_inertia * (v.turn[G] + v.facts[5] * v.facts[2]) ** 2
    strain = 0.0
    for i in range(n):
        strain += 0.5 * v.row[KINDS * N * n + i] * y[1 + i] ** 2
    gravity = 0.0
    if p.has_gravity:
        moment_1 += p.tip_mass * (v.z[end, 0] + ec)
        moment_2 += p.tip_mass * (v.z[end, 1] + es)
        cosine, sine = math.cos(q2), math.sin(q2)
        mass = p.rhoA * p.L + p.tip_mass
        gravity -= p.gravity_1 * (mass * p.d + cosine * moment_1 - sine * moment_2 + p.crank_moment * math.cos(y[0]))
        gravity -= p.gravity_2 * (sine * moment_1 + cosine * moment_2 + p.crank_moment * math.sin(y[0]))
    o[13], o[14], o[17] = kinetic, strain, gravity


@inlined
def _recover(
    p: MovingParameters,
    t: SpanTables,
    v: MovingWorkspace,
    y: NDArray[np.float64],
    normal: float,
    tangential: float,
    slider_moment: float,
    o: NDArray[np.float64],
) -> None:
    """Curvature from equilibrium, then shape, base angle, slider and tip place (equations 12.5 to 12.9)."""
    n, G, s = p.n, t.G, y[p.n + 1]
    N = 2 * G + 2
    end = N - 1
    # forces of the tip body
    turn = v.turn_0[end]
    for k in range(n + 1):
        turn += v.beta[k, end] * v.acceleration[k]
    ec, es = p.tip_offset * v.e[end, 0], p.tip_offset * v.e[end, 1]
    f1 = -p.tip_mass * (v.integrand[end, 0] - es * turn - ec * v.turn[end] ** 2)
    f2 = -p.tip_mass * (v.integrand[end, 1] + ec * turn - es * v.turn[end] ** 2)
    outboard_m = (v.z[end, 0] + ec) * f2 - (v.z[end, 1] + es) * f1 - p.tip_inertia * turn
    outboard_1, outboard_2 = f1, f2
    # force density at the points, and its moment about P in A0 (spent)
    for j in range(N):
        d1 = -p.rhoA * v.integrand[j, 0] - p.beam_damping * v.relative[j, 0]
        d2 = -p.rhoA * v.integrand[j, 1] - p.beam_damping * v.relative[j, 1]
        v.integrand[j, 0], v.integrand[j, 1] = d1, d2
        v.A0[j, 0], v.A0[j, 1] = v.z[j, 0] * d2 - v.z[j, 1] * d1, 0.0
    _cumulate_spans(t, s, p.L, v.integrand, v.relative)  # inboard force
    _cumulate_spans(t, s, p.L, v.A0, v.V[0])  # inboard moment
    outboard_1 += v.relative[end, 0]
    outboard_2 += v.relative[end, 1]
    outboard_m += v.V[0, end, 0]
    t1, t2 = v.e[G, 0], v.e[G, 1]
    s1, s2 = -normal * t2 + tangential * t1, normal * t1 + tangential * t2
    for j in range(N):
        x, W = v.z[j, 0], v.z[j, 1]
        moment = outboard_m - v.V[0, j, 0] - x * (outboard_2 - v.relative[j, 1]) + W * (outboard_1 - v.relative[j, 0])
        if j < G or (j == G and slider_moment == 0.0):
            moment += (v.z[G, 0] - x) * s2 - (v.z[G, 1] - W) * s1 + slider_moment
        v.gamma[j] = moment / p.EI
        v.integrand[j, 0], v.integrand[j, 1] = v.gamma[j], 0.0
    for gauge in range(3):
        o[8 + gauge] = 0.5 * p.thickness * _curvature_at(p, t, v, s, p.gauges[gauge])
    _cumulate_spans(t, s, p.L, v.integrand, v.A0)
    for j in range(N):
        v.integrand[j, 0], v.integrand[j, 1] = math.cos(v.A0[j, 0]), math.sin(v.A0[j, 0])
    c1, c2 = v.integrand[G, 0], v.integrand[G, 1]
    _cumulate_spans(t, s, p.L, v.integrand, v.relative)
    P1, P2 = p.LA * math.cos(y[0]) - p.d, p.LA * math.sin(y[0])
    Z1, Z2 = v.relative[G, 0], v.relative[G, 1]
    ds = 0.5 * (P1 * P1 + P2 * P2 - Z1 * Z1 - Z2 * Z2) / (Z1 * c1 + Z2 * c2)
    Z1, Z2 = Z1 + ds * c1, Z2 + ds * c2
    q2 = math.pi + math.atan2(-P2, -P1) - math.atan2(Z2, Z1)
    tip_1, tip_2 = v.relative[end, 0], v.relative[end, 1]
    o[2], o[3] = q2, s + ds
    o[4] = p.d + math.cos(q2) * tip_1 - math.sin(q2) * tip_2
    o[5] = math.sin(q2) * tip_1 + math.cos(q2) * tip_2
    o[6] = tip_2
    o[16] = abs(math.hypot(v.z[G, 0], v.z[G, 1]) - math.hypot(P1, P2))


@inlined
def _curvature_at(p: MovingParameters, t: SpanTables, v: MovingWorkspace, s: float, x: float) -> float:
    """Curvature at x by the polynomial through the points of its span (Lagrange's form)."""
    G = t.G
    span = 0 if x <= s else 1
    u = x / s if span == 0 else (x - s) / (p.L - s)
    total = 0.0
    for j in range(G):
        basis = 1.0
        for k in range(G):
            if k != j:
                basis *= (u - t.u[k]) / (t.u[j] - t.u[k])
        total += basis * v.gamma[span * (G + 1) + j]
    return total
