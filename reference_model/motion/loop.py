"""The slider: where the crank tip meets the follower, and how gap, slider and follower angle move (DERIVATION.md, section 3)."""

import math

from quickreturn.reference_model.arrays import Array
from quickreturn.reference_model.joint import CHORDS, ELIMINATED, LEVER
from quickreturn.reference_model.mechanism import base_motion
from quickreturn.reference_model.motion.fields import combine, cumulate
from quickreturn.reference_model.motion.layout import BeamParameters, BeamTables, BeamWorkspace
from quickreturn.reference_model.motion.plane import cross, direction, dot, point
from quickreturn.reference_model.native.compilation import inlined, inner
from quickreturn.reference_model.native.simd import load, plus, spread, store
from quickreturn.reference_model.state import State

turn_of_base = inner(base_motion)


@inner
def motion_of_base(p: BeamParameters, t: float) -> tuple[float, float, float]:
    """Prescribed angle, rate and acceleration of the base at the instant t (equation 11.1)."""
    return turn_of_base(p.base_speed, p.base_time, t)


@inlined
def _on_line(p: BeamParameters, t: BeamTables, w: BeamWorkspace, y: State, slider_point: int) -> None:
    """Foot, tangent and their derivatives and partial rates for a slider on the centre line."""
    f = w.facts
    f.foot, f.tangent = point(w.z, slider_point, t.points), point(w.e, slider_point, t.points)
    f.curvature = f.angle_by_s = 0.0
    for i in range(p.n):
        w.foot_rate[1 + i], w.tangent_rate[1 + i] = point(w.U[i], slider_point, t.points), w.psi_i[i, slider_point]
        f.curvature += w.curvature_at_slider[i] * y.eta[i]
        f.angle_by_s += w.angle_at_slider_s[i] * y.eta[i]
    f.foot_by_s = complex(1.0, 0.0)
    if t.moves:
        f.foot_by_s += f.tangent.conjugate() * point(w.Y, slider_point, t.points)


@inlined
def nodes_of_slider(t: BeamTables, w: BeamWorkspace, slider_point: int) -> tuple[int, int, float, float]:
    """The slider's element: points of its two nodes (negative for the pivot), length (m), and the slider's place as a fraction of it."""
    cell = slider_point // t.cell_size
    length = w.length[cell] + w.length[cell + 1]
    return slider_point - t.cell_size, slider_point + t.cell_size, length, w.length[cell] / length


@inlined
def _at_node(row: Array, node: int, N: int) -> complex:
    """The vector of a row at a node; zero at the pivot."""
    return point(row, node, N) if node >= 0 else complex(0.0, 0.0)


@inlined
def _on_chord(p: BeamParameters, t: BeamTables, w: BeamWorkspace, slider_point: int) -> None:
    """The results of `_on_line` for a slider on the chord between the two nodes of its element (equation 3.9)."""
    f = w.facts
    left, right, length, share = nodes_of_slider(t, w, slider_point)
    begin = _at_node(w.z, left, t.points)
    chord = point(w.z, right, t.points) - begin
    size = math.sqrt(dot(chord, chord))
    f.tangent, f.foot, f.foot_by_s = chord / size, begin + share * chord, complex(size / length, 0.0)
    f.curvature = f.angle_by_s = 0.0
    for i in range(p.n):
        begin = _at_node(w.U[i], left, t.points)
        change = point(w.U[i], right, t.points) - begin
        w.foot_rate[1 + i], w.tangent_rate[1 + i] = begin + share * change, cross(f.tangent, change) / size


@inner
def move_loop(p: BeamParameters, t: BeamTables, w: BeamWorkspace, y: State, slider_point: int) -> bool:
    """To `w`: gap, partial rates of s (`sigma`), q2 (`c`) and gap, and the rates (equations 3.1 to 3.6); False for a singular loop."""
    n, m, f = p.n, p.speeds, w.facts
    if p.constraint == CHORDS:
        _on_chord(p, t, w, slider_point)
    else:
        _on_line(p, t, w, y, slider_point)
    crank = p.LA * direction(y.q[0])
    tip = crank - p.d
    if p.constraint == ELIMINATED:
        distance, reach = math.sqrt(dot(tip, tip)), math.sqrt(dot(f.foot, f.foot))
        f.frame = tip * f.foot.conjugate() / (distance * reach)
        f.gap, f.missed = 0.0, distance - reach
        f.unclosed = abs(f.missed)
    else:
        f.frame = direction(y.q[n + 1])
        apart = f.tangent.conjugate() * (f.frame.conjugate() * tip - f.foot)
        f.missed, f.gap = apart.real, apart.imag
        f.unclosed = abs(f.gap)
    f.arm = f.frame.conjugate() * crank / p.LA
    f.foot_by_s -= f.gap * f.angle_by_s
    f.closing_by_q2 = f.gap - 1j * f.tangent.conjugate() * f.foot
    w.closing[0] = 1j * p.LA * f.tangent.conjugate() * f.arm
    for k in range(1, n + 1):
        w.closing[k] = f.gap * w.tangent_rate[k] - f.tangent.conjugate() * w.foot_rate[k]
    if p.constraint == ELIMINATED:
        # the rates of q2 and s follow from a gap that stays zero
        determinant = cross(f.closing_by_q2, f.foot_by_s)
        if not abs(determinant) > 1e-6 * p.L:
            return False
        for k in range(m):
            w.sigma[k] = cross(f.closing_by_q2, w.closing[k]) / determinant
            w.c[k] = cross(f.foot_by_s, w.closing[k]) / determinant
            w.row_of_gap[k] = 0.0
    else:
        if not f.foot_by_s.real > 1e-3:
            return False
        w.closing[n + 1] = f.closing_by_q2
        for k in range(m):
            w.sigma[k] = w.closing[k].real / f.foot_by_s.real
            w.row_of_gap[k] = w.closing[k].imag - f.foot_by_s.imag * w.sigma[k]
            w.c[k] = 0.0
        w.c[n + 1] = 1.0
    f.q2_rate = f.s_rate = f.gap_rate = 0.0
    for k in range(m):
        f.q2_rate += w.c[k] * y.u[k]
        f.s_rate += w.sigma[k] * y.u[k]
        f.gap_rate += w.row_of_gap[k] * y.u[k]
    return True


@inlined
def bias_of_loop(p: BeamParameters, t: BeamTables, w: BeamWorkspace, y: State, slider_point: int) -> None:
    """To the facts: bias of the second derivatives of q2, s and the gap (equations 3.7 and 3.8)."""
    n, f = p.n, w.facts
    s_rate = f.s_rate
    bias_of_places(p, t, w, y)
    if p.constraint == CHORDS:
        turn, turn_bias, foot_bias = _bias_of_chord(p, t, w, y, slider_point)
    else:
        turn, turn_bias = w.turn[slider_point] + f.curvature * s_rate, 0.0
        foot_bias = point(w.A, slider_point, t.points) + 1j * s_rate * (2.0 * w.turn[slider_point] + f.curvature * s_rate) * f.tangent
        for i in range(n):
            turn_bias += 2.0 * w.angle_at_slider_s[i] * s_rate * y.eta_rate[i] + w.angle_at_slider_ss[i] * s_rate**2 * y.eta[i]
    away = foot_bias + p.LA * y.u[0] ** 2 * f.arm
    closing = 2.0 * f.gap_rate * turn + f.gap * turn_bias + 1j * f.gap * turn**2 - f.tangent.conjugate() * away
    if p.constraint == ELIMINATED:
        determinant = cross(f.closing_by_q2, f.foot_by_s)
        f.s_bias = cross(f.closing_by_q2, closing) / determinant
        f.q2_bias, f.gap_bias = cross(f.foot_by_s, closing) / determinant, 0.0
    else:
        f.s_bias = closing.real / f.foot_by_s.real
        f.q2_bias, f.gap_bias = 0.0, closing.imag - f.foot_by_s.imag * f.s_bias


@inner
def bias_of_places(p: BeamParameters, t: BeamTables, w: BeamWorkspace, y: State) -> None:
    """To `turn`, `gamma` and `A`: angular rates, and the bias accelerations from them and from the moving shapes (equation 2.6)."""
    n, N, f = p.n, t.points, w.facts
    s_rate, q2_rate = f.s_rate, f.q2_rate
    combine(w.psi_i, y.eta_rate, w.turn)
    if t.moves:
        for j in range(N):
            w.turn[j] += q2_rate + w.psi_s[j] * s_rate
        for j in range(0, N, 4):
            swing = bend = spread(0.0)
            for i in range(n):
                swing = plus(swing, y.eta_rate[i], load(w.psi_i_s[i], j))
                bend = plus(bend, y.eta[i], load(w.psi_i_ss[i], j))
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
def _bias_of_chord(p: BeamParameters, t: BeamTables, w: BeamWorkspace, y: State, slider_point: int) -> tuple[float, float, complex]:
    """Rate and bias acceleration of the chord's angle, and the bias acceleration of the foot (equation 3.9)."""
    N, f = t.points, w.facts
    left, right, length, share = nodes_of_slider(t, w, slider_point)
    chord = point(w.z, right, N) - _at_node(w.z, left, N)
    size = math.sqrt(dot(chord, chord))
    velocity = 1j * f.q2_rate * chord
    for i in range(p.n):
        velocity += y.eta_rate[i] * (point(w.U[i], right, N) - _at_node(w.U[i], left, N))
    begin = _at_node(w.A, left, N)
    bias = point(w.A, right, N) - begin
    turn = cross(f.tangent, velocity) / size
    turn_bias = (cross(f.tangent, bias) - 2.0 * turn * dot(f.tangent, velocity)) / size
    return turn, turn_bias, begin + share * bias + 2.0 * f.s_rate / length * velocity


@inner
def share_force(p: BeamParameters, t: BeamTables, w: BeamWorkspace, slider_point: int) -> None:
    """To `spread`: generalised force of each speed per unit of the slider's force, sign reversed (equation 4.8)."""
    N, f = t.points, w.facts
    if p.constraint != LEVER:
        for k in range(p.speeds):
            w.spread[k] = w.row_of_gap[k]
        return
    normal = 1j * f.tangent
    left, right, _, share = nodes_of_slider(t, w, slider_point)
    for k in range(p.speeds):
        w.spread[k] = -share * dot(normal, point(w.V[k], right, N)) - (1.0 - share) * dot(normal, _at_node(w.V[k], left, N))
    w.spread[0] += p.LA * dot(normal, 1j * f.arm)


@inlined
def joint_power(p: BeamParameters, w: BeamWorkspace, y: State) -> float:
    """Power of the slider's force on crank and follower together, W: none for an ideal constraint."""
    total = 0.0
    for k in range(p.speeds):
        total -= w.facts.force * w.spread[k] * y.u[k]
    return total
