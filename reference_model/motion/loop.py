"""The slider: where the crank tip meets the follower, and how gap, slider and follower angle move (DERIVATION.md, section 3)."""

import math

import numpy as np
from numpy.typing import NDArray

from quickreturn.reference_model.compilation import inlined, stage
from quickreturn.reference_model.motion.fields import combine, cumulate
from quickreturn.reference_model.motion.lanes import load, plus, spread, store
from quickreturn.reference_model.motion.layout import Parameters, Tables, Workspace
from quickreturn.reference_model.treatment import CHORDS, ELIMINATED, LEVER

Array = NDArray[np.float64]


@inlined
def _on_line(p: Parameters, t: Tables, w: Workspace, y: Array, at: int) -> None:
    """Foot, tangent and their changes where the slider rides on the centre line."""
    n, N, f = p.n, t.points, w.facts
    f.foot_1, f.foot_2, f.tangent_1, f.tangent_2 = w.z[at], w.z[N + at], w.e[at], w.e[N + at]
    curvature = slope_by_s = 0.0
    for i in range(n):
        w.foot[0, 1 + i], w.foot[1, 1 + i], w.foot[2, 1 + i] = w.U[i, at], w.U[i, N + at], w.shape[i, at]
        curvature += w.curvature_at_slider[i] * y[1 + i]
        slope_by_s += w.angle_at_slider_s[i] * y[1 + i]
    f.curvature, f.angle_by_s = curvature, slope_by_s


@inlined
def nodes_of_slider(t: Tables, at: int) -> tuple[int, int]:
    """Places among the points of the two nodes of the slider's element; -1 for the pivot."""
    return at - t.cell_size, at + t.cell_size


@inlined
def _on_chord(p: Parameters, t: Tables, w: Workspace, at: int) -> None:
    """The same where it rides on the chord between the two nodes of its element (equation 3.9)."""
    N, f = t.points, w.facts
    left, right = nodes_of_slider(t, at)
    share = w.length[at // t.cell_size] / (w.length[at // t.cell_size] + w.length[at // t.cell_size + 1])
    x1 = x2 = 0.0
    if left >= 0:
        x1, x2 = w.z[left], w.z[N + left]
    chord_1, chord_2 = w.z[right] - x1, w.z[N + right] - x2
    chord = math.sqrt(chord_1 * chord_1 + chord_2 * chord_2)
    f.tangent_1, f.tangent_2 = chord_1 / chord, chord_2 / chord
    f.foot_1, f.foot_2 = x1 + share * chord_1, x2 + share * chord_2
    f.curvature = f.angle_by_s = 0.0
    for i in range(1, p.n + 1):
        a1 = a2 = 0.0
        if left >= 0:
            a1, a2 = w.U[i - 1, left], w.U[i - 1, N + left]
        b1, b2 = w.U[i - 1, right] - a1, w.U[i - 1, N + right] - a2
        w.foot[0, i], w.foot[1, i] = a1 + share * b1, a2 + share * b2
        w.foot[2, i] = (f.tangent_1 * b2 - f.tangent_2 * b1) / chord


@stage
def move_loop(p: Parameters, t: Tables, w: Workspace, y: Array, at: int) -> bool:
    """Gap and partial rates sigma of s, of the gap and c of q2; then the rates themselves (equations 3.1 to 3.6)."""
    n, m, f = p.n, p.speeds, w.facts
    N = t.points
    if p.treatment == CHORDS:
        _on_chord(p, t, w, at)
    else:
        _on_line(p, t, w, y, at)
    t1, t2, Z1, Z2 = f.tangent_1, f.tangent_2, f.foot_1, f.foot_2
    v1, v2 = p.LA * math.cos(y[0]) - p.d, p.LA * math.sin(y[0])
    if p.treatment == ELIMINATED:
        # exp(i q2) has the direction of v / Z
        distance, reach = math.sqrt(v1 * v1 + v2 * v2), math.sqrt(Z1 * Z1 + Z2 * Z2)
        scale = 1.0 / (distance * reach)
        f.cos_q2, f.sin_q2 = scale * (v1 * Z1 + v2 * Z2), scale * (v2 * Z1 - v1 * Z2)
        f.gap, f.missed = 0.0, distance - reach
        f.excess = abs(f.missed)
    else:
        f.cos_q2, f.sin_q2 = math.cos(y[n + 1]), math.sin(y[n + 1])
        C1, C2 = f.cos_q2 * v1 + f.sin_q2 * v2 - Z1, f.cos_q2 * v2 - f.sin_q2 * v1 - Z2
        f.gap, f.missed = t1 * C2 - t2 * C1, t1 * C1 + t2 * C2
        f.excess = abs(f.gap)
    f.along = ((v1 + p.d) * f.cos_q2 + v2 * f.sin_q2) / p.LA
    f.across = (v2 * f.cos_q2 - (v1 + p.d) * f.sin_q2) / p.LA
    gap = f.gap
    # along and across the tangent: b, the change of the foot with s, and the right side of every speed
    b1, b2 = 1.0, 0.0
    if p.treatment == CHORDS:
        b1 = _chord_per_length(t, w, at)
    elif t.moves:
        b1, b2 = 1.0 + t1 * w.Y[at] + t2 * w.Y[N + at], t1 * w.Y[N + at] - t2 * w.Y[at]
    b1 -= gap * f.angle_by_s
    along_q2, across_q2 = t1 * Z2 - t2 * Z1 + gap, -t1 * Z1 - t2 * Z2
    f.foot_by_s_1, f.foot_by_s_2, f.along_by_q2, f.across_by_q2 = b1, b2, along_q2, across_q2
    w.foot[0, 0], w.foot[1, 0] = p.LA * (f.along * t2 - f.across * t1), p.LA * (f.along * t1 + f.across * t2)
    for k in range(1, n + 1):
        u1, u2 = w.foot[0, k], w.foot[1, k]
        w.foot[0, k], w.foot[1, k] = gap * w.foot[2, k] - t1 * u1 - t2 * u2, t2 * u1 - t1 * u2
    if p.treatment == ELIMINATED:
        # q2 and s are what leaves no gap
        determinant = along_q2 * b2 - across_q2 * b1
        if not abs(determinant) > 1e-6 * p.L:
            return False
        for k in range(m):
            w.sigma[k] = (along_q2 * w.foot[1, k] - across_q2 * w.foot[0, k]) / determinant
            w.c[k] = (b1 * w.foot[1, k] - b2 * w.foot[0, k]) / determinant
            w.row_of_gap[k] = 0.0
    else:
        if not b1 > 1e-3:
            return False
        w.foot[0, n + 1], w.foot[1, n + 1] = along_q2, across_q2
        for k in range(m):
            w.sigma[k] = w.foot[0, k] / b1
            w.row_of_gap[k] = w.foot[1, k] - b2 * w.sigma[k]
            w.c[k] = 0.0
        w.c[n + 1] = 1.0
    f.q2_rate = f.s_rate = f.gap_rate = 0.0
    for k in range(m):
        f.q2_rate += w.c[k] * y[m + 1 + k]
        f.s_rate += w.sigma[k] * y[m + 1 + k]
        f.gap_rate += w.row_of_gap[k] * y[m + 1 + k]
    return True


@inlined
def _chord_per_length(t: Tables, w: Workspace, at: int) -> float:
    """Length of the slider's chord over that of its element."""
    N = t.points
    left, right = nodes_of_slider(t, at)
    x1 = x2 = 0.0
    if left >= 0:
        x1, x2 = w.z[left], w.z[N + left]
    chord = math.sqrt((w.z[right] - x1) ** 2 + (w.z[N + right] - x2) ** 2)
    return chord / (w.length[at // t.cell_size] + w.length[at // t.cell_size + 1])


@inlined
def bias_of_loop(p: Parameters, t: Tables, w: Workspace, y: Array, at: int) -> None:
    """Bias of the second derivatives of q2, s and gap: what they are when no speed changes (equations 3.7 and 3.8)."""
    n, m, N, f = p.n, p.speeds, t.points, w.facts
    q1_rate, s_rate = y[m + 1], f.s_rate
    bias_of_places(p, t, w, y)
    if p.treatment == CHORDS:
        turn, turn_0, a1, a2 = _bias_of_chord(p, t, w, y, at)
    else:
        turn = w.turn[at] + f.curvature * s_rate
        bend = s_rate * (2.0 * w.turn[at] + f.curvature * s_rate)
        a1, a2 = w.A[at] - bend * f.tangent_2, w.A[N + at] + bend * f.tangent_1
        turn_0 = 0.0
        for i in range(n):
            turn_0 += 2.0 * w.angle_at_slider_s[i] * s_rate * y[m + 2 + i] + w.angle_at_slider_ss[i] * s_rate**2 * y[1 + i]
    a1 += p.LA * q1_rate**2 * f.along
    a2 += p.LA * q1_rate**2 * f.across
    t1, t2, gap = f.tangent_1, f.tangent_2, f.gap
    along, across = 2.0 * f.gap_rate * turn + gap * turn_0 - t1 * a1 - t2 * a2, gap * turn**2 - t1 * a2 + t2 * a1
    b1, b2, along_q2, across_q2 = f.foot_by_s_1, f.foot_by_s_2, f.along_by_q2, f.across_by_q2
    if p.treatment == ELIMINATED:
        determinant = along_q2 * b2 - across_q2 * b1
        f.s_bias = (along_q2 * across - across_q2 * along) / determinant
        f.q2_bias, f.gap_bias = (b1 * across - b2 * along) / determinant, 0.0
    else:
        f.s_bias = along / b1
        f.q2_bias, f.gap_bias = 0.0, across - b2 * f.s_bias


@stage
def bias_of_places(p: Parameters, t: Tables, w: Workspace, y: Array) -> None:
    """To `turn`, `gamma` and `A`: angular rates, and what they and the moving shapes alone do to the accelerations (equation 2.6)."""
    n, N, m, f = p.n, t.points, p.speeds, w.facts
    s_rate, q2_rate = f.s_rate, f.q2_rate
    combine(w.shape, y, m + 2, w.turn)
    if t.moves:
        for j in range(N):
            w.turn[j] += q2_rate + w.psi_s[j] * s_rate
        for j in range(0, N, 4):
            swing = bend = spread(0.0)
            for i in range(n):
                swing = plus(swing, y[m + 2 + i], load(w.shape_s[i], j))
                bend = plus(bend, y[1 + i], load(w.shape_ss[i], j))
            store(w.gamma, j, plus(plus(spread(0.0), 2.0 * s_rate, swing), s_rate * s_rate, bend))
    else:
        for j in range(N):
            w.turn[j] += q2_rate
    for j in range(N):
        w.integrand[j] = -w.gamma[j] * w.e[N + j] - w.turn[j] * w.turn[j] * w.e[j]
    for j in range(N):
        w.integrand[N + j] = w.gamma[j] * w.e[j] - w.turn[j] * w.turn[j] * w.e[N + j]
    cumulate(t, w.length, w.integrand, w.A)


@inlined
def _bias_of_chord(p: Parameters, t: Tables, w: Workspace, y: Array, at: int) -> tuple[float, float, float, float]:
    """Rate and remaining acceleration of the chord's angle, and the remaining acceleration of the foot (equation 3.9)."""
    N, m, f = t.points, p.speeds, w.facts
    left, right = nodes_of_slider(t, at)
    length = w.length[at // t.cell_size] + w.length[at // t.cell_size + 1]
    share = w.length[at // t.cell_size] / length
    # differences from the left node to the right one: place, velocity, remaining acceleration; the pivot stands still
    x1, x2, a1, a2 = w.z[right], w.z[N + right], w.A[right], w.A[N + right]
    v1, v2, left_1, left_2 = 0.0, 0.0, 0.0, 0.0
    for i in range(1, p.n + 1):
        v1 += y[m + 1 + i] * w.U[i - 1, right]
        v2 += y[m + 1 + i] * w.U[i - 1, N + right]
    if left >= 0:
        x1, x2 = x1 - w.z[left], x2 - w.z[N + left]
        left_1, left_2 = w.A[left], w.A[N + left]
        a1, a2 = a1 - left_1, a2 - left_2
        for i in range(1, p.n + 1):
            v1 -= y[m + 1 + i] * w.U[i - 1, left]
            v2 -= y[m + 1 + i] * w.U[i - 1, N + left]
    v1, v2 = v1 - f.q2_rate * x2, v2 + f.q2_rate * x1
    chord = math.sqrt(x1 * x1 + x2 * x2)
    t1, t2 = f.tangent_1, f.tangent_2
    turn = (t1 * v2 - t2 * v1) / chord
    turn_0 = (t1 * a2 - t2 * a1 - 2.0 * turn * (t1 * v1 + t2 * v2)) / chord
    swing = 2.0 * f.s_rate / length
    return turn, turn_0, left_1 + share * a1 + swing * v1, left_2 + share * a2 + swing * v2


@stage
def share_force(p: Parameters, t: Tables, w: Workspace, at: int) -> None:
    """To `spread`: what a unit of the slider's force, sign reversed, does for every speed (equation 4.8)."""
    m, N, f = p.speeds, t.points, w.facts
    if p.treatment != LEVER:
        for k in range(m):
            w.spread[k] = w.row_of_gap[k]
        return
    n1, n2 = -f.tangent_2, f.tangent_1
    left, right = nodes_of_slider(t, at)
    share = w.length[at // t.cell_size] / (w.length[at // t.cell_size] + w.length[at // t.cell_size + 1])
    for k in range(m):
        w.spread[k] = -share * (n1 * w.V[k, right] + n2 * w.V[k, N + right])
        if left >= 0:
            w.spread[k] -= (1.0 - share) * (n1 * w.V[k, left] + n2 * w.V[k, N + left])
    w.spread[0] += p.LA * (n2 * f.along - n1 * f.across)


@inlined
def joint_power(p: Parameters, w: Workspace, y: Array) -> float:
    """Power of the slider's force on crank and follower together, W: none for an ideal constraint."""
    total = 0.0
    for k in range(p.speeds):
        total -= w.facts.force * w.spread[k] * y[p.speeds + 1 + k]
    return total
