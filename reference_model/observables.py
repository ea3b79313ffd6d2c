"""Observables and energies at output times, compiled (DERIVATION.md, sections 6 and 7).

The converged model recovers curvature from equilibrium: the bending moment of the outboard inertia, damping, gravity and slider
forces over EI. The series of fixed shapes converges slowly there, because the moment has a kink at the slider that no fixed smooth
shape has; its accelerations are much better. Deflection, base angle, slider place and tip place then follow by integrating the
recovered curvature. The thesis' model shows its shapes as they are.
"""

import math
from typing import Final

import numpy as np
from numpy.typing import NDArray

from reference_model.compilation import compiled, inlined, inside
from reference_model.dynamics import evaluate, reactions
from reference_model.kinematics import Contact, Slider, centre_line, tangent_angle
from reference_model.parameters import Parameters, Workspace
from reference_model.tables import POINTS, UNIT_POINTS, UNIT_WEIGHTS, Tables, cumulate, find_cell, partial_weights

#: Columns of the output, in this order; `time` is added by the caller.
COLUMNS: Final = (
    "crank_angle",
    "crank_speed",
    "follower_angle",
    "slider_position",
    "tip_x",
    "tip_y",
    "tip_deflection",
    "tip_acceleration",
    "strain_1",
    "strain_2",
    "strain_3",
    "slider_force",
    "crank_torque",
    "kinetic_energy",
    "strain_energy",
    "dissipated_energy",
    "constraint_gap",
    "gravity_energy",
    "drive_work",
)


@compiled
def observe(
    p: Parameters, w: Workspace, mesh: Tables, v: Workspace, states: NDArray[np.float64], recover: bool, out: NDArray[np.float64]
) -> int:
    """Fill `out` (k, 19) with the observables of `states` (k, 2 n + 4).

    Args:
        p: parameters.
        w: workspace of the model's mesh.
        mesh: tables of an even number of cells that are laid anew, half of them to either side of the slider, for every state.
        v: workspace of `mesh`.
        states: rows of the state vector.
        recover: recover curvature and shape from equilibrium.
        out: the table to fill.

    Returns:
        Number of rows filled; less than k where a state cannot be evaluated.
    """
    for row in range(len(states)):
        y = states[row]
        good, c, k = evaluate(p, w, y)
        if not good:
            return row
        force, drive = reactions(p, c, k, w)
        # the loop is closed on the centre line to the last bits of the slider's place
        gap = abs(math.hypot(c.x, c.W) - math.hypot(p.LA * math.cos(y[0]) - p.d, p.LA * math.sin(y[0])))
        observe_row(p, w, mesh, v, c, k, y, force, drive, 0.0, recover, out[row])
        if not (recover and p.n > 0):
            out[row, 16] = gap
    return len(states)


@inside
def observe_row(
    p: Parameters,
    w: Workspace,
    mesh: Tables,
    v: Workspace,
    c: Slider,
    k: Contact,
    y: NDArray[np.float64],
    force: float,
    drive: float,
    gap: float,
    recover: bool,
    o: NDArray[np.float64],
) -> None:
    """One row of the output, from what an evaluation left in `w`.

    Args:
        p: parameters.
        w: workspace after the evaluation of the row's state.
        mesh: as in `observe`.
        v: workspace of `mesh`.
        c: the slider.
        k: its contact.
        y: q1, eta, q1dot, etadot, dissipated energy, work of the drive.
        force: slider force, N.
        drive: torque of the drive, N m.
        gap: signed distance of the crank tip from the centre line along the normal, m.
        recover: recover curvature and shape from equilibrium.
        o: the row to fill, (19,); without recovery its `constraint_gap` is left to the caller.
    """
    n = p.n
    eta_rate = y[n + 2 : 2 * n + 2]
    o[0], o[1], o[2], o[3] = y[0], y[n + 1], c.q2, c.s
    end = len(p.tables.edges) - 1
    tip_1, tip_2 = p.L - w.F_edges[end], w.end[1]
    cosine, sine = math.cos(c.q2), math.sin(c.q2)
    o[4], o[5], o[6] = p.d + cosine * tip_1 - sine * tip_2, sine * tip_1 + cosine * tip_2, tip_2
    o[7] = tip_acceleration(p, k, w, eta_rate)
    o[11], o[12] = force, drive
    energies(p, c, k, w, y, o)
    if recover and n > 0:
        _recover(p, c, k, w, mesh, v, y, force, gap, o)
    else:
        for gauge in range(3):
            curvature = 0.0
            for i in range(n):
                curvature += curvature_of_shape(p, i, p.gauges[gauge]) * y[1 + i]
            o[8 + gauge] = 0.5 * p.thickness * curvature


@inlined
def curvature_of_shape(p: Parameters, i: int, x: float) -> float:
    """phi_i'' at x."""
    cell = find_cell(p.shape_edges, x)
    length = p.shape_edges[cell + 1] - p.shape_edges[cell]
    u = (x - p.shape_edges[cell]) / length
    value = 0.0
    for power in range(p.shape_coefficients.shape[1] - 1, 1, -1):
        value = value * u + power * (power - 1) * p.shape_coefficients[cell, power, i]
    return value / length**2


@inside
def tip_acceleration(p: Parameters, k: Contact, w: Workspace, eta_rate: NDArray[np.float64]) -> float:
    """Absolute acceleration of x = L along the beam's normal there (equation 6.3)."""
    t, end = p.tables, len(p.tables.edges) - 1
    x, W = p.L - w.F_edges[end], w.end[1]
    W_rate = F_rate = 0.0
    a1 = -w.acceleration[1] * W - k.q2_rate**2 * x - w.H_edges[end]
    a2 = w.acceleration[1] * x - k.q2_rate**2 * W
    for i in range(p.n):
        W_rate += t.end_phi[i] * eta_rate[i]
        F_rate += w.f_edges[end, i] * eta_rate[i]
        a1 -= w.f_edges[end, i] * w.acceleration[i + 2]
        a2 += t.end_phi[i] * w.acceleration[i + 2]
    a1 -= 2.0 * k.q2_rate * W_rate
    a2 -= 2.0 * k.q2_rate * F_rate
    angle = tangent_angle(w.end[0], p.exact_geometry)[0]
    return -math.sin(angle) * a1 + math.cos(angle) * a2


@compiled
def energies(p: Parameters, c: Slider, k: Contact, w: Workspace, y: NDArray[np.float64], o: NDArray[np.float64]) -> None:
    """Kinetic, strain and gravity energy, dissipated energy and drive work (equations 6.4 to 6.6)."""
    n = p.n
    kinetic = strain = 0.0
    for a in range(n + 2):
        rate_a = k.q2_rate if a == 1 else (y[n + 1] if a == 0 else y[n + a])
        for b in range(n + 2):
            kinetic += 0.5 * rate_a * w.M[a, b] * (k.q2_rate if b == 1 else (y[n + 1] if b == 0 else y[n + b]))
    for i in range(n):
        for j in range(n):
            strain += 0.5 * y[1 + i] * p.stiffness[i, j] * y[1 + j]
    moment_1 = moment_2 = 0.0  # first moments of base frame bodies about P, in frame B
    for point in range(len(p.tables.x)):
        dm = p.rhoA * p.tables.weights[point]
        moment_1 += dm * (p.tables.x[point] - w.F[point])
        moment_2 += dm * w.W[point]
        if p.exact_geometry:
            curvature = 0.0
            for i in range(n):
                curvature += p.tables.ddphi[point, i] * y[1 + i]
            slope2 = w.slope[point] ** 2
            strain += 0.5 * p.EI * p.tables.weights[point] * curvature**2 * slope2 / (1.0 - slope2)
    angle = tangent_angle(w.end[0], p.exact_geometry)[0]
    end = len(p.tables.edges) - 1
    moment_1 += p.tip_mass * (p.L - w.F_edges[end] + p.tip_offset * math.cos(angle))
    moment_2 += p.tip_mass * (w.end[1] + p.tip_offset * math.sin(angle))
    o[13], o[14], o[15], o[18] = kinetic, strain, y[2 * n + 2], y[2 * n + 3]
    gravity = 0.0
    if p.has_gravity:
        cosine, sine = math.cos(c.q2), math.sin(c.q2)
        mass = p.rhoA * p.L + p.tip_mass
        gravity -= p.gravity_1 * (mass * p.d + cosine * moment_1 - sine * moment_2 + p.crank_moment * math.cos(y[0]))
        gravity -= p.gravity_2 * (sine * moment_1 + cosine * moment_2 + p.crank_moment * math.sin(y[0]))
    o[17] = gravity


@inlined
def _lay_mesh(p: Parameters, s: float, mesh: Tables) -> None:
    """Lay the cells of `mesh`, half to either side of s, and evaluate the shapes at its points."""
    cells = len(mesh.edges) - 1
    half = cells // 2
    for e in range(cells + 1):
        mesh.edges[e] = s * e / half if e <= half else s + (p.L - s) * (e - half) / (cells - half)
    degree = p.shape_coefficients.shape[1] - 1
    for point in range(len(mesh.x)):
        cell = point // POINTS
        length = mesh.edges[cell + 1] - mesh.edges[cell]
        x = mesh.edges[cell] + UNIT_POINTS[point % POINTS] * length
        mesh.x[point], mesh.weights[point] = x, UNIT_WEIGHTS[point % POINTS] * length
        own = find_cell(p.shape_edges, x)
        size = p.shape_edges[own + 1] - p.shape_edges[own]
        u = (x - p.shape_edges[own]) / size
        for i in range(p.n):
            mesh.phi[point, i] = mesh.dphi[point, i] = mesh.ddphi[point, i] = 0.0
        for power in range(degree, -1, -1):
            for i in range(p.n):
                mesh.ddphi[point, i] = mesh.ddphi[point, i] * u + 2.0 * mesh.dphi[point, i]
                mesh.dphi[point, i] = mesh.dphi[point, i] * u + mesh.phi[point, i]
                mesh.phi[point, i] = mesh.phi[point, i] * u + p.shape_coefficients[own, power, i]
        for i in range(p.n):
            mesh.dphi[point, i] /= size
            mesh.ddphi[point, i] /= size**2


@inside
def recover_shape(
    p: Parameters,
    c: Slider,
    k: Contact,
    w: Workspace,
    mesh: Tables,
    v: Workspace,
    y: NDArray[np.float64],
    force: float,
    o: NDArray[np.float64],
) -> None:
    """Strains, and the shape relative to the base tangent, from equilibrium (equations 7.1 to 7.6).

    The place of the edges of `mesh` is left in `v.F1_edges` and `v.F2_edges`, the tangent's angle there in `v.M_edges`.
    """
    n, N = p.n, len(mesh.x)
    cells = len(mesh.edges) - 1
    half = cells // 2
    _lay_mesh(p, c.s, mesh)
    centre_line(mesh, p.exact_geometry, y[1 : n + 1], y[n + 2 : 2 * n + 2], v)
    gravity_1 = gravity_2 = 0.0
    if p.has_gravity:
        gravity_1 = math.cos(c.q2) * p.gravity_1 + math.sin(c.q2) * p.gravity_2
        gravity_2 = -math.sin(c.q2) * p.gravity_1 + math.cos(c.q2) * p.gravity_2
    # force density at the points: f1 in W_rate, f2 in slope_rate, moment about P in integrand (their old contents are spent)
    for point in range(N):
        x, W = mesh.x[point] - v.F[point], v.W[point]
        a1 = -w.acceleration[1] * W - k.q2_rate**2 * x - 2.0 * k.q2_rate * v.W_rate[point] - v.H[point] - gravity_1
        a2 = w.acceleration[1] * x - k.q2_rate**2 * W - 2.0 * k.q2_rate * v.F_rate[point] - gravity_2
        for i in range(n):
            a1 -= v.f[point, i] * w.acceleration[i + 2]
            a2 += mesh.phi[point, i] * w.acceleration[i + 2]
        f1 = -p.rhoA * a1 + p.axial_share * p.beam_damping * v.F_rate[point]
        f2 = -p.rhoA * a2 - p.beam_damping * v.W_rate[point]
        v.W_rate[point], v.slope_rate[point] = f1, f2
        v.integrand[point] = x * f2 - W * f1
    sum_1, sum_2, sum_m = v.F_rate, v.H, v.g1  # reused for the inboard sums of force and moment at the points
    cumulate(mesh.edges, v.W_rate, sum_1, v.F1_edges)
    cumulate(mesh.edges, v.slope_rate, sum_2, v.F2_edges)
    cumulate(mesh.edges, v.integrand, sum_m, v.M_edges)
    total_1, total_2, total_m = v.F1_edges[cells], v.F2_edges[cells], v.M_edges[cells]
    tip_1, tip_2, tip_m = _tip_loads(p, k, w, y, gravity_1, gravity_2)
    total_1, total_2, total_m = total_1 + tip_1, total_2 + tip_2, total_m + tip_m
    # slider: normal force, and with rotary inertia a moment and a tangential part (equation 7.3)
    t1, t2 = c.t1 / k.normal, c.slope / k.normal
    slider_m, tangential = _slider_moment(p, c, k, w, y)
    s1, s2 = -force * t2 + tangential * t1, force * t1 + tangential * t2
    for point in range(N):
        x, W = mesh.x[point] - v.F[point], v.W[point]
        moment = total_m - sum_m[point] - x * (total_2 - sum_2[point]) + W * (total_1 - sum_1[point])
        if point < half * POINTS:
            moment += (c.x - x) * s2 - (c.W - W) * s1 + slider_m
        v.integrand[point] = moment / p.EI
    for gauge in range(3):
        o[8 + gauge] = 0.5 * p.thickness * _at(mesh, v.integrand, p.gauges[gauge], v)
    # shape: psi, then the place relative to the base tangent
    cumulate(mesh.edges, v.integrand, v.W, v.M_edges)
    for point in range(N):
        v.g[point] = math.cos(v.W[point])
        v.slope[point] = math.sin(v.W[point])
    cumulate(mesh.edges, v.g, v.F, v.F1_edges)
    cumulate(mesh.edges, v.slope, v.g1, v.F2_edges)


@inlined
def _recover(
    p: Parameters,
    c: Slider,
    k: Contact,
    w: Workspace,
    mesh: Tables,
    v: Workspace,
    y: NDArray[np.float64],
    force: float,
    gap: float,
    o: NDArray[np.float64],
) -> None:
    """Curvature from equilibrium, then shape, base angle, slider and tip place (equations 7.1 to 7.7)."""
    recover_shape(p, c, k, w, mesh, v, y, force, o)
    cells = len(mesh.edges) - 1
    half = cells // 2
    psi_s = v.M_edges[half]
    P1, P2 = p.LA * math.cos(y[0]) - p.d, p.LA * math.sin(y[0])
    # the crank tip lies off the centre line where the joint gives way
    Z1, Z2 = v.F1_edges[half] - gap * math.sin(psi_s), v.F2_edges[half] + gap * math.cos(psi_s)
    radial = Z1 * math.cos(psi_s) + Z2 * math.sin(psi_s)
    ds = 0.5 * (P1 * P1 + P2 * P2 - Z1 * Z1 - Z2 * Z2) / radial
    Z1, Z2 = Z1 + ds * math.cos(psi_s), Z2 + ds * math.sin(psi_s)
    q2 = math.pi + math.atan2(-P2, -P1) - math.atan2(Z2, Z1)
    tip_1, tip_2 = v.F1_edges[cells], v.F2_edges[cells]
    o[2], o[3] = q2, c.s + ds
    o[4] = p.d + math.cos(q2) * tip_1 - math.sin(q2) * tip_2
    o[5] = math.sin(q2) * tip_1 + math.cos(q2) * tip_2
    o[6] = tip_2
    o[16] = abs(math.hypot(Z1, Z2) - math.hypot(P1, P2))


@inlined
def _tip_loads(
    p: Parameters, k: Contact, w: Workspace, y: NDArray[np.float64], gravity_1: float, gravity_2: float
) -> tuple[float, float, float]:
    """Inertia and gravity force of the tip body (frame B) and its moment about P (equation 7.2)."""
    n, t, e = p.n, p.tables, p.tip_offset
    end = len(t.edges) - 1
    slope_rate = slope_acceleration = W_rate = F_rate = W_acceleration = F_acceleration = 0.0
    for i in range(n):
        rate, acceleration = y[n + 2 + i], w.acceleration[i + 2]
        slope_rate += t.end_dphi[i] * rate
        slope_acceleration += t.end_dphi[i] * acceleration
        W_rate += t.end_phi[i] * rate
        W_acceleration += t.end_phi[i] * acceleration
        F_rate += w.f_edges[end, i] * rate
        F_acceleration += w.f_edges[end, i] * acceleration
    angle, angle_1, angle_2 = tangent_angle(w.end[0], p.exact_geometry)
    ec, es = e * math.cos(angle), e * math.sin(angle)
    turn = angle_1 * slope_rate
    turn_rate = angle_1 * slope_acceleration + angle_2 * slope_rate**2
    x, W = p.L - w.F_edges[end] + ec, w.end[1] + es
    x_rate, y_rate = -F_rate - es * turn, W_rate + ec * turn
    x_acceleration = -F_acceleration - w.H_edges[end] - es * turn_rate - ec * turn**2
    y_acceleration = W_acceleration + ec * turn_rate - es * turn**2
    a1 = x_acceleration - w.acceleration[1] * W - k.q2_rate**2 * x - 2.0 * k.q2_rate * y_rate - gravity_1
    a2 = y_acceleration + w.acceleration[1] * x - k.q2_rate**2 * W + 2.0 * k.q2_rate * x_rate - gravity_2
    f1, f2 = -p.tip_mass * a1, -p.tip_mass * a2
    return f1, f2, x * f2 - W * f1 - p.tip_inertia * (w.acceleration[1] + turn_rate)


@inlined
def _slider_moment(p: Parameters, c: Slider, k: Contact, w: Workspace, y: NDArray[np.float64]) -> tuple[float, float]:
    """Moment (N m) of a slider with rotary inertia on the follower and the tangential force it brings (equation 7.3)."""
    if p.slider_inertia == 0.0:
        return 0.0, 0.0
    turn_rate = k.d0
    for a in range(p.n + 2):
        turn_rate += w.D[a] * w.acceleration[a]
    moment = -p.slider_inertia * turn_rate
    angle_1 = tangent_angle(c.slope, p.exact_geometry)[1]
    return moment, -moment * angle_1 * c.curvature / k.normal


@inlined
def _at(mesh: Tables, values: NDArray[np.float64], x: float, v: Workspace) -> float:
    """The polynomial through a cell's points, at x."""
    cell = find_cell(mesh.edges, x)
    length = mesh.edges[cell + 1] - mesh.edges[cell]
    partial_weights((x - mesh.edges[cell]) / length, length, v.weights[0], v.weights[1], v.weights[2])
    total = 0.0
    for j in range(POINTS):
        total += v.weights[1, j] * values[cell * POINTS + j]
    return total
