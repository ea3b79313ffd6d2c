"""Observables of a state, directly from the shapes (thesis/DERIVATION.md, section 6)."""

import math
from typing import Any

from quickreturn.reference_model.arrays import Array
from quickreturn.reference_model.columns import PLACES
from quickreturn.reference_model.native.compilation import inlined, inner
from quickreturn.reference_model.state import BY_DRIVE, DISSIPATED, State
from quickreturn.reference_model.thesis.dynamics import gravity_in_b
from quickreturn.reference_model.thesis.kinematics import Contact, Slider, tangent_angle
from quickreturn.reference_model.thesis.parameters import POINTS, ThesisParameters, ThesisWorkspace, find_cell
from quickreturn.reference_model.tip import tool_force

tool = inner(tool_force)


@inlined
def observe(p: ThesisParameters, place: Slider, k: Contact, w: ThesisWorkspace, y: State, force: float, drive: float, row: Any) -> None:
    """Fill a row of `reference_model.columns.ROW`.

    Args:
        p: parameters.
        place: the slider.
        k: its contact.
        w: workspace after the evaluation of the state.
        y: the state.
        force: slider force, N.
        drive: torque of the drive, N m.
        row: the row.
    """
    n = p.n
    row.crank_angle, row.crank_speed, row.follower_angle, row.slider_position = y.q[0], y.u[0], place.q2, place.s
    row.follower_rate, row.follower_acceleration = k.q2_rate, w.acceleration[1]
    end = len(p.tables.edges) - 1
    tip_1, tip_2 = p.L - w.F_edges[end], w.end[1]
    cosine, sine = math.cos(place.q2), math.sin(place.q2)
    row.tip_x, row.tip_y, row.tip_deflection = p.d + cosine * tip_1 - sine * tip_2, sine * tip_1 + cosine * tip_2, tip_2
    row.tip_acceleration = tip_acceleration(p, k, w, y.eta_rate)
    row.slider_force, row.crank_torque = force, drive
    energies(p, place, k, w, y, row)
    bearing_forces(p, place, k, w, y, force, row)
    for gauge in range(3):
        curvature = 0.0
        for i in range(n):
            curvature += curvature_of_shape(p, i, p.gauges[gauge]) * y.eta[i]
        row.strains[gauge] = p.extreme_fibre * curvature
    end_moments(p, place, k, w, y.eta_rate, row)
    axial_forces(p, place, k, w, y, force, row)
    row.moment_slider = p.EI * place.curvature
    row.moment_inboard = row.moment_slider - p.slider_inertia * _turning_of_slider(p, k, w)
    for point in range(PLACES):
        deflection = moment = 0.0
        for i in range(n):
            deflection += p.shape_places[point, i] * y.eta[i]
            moment += p.moment_places[point, i] * y.eta[i]
        row.shapes[point], row.moments[point] = deflection, moment
    # only round-off is left of it
    row.constraint_gap = abs(
        math.sqrt(place.x**2 + place.W**2) - math.sqrt((p.LA * math.cos(y.q[0]) - p.d) ** 2 + (p.LA * math.sin(y.q[0])) ** 2)
    )


@inner
def curvature_of_shape(p: ThesisParameters, i: int, x: float) -> float:
    """phi_i'' at x, for the strains (equation 6.8)."""
    cell = find_cell(p.shape_edges, x)
    length = p.shape_edges[cell + 1] - p.shape_edges[cell]
    u = (x - p.shape_edges[cell]) / length
    value = 0.0
    for power in range(p.shape_coefficients.shape[1] - 1, 1, -1):
        value = value * u + power * (power - 1) * p.shape_coefficients[cell, power, i]
    return value / length**2


@inner
def tip_acceleration(p: ThesisParameters, k: Contact, w: ThesisWorkspace, eta_rate: Array) -> float:
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


@inner
def bearing_forces(p: ThesisParameters, place: Slider, k: Contact, w: ThesisWorkspace, y: State, force: float, row: Any) -> None:
    """To the row: forces of the ground on base and crank in frame N, by Newton's law for follower and crank (equations 6.9 to 6.11)."""
    cosine, sine = math.cos(place.q2), math.sin(place.q2)
    F1, F2 = _slider_on_follower(p, place, k, w, force)
    p1, p2 = _rate_of_momentum(p, k, w, y.eta_rate)
    p1, p2 = p1 - F1, p2 - F2
    mass, turning, square = p.rhoA * p.L + p.tip_mass, p.crank_moment * w.acceleration[0], p.crank_moment * y.u[0] ** 2
    c1, c2 = F1 - turning * place.a2 - square * place.a1, F2 + turning * place.a1 - square * place.a2
    acting, h1, h2 = tool(y.q[0], p.force_1, p.force_2, p.force_begin, p.force_span, p.force_ramp, p.force_table)
    row.pivot_force_x = cosine * p1 - sine * p2 - mass * p.gravity_1 - acting * h1
    row.pivot_force_y = sine * p1 + cosine * p2 - mass * p.gravity_2 - acting * h2
    row.crank_force_x = cosine * c1 - sine * c2 - p.crank_mass * p.gravity_1
    row.crank_force_y = sine * c1 + cosine * c2 - p.crank_mass * p.gravity_2


@inlined
def _slider_on_follower(p: ThesisParameters, place: Slider, k: Contact, w: ThesisWorkspace, force: float) -> tuple[float, float]:
    """The slider's force on the follower in frame B, N: along n, and with rotary inertia along t (equation 6.9)."""
    along = 0.0
    if p.slider_inertia > 0.0:
        bend = tangent_angle(place.slope, p.exact_geometry)[1] * place.curvature
        along = p.slider_inertia * _turning_of_slider(p, k, w) * bend / k.normal**2
    across = force / k.normal
    return along * place.t1 - across * place.slope, along * place.slope + across * place.t1


@inlined
def _turning_of_slider(p: ThesisParameters, k: Contact, w: ThesisWorkspace) -> float:
    """Angular acceleration of the slider, rad/s^2 (equation 3.9); 0 without rotary inertia."""
    turning = 0.0
    if p.slider_inertia > 0.0:
        turning = k.d0
        for a in range(p.n + 2):
            turning += w.D[a] * w.acceleration[a]
    return turning


@inner
def end_moments(p: ThesisParameters, place: Slider, k: Contact, w: ThesisWorkspace, eta_rate: Array, row: Any) -> None:
    """To the row: bending moments that base block and tip body require (equations 6.12 and 6.13), without a torque on the base."""
    q2_acceleration, damped = w.acceleration[1], 0.0
    for point in range(len(p.tables.x)):
        x = p.tables.x[point] - w.F[point]
        damped += p.tables.weights[point] * (x * w.W_rate[point] + w.W[point] * w.F_rate[point])
    row.moment_base = p.base_inertia * q2_acceleration + p.base_damping * k.q2_rate - p.beam_damping * damped
    ec, es, a1, a2, turning = _tip_body(p, k, w, eta_rate)
    gravity_1, gravity_2 = gravity_in_b(p, place.q2)
    lever = ec * (a2 - gravity_2) - es * (a1 - gravity_1)
    row.moment_tip = -p.tip_inertia * (q2_acceleration + turning) - p.tip_mass * lever


@inner
def _rate_of_momentum(p: ThesisParameters, k: Contact, w: ThesisWorkspace, eta_rate: Array) -> tuple[float, float]:
    """Rate of momentum of beam and tip body in frame B, N: integrals of (4.3) and (4.8), with the accelerations and without gravity."""
    t = p.tables
    total_1 = total_2 = 0.0
    for point in range(len(t.x)):
        a1, a2 = _acceleration(p, k, w, point)
        total_1 += p.rhoA * t.weights[point] * a1
        total_2 += p.rhoA * t.weights[point] * a2
    _, _, a1, a2, _ = _tip_body(p, k, w, eta_rate)
    return total_1 + p.tip_mass * a1, total_2 + p.tip_mass * a2


@inlined
def _acceleration(p: ThesisParameters, k: Contact, w: ThesisWorkspace, point: int) -> tuple[float, float]:
    """Acceleration of a point of the beam in frame B, m/s^2 (equation 4.3, with the accelerations and without gravity)."""
    x, W = p.tables.x[point] - w.F[point], w.W[point]
    a1 = -w.H[point] - 2.0 * k.q2_rate * w.W_rate[point] - k.q2_rate**2 * x - w.acceleration[1] * W
    a2 = -2.0 * k.q2_rate * w.F_rate[point] - k.q2_rate**2 * W + w.acceleration[1] * x
    for i in range(p.n):
        a1 -= w.f[point, i] * w.acceleration[i + 2]
        a2 += p.tables.phi[point, i] * w.acceleration[i + 2]
    return a1, a2


@inner
def axial_forces(p: ThesisParameters, place: Slider, k: Contact, w: ThesisWorkspace, y: State, force: float, row: Any) -> None:
    """To the row: normal forces in the arm, the part of the outboard forces along the tangent (equation 6.14)."""
    t, cell = p.tables, find_cell(p.tables.edges, place.s)
    gravity_1, gravity_2 = gravity_in_b(p, place.q2)
    beam_1 = outboard_1 = outboard_2 = 0.0
    for point in range(len(t.x)):
        a1, a2 = _acceleration(p, k, w, point)
        load_1 = p.rhoA * (gravity_1 - a1) + p.beam_damping * w.F_rate[point]
        load_2 = p.rhoA * (gravity_2 - a2) - p.beam_damping * w.W_rate[point]
        beyond = t.weights[point]
        if point < (cell + 1) * POINTS:
            beyond -= w.weights[0, point - cell * POINTS] if point >= cell * POINTS else t.weights[point]
        beam_1 += t.weights[point] * load_1
        outboard_1, outboard_2 = outboard_1 + beyond * load_1, outboard_2 + beyond * load_2
    _, _, a1, a2, _ = _tip_body(p, k, w, y.eta_rate)
    acting, h1, h2 = tool(y.q[0], p.force_1, p.force_2, p.force_begin, p.force_span, p.force_ramp, p.force_table)
    cosine, sine = math.cos(place.q2), math.sin(place.q2)
    tip_1 = p.tip_mass * (gravity_1 - a1) + acting * (cosine * h1 + sine * h2)
    tip_2 = p.tip_mass * (gravity_2 - a2) + acting * (cosine * h2 - sine * h1)
    F1, F2 = _slider_on_follower(p, place, k, w, force)
    angle = tangent_angle(w.end[0], p.exact_geometry)[0]
    row.axial_base, row.axial_tip = beam_1 + tip_1 + F1, math.cos(angle) * tip_1 + math.sin(angle) * tip_2
    row.axial_slider = (place.t1 * (outboard_1 + tip_1) + place.slope * (outboard_2 + tip_2)) / k.normal
    row.axial_inboard = row.axial_slider + (place.t1 * F1 + place.slope * F2) / k.normal


@inner
def _tip_body(p: ThesisParameters, k: Contact, w: ThesisWorkspace, eta_rate: Array) -> tuple[float, float, float, float, float]:
    """The tip body in frame B (equations 4.7 and 4.8, with the accelerations and without gravity).

    Returns:
        Its centre from x = L (m), the centre's acceleration (m/s^2), and its angular acceleration relative to the base (rad/s^2).
    """
    t, n, end, e, q2_acceleration = p.tables, p.n, len(p.tables.edges) - 1, p.tip_offset, w.acceleration[1]
    angle, angle_1, angle_2 = tangent_angle(w.end[0], p.exact_geometry)
    ec, es = e * math.cos(angle), e * math.sin(angle)
    slope_rate = slope_acceleration = W_rate = F_rate = W_acceleration = F_acceleration = 0.0
    for i in range(n):
        slope_rate += t.end_dphi[i] * eta_rate[i]
        slope_acceleration += t.end_dphi[i] * w.acceleration[i + 2]
        W_rate += t.end_phi[i] * eta_rate[i]
        W_acceleration += t.end_phi[i] * w.acceleration[i + 2]
        F_rate += w.f_edges[end, i] * eta_rate[i]
        F_acceleration += w.f_edges[end, i] * w.acceleration[i + 2]
    turn, turning = angle_1 * slope_rate, angle_1 * slope_acceleration + angle_2 * slope_rate**2
    x, y, x_rate, y_rate = p.L - w.F_edges[end] + ec, w.end[1] + es, -F_rate - es * turn, W_rate + ec * turn
    a1 = -w.H_edges[end] - F_acceleration - es * turning - ec * turn**2
    a2 = W_acceleration + ec * turning - es * turn**2
    a1 -= 2.0 * k.q2_rate * y_rate + k.q2_rate**2 * x + q2_acceleration * y
    a2 += 2.0 * k.q2_rate * x_rate - k.q2_rate**2 * y + q2_acceleration * x
    return ec, es, a1, a2, turning


@inner
def energies(p: ThesisParameters, place: Slider, k: Contact, w: ThesisWorkspace, y: State, row: Any) -> None:
    """To the row: kinetic, strain and gravity energy, dissipated energy and drive work (equations 6.4 to 6.6)."""
    n = p.n
    kinetic = strain = 0.0
    for a in range(n + 2):
        rate_a = k.q2_rate if a == 1 else (y.u[0] if a == 0 else y.eta_rate[a - 2])
        for b in range(n + 2):
            kinetic += 0.5 * rate_a * w.M[a, b] * (k.q2_rate if b == 1 else (y.u[0] if b == 0 else y.eta_rate[b - 2]))
    for i in range(n):
        for j in range(n):
            strain += 0.5 * y.eta[i] * p.stiffness[i, j] * y.eta[j]
    moment_1 = moment_2 = 0.0  # first moments of beam and tip body about P, in frame B
    for point in range(len(p.tables.x)):
        dm = p.rhoA * p.tables.weights[point]
        moment_1 += dm * (p.tables.x[point] - w.F[point])
        moment_2 += dm * w.W[point]
        if p.exact_geometry:
            curvature = 0.0
            for i in range(n):
                curvature += p.tables.ddphi[point, i] * y.eta[i]
            slope2 = w.slope[point] ** 2
            strain += 0.5 * p.EI * p.tables.weights[point] * curvature**2 * slope2 / (1.0 - slope2)
    angle = tangent_angle(w.end[0], p.exact_geometry)[0]
    end = len(p.tables.edges) - 1
    moment_1 += p.tip_mass * (p.L - w.F_edges[end] + p.tip_offset * math.cos(angle))
    moment_2 += p.tip_mass * (w.end[1] + p.tip_offset * math.sin(angle))
    row.kinetic_energy, row.strain_energy, row.dissipated_energy, row.drive_work = kinetic, strain, y.work[DISSIPATED], y.work[BY_DRIVE]
    gravity = 0.0
    if p.has_gravity:
        cosine, sine = math.cos(place.q2), math.sin(place.q2)
        mass = p.rhoA * p.L + p.tip_mass
        gravity -= p.gravity_1 * (mass * p.d + cosine * moment_1 - sine * moment_2 + p.crank_moment * math.cos(y.q[0]))
        gravity -= p.gravity_2 * (sine * moment_1 + cosine * moment_2 + p.crank_moment * math.sin(y.q[0]))
    row.gravity_energy = gravity
