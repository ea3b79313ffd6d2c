"""Equations of motion with shapes that follow the slider, compiled (DERIVATION.md, sections 10 and 11).

State vector, length 2 n + 5: q1, eta (n), s, q1dot, etadot (n), dissipated energy, work of the drive. The slider's arc length is
carried along as a state of its own, which spares an iteration in every evaluation; a weak feedback keeps it on the loop.
"""

import math

import numpy as np
from numpy.typing import NDArray

from reference_model.compilation import compiled, inlined
from reference_model.dynamics import _solve_cholesky
from reference_model.moving_parameters import KINDS, MovingParameters, MovingWorkspace, SpanTables

#: Rate (1/s) at which a violation of the loop's length decays.
FEEDBACK = 100.0


@inlined
def _interpolate_row(t: SpanTables, s: float, row: NDArray[np.float64]) -> None:
    """The table's row at s, cubic in s."""
    k = min(max(int((s - t.low) / t.step), 0), t.coefficients.shape[0] - 1)
    ds = s - t.low - k * t.step
    for m in range(len(row)):
        row[m] = ((t.coefficients[k, 0, m] * ds + t.coefficients[k, 1, m]) * ds + t.coefficients[k, 2, m]) * ds + t.coefficients[k, 3, m]


@inlined
def _cumulate_spans(t: SpanTables, s: float, L: float, f: NDArray[np.float64], out: NDArray[np.float64]) -> None:
    """Integrals from 0 of a complex function given at the points (N, 2), to every point; slider and end included."""
    G = t.G
    start_1 = start_2 = 0.0
    for span in range(2):
        h = s if span == 0 else L - s
        first = span * (G + 1)
        total_1 = total_2 = 0.0
        for p in range(G):
            part_1 = part_2 = 0.0
            for j in range(G):
                part_1 += t.to_points[p, j] * f[first + j, 0]
                part_2 += t.to_points[p, j] * f[first + j, 1]
            out[first + p, 0] = start_1 + h * part_1
            out[first + p, 1] = start_2 + h * part_2
            total_1 += t.weights[p] * f[first + p, 0]
            total_2 += t.weights[p] * f[first + p, 1]
        start_1 += h * total_1
        start_2 += h * total_2
        out[first + G, 0] = start_1
        out[first + G, 1] = start_2


@inlined
def _to_slider(t: SpanTables, s: float, f: NDArray[np.float64]) -> tuple[float, float]:
    """Integral from 0 to the slider of a complex function given at the points."""
    total_1 = total_2 = 0.0
    for j in range(t.G):
        total_1 += t.weights[j] * f[j, 0]
        total_2 += t.weights[j] * f[j, 1]
    return s * total_1, s * total_2


@inlined
def _two_by_two(a1: float, a2: float, b1: float, b2: float, r1: float, r2: float) -> tuple[float, float]:
    """Real c, sigma with a c + b sigma = r for complex a, b, r."""
    determinant = a1 * b2 - a2 * b1
    return (r1 * b2 - r2 * b1) / determinant, (a1 * r2 - a2 * r1) / determinant


@compiled
def moving_motion(p: MovingParameters, t: SpanTables, w: MovingWorkspace, y: NDArray[np.float64]) -> bool:
    """Close the loop, find the partial rates and velocities and the remaining acceleration, and solve for the accelerations.

    Equations 10.3 to 11.8; leaves everything in `w`. False where the state cannot be: outside the tables, or a singular loop.
    """
    n, G = p.n, t.G
    N = 2 * G + 2
    s = y[n + 1]
    if not (t.low <= s <= p.reach and abs(y[0]) < 1e9):
        return False
    _interpolate_row(t, s, w.row)
    q1_rate = y[n + 2]
    block = N * n
    mixed_base = KINDS * block
    # angle, its derivatives by s, and what changes with time at fixed s (equations 10.3 and 10.4)
    for j in range(N):
        psi = psi_s = psi_ss = psi_rate = psi_s_rate = 0.0
        for i in range(n):
            m = j * n + i
            psi += w.row[m] * y[1 + i]
            psi_s += w.row[block + m] * y[1 + i]
            psi_ss += w.row[2 * block + m] * y[1 + i]
            psi_rate += w.row[m] * y[n + 3 + i]
            psi_s_rate += w.row[block + m] * y[n + 3 + i]
        w.psi[j], w.psi_s[j], w.turn[j] = psi, psi_s, psi_rate
        w.gamma[j], w.turn_0[j] = psi_s_rate, psi_ss
        w.e[j, 0], w.e[j, 1] = math.cos(psi), math.sin(psi)
    _cumulate_spans(t, s, p.L, w.e, w.z)
    Z1, Z2 = w.z[G, 0], w.z[G, 1]
    v1, v2 = p.LA * math.cos(y[0]) - p.d, p.LA * math.sin(y[0])
    q2 = math.pi + math.atan2(-v2, -v1) - math.atan2(Z2, Z1)
    along, across = math.cos(y[0] - q2), math.sin(y[0] - q2)
    # matrix of the loop: columns i Z and exp(i psi(s)) + i int psi_s exp(i psi) (equation 10.6)
    for j in range(G):
        w.integrand[j, 0], w.integrand[j, 1] = -w.psi_s[j] * w.e[j, 1], w.psi_s[j] * w.e[j, 0]
    Y1, Y2 = _to_slider(t, s, w.integrand)
    b1, b2 = w.e[G, 0] + Y1, w.e[G, 1] + Y2
    if not abs(-Z2 * b2 - Z1 * b1) > 1e-6 * p.L:
        return False
    w.c[0], w.sigma[0] = _two_by_two(-Z2, Z1, b1, b2, -p.LA * across, p.LA * along)
    q2_rate, s_rate = w.c[0] * q1_rate, w.sigma[0] * q1_rate
    for i in range(n):
        r1 = r2 = 0.0
        for j in range(G):
            r1 += t.weights[j] * w.row[j * n + i] * w.e[j, 1]
            r2 -= t.weights[j] * w.row[j * n + i] * w.e[j, 0]
        w.c[1 + i], w.sigma[1 + i] = _two_by_two(-Z2, Z1, b1, b2, s * r1, s * r2)
        q2_rate += w.c[1 + i] * y[n + 3 + i]
        s_rate += w.sigma[1 + i] * y[n + 3 + i]
    curvature = 0.0
    for i in range(n):
        curvature += w.row[mixed_base + 2 * n + i] * y[1 + i]
    for j in range(N):
        w.gamma[j] = 2.0 * s_rate * w.gamma[j] + s_rate**2 * w.turn_0[j]
        w.turn[j] += q2_rate + w.psi_s[j] * s_rate
    # remainders of q2 and s (equation 10.8)
    for j in range(G):
        square = w.turn[j] ** 2
        w.integrand[j, 0] = w.gamma[j] * w.e[j, 1] + square * w.e[j, 0]
        w.integrand[j, 1] = -w.gamma[j] * w.e[j, 0] + square * w.e[j, 1]
    r1, r2 = _to_slider(t, s, w.integrand)
    swing = s_rate * (2.0 * w.turn[G] + curvature * s_rate)
    r1 += -p.LA * q1_rate**2 * along + swing * w.e[G, 1]
    r2 += -p.LA * q1_rate**2 * across - swing * w.e[G, 0]
    q2_0, s_0 = _two_by_two(-Z2, Z1, b1, b2, r1, r2)
    f = w.facts
    f[0], f[1], f[2], f[3], f[4], f[5], f[6], f[7] = q2, q2_rate, s_rate, q2_0, s_0, curvature, along, across
    for j in range(N):
        turn_0 = q2_0 + w.gamma[j] + w.psi_s[j] * s_0
        w.turn_0[j] = turn_0
        square = w.turn[j] ** 2
        w.integrand[j, 0] = -turn_0 * w.e[j, 1] - square * w.e[j, 0]
        w.integrand[j, 1] = turn_0 * w.e[j, 0] - square * w.e[j, 1]
    _cumulate_spans(t, s, p.L, w.integrand, w.A0)
    # partial angular rates and velocities (equations 10.9 and 10.10)
    for k in range(n + 1):
        for j in range(N):
            beta = w.c[k] + w.psi_s[j] * w.sigma[k]
            if k > 0:
                beta += w.row[j * n + k - 1]
            w.beta[k, j] = beta
            w.integrand[j, 0], w.integrand[j, 1] = -beta * w.e[j, 1], beta * w.e[j, 0]
        _cumulate_spans(t, s, p.L, w.integrand, w.V[k])
    w.slider[0] = s
    return _solve_motion(p, t, w, y)


@inlined
def _solve_motion(p: MovingParameters, t: SpanTables, w: MovingWorkspace, y: NDArray[np.float64]) -> bool:
    """Mass matrix and forces for the free speeds, and their solution (equations 11.1 to 11.7)."""
    n, G = p.n, t.G
    N = 2 * G + 2
    s = y[n + 1]
    q1_rate = y[n + 2]
    q2, q2_rate, q2_0, along, across = w.facts[0], w.facts[1], w.facts[3], w.facts[6], w.facts[7]
    g1 = g2 = 0.0
    if p.has_gravity:
        g1 = math.cos(q2) * p.gravity_1 + math.sin(q2) * p.gravity_2
        g2 = -math.sin(q2) * p.gravity_1 + math.cos(q2) * p.gravity_2
    for j in range(N):  # velocity relative to the base frame: v - i q2dot z
        r1, r2 = q2_rate * w.z[j, 1], -q2_rate * w.z[j, 0]
        for k in range(n + 1):
            speed = q1_rate if k == 0 else y[n + 2 + k]
            r1 += speed * w.V[k, j, 0]
            r2 += speed * w.V[k, j, 1]
        w.relative[j, 0], w.relative[j, 1] = r1, r2
    base = n * (2 * G + 2) * KINDS
    end = N - 1
    ec, es = p.tip_offset * w.e[end, 0], p.tip_offset * w.e[end, 1]
    tip_1 = w.A0[end, 0] - es * w.turn_0[end] - ec * w.turn[end] ** 2 - g1
    tip_2 = w.A0[end, 1] + ec * w.turn_0[end] - es * w.turn[end] ** 2 - g2
    slider_0 = 0.0
    if p.slider_inertia > 0.0:
        slider_0 = _slider_remainder(n, base, w, y)
    for k in range(n + 1):
        force = -(p.base_inertia * q2_0 + p.base_damping * q2_rate) * w.c[k]
        for span in range(2):
            h = s if span == 0 else p.L - s
            for q in range(G):
                j = span * (G + 1) + q
                dx = h * t.weights[q]
                V1, V2 = w.V[k, j, 0], w.V[k, j, 1]
                force -= p.rhoA * dx * (V1 * (w.A0[j, 0] - g1) + V2 * (w.A0[j, 1] - g2))
                R1, R2 = V1 + w.c[k] * w.z[j, 1], V2 - w.c[k] * w.z[j, 0]
                force -= p.beam_damping * dx * (R1 * w.relative[j, 0] + R2 * w.relative[j, 1])
        T1, T2 = w.V[k, end, 0] - es * w.beta[k, end], w.V[k, end, 1] + ec * w.beta[k, end]
        force -= p.tip_mass * (T1 * tip_1 + T2 * tip_2) + p.tip_inertia * w.beta[k, end] * w.turn_0[end]
        # strain energy 1/2 sum omega_i^2(s) eta_i^2 (equation 11.4)
        for i in range(n):
            force -= 0.5 * w.row[base + n + i] * y[1 + i] ** 2 * w.sigma[k]
        if k > 0:
            force -= w.row[base + k - 1] * y[k]
        else:
            force += p.torque - p.crank_damping * q1_rate + p.crank_moment * (g2 * along - g1 * across)
        turning = _slider_rate(n, base, k, w, y) if p.slider_inertia > 0.0 else 0.0
        force -= p.slider_inertia * turning * slider_0
        w.rhs[k] = force
        for m in range(k + 1):
            mass = p.base_inertia * w.c[k] * w.c[m]
            beam = 0.0
            for span in range(2):
                h = s if span == 0 else p.L - s
                for q in range(G):
                    j = span * (G + 1) + q
                    beam += h * t.weights[q] * (w.V[k, j, 0] * w.V[m, j, 0] + w.V[k, j, 1] * w.V[m, j, 1])
            U1, U2 = w.V[m, end, 0] - es * w.beta[m, end], w.V[m, end, 1] + ec * w.beta[m, end]
            mass += p.rhoA * beam + p.tip_mass * (T1 * U1 + T2 * U2) + p.tip_inertia * w.beta[k, end] * w.beta[m, end]
            if p.slider_inertia > 0.0:
                mass += p.slider_inertia * turning * _slider_rate(n, base, m, w, y)
            if k == 0:
                mass += p.crank_inertia
            w.reduced[k, m] = mass
    if p.crank_is_free:
        if not _solve_cholesky(w.reduced, w.rhs, n + 1):
            return False
        for k in range(n + 1):
            w.acceleration[k] = w.rhs[k]
        return True
    for k in range(n):
        w.rhs[k] = w.rhs[k + 1]
        for m in range(k + 1):
            w.reduced[k, m] = w.reduced[k + 1, m + 1]
    if not _solve_cholesky(w.reduced, w.rhs, n):
        return False
    w.acceleration[0] = 0.0
    for k in range(n):
        w.acceleration[k + 1] = w.rhs[k]
    return True


@inlined
def _slider_rate(n: int, base: int, k: int, w: MovingWorkspace, y: NDArray[np.float64]) -> float:
    """Partial rate of the slider's angle q2 + psi(s; s) for speed k (equation 11.6); `base` begins the row's extra blocks."""
    rate = w.c[k]
    for i in range(n):
        rate += w.row[base + 3 * n + i] * y[1 + i] * w.sigma[k]
    if k > 0:
        rate += w.row[(len(w.psi) // 2 - 1) * n + k - 1]
    return rate


@inlined
def _slider_remainder(n: int, base: int, w: MovingWorkspace, y: NDArray[np.float64]) -> float:
    """Remainder of the slider's angular acceleration (equation 11.7)."""
    s_rate = w.facts[2]
    remainder = w.facts[3]
    for i in range(n):
        remainder += 2.0 * w.row[base + 3 * n + i] * s_rate * y[n + 3 + i]
        remainder += (w.row[base + 4 * n + i] * s_rate**2 + w.row[base + 3 * n + i] * w.facts[4]) * y[1 + i]
    return remainder


@inlined
def _moving_dissipation(p: MovingParameters, t: SpanTables, w: MovingWorkspace, y: NDArray[np.float64]) -> float:
    """Power taken by all dampings, W (equation 11.5)."""
    G, s = t.G, y[p.n + 1]
    total = 0.0
    for span in range(2):
        h = s if span == 0 else p.L - s
        for q in range(G):
            j = span * (G + 1) + q
            total += h * t.weights[q] * (w.relative[j, 0] ** 2 + w.relative[j, 1] ** 2)
    return p.crank_damping * y[p.n + 2] ** 2 + p.base_damping * w.facts[1] ** 2 + p.beam_damping * total


@inlined
def slider_force(p: MovingParameters, t: SpanTables, w: MovingWorkspace, y: NDArray[np.float64]) -> tuple[float, float, float, float]:
    """Normal and tangential force (N) and moment (N m) of the slider on the follower, and the drive's torque (equations 11.9 to 11.12).

    From the moment about P of everything that turns there; the beam damping acts between beam and base and drops out.
    """
    n, G = p.n, t.G
    N = 2 * G + 2
    s = y[n + 1]
    q2 = w.facts[0]
    g1 = g2 = 0.0
    if p.has_gravity:
        g1 = math.cos(q2) * p.gravity_1 + math.sin(q2) * p.gravity_2
        g2 = -math.sin(q2) * p.gravity_1 + math.cos(q2) * p.gravity_2
    q2_acceleration = w.facts[3]
    for k in range(n + 1):
        q2_acceleration += w.c[k] * w.acceleration[k]
    moment = p.base_inertia * q2_acceleration + p.base_damping * w.facts[1]
    for j in range(N):
        a1, a2 = w.A0[j, 0] - g1, w.A0[j, 1] - g2
        for k in range(n + 1):
            a1 += w.V[k, j, 0] * w.acceleration[k]
            a2 += w.V[k, j, 1] * w.acceleration[k]
        w.integrand[j, 0], w.integrand[j, 1] = a1, a2
        if j != G and j != N - 1:
            h = s if j < G else p.L - s
            dm = p.rhoA * h * t.weights[j if j < G else j - G - 1]
            moment += dm * (w.z[j, 0] * a2 - w.z[j, 1] * a1)
    end = N - 1
    turn = w.turn_0[end]
    for k in range(n + 1):
        turn += w.beta[k, end] * w.acceleration[k]
    ec, es = p.tip_offset * w.e[end, 0], p.tip_offset * w.e[end, 1]
    a1 = w.integrand[end, 0] - es * turn - ec * w.turn[end] ** 2
    a2 = w.integrand[end, 1] + ec * turn - es * w.turn[end] ** 2
    moment += p.tip_mass * ((w.z[end, 0] + ec) * a2 - (w.z[end, 1] + es) * a1) + p.tip_inertia * turn
    slider_moment = tangential = 0.0
    if p.slider_inertia > 0.0:
        base = KINDS * N * n
        rate = _slider_remainder(n, base, w, y)
        for k in range(n + 1):
            rate += _slider_rate(n, base, k, w, y) * w.acceleration[k]
        slider_moment = -p.slider_inertia * rate
        tangential = -slider_moment * w.facts[5]
    t1, t2 = w.e[G, 0], w.e[G, 1]
    x, W = w.z[G, 0], w.z[G, 1]
    normal = (moment - slider_moment - tangential * (x * t2 - W * t1)) / (x * t1 + W * t2)
    if p.crank_is_free:
        return normal, tangential, slider_moment, p.torque
    along, across = w.facts[6], w.facts[7]
    F1, F2 = -normal * t2 + tangential * t1, normal * t1 + tangential * t2
    # the crank tip moves along LA (-across, along); it carries the opposite force; the slider's moment turns with the follower
    torque = p.LA * (-across * F1 + along * F2) - p.crank_moment * (g2 * along - g1 * across)
    return normal, tangential, slider_moment, torque


@compiled
def moving_right_hand_side(p: MovingParameters, w: MovingWorkspace, y: NDArray[np.float64], rate: NDArray[np.float64]) -> bool:
    """dy/dt, written to `rate`; False and all nan where the state cannot be (a rejected step)."""
    n = p.n
    if not moving_motion(p, p.tables, w, y):
        rate[:] = math.nan
        return False
    for i in range(n):
        rate[1 + i] = y[n + 3 + i]
        rate[n + 3 + i] = w.acceleration[1 + i]
    rate[0] = y[n + 2]
    rate[n + 2] = w.acceleration[0]
    G = p.tables.G
    distance = math.hypot(p.LA * math.cos(y[0]) - p.d, p.LA * math.sin(y[0]))
    rate[n + 1] = w.facts[2] - FEEDBACK * (math.hypot(w.z[G, 0], w.z[G, 1]) - distance)
    rate[2 * n + 3] = _moving_dissipation(p, p.tables, w, y)
    rate[2 * n + 4] = p.torque * y[n + 2] if p.crank_is_free else slider_force(p, p.tables, w, y)[3] * y[n + 2]
    return True
