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
from quickreturn.reference_model.motion.layout import TIP_1, TIP_2, TIP_TURN, Parameters, Tables, Workspace
from quickreturn.reference_model.motion.loop import joint_power
from quickreturn.reference_model.spin_up import base_motion as motion_of_base
from quickreturn.reference_model.treatment import BASE

Array = NDArray[np.float64]

base_motion, joint_energy = stage(motion_of_base), stage(energy_of_joint)

#: Numbers in a row: those of `columns.OBSERVED`, then those of `columns.JOINT_COLUMNS`.
WIDTH: Final = len(c.OBSERVED) + len(c.JOINT_COLUMNS)


@inlined
def observe(p: Parameters, t: Tables, w: Workspace, y: Array, o: Array) -> bool:
    """Fill the row `o` (WIDTH,) for the state evaluated last, with its forces.

    False where the recovered line is bent too far.
    """
    m, f = p.speeds, w.facts
    at = f.at_slider
    o[c.CRANK_ANGLE], o[c.CRANK_SPEED], o[c.TIP_ACCELERATION] = y[0], y[m + 1], _tip_acceleration(p, t, w)
    o[c.SLIDER_FORCE], o[c.CRANK_TORQUE], o[c.DISSIPATED_ENERGY], o[c.DRIVE_WORK] = f.normal, f.torque, y[2 * m + 1], y[2 * m + 2]
    o[c.CONSTRAINT_GAP], o[c.GAP_RATE], o[c.JOINT_POWER] = f.excess, f.gap_rate, 0.0
    if m > p.n + 1:
        o[c.JOINT_POWER] = joint_power(p, w, y)
    _energies(p, t, w, y, at, o)
    _bearing_forces(p, t, w, y, o)
    _bending_moment(p, t, w, at)
    return _recover(p, t, w, y, at, o)


@stage
def _tip_acceleration(p: Parameters, t: Tables, w: Workspace) -> float:
    """Absolute acceleration of x = L along the normal there (equation 6.1)."""
    N, f = t.points, w.facts
    end = t.tip
    g1 = f.cos_q2 * p.gravity_1 + f.sin_q2 * p.gravity_2
    g2 = -f.sin_q2 * p.gravity_1 + f.cos_q2 * p.gravity_2
    return -w.e[N + end] * (w.a[end] + g1) + w.e[end] * (w.a[N + end] + g2)


@stage
def _energies(p: Parameters, t: Tables, w: Workspace, y: Array, at: int, o: Array) -> None:
    """Kinetic, strain and gravity energy (equations 6.2 to 6.4)."""
    n, m, N, f = p.n, p.speeds, t.points, w.facts
    end = t.tip
    q2_rate, q1_rate = f.q2_rate, y[m + 1]
    kinetic = 0.5 * p.crank_inertia * q1_rate * q1_rate + 0.5 * p.base_inertia * q2_rate * q2_rate
    for j in range(N):
        v1, v2 = w.relative[j] - q2_rate * w.z[N + j], w.relative[N + j] + q2_rate * w.z[j]
        kinetic += 0.5 * w.mass[j] * (v1 * v1 + v2 * v2)
    ec, es = p.tip_offset * w.e[end], p.tip_offset * w.e[N + end]
    v1 = w.relative[end] - q2_rate * w.z[N + end] - es * w.turn[end]
    v2 = w.relative[N + end] + q2_rate * w.z[end] + ec * w.turn[end]
    kinetic += 0.5 * p.tip_mass * (v1 * v1 + v2 * v2) + 0.5 * p.tip_inertia * w.turn[end] ** 2
    kinetic += 0.5 * p.slider_inertia * (w.turn[at] + f.curvature * f.s_rate) ** 2
    kinetic += 0.5 * p.joint_inertia * f.gap_rate**2
    strain = joint_energy(f.gap, p.plus, p.minus, p.plus_from, p.minus_from)
    for i in range(n):
        strain += 0.5 * w.squares[i] * y[1 + i] ** 2
    moment_1, moment_2 = p.tip_mass * (w.z[end] + ec), p.tip_mass * (w.z[N + end] + es)
    for j in range(N):
        moment_1 += w.mass[j] * w.z[j]
        moment_2 += w.mass[j] * w.z[N + j]
    cosine, sine = f.cos_q2, f.sin_q2
    mass = p.rhoA * p.L + p.tip_mass
    gravity = -p.gravity_1 * (mass * p.d + cosine * moment_1 - sine * moment_2 + p.crank_moment * math.cos(y[0]))
    gravity -= p.gravity_2 * (sine * moment_1 + cosine * moment_2 + p.crank_moment * math.sin(y[0]))
    o[c.KINETIC_ENERGY], o[c.STRAIN_ENERGY], o[c.GRAVITY_ENERGY] = kinetic, strain, gravity


@inlined
def _slider_on_follower(w: Workspace) -> tuple[float, float]:
    """The slider's force on the follower in frame B, N (equation 5.6)."""
    f = w.facts
    t1, t2 = f.tangent_1, f.tangent_2
    return -f.normal * t2 + f.tangential * t1, f.normal * t1 + f.tangential * t2


@stage
def _bearing_forces(p: Parameters, t: Tables, w: Workspace, y: Array, o: Array) -> None:
    """Forces of the ground on base and crank in frame N, by Newton's law for follower and crank (equations 6.10 and 6.11)."""
    N, f = t.points, w.facts
    bodies = 2 * N
    s1 = s2 = 0.0
    if p.treatment != BASE:
        s1, s2 = _slider_on_follower(w)
    beam_1 = beam_2 = spread(0.0)
    for j in range(0, N, 4):
        beam_1 = plus_product(beam_1, load(w.mass, j), load(w.a, j))
        beam_2 = plus_product(beam_2, load(w.mass, N + j), load(w.a, N + j))
    p1 = total(beam_1) + p.tip_mass * w.a[bodies + TIP_1] - f.tip_force_1 - s1
    p2 = total(beam_2) + p.tip_mass * w.a[bodies + TIP_2] - f.tip_force_2 - s2
    turning, centripetal = p.crank_moment * w.acceleration[0], p.crank_moment * y[p.speeds + 1] ** 2
    c1 = s1 - turning * f.across - centripetal * f.along
    c2 = s2 + turning * f.along - centripetal * f.across
    cosine, sine = f.cos_q2, f.sin_q2
    o[c.PIVOT_FORCE_X], o[c.PIVOT_FORCE_Y] = cosine * p1 - sine * p2, sine * p1 + cosine * p2
    o[c.CRANK_FORCE_X] = cosine * c1 - sine * c2 - p.crank_mass * p.gravity_1
    o[c.CRANK_FORCE_Y] = sine * c1 + cosine * c2 - p.crank_mass * p.gravity_2


@stage
def _bending_moment(p: Parameters, t: Tables, w: Workspace, at: int) -> None:
    """Moment of the outboard forces at the points, N m, in `w.moment` (equations 6.5 and 6.6)."""
    N, f = t.points, w.facts
    end, bodies = t.tip, 2 * N
    force, moment = w.load, w.load_moment
    ec, es = p.tip_offset * w.e[end], p.tip_offset * w.e[N + end]
    s1, s2 = _slider_on_follower(w)
    for j in range(N):
        force[j] = -p.rhoA * w.a[j] - p.beam_damping * p.damps_along * w.relative[j]
        force[N + j] = -p.rhoA * w.a[N + j] - p.beam_damping * w.relative[N + j]
    for j in range(N):
        moment[j] = w.z[j] * force[N + j] - w.z[N + j] * force[j]
    for j in range(N):
        moment[N + j] = 0.0
    cumulate(t, w.length, force, w.inboard_force)  # inboard force
    cumulate(t, w.length, moment, w.inboard_moment)  # and its moment about P
    # the tip body's and the tool's, and with them everything outboard of P
    f1, f2 = -p.tip_mass * w.a[bodies + TIP_1], -p.tip_mass * w.a[bodies + TIP_2]
    total_m = (w.z[end] + ec) * f2 - (w.z[N + end] + es) * f1 - p.tip_inertia * w.a[bodies + TIP_TURN] + w.inboard_moment[end]
    total_m += w.z[end] * f.tip_force_2 - w.z[N + end] * f.tip_force_1
    total_1, total_2 = f1 + w.inboard_force[end] + f.tip_force_1, f2 + w.inboard_force[N + end] + f.tip_force_2
    for j in range(N):
        w.moment[j] = (
            total_m - w.inboard_moment[j] - w.z[j] * (total_2 - w.inboard_force[N + j]) + w.z[N + j] * (total_1 - w.inboard_force[j])
        )
    if p.treatment != BASE:
        # at the slider itself the moment jumps by the slider's; the outboard side is shown
        for j in range(at if f.slider_moment != 0.0 else at + 1):
            w.moment[j] += (w.z[at] - w.z[j]) * s2 - (w.z[N + at] - w.z[N + j]) * s1 + f.slider_moment


@stage
def _recover(p: Parameters, t: Tables, w: Workspace, y: Array, at: int, o: Array) -> bool:
    """Moments and strains; shape, base angle, slider and tip place of the recovered curvature (equations 6.7 to 6.9)."""
    N, s, f = t.points, w.slider[0], w.facts
    end, flexibility = t.tip, 1.0 / p.EI
    for j in range(N):
        w.curvature[j] = flexibility * w.moment[j]
    if p.bending_damping > 0.0:
        for j in range(N):
            w.curvature[j] -= p.bending_damping * w.curvature_rate[j]
    for j in range(N):
        w.integrand[j], w.integrand[N + j] = w.curvature[j], 0.0
    cumulate(t, w.length, w.integrand, w.recovered_angle)
    if not directions(w.recovered_angle[:N], w.recovered_e):
        return False
    cumulate(t, w.length, w.recovered_e, w.recovered_place)
    tip_1, tip_2 = w.recovered_place[end], w.recovered_place[N + end]
    o[c.MOMENT_SLIDER] = w.moment[at]
    for place in range(c.PLACES):
        x = (place + 1) * p.L / (c.PLACES + 1)
        o[c.FIRST_OF_MOMENTS + place], o[c.FIRST_OF_SHAPE + place] = _at_place(t, w, w.moment, x)
    for gauge in range(3):
        o[c.STRAIN_1 + gauge] = 0.5 * p.thickness * _at_place(t, w, w.curvature, p.gauges[gauge])[0]
    cosine, sine, ds = f.cos_q2, f.sin_q2, 0.0
    if p.treatment == BASE:
        o[c.FOLLOWER_ANGLE] = base_motion(p.base_speed, p.base_time, y[0])[0]
    else:
        # the crank tip is beside the line, by the gap along its normal
        c1, c2 = w.recovered_e[at], w.recovered_e[N + at]
        Z1, Z2 = w.recovered_place[at] - f.gap * c2, w.recovered_place[N + at] + f.gap * c1
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
    first, across, u = cell * t.cell_size, t.points + cell * t.cell_size, (x - begin) / w.length[cell]
    value, deflection, before = 0.0, 0.0, 1.0  # before: product of the distances from the points passed
    for j in range(t.gauss_points):
        away, share = u - t.u[j], t.lagrange[j] * before
        value = value * away + share * field[first + j]
        deflection = deflection * away + share * w.recovered_place[across + j]
        before *= away
    return value, deflection
