"""The slider: where the crank tip meets the follower, and how gap, slider and follower angle move (DERIVATION.md, section 3)."""

import math

import numpy as np
from numpy.typing import NDArray

from quickreturn.reference_model.compilation import inlined, stage
from quickreturn.reference_model.motion.fields import combine, cumulate
from quickreturn.reference_model.motion.lanes import load, plus, spread, store
from quickreturn.reference_model.motion.layout import (
    ACROSS,
    ACROSS_BY_Q2,
    ALONG,
    ALONG_BY_Q2,
    COS_Q2,
    CURVATURE,
    EXCESS,
    FOOT_1,
    FOOT_2,
    FOOT_BY_S_1,
    FOOT_BY_S_2,
    FORCE,
    GAP,
    GAP_RATE,
    GAP_REMAINDER,
    MISSED,
    Q2_RATE,
    Q2_REMAINDER,
    S_RATE,
    S_REMAINDER,
    SIN_Q2,
    SLIDER_SLOPE,
    TANGENT_1,
    TANGENT_2,
    Parameters,
    Tables,
    Workspace,
)
from quickreturn.reference_model.treatment import CHORDS, ELIMINATED, LEVER

Array = NDArray[np.float64]


@inlined
def _on_line(p: Parameters, t: Tables, w: Workspace, y: Array, at: int) -> None:
    """Foot, tangent and their changes where the slider rides on the centre line."""
    n, N, f = p.n, t.cells * t.S, w.facts
    f[FOOT_1], f[FOOT_2], f[TANGENT_1], f[TANGENT_2] = w.z[at], w.z[N + at], w.e[at], w.e[N + at]
    extra = t.kinds * n * N
    curvature = slope_by_s = 0.0
    for i in range(n):
        w.foot[0, 1 + i], w.foot[1, 1 + i], w.foot[2, 1 + i] = w.V[1 + i, at], w.V[1 + i, N + at], w.row[i * N + at]
        curvature += w.row[extra + 2 * n + i] * y[1 + i]
        slope_by_s += w.row[extra + 3 * n + i] * y[1 + i]
    f[CURVATURE], f[SLIDER_SLOPE] = curvature, slope_by_s


@inlined
def nodes_of_slider(t: Tables, at: int) -> tuple[int, int]:
    """Places among the points of the two nodes of the slider's element; -1 for the pivot."""
    return at - t.S, at + t.S


@inlined
def _on_chord(p: Parameters, t: Tables, w: Workspace, at: int) -> None:
    """The same where it rides on the chord between the two nodes of its element (equation 3.9)."""
    N, f = t.cells * t.S, w.facts
    left, right = nodes_of_slider(t, at)
    share = w.length[at // t.S] / (w.length[at // t.S] + w.length[at // t.S + 1])
    x1 = x2 = 0.0
    if left >= 0:
        x1, x2 = w.z[left], w.z[N + left]
    chord_1, chord_2 = w.z[right] - x1, w.z[N + right] - x2
    chord = math.sqrt(chord_1 * chord_1 + chord_2 * chord_2)
    f[TANGENT_1], f[TANGENT_2] = chord_1 / chord, chord_2 / chord
    f[FOOT_1], f[FOOT_2] = x1 + share * chord_1, x2 + share * chord_2
    f[CURVATURE] = f[SLIDER_SLOPE] = 0.0
    for i in range(1, p.n + 1):
        a1 = a2 = 0.0
        if left >= 0:
            a1, a2 = w.V[i, left], w.V[i, N + left]
        b1, b2 = w.V[i, right] - a1, w.V[i, N + right] - a2
        w.foot[0, i], w.foot[1, i] = a1 + share * b1, a2 + share * b2
        w.foot[2, i] = (f[TANGENT_1] * b2 - f[TANGENT_2] * b1) / chord


@stage
def move_loop(p: Parameters, t: Tables, w: Workspace, y: Array, at: int) -> bool:
    """Gap and partial rates sigma of s, of the gap and c of q2; then the rates themselves (equations 3.1 to 3.6)."""
    n, m, f = p.n, p.speeds, w.facts
    N = t.cells * t.S
    if p.treatment == CHORDS:
        _on_chord(p, t, w, at)
    else:
        _on_line(p, t, w, y, at)
    t1, t2, Z1, Z2 = f[TANGENT_1], f[TANGENT_2], f[FOOT_1], f[FOOT_2]
    v1, v2 = p.LA * math.cos(y[0]) - p.d, p.LA * math.sin(y[0])
    if p.treatment == ELIMINATED:
        # exp(i q2) has the direction of v / Z
        distance, reach = math.sqrt(v1 * v1 + v2 * v2), math.sqrt(Z1 * Z1 + Z2 * Z2)
        scale = 1.0 / (distance * reach)
        f[COS_Q2], f[SIN_Q2] = scale * (v1 * Z1 + v2 * Z2), scale * (v2 * Z1 - v1 * Z2)
        f[GAP], f[MISSED] = 0.0, distance - reach
        f[EXCESS] = abs(f[MISSED])
    else:
        f[COS_Q2], f[SIN_Q2] = math.cos(y[n + 1]), math.sin(y[n + 1])
        C1, C2 = f[COS_Q2] * v1 + f[SIN_Q2] * v2 - Z1, f[COS_Q2] * v2 - f[SIN_Q2] * v1 - Z2
        f[GAP], f[MISSED] = t1 * C2 - t2 * C1, t1 * C1 + t2 * C2
        f[EXCESS] = abs(f[GAP])
    f[ALONG] = ((v1 + p.d) * f[COS_Q2] + v2 * f[SIN_Q2]) / p.LA
    f[ACROSS] = (v2 * f[COS_Q2] - (v1 + p.d) * f[SIN_Q2]) / p.LA
    gap = f[GAP]
    # along and across the tangent: b, the change of the foot with s, and the right side of every speed
    b1, b2 = 1.0, 0.0
    if p.treatment == CHORDS:
        b1 = _chord_per_length(t, w, at)
    elif t.kinds == 3:
        b1, b2 = 1.0 + t1 * w.Y[at] + t2 * w.Y[N + at], t1 * w.Y[N + at] - t2 * w.Y[at]
    b1 -= gap * f[SLIDER_SLOPE]
    along_q2, across_q2 = t1 * Z2 - t2 * Z1 + gap, -t1 * Z1 - t2 * Z2
    f[FOOT_BY_S_1], f[FOOT_BY_S_2], f[ALONG_BY_Q2], f[ACROSS_BY_Q2] = b1, b2, along_q2, across_q2
    w.foot[0, 0], w.foot[1, 0] = p.LA * (f[ALONG] * t2 - f[ACROSS] * t1), p.LA * (f[ALONG] * t1 + f[ACROSS] * t2)
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
    f[Q2_RATE] = f[S_RATE] = f[GAP_RATE] = 0.0
    for k in range(m):
        f[Q2_RATE] += w.c[k] * y[m + 1 + k]
        f[S_RATE] += w.sigma[k] * y[m + 1 + k]
        f[GAP_RATE] += w.row_of_gap[k] * y[m + 1 + k]
    return True


@inlined
def _chord_per_length(t: Tables, w: Workspace, at: int) -> float:
    """Length of the slider's chord over that of its element."""
    N = t.cells * t.S
    left, right = nodes_of_slider(t, at)
    x1 = x2 = 0.0
    if left >= 0:
        x1, x2 = w.z[left], w.z[N + left]
    chord = math.sqrt((w.z[right] - x1) ** 2 + (w.z[N + right] - x2) ** 2)
    return chord / (w.length[at // t.S] + w.length[at // t.S + 1])


@inlined
def accelerate_loop(p: Parameters, t: Tables, w: Workspace, y: Array, at: int) -> None:
    """Remainders of the second derivatives of q2, s and gap (equations 3.7 and 3.8).

    The remaining acceleration less what q2 and s add to it goes to `w.A`.
    """
    n, m, N, f = p.n, p.speeds, t.cells * t.S, w.facts
    q1_rate, s_rate = y[m + 1], f[S_RATE]
    remaining_places(p, t, w, y)
    if p.treatment == CHORDS:
        turn, turn_0, a1, a2 = _accelerate_chord(p, t, w, y, at)
    else:
        turn = w.turn[at] + f[CURVATURE] * s_rate
        bend = s_rate * (2.0 * w.turn[at] + f[CURVATURE] * s_rate)
        a1, a2 = w.A[at] - bend * f[TANGENT_2], w.A[N + at] + bend * f[TANGENT_1]
        extra = t.kinds * n * N
        turn_0 = 0.0
        for i in range(n):
            turn_0 += 2.0 * w.row[extra + 3 * n + i] * s_rate * y[m + 2 + i] + w.row[extra + 4 * n + i] * s_rate**2 * y[1 + i]
    a1 += p.LA * q1_rate**2 * f[ALONG]
    a2 += p.LA * q1_rate**2 * f[ACROSS]
    t1, t2, gap = f[TANGENT_1], f[TANGENT_2], f[GAP]
    along, across = 2.0 * f[GAP_RATE] * turn + gap * turn_0 - t1 * a1 - t2 * a2, gap * turn**2 - t1 * a2 + t2 * a1
    b1, b2, along_q2, across_q2 = f[FOOT_BY_S_1], f[FOOT_BY_S_2], f[ALONG_BY_Q2], f[ACROSS_BY_Q2]
    if p.treatment == ELIMINATED:
        determinant = along_q2 * b2 - across_q2 * b1
        f[S_REMAINDER] = (along_q2 * across - across_q2 * along) / determinant
        f[Q2_REMAINDER], f[GAP_REMAINDER] = (b1 * across - b2 * along) / determinant, 0.0
    else:
        f[S_REMAINDER] = along / b1
        f[Q2_REMAINDER], f[GAP_REMAINDER] = 0.0, across - b2 * f[S_REMAINDER]


@stage
def remaining_places(p: Parameters, t: Tables, w: Workspace, y: Array) -> None:
    """To `turn`, `gamma` and `A`: angular rates, and what they and the moving shapes alone do to the accelerations (equation 2.6)."""
    n, N, m, f = p.n, t.cells * t.S, p.speeds, w.facts
    s_rate, q2_rate = f[S_RATE], f[Q2_RATE]
    combine(w.row, 0, n, y, m + 2, w.turn)
    if t.kinds == 3:
        for j in range(N):
            w.turn[j] += q2_rate + w.psi_s[j] * s_rate
        for j in range(0, N, 4):
            swing = bend = spread(0.0)
            for i in range(n):
                swing = plus(swing, y[m + 2 + i], load(w.row, (n + i) * N + j))
                bend = plus(bend, y[1 + i], load(w.row, (2 * n + i) * N + j))
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
def _accelerate_chord(p: Parameters, t: Tables, w: Workspace, y: Array, at: int) -> tuple[float, float, float, float]:
    """Rate and remaining acceleration of the chord's angle, and the remaining acceleration of the foot (equation 3.9)."""
    N, m, f = t.cells * t.S, p.speeds, w.facts
    left, right = nodes_of_slider(t, at)
    length = w.length[at // t.S] + w.length[at // t.S + 1]
    share = w.length[at // t.S] / length
    # differences from the left node to the right one: place, velocity, remaining acceleration; the pivot stands still
    x1, x2, a1, a2 = w.z[right], w.z[N + right], w.A[right], w.A[N + right]
    v1, v2, left_1, left_2 = 0.0, 0.0, 0.0, 0.0
    for i in range(1, p.n + 1):
        v1 += y[m + 1 + i] * w.V[i, right]
        v2 += y[m + 1 + i] * w.V[i, N + right]
    if left >= 0:
        x1, x2 = x1 - w.z[left], x2 - w.z[N + left]
        left_1, left_2 = w.A[left], w.A[N + left]
        a1, a2 = a1 - left_1, a2 - left_2
        for i in range(1, p.n + 1):
            v1 -= y[m + 1 + i] * w.V[i, left]
            v2 -= y[m + 1 + i] * w.V[i, N + left]
    v1, v2 = v1 - f[Q2_RATE] * x2, v2 + f[Q2_RATE] * x1
    chord = math.sqrt(x1 * x1 + x2 * x2)
    t1, t2 = f[TANGENT_1], f[TANGENT_2]
    turn = (t1 * v2 - t2 * v1) / chord
    turn_0 = (t1 * a2 - t2 * a1 - 2.0 * turn * (t1 * v1 + t2 * v2)) / chord
    swing = 2.0 * f[S_RATE] / length
    return turn, turn_0, left_1 + share * a1 + swing * v1, left_2 + share * a2 + swing * v2


@stage
def share_force(p: Parameters, t: Tables, w: Workspace, at: int) -> None:
    """To `spread`: what a unit of the slider's force, sign reversed, does for every speed (equation 4.8)."""
    m, N, f = p.speeds, t.cells * t.S, w.facts
    if p.treatment != LEVER:
        for k in range(m):
            w.spread[k] = w.row_of_gap[k]
        return
    n1, n2 = -f[TANGENT_2], f[TANGENT_1]
    left, right = nodes_of_slider(t, at)
    share = w.length[at // t.S] / (w.length[at // t.S] + w.length[at // t.S + 1])
    for k in range(m):
        w.spread[k] = -share * (n1 * w.V[k, right] + n2 * w.V[k, N + right])
        if left >= 0:
            w.spread[k] -= (1.0 - share) * (n1 * w.V[k, left] + n2 * w.V[k, N + left])
    w.spread[0] += p.LA * (n2 * f[ALONG] - n1 * f[ACROSS])


@inlined
def joint_power(p: Parameters, w: Workspace, y: Array) -> float:
    """Power of the slider's force on crank and follower together, W: none for an ideal constraint."""
    total = 0.0
    for k in range(p.speeds):
        total -= w.facts[FORCE] * w.spread[k] * y[p.speeds + 1 + k]
    return total
