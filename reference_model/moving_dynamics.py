"""Equations of motion with shapes that follow the slider, compiled (DERIVATION.md, sections 10 and 11).

State vector, length 2 n + 5: q1, eta (n), s, q1dot, etadot (n), dissipated energy, work of the drive. The slider's arc length is
carried along as a state of its own, which spares an iteration in every evaluation; a weak feedback keeps it on the loop.

All fields over the points lie in rows, complex ones as their N real parts followed by their N imaginary parts, so that loops run along
memory and the compiler makes vectors of them. Everything is linear in three kinds of integrals along the beam, the place
z = int e, the turning by the slider's motion Y = int psi_s i e and by each shape U_i = int psi_i i e, with e = exp(i psi).
"""

import math

import numpy as np
from numpy.typing import NDArray

from reference_model.compilation import borrowing, inlined, merged, merged_and_callable
from reference_model.moving_parameters import (
    ACROSS,
    ALONG,
    BASE_TURN,
    COS_Q2,
    CRANK_TURN,
    CURVATURE,
    EXCESS,
    KINDS,
    Q2_RATE,
    Q2_REMAINDER,
    S_RATE,
    S_REMAINDER,
    SIN_Q2,
    SLIDER_SLOPE,
    SLIDER_TURN,
    TIP_1,
    TIP_2,
    TIP_TURN,
    MovingParameters,
    MovingWorkspace,
    SpanTables,
)

Array = NDArray[np.float64]
Four = tuple[float, float, float, float]

#: Rate (1/s) at which a violation of the loop's length decays.
FEEDBACK = 100.0
#: Largest angle (rad) between a tangent and the base at which a state is accepted.
LARGEST_ANGLE = 2.0 * math.pi


@inlined
def _interpolate_row(t: SpanTables, s: float, row: Array) -> None:
    """The table's row at s, cubic in s."""
    k = min(max(int((s - t.low) / t.step), 0), t.coefficients.shape[0] - 1)
    ds = s - t.low - k * t.step
    for m in range(len(row)):
        row[m] = ((t.coefficients[k, 0, m] * ds + t.coefficients[k, 1, m]) * ds + t.coefficients[k, 2, m]) * ds + t.coefficients[k, 3, m]


@inlined
def directions(psi: Array, e: Array) -> bool:
    """exp(i psi): Taylor's series of an eighth of the angle, doubled three times; good to 1e-15 and, unlike the library's, vectorised."""
    N = len(psi)
    largest = 0.0
    for j in range(N):
        largest = max(largest, abs(psi[j]))
    if not largest <= LARGEST_ANGLE:
        return False
    for j in range(N):
        x = 0.125 * psi[j]
        q = x * x
        odd = q * (-1 / 5040 + q * (1 / 362880 + q * (-1 / 39916800 + q * (1 / 6227020800 - q / 1307674368000))))
        even = q * (1 / 40320 + q * (-1 / 3628800 + q * (1 / 479001600 + q * (-1 / 87178291200 + q / 20922789888000))))
        sine = x * (1.0 + q * (-1 / 6 + q * (1 / 120 + odd)))
        cosine = 1.0 + q * (-1 / 2 + q * (1 / 24 + q * (-1 / 720 + even)))
        for _ in range(3):
            sine, cosine = 2.0 * sine * cosine, 1.0 - 2.0 * sine * sine
        e[j], e[N + j] = cosine, sine
    return True


@borrowing
def _four(table: Array, j: int, p: int) -> Four:
    return table[j, p], table[j, p + 1], table[j, p + 2], table[j, p + 3]


@borrowing
def _plus(sums: Four, x: float, row: Four) -> Four:
    return sums[0] + x * row[0], sums[1] + x * row[1], sums[2] + x * row[2], sums[3] + x * row[3]


@borrowing
def _put(out: Array, p: int, h: float, sums: Four) -> None:
    out[p], out[p + 1], out[p + 2], out[p + 3] = h * sums[0], h * sums[1], h * sums[2], h * sums[3]


@borrowing
def cumulate(to_points: Array, s: float, h: float, f: Array, out: Array) -> None:
    """Integrals from 0 to every point of a complex function f given at the points; spans of length s and h.

    Four points at a time, so that the sums stay in registers.
    """
    G, S = to_points.shape
    for p in range(0, S, 4):
        a = b = c = d = (0.0, 0.0, 0.0, 0.0)
        for j in range(G):
            weights = _four(to_points, j, p)
            a, b = _plus(a, f[j], weights), _plus(b, f[S + j], weights)
            c, d = _plus(c, f[2 * S + j], weights), _plus(d, f[3 * S + j], weights)
        _put(out, p, s, a)
        _put(out, S + p, h, b)
        _put(out, 2 * S + p, s, c)
        _put(out, 3 * S + p, h, d)
    at_slider_1, at_slider_2 = out[G], out[2 * S + G]
    for p in range(S, 2 * S):
        out[p] += at_slider_1
    for p in range(3 * S, 4 * S):
        out[p] += at_slider_2


@inlined
def _turned(rate: Array, first: int, e: Array, f: Array) -> None:
    """To `f`: i rate e, for N real rates from rate[first] on."""
    N = len(e) // 2
    for j in range(N):
        f[j] = -rate[first + j] * e[N + j]
    for j in range(N):
        f[N + j] = rate[first + j] * e[j]


@inlined
def _combine(row: Array, first: int, n: int, y: Array, at: int, out: Array) -> None:
    """To `out`: sum_i y[at + i] (block i of the row from `first` on)."""
    N = len(out)
    for j in range(N):
        out[j] = y[at] * row[first + j]
    for i in range(1, n):
        for j in range(N):
            out[j] += y[at + i] * row[first + i * N + j]


@inlined
def _two_by_two(a1: float, a2: float, b1: float, b2: float, r1: float, r2: float) -> tuple[float, float]:
    """Real c, sigma with a c + b sigma = r for complex a, b, r."""
    scale = 1.0 / (a1 * b2 - a2 * b1)
    return scale * (r1 * b2 - r2 * b1), scale * (a1 * r2 - a2 * r1)


@inlined
def _place(p: MovingParameters, t: SpanTables, w: MovingWorkspace, y: Array) -> bool:
    """Angles, places and the integrals U_i (in V) and Y of the state `y` (equations 10.1 to 10.5)."""
    n, N, s = p.n, 2 * t.S, y[p.n + 1]
    h = p.L - s
    _interpolate_row(t, s, w.row)
    _combine(w.row, 0, n, y, 1, w.psi)
    _combine(w.row, n * N, n, y, 1, w.psi_s)
    if not directions(w.psi, w.e):
        return False
    cumulate(t.to_points, s, h, w.e, w.z)
    _turned(w.psi_s, 0, w.e, w.integrand)
    cumulate(t.to_points, s, h, w.integrand, w.Y)
    for i in range(n):
        _turned(w.row, i * N, w.e, w.integrand)
        cumulate(t.to_points, s, h, w.integrand, w.V[1 + i])
    return True


@inlined
def _close_loop(p: MovingParameters, t: SpanTables, w: MovingWorkspace, y: Array) -> bool:
    """Partial rates c of q2 and sigma of s, the rates themselves and their remainders (equations 10.6 to 10.8).

    The remaining acceleration less what q2 and s add to it goes to `w.A`.
    """
    n, G, N, s = p.n, t.G, 2 * t.S, y[p.n + 1]
    f, q1_rate = w.facts, y[n + 2]
    Z1, Z2 = w.z[G], w.z[N + G]
    v1, v2 = p.LA * math.cos(y[0]) - p.d, p.LA * math.sin(y[0])
    # exp(i q2) has the direction of v / Z
    distance, reach = math.sqrt(v1 * v1 + v2 * v2), math.sqrt(Z1 * Z1 + Z2 * Z2)
    scale = 1.0 / (distance * reach)
    f[EXCESS] = reach - distance
    f[COS_Q2], f[SIN_Q2] = scale * (v1 * Z1 + v2 * Z2), scale * (v2 * Z1 - v1 * Z2)
    along = ((v1 + p.d) * f[COS_Q2] + v2 * f[SIN_Q2]) / p.LA
    across = (v2 * f[COS_Q2] - (v1 + p.d) * f[SIN_Q2]) / p.LA
    f[ALONG], f[ACROSS] = along, across
    # matrix of the loop: columns i Z and exp(i psi(s)) + Y(s)
    b1, b2 = w.e[G] + w.Y[G], w.e[N + G] + w.Y[N + G]
    if not abs(-Z2 * b2 - Z1 * b1) > 1e-6 * p.L:
        return False
    w.c[0], w.sigma[0] = _two_by_two(-Z2, Z1, b1, b2, -p.LA * across, p.LA * along)
    q2_rate, s_rate = w.c[0] * q1_rate, w.sigma[0] * q1_rate
    for i in range(n):
        w.c[1 + i], w.sigma[1 + i] = _two_by_two(-Z2, Z1, b1, b2, -w.V[1 + i, G], -w.V[1 + i, N + G])
        q2_rate += w.c[1 + i] * y[n + 3 + i]
        s_rate += w.sigma[1 + i] * y[n + 3 + i]
    curvature = 0.0
    for i in range(n):
        curvature += w.row[KINDS * n * N + 2 * n + i] * y[1 + i]
    # remainders (equation 10.8): gamma i e - turn^2 e integrates to what the shapes' motion alone does to the acceleration
    _combine(w.row, 0, n, y, n + 3, w.turn)
    for j in range(N):
        w.turn[j] += q2_rate + w.psi_s[j] * s_rate
    for j in range(N):
        w.gamma[j] = 0.0
    for i in range(n):
        swing, bend = 2.0 * s_rate * y[n + 3 + i], s_rate * s_rate * y[1 + i]
        for j in range(N):
            w.gamma[j] += swing * w.row[(n + i) * N + j] + bend * w.row[(2 * n + i) * N + j]
    for j in range(N):
        w.integrand[j] = -w.gamma[j] * w.e[N + j] - w.turn[j] * w.turn[j] * w.e[j]
    for j in range(N):
        w.integrand[N + j] = w.gamma[j] * w.e[j] - w.turn[j] * w.turn[j] * w.e[N + j]
    cumulate(t.to_points, s, p.L - s, w.integrand, w.A)
    swing = s_rate * (2.0 * w.turn[G] + curvature * s_rate)
    r1 = -p.LA * q1_rate**2 * along + swing * w.e[N + G] - w.A[G]
    r2 = -p.LA * q1_rate**2 * across - swing * w.e[G] - w.A[N + G]
    f[Q2_REMAINDER], f[S_REMAINDER] = _two_by_two(-Z2, Z1, b1, b2, r1, r2)
    f[Q2_RATE], f[S_RATE], f[CURVATURE] = q2_rate, s_rate, curvature
    return True


@inlined
def _relative_velocities(p: MovingParameters, t: SpanTables, w: MovingWorkspace, y: Array) -> None:
    """Velocities of the points relative to the base frame, which the beam damping opposes; V still holds the U_i."""
    n = p.n
    size = len(w.relative)
    for j in range(size):
        w.relative[j] = w.facts[S_RATE] * w.Y[j]
    for i in range(1, n + 1):
        for j in range(size):
            w.relative[j] += y[n + 2 + i] * w.V[i, j]


@inlined
def _partial_velocities(p: MovingParameters, t: SpanTables, w: MovingWorkspace, y: Array) -> None:
    """Rows of V: partial velocities of the beam's points and of all bodies for every free speed (equations 10.9, 10.10 and 11.6)."""
    n, G, N = p.n, t.G, 2 * t.S
    end = N - t.S + G
    ec, es = p.tip_offset * w.e[end], p.tip_offset * w.e[N + end]
    bodies = 2 * N
    slope_by_s = 0.0
    for i in range(n):
        slope_by_s += w.row[KINDS * n * N + 3 * n + i] * y[1 + i]
    w.facts[SLIDER_SLOPE] = slope_by_s
    for j in range(2 * N):
        w.V[0, j] = 0.0
    for k in range(n + 1):
        c, sigma = w.c[k], w.sigma[k]
        for j in range(N):
            w.V[k, j] += sigma * w.Y[j] - c * w.z[N + j]
        for j in range(N):
            w.V[k, N + j] += sigma * w.Y[N + j] + c * w.z[j]
        tip, slider = c + sigma * w.psi_s[end], c + sigma * slope_by_s
        if k > 0:
            tip += w.row[(k - 1) * N + end]
            slider += w.row[(k - 1) * N + G]
        w.V[k, bodies + TIP_1] = w.V[k, end] - es * tip
        w.V[k, bodies + TIP_2] = w.V[k, N + end] + ec * tip
        w.V[k, bodies + TIP_TURN] = tip
        w.V[k, bodies + BASE_TURN] = c
        w.V[k, bodies + SLIDER_TURN] = slider
        w.V[k, bodies + CRANK_TURN] = 1.0 if k == 0 else 0.0


@inlined
def _remaining_accelerations(p: MovingParameters, t: SpanTables, w: MovingWorkspace, y: Array) -> None:
    """Row A: accelerations of points and bodies without those of the free speeds, less gravity (equations 10.8 and 11.7)."""
    n, G, N = p.n, t.G, 2 * t.S
    f = w.facts
    g1 = f[COS_Q2] * p.gravity_1 + f[SIN_Q2] * p.gravity_2
    g2 = -f[SIN_Q2] * p.gravity_1 + f[COS_Q2] * p.gravity_2
    q2_0, s_0 = f[Q2_REMAINDER], f[S_REMAINDER]
    for j in range(N):
        w.A[j] += s_0 * w.Y[j] - q2_0 * w.z[N + j] - g1
    for j in range(N):
        w.A[N + j] += s_0 * w.Y[N + j] + q2_0 * w.z[j] - g2
    end = N - t.S + G
    ec, es = p.tip_offset * w.e[end], p.tip_offset * w.e[N + end]
    turn_0, square = q2_0 + w.gamma[end] + w.psi_s[end] * s_0, w.turn[end] ** 2
    bodies = 2 * N
    w.A[bodies + TIP_1] = w.A[end] - es * turn_0 - ec * square
    w.A[bodies + TIP_2] = w.A[N + end] + ec * turn_0 - es * square
    w.A[bodies + TIP_TURN] = turn_0
    w.A[bodies + BASE_TURN] = q2_0
    slider = q2_0 + f[SLIDER_SLOPE] * s_0
    for i in range(n):
        slider += 2.0 * w.row[KINDS * n * N + 3 * n + i] * f[S_RATE] * y[n + 3 + i]
        slider += w.row[KINDS * n * N + 4 * n + i] * f[S_RATE] ** 2 * y[1 + i]
    w.A[bodies + SLIDER_TURN] = slider
    w.A[bodies + CRANK_TURN] = 0.0


@inlined
def _weigh(p: MovingParameters, t: SpanTables, w: MovingWorkspace, s: float) -> None:
    """Row `dx` of the points' share of the length (m), and row `mass` of what each entry of V and A weighs (kg, kg m^2)."""
    S, N = t.S, 2 * t.S
    for j in range(S):
        w.dx[j] = w.dx[N + j] = s * t.weights[j]
    for j in range(S):
        w.dx[S + j] = w.dx[N + S + j] = (p.L - s) * t.weights[j]
    for j in range(2 * N):
        w.mass[j] = p.rhoA * w.dx[j]
    bodies = 2 * N
    w.mass[bodies + TIP_1] = w.mass[bodies + TIP_2] = p.tip_mass
    w.mass[bodies + TIP_TURN], w.mass[bodies + BASE_TURN] = p.tip_inertia, p.base_inertia
    w.mass[bodies + SLIDER_TURN], w.mass[bodies + CRANK_TURN] = p.slider_inertia, p.crank_inertia


@inlined
def _dot(a: Array, b: Array, size: int) -> float:
    total = 0.0
    for j in range(size):
        total += a[j] * b[j]
    return total


@merged
def moving_motion(p: MovingParameters, t: SpanTables, w: MovingWorkspace, y: Array) -> bool:
    """Close the loop, find partial velocities and remaining accelerations, and solve for the accelerations.

    Equations 10.1 to 11.8; leaves everything in `w`. False where the state cannot be: outside the tables, bent too far, or a singular
    loop.
    """
    n, s = p.n, y[p.n + 1]
    if not (t.low <= s <= t.high and abs(y[0]) < 1e9):
        return False
    w.slider[0] = s
    if not (_place(p, t, w, y) and _close_loop(p, t, w, y)):
        return False
    _relative_velocities(p, t, w, y)
    _partial_velocities(p, t, w, y)
    _remaining_accelerations(p, t, w, y)
    _weigh(p, t, w, s)
    _assemble(p, t, w, y)
    w.slider[1] = _highest_frequency(p, t, w)
    if p.crank_is_free:
        return _solve_positive(w.reduced, w.acceleration, 0, n + 1)
    w.acceleration[0] = 0.0
    return _solve_positive(w.reduced, w.acceleration, 1, n + 1)


@inlined
def _assemble(p: MovingParameters, t: SpanTables, w: MovingWorkspace, y: Array) -> None:
    """Mass matrix (lower triangle) and forces for the free speeds, these in `w.acceleration` (equations 11.1 to 11.5)."""
    n, N, f = p.n, 2 * t.S, w.facts
    lanes = len(w.mass)
    for j in range(lanes):
        w.force[j] = w.mass[j] * w.A[j]
    moment = 0.0
    if p.beam_damping > 0.0:
        for j in range(2 * N):
            w.force[j] += p.beam_damping * w.dx[j] * w.relative[j]
        for j in range(N):
            moment += w.dx[j] * (w.z[j] * w.relative[N + j] - w.z[N + j] * w.relative[j])
    moment = p.beam_damping * moment - p.base_damping * f[Q2_RATE]
    extra = KINDS * n * N
    hardening = 0.0
    for i in range(n):
        hardening += 0.5 * w.row[extra + n + i] * y[1 + i] ** 2
    for k in range(n + 1):
        w.acceleration[k] = moment * w.c[k] - hardening * w.sigma[k] - _dot(w.V[k], w.force, lanes)
        if k > 0:
            w.acceleration[k] -= w.row[extra + k - 1] * y[k]
        for j in range(lanes):
            w.weighted[j] = w.mass[j] * w.V[k, j]
        for m in range(k + 1):
            w.reduced[k, m] = _dot(w.weighted, w.V[m], lanes)
    if p.crank_is_free:
        weight = f[ALONG] * (-f[SIN_Q2] * p.gravity_1 + f[COS_Q2] * p.gravity_2)
        weight -= f[ACROSS] * (f[COS_Q2] * p.gravity_1 + f[SIN_Q2] * p.gravity_2)
        w.acceleration[0] += p.torque - p.crank_damping * y[n + 2] + p.crank_moment * weight


@inlined
def _highest_frequency(p: MovingParameters, t: SpanTables, w: MovingWorkspace) -> float:
    """Bound of the highest angular frequency (rad/s) of small vibrations about the present state (equation 11.13)."""
    n = p.n
    square = w.row[KINDS * n * 2 * t.S + n - 1]
    if not p.crank_is_free:
        return math.sqrt(square)
    coupling = 0.0
    for k in range(1, n + 1):
        coupling += w.reduced[k, 0] ** 2 / (w.reduced[k, k] * w.reduced[0, 0])
    return math.sqrt(square / max(1.0 - coupling, 1e-6))


@inlined
def _solve_positive(A: Array, b: Array, first: int, size: int) -> bool:
    """Solve A x = b in place for rows and columns from `first` on; False if A (lower triangle given) is not positive definite.

    A = L D L^T without roots; the reciprocals of D replace the diagonal, L D the rest.
    """
    for i in range(first, size):
        for j in range(first, i):
            total = A[i, j]
            for m in range(first, j):
                total -= A[i, m] * A[j, m] * A[m, m]
            A[i, j] = total
        pivot = A[i, i]
        for m in range(first, i):
            pivot -= A[i, m] * A[i, m] * A[m, m]
        if not pivot > 0.0:
            return False
        A[i, i] = 1.0 / pivot
    for i in range(first, size):
        for m in range(first, i):
            b[i] -= A[i, m] * b[m]
        b[i] *= A[i, i]
    for i in range(size - 1, first - 1, -1):
        total = 0.0
        for m in range(i + 1, size):
            total += A[m, i] * b[m]
        b[i] -= total * A[i, i]
    return True


@inlined
def _moving_dissipation(p: MovingParameters, w: MovingWorkspace, y: Array) -> float:
    """Power taken by all dampings, W (equation 11.5)."""
    total = 0.0
    for j in range(len(w.dx)):
        total += w.dx[j] * w.relative[j] * w.relative[j]
    return p.crank_damping * y[p.n + 2] ** 2 + p.base_damping * w.facts[Q2_RATE] ** 2 + p.beam_damping * total


@merged
def slider_force(p: MovingParameters, t: SpanTables, w: MovingWorkspace, y: Array) -> tuple[float, float, float, float]:
    """Normal and tangential force (N) and moment (N m) of the slider on the follower, and the drive's torque (equations 11.9 to 11.12).

    From the moment about P of everything that turns there; the beam damping acts between beam and base and drops out. Leaves the
    accelerations of points and bodies, less gravity, in `w.A`.
    """
    n, G, N = p.n, t.G, 2 * t.S
    f = w.facts
    bodies, end = 2 * N, N - t.S + G
    for k in range(n + 1):
        for j in range(len(w.A)):
            w.A[j] += w.acceleration[k] * w.V[k, j]
    moment = p.base_inertia * w.A[bodies + BASE_TURN] + p.base_damping * f[Q2_RATE] + p.tip_inertia * w.A[bodies + TIP_TURN]
    for j in range(N):
        moment += w.mass[j] * (w.z[j] * w.A[N + j] - w.z[N + j] * w.A[j])
    arm_1, arm_2 = w.z[end] + p.tip_offset * w.e[end], w.z[N + end] + p.tip_offset * w.e[N + end]
    moment += p.tip_mass * (arm_1 * w.A[bodies + TIP_2] - arm_2 * w.A[bodies + TIP_1])
    slider_moment = -p.slider_inertia * w.A[bodies + SLIDER_TURN]
    tangential = -slider_moment * f[CURVATURE]
    t1, t2 = w.e[G], w.e[N + G]
    x, W = w.z[G], w.z[N + G]
    normal = (moment - slider_moment - tangential * (x * t2 - W * t1)) / (x * t1 + W * t2)
    if p.crank_is_free:
        return normal, tangential, slider_moment, p.torque
    along, across = f[ALONG], f[ACROSS]
    F1, F2 = -normal * t2 + tangential * t1, normal * t1 + tangential * t2
    weight = along * (-f[SIN_Q2] * p.gravity_1 + f[COS_Q2] * p.gravity_2)
    weight -= across * (f[COS_Q2] * p.gravity_1 + f[SIN_Q2] * p.gravity_2)
    # the crank tip moves along LA (-across, along); it carries the opposite force; the slider's moment turns with the follower
    return normal, tangential, slider_moment, p.LA * (-across * F1 + along * F2) - p.crank_moment * weight


@merged_and_callable
def moving_right_hand_side(p: MovingParameters, w: MovingWorkspace, y: Array, rate: Array) -> bool:
    """dy/dt, written to `rate`; False and all nan where the state cannot be (a rejected step)."""
    n, t = p.n, p.tables
    if not moving_motion(p, t, w, y):
        rate[:] = math.nan
        return False
    for i in range(n):
        rate[1 + i] = y[n + 3 + i]
        rate[n + 3 + i] = w.acceleration[1 + i]
    rate[0] = y[n + 2]
    rate[n + 2] = w.acceleration[0]
    rate[n + 1] = w.facts[S_RATE] - FEEDBACK * w.facts[EXCESS]
    rate[2 * n + 3] = _moving_dissipation(p, w, y)
    rate[2 * n + 4] = p.torque * y[n + 2] if p.crank_is_free else slider_force(p, t, w, y)[3] * y[n + 2]
    return True
