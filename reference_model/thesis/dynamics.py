"""Equations of motion by projection onto the free speeds, compiled (thesis/DERIVATION.md, sections 4 to 6).

The state (equation 6.7) has no place of the slider: the loop is closed at every evaluation, so there is no constraint to drift from and no
multiplier to solve for.
"""

import math

from quickreturn.reference_model.arrays import Array
from quickreturn.reference_model.compiled_drive import given_torque, prescribed_acceleration
from quickreturn.reference_model.native.compilation import inlined, inner
from quickreturn.reference_model.state import State
from quickreturn.reference_model.thesis.kinematics import Contact, Slider, centre_line, constraint_row, place_slider, tangent_angle
from quickreturn.reference_model.thesis.parameters import ThesisParameters, ThesisWorkspace
from quickreturn.reference_model.tip import tool_force

tool = inner(tool_force)


@inner
def assemble(
    p: ThesisParameters,
    c: Slider,
    k: Contact,
    q1: float,
    q1_rate: float,
    eta: Array,
    eta_rate: Array,
    w: ThesisWorkspace,
) -> None:
    """To `M` and `Q`: mass matrix and force (applied minus inertia) for (q1, q2, eta), without the constraint (equations 4.1 to 4.13)."""
    _push_tip(p, q1, c.q2, w)
    for a in range(p.n + 2):
        w.Q[a] = w.tool[a]
        for b in range(p.n + 2):
            w.M[a, b] = 0.0
    gravity_1, gravity_2 = gravity_in_b(p, c.q2)
    _add_beam(p, k.q2_rate, gravity_1, gravity_2, eta, eta_rate, w)
    if p.tip_mass > 0.0 or p.tip_inertia > 0.0:
        _add_tip(p, k.q2_rate, gravity_1, gravity_2, eta_rate, w)
    _add_crank_and_base(p, c, k.q2_rate, q1_rate, gravity_1, gravity_2, w)
    if p.slider_inertia > 0.0:
        for a in range(p.n + 2):
            w.Q[a] -= p.slider_inertia * w.D[a] * k.d0
            for b in range(a + 1):
                w.M[a, b] += p.slider_inertia * w.D[a] * w.D[b]
    for a in range(p.n + 2):
        for b in range(a):
            w.M[b, a] = w.M[a, b]


@inner
def gravity_in_b(p: ThesisParameters, q2: float) -> tuple[float, float]:
    """Gravity in frame B, m/s^2."""
    if not p.has_gravity:
        return 0.0, 0.0
    cosine, sine = math.cos(q2), math.sin(q2)
    return cosine * p.gravity_1 + sine * p.gravity_2, -sine * p.gravity_1 + cosine * p.gravity_2


@inner
def _add_beam(
    p: ThesisParameters,
    q2_rate: float,
    gravity_1: float,
    gravity_2: float,
    eta: Array,
    eta_rate: Array,
    w: ThesisWorkspace,
) -> None:
    """Inertia, gravity, damping and elasticity of the beam (lower triangle of M), equations 4.2 to 4.6."""
    t, n = p.tables, p.n
    ratio = p.beam_damping / p.rhoA  # damping acts on the rate relative to frame B: proportional to the beam's own mass matrix
    for i in range(n):
        force = 0.0
        for j in range(n):
            force -= p.stiffness[i, j] * eta[j] + ratio * p.mass_transverse[i, j] * eta_rate[j]
        w.Q[i + 2] += force
        for j in range(i + 1):
            w.M[i + 2, j + 2] += p.mass_transverse[i, j]
    for point in range(len(t.x)):
        dm = p.rhoA * t.weights[point]
        x, W = t.x[point] - w.F[point], w.W[point]
        # bias acceleration less gravity, equation 4.3
        a1 = -(q2_rate**2) * x - 2.0 * q2_rate * w.W_rate[point] - w.H[point] - gravity_1
        a2 = -(q2_rate**2) * W - 2.0 * q2_rate * w.F_rate[point] - gravity_2
        w.M[1, 1] += dm * (x * x + W * W)
        w.Q[1] -= dm * (a2 * x - a1 * W)
        damping = ratio * dm * w.F_rate[point]
        bend_2 = bend_1 = 0.0
        if p.exact_geometry:  # strain energy beyond the quadratic one, equation 4.6
            slope2 = w.slope[point] ** 2
            curvature = 0.0
            for i in range(n):
                curvature += t.ddphi[point, i] * eta[i]
            stretch = 1.0 / (1.0 - slope2)
            bend_2 = p.EI * t.weights[point] * curvature * slope2 * stretch
            bend_1 = p.EI * t.weights[point] * curvature * curvature * w.slope[point] * stretch * stretch
        for i in range(n):
            f, phi = w.f[point, i], t.phi[point, i]
            w.M[i + 2, 1] += dm * (W * f + x * phi)
            w.Q[i + 2] += dm * (a1 * f - a2 * phi) - damping * f - bend_2 * t.ddphi[point, i] - bend_1 * t.dphi[point, i]
            scaled = dm * f
            for j in range(i + 1):
                w.M[i + 2, j + 2] += scaled * w.f[point, j]


@inner
def _add_tip(p: ThesisParameters, q2_rate: float, gravity_1: float, gravity_2: float, eta_rate: Array, w: ThesisWorkspace) -> None:
    """Rigid body at the follower's end: its centre and its rotation, equations 4.7 to 4.9."""
    t, n, m, J, e = p.tables, p.n, p.tip_mass, p.tip_inertia, p.tip_offset
    end = len(t.edges) - 1
    slope, slope_rate, W, W_rate, F_rate = _end_fields(p, eta_rate, w)
    angle, angle_1, angle_2 = tangent_angle(slope, p.exact_geometry)
    ec, es = e * math.cos(angle), e * math.sin(angle)
    turn = angle_1 * slope_rate  # rotation rate relative to frame B
    turn_0 = angle_2 * slope_rate**2
    x, y = p.L - w.F_edges[end] + ec, W + es
    x_rate, y_rate = -F_rate - es * turn, W_rate + ec * turn
    a1 = -(q2_rate**2) * x - 2.0 * q2_rate * y_rate - w.H_edges[end] - es * turn_0 - ec * turn**2 - gravity_1
    a2 = -(q2_rate**2) * y + 2.0 * q2_rate * x_rate + ec * turn_0 - es * turn**2 - gravity_2
    w.M[1, 1] += m * (x * x + y * y) + J
    w.Q[1] -= m * (x * a2 - y * a1) + J * turn_0
    for i in range(n):
        rotation_i = angle_1 * t.end_dphi[i]
        p1, p2 = -w.f_edges[end, i] - es * rotation_i, t.end_phi[i] + ec * rotation_i
        w.M[i + 2, 1] += m * (x * p2 - y * p1) + J * rotation_i
        w.Q[i + 2] -= m * (p1 * a1 + p2 * a2) + J * rotation_i * turn_0
        for j in range(i + 1):
            rotation_j = angle_1 * t.end_dphi[j]
            product = p1 * (-w.f_edges[end, j] - es * rotation_j) + p2 * (t.end_phi[j] + ec * rotation_j)
            w.M[i + 2, j + 2] += m * product + J * rotation_i * rotation_j


@inner
def _push_tip(p: ThesisParameters, q1: float, q2: float, w: ThesisWorkspace) -> None:
    """To `tool`: generalised forces of the force on the tip, at x = L (equation 4.14)."""
    n, end = p.n, len(p.tables.edges) - 1
    acting, h1, h2 = tool(q1, p.force_1, p.force_2, p.force_begin, p.force_span, p.force_ramp, p.force_table)
    F1 = acting * (math.cos(q2) * h1 + math.sin(q2) * h2)
    F2 = acting * (math.cos(q2) * h2 - math.sin(q2) * h1)
    w.tool[0] = 0.0
    w.tool[1] = (p.L - w.F_edges[end]) * F2 - w.end[1] * F1
    for i in range(n):
        w.tool[i + 2] = p.tables.end_phi[i] * F2 - w.f_edges[end, i] * F1


@inner
def _end_fields(p: ThesisParameters, eta_rate: Array, w: ThesisWorkspace) -> tuple[float, float, float, float, float]:
    """W', its rate, W, its rate and the rate of F at x = L."""
    t = p.tables
    end = len(t.edges) - 1
    slope_rate = W_rate = F_rate = 0.0
    for i in range(p.n):
        slope_rate += t.end_dphi[i] * eta_rate[i]
        W_rate += t.end_phi[i] * eta_rate[i]
        F_rate += w.f_edges[end, i] * eta_rate[i]
    return w.end[0], slope_rate, w.end[1], W_rate, F_rate


@inner
def _add_crank_and_base(
    p: ThesisParameters, c: Slider, q2_rate: float, q1_rate: float, gravity_1: float, gravity_2: float, w: ThesisWorkspace
) -> None:
    """Crank with the slider's mass, its drive, and the base block, equations 4.10 and 4.11."""
    w.M[0, 0] += p.crank_inertia
    w.M[1, 1] += p.base_inertia
    w.Q[0] += given_torque(p, q1_rate)[0] - p.crank_damping * q1_rate + p.crank_moment * (gravity_2 * c.a1 - gravity_1 * c.a2)
    w.Q[1] -= p.base_damping * q2_rate


@inlined
def project(p: ThesisParameters, k: Contact, prescribed: float, w: ThesisWorkspace) -> bool:
    """To `acceleration`: those of (q1, q2, eta) by projection (equations 5.1 to 5.4); that of q1 may be `prescribed`.

    False for an indefinite projected mass matrix.
    """
    n = p.n
    first = 0 if p.crank_is_free else 1
    size = n + 1 - first
    for a in range(size):
        A = _full_index(a + first)
        to_base = w.M[A, 1] + w.C[A] * w.M[1, 1]
        w.rhs[a] = w.Q[A] + w.C[A] * w.Q[1] - to_base * k.c0
        if prescribed != 0.0:
            w.rhs[a] -= (w.M[A, 0] + w.C[A] * w.M[1, 0] + to_base * w.C[0]) * prescribed
        for b in range(a + 1):
            B = _full_index(b + first)
            w.reduced[a, b] = w.M[A, B] + w.C[A] * w.M[1, B] + to_base * w.C[B]
    if not factorize(w.reduced, size):
        return False
    substitute(w.reduced, w.rhs, size)
    w.acceleration[0] = w.rhs[0] if p.crank_is_free else prescribed
    q2_acceleration = k.c0 + w.C[0] * w.acceleration[0]
    for i in range(n):
        w.acceleration[i + 2] = w.rhs[i + 1 - first]
        q2_acceleration += w.C[i + 2] * w.acceleration[i + 2]
    w.acceleration[1] = q2_acceleration
    return True


@inner
def _full_index(free: int) -> int:
    """Index among (q1, q2, eta) of a speed with the given index among (q1, eta)."""
    return 0 if free == 0 else free + 1


@inner
def factorize(A: Array, size: int) -> bool:
    """Cholesky's factor in place of the lower triangle of A; False if A is not positive definite."""
    for i in range(size):
        for j in range(i + 1):
            total = A[i, j]
            for m in range(j):
                total -= A[i, m] * A[j, m]
            if i == j:
                if not total > 0.0:
                    return False
                A[i, i] = math.sqrt(total)
            else:
                A[i, j] = total / A[j, j]
    return True


@inner
def substitute(A: Array, b: Array, size: int) -> None:
    """Solve L L^T x = b in place of b, with the factor L that `factorize` wrote into A."""
    for i in range(size):
        total = b[i]
        for m in range(i):
            total -= A[i, m] * b[m]
        b[i] = total / A[i, i]
    for i in range(size - 1, -1, -1):
        total = b[i]
        for m in range(i + 1, size):
            total -= A[m, i] * b[m]
        b[i] = total / A[i, i]


@inner
def reactions(p: ThesisParameters, c: Slider, k: Contact, q1_rate: float, w: ThesisWorkspace) -> tuple[float, float]:
    """Slider force (N, normal on the follower, equation 6.1) and torque of the drive (N m, equation 6.2) after `project`."""
    row_1, row_2 = -w.Q[0], -w.Q[1]
    for a in range(p.n + 2):
        row_1 += w.M[0, a] * w.acceleration[a]
        row_2 += w.M[1, a] * w.acceleration[a]
    multiplier = row_2 / k.B0
    # n . LA a2 = C_0 B0; the opposite of the follower's force acts on the crank
    drive = given_torque(p, q1_rate)[0] if p.crank_is_free else row_1 + multiplier * w.C[0] * k.B0
    return multiplier * k.normal, drive


@inner
def dissipation(p: ThesisParameters, q1_rate: float, q2_rate: float, eta_rate: Array, w: ThesisWorkspace) -> float:
    """Power that all dampings dissipate, W, equation 4.12."""
    power = p.crank_damping * q1_rate**2 + p.base_damping * q2_rate**2
    if p.beam_damping > 0.0:
        total = 0.0
        for point in range(len(p.tables.x)):
            total += p.tables.weights[point] * (w.F_rate[point] ** 2 + w.W_rate[point] ** 2)
        power += p.beam_damping * total
    return power


@inlined
def evaluate(p: ThesisParameters, w: ThesisWorkspace, y: State) -> tuple[bool, Slider, Contact]:
    """To `w`: closed loop, equations and accelerations of the state y. Returns whether the state is possible, its slider, its contact."""
    q1, eta, q1_rate, eta_rate = y.q[0], y.eta, y.u[0], y.eta_rate
    none = Contact(False, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0)
    regular = centre_line(p.tables, p.exact_geometry, eta, eta_rate, w)
    if not regular:
        return False, Slider(False, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0), none
    c = place_slider(p, q1, eta, w)
    w.watched[0] = c.s
    if not (c.closes and abs(c.slope) < 1.0 and abs(w.end[0]) < 1.0):
        return False, c, none
    k = constraint_row(p, c, q1_rate, eta, eta_rate, w)
    if not k.regular:
        return False, c, k
    assemble(p, c, k, q1, q1_rate, eta, eta_rate, w)
    return project(p, k, prescribed_acceleration(p, q1, q1_rate), w), c, k
