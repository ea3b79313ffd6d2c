"""Partial velocities, bias accelerations, mass matrix and forces of beam and bodies (DERIVATION.md, section 4)."""

import math

from quickreturn.reference_model import joint
from quickreturn.reference_model.arrays import Array
from quickreturn.reference_model.compiled_drive import given_torque
from quickreturn.reference_model.joint import BASE, ELIMINATED, ROLLERS
from quickreturn.reference_model.motion.layout import (
    BASE_TURN,
    CRANK_TURN,
    SLIDER_TURN,
    TIP_1,
    TIP_2,
    TIP_TURN,
    BeamParameters,
    BeamTables,
    BeamWorkspace,
)
from quickreturn.reference_model.motion.plane import cross, dot, point
from quickreturn.reference_model.motion.spring import at_spring, load_spring, spring_stiffness
from quickreturn.reference_model.native.compilation import inlined, inner
from quickreturn.reference_model.native.simd import load, plus, spread, store, total
from quickreturn.reference_model.state import State
from quickreturn.reference_model.tip import STILL, tool_force

_tool_force, friction_share, joint_force = inner(tool_force), inner(joint.friction_share), inner(joint.joint_force)


@inner
def acting_force(p: BeamParameters, crank_angle: float) -> tuple[float, complex]:
    """Fraction of the force on the tip that acts, and the force in full, N, in its frame (equations 4.9 and 4.11)."""
    share, one, other = _tool_force(crank_angle, p.force_1, p.force_2, p.force_begin, p.force_span, p.force_ramp, p.force_table)
    return share, complex(one, other)


@inner
def relative_velocities(p: BeamParameters, t: BeamTables, w: BeamWorkspace, y: State) -> None:
    """To `relative`: velocities of the points relative to the base frame, which the beam damping opposes."""
    s_rate = w.facts.s_rate if t.moves else 0.0
    for j in range(0, len(w.relative), 4):
        velocity = plus(spread(0.0), s_rate, load(w.Y, j))
        for i in range(p.n):
            velocity = plus(velocity, y.eta_rate[i], load(w.U[i], j))
        store(w.relative, j, velocity)


@inner
def partial_velocities(p: BeamParameters, t: BeamTables, w: BeamWorkspace, slider_point: int) -> None:
    """To `V`: partial velocities of the beam's points and of all bodies for every speed (equations 4.1 and 4.2)."""
    n, N = p.n, t.points
    end, bodies, arm = t.tip, 2 * N, w.facts.tip_arm
    for k in range(p.speeds):
        c, sigma = w.c[k], w.sigma[k]
        row = w.V[k]
        for j in range(0, N, 4):  # Y is zero for shapes that do not move
            real = imaginary = spread(0.0)
            if 0 < k <= n:
                real, imaginary = load(w.U[k - 1], j), load(w.U[k - 1], N + j)
            store(row, j, plus(plus(real, sigma, load(w.Y, j)), -c, load(w.z, N + j)))
            store(row, N + j, plus(plus(imaginary, sigma, load(w.Y, N + j)), c, load(w.z, j)))
        tip, slider = c + sigma * w.psi_s[end], c + sigma * w.facts.angle_by_s
        if 0 < k <= n:
            tip += w.psi_i[k - 1, end]
            slider += w.psi_i[k - 1, slider_point]
        w.V[k, bodies + TIP_1] = w.V[k, end] - arm.imag * tip
        w.V[k, bodies + TIP_2] = w.V[k, N + end] + arm.real * tip
        w.V[k, bodies + TIP_TURN] = tip
        w.V[k, bodies + BASE_TURN] = c
        w.V[k, bodies + SLIDER_TURN] = slider
        w.V[k, bodies + CRANK_TURN] = 1.0 if k == 0 else 0.0


@inner
def bias_accelerations(p: BeamParameters, t: BeamTables, w: BeamWorkspace, y: State) -> None:
    """To `bias`: accelerations of points and bodies at constant speeds, less gravity (4.3 and 4.4). Also the force on the tip (4.9)."""
    n, N, f = p.n, t.points, w.facts
    _push_tip(p, t, w, y)
    f.gravity = f.frame.conjugate() * complex(p.gravity_1, p.gravity_2)
    g1, g2 = f.gravity.real, f.gravity.imag
    q2_0, s_0 = f.q2_bias, f.s_bias if t.moves else 0.0
    for j in range(N):
        w.bias[j] = w.A[j] + s_0 * w.Y[j] - q2_0 * w.z[N + j] - g1
    for j in range(N):
        w.bias[N + j] = w.A[N + j] + s_0 * w.Y[N + j] + q2_0 * w.z[j] - g2
    end, bodies = t.tip, 2 * N
    turn_0 = q2_0 + w.gamma[end] + w.psi_s[end] * s_0
    centre = point(w.bias, end, N) + (1j * turn_0 - w.turn[end] ** 2) * f.tip_arm
    w.bias[bodies + TIP_1], w.bias[bodies + TIP_2] = centre.real, centre.imag
    w.bias[bodies + TIP_TURN] = turn_0
    w.bias[bodies + BASE_TURN] = q2_0
    slider = q2_0 + f.angle_by_s * f.s_bias
    for i in range(n):
        slider += 2.0 * w.angle_at_slider_s[i] * f.s_rate * y.eta_rate[i]
        slider += w.angle_at_slider_ss[i] * f.s_rate**2 * y.eta[i]
    w.bias[bodies + SLIDER_TURN] = slider
    w.bias[bodies + CRANK_TURN] = 0.0


@inlined
def _push_tip(p: BeamParameters, t: BeamTables, w: BeamWorkspace, y: State) -> None:
    """To the facts: force on the tip with the friction of the tool's slide, and the power that this dissipates (equations 4.9 to 4.12)."""
    f = w.facts
    f.tip_force, f.slide_loss = 0j, 0.0
    if p.force_1 != 0.0 or p.force_2 != 0.0 or len(p.force_table) > 0:
        acting, force = acting_force(p, y.q[0])
        if p.force_follows == 0:
            f.tip_force = acting * f.frame.conjugate() * force
        else:
            f.tip_force = acting * point(w.e, t.tip, t.points) * force
    if p.slide_friction > 0.0:
        velocity = _tip_velocity(t, w)
        speed = math.sqrt(dot(velocity, velocity)) + STILL * p.slide_speed
        resistance = p.slide_friction * friction_share(speed, p.slide_speed) / speed
        f.tip_force -= resistance * velocity
        f.slide_loss = resistance * dot(velocity, velocity)


@inlined
def _tip_velocity(t: BeamTables, w: BeamWorkspace) -> complex:
    """Velocity of x = L, m/s."""
    return point(w.relative, t.tip, t.points) + 1j * w.facts.q2_rate * point(w.z, t.tip, t.points)


@inner
def assemble(p: BeamParameters, t: BeamTables, w: BeamWorkspace, y: State) -> None:
    """Mass matrix (lower triangle) and generalised forces Q for the speeds (equations 4.5 to 4.7, 5.15)."""
    n, m, N, f = p.n, p.speeds, t.points, w.facts
    bodies, size = 2 * N, len(w.mass)
    for j in range(2 * N):
        w.mass[j] = p.rhoA * w.dx[j]
    w.mass[bodies + TIP_1] = w.mass[bodies + TIP_2] = p.tip_mass
    w.mass[bodies + TIP_TURN], w.mass[bodies + BASE_TURN] = p.tip_inertia, p.base_inertia
    w.mass[bodies + SLIDER_TURN], w.mass[bodies + CRANK_TURN] = p.slider_inertia, p.crank_inertia
    for j in range(size):
        w.force[j] = w.mass[j] * w.bias[j]
    moment = 0.0
    if p.beam_damping > 0.0:
        # it opposes the velocities relative to the base frame, so that turning with the base costs no work
        for j in range(2 * N):
            w.force[j] += p.beam_damping * w.dx[j] * w.relative[j]
        for j in range(N):
            moment += p.beam_damping * w.dx[j] * (w.z[j] * w.relative[N + j] - w.z[N + j] * w.relative[j])
    moment -= pivot_torque(p, w)
    end = t.tip
    w.force[end] -= f.tip_force.real
    w.force[N + end] -= f.tip_force.imag
    if p.is_held > 0:
        load_spring(t, w)
    strain_energy_by_s = 0.0
    for i in range(n):
        strain_energy_by_s += 0.5 * w.squares_s[i] * y.eta[i] ** 2
    if p.bending_damping > 0.0:
        _damp_bending(p, t, w)
    for k in range(m):
        w.Q[k] = moment * w.c[k] - strain_energy_by_s * w.sigma[k] - _dot(w.V[k], w.force, size)
        if 0 < k <= n:
            w.Q[k] -= w.squares[k - 1] * y.eta[k - 1]
        if p.bending_damping > 0.0:
            w.Q[k] -= _bending_force(t, w, k, n)
        for j in range(0, size, 4):
            store(w.weighted, j, plus(spread(0.0), load(w.mass, j), load(w.V[k], j)))
        for i in range(k + 1):
            w.M[k, i] = _dot(w.weighted, w.V[i], size)
        if 0 < k <= n:
            w.M[k, k] += p.added_inertia[k - 1]
    torque, f.torque_slope = given_torque(p, y.u[0])
    w.Q[0] += torque - p.crank_damping * y.u[0] + crank_weight(p, w)


@inner
def pivot_torque(p: BeamParameters, w: BeamWorkspace) -> float:
    """Torque by which damping and friction of the pivot P oppose the follower, N m (equations 4.7 and 5.14)."""
    rate = w.facts.q2_rate
    if p.base_friction == 0.0:
        return p.base_damping * rate
    return p.base_damping * rate + p.base_friction * friction_share(rate, p.base_friction_rate)


@inner
def _damp_bending(p: BeamParameters, t: BeamTables, w: BeamWorkspace) -> None:
    """To `curvature_rate` and `bending_load`: rates of the curvature, and forces of the material's damping (equation 4.10).

    Angles are differentiated as the polynomial through their values at a cell's Gauss points.
    """
    for cell in range(t.cells):
        first = cell * t.cell_size
        for j in range(t.cell_size):
            w.curvature_rate[first + j] = w.bending_load[first + j] = 0.0
        for i in range(t.gauss_points):
            rate = 0.0
            for j in range(t.gauss_points):
                if j != i:
                    rate += _slope_weight(t, i, j) * (w.turn[first + j] - w.turn[first + i])
            w.curvature_rate[first + i] = rate / w.length[cell]
            load = p.EI * p.bending_damping * t.weights[i] * w.curvature_rate[first + i]
            for j in range(t.gauss_points):
                if j != i:
                    w.bending_load[first + j] += _slope_weight(t, i, j) * load
                    w.bending_load[first + i] -= _slope_weight(t, i, j) * load


@inlined
def _slope_weight(t: BeamTables, i: int, j: int) -> float:
    """Weight of the value at Gauss point j in the slope at another point i, for a cell of unit length."""
    return t.lagrange[j] / (t.lagrange[i] * (t.u[i] - t.u[j]))


@inlined
def _bending_force(t: BeamTables, w: BeamWorkspace, k: int, n: int) -> float:
    """Generalised force of the material's damping for the speed k, sign reversed (equation 4.10)."""
    N = t.points
    force = 0.0
    for j in range(N):
        angle = w.sigma[k] * w.psi_s[j]
        if 0 < k <= n:
            angle += w.psi_i[k - 1, j]
        force += angle * w.bending_load[j]
    return force


@inlined
def crank_weight(p: BeamParameters, w: BeamWorkspace) -> float:
    """Moment of gravity on the crank about O, N m."""
    return p.crank_moment * cross(w.facts.arm, w.facts.gravity)


@inlined
def _dot(a: Array, b: Array, size: int) -> float:
    """Scalar product of two rows whose length is a multiple of eight, in two sums that do not wait for each other."""
    sums = others = spread(0.0)
    for j in range(0, size, 8):
        sums = plus(sums, load(a, j), load(b, j))
        others = plus(others, load(a, j + 4), load(b, j + 4))
    return total(sums) + total(others)


@inner
def highest_frequency(p: BeamParameters, t: BeamTables, w: BeamWorkspace) -> float:
    """Upper bound of the highest angular frequency (rad/s) of small vibrations about the present state; 0 if unknown (equation 5.9)."""
    n = p.n
    if p.knows_frequency == 0:
        return 0.0
    square = 0.0
    for k in range(n):
        square = max(square, w.squares[k] / (1.0 + p.added_inertia[k]))
    if p.is_held > 0:
        square += _square_of_spring(p, t, w)
    if p.first == 1:
        return math.sqrt(square)
    coupling = 0.0
    for k in range(1, n + 1):
        coupling += w.M[k, 0] ** 2 / (w.M[k, k] * w.M[0, 0])
    return math.sqrt(square / max(1.0 - coupling, 1e-6))


@inner
def _square_of_spring(p: BeamParameters, t: BeamTables, w: BeamWorkspace) -> float:
    """What the spring's present stiffness adds at most to the square of the highest frequency, rad^2/s^2."""
    square = 0.0
    for k in range(1, p.n + 1):
        square += dot(w.facts.spring_line, at_spring(w, w.V[k], t.points)) ** 2 / w.M[k, k]
    return spring_stiffness(w.facts.spring_length, p.spring) * square


@inner
def dissipation(p: BeamParameters, t: BeamTables, w: BeamWorkspace, y: State) -> float:
    """Power that all dampings and frictions dissipate, W (equation 4.7)."""
    N = t.points
    total = 0.0
    for j in range(N):
        total += w.dx[j] * (w.relative[j] * w.relative[j] + w.relative[N + j] * w.relative[N + j])
    power = p.crank_damping * y.u[0] ** 2 + pivot_torque(p, w) * w.facts.q2_rate + p.beam_damping * total
    if p.bending_damping > 0.0:
        for j in range(N):
            power += p.EI * p.bending_damping * w.dx[j] * w.curvature_rate[j] ** 2
    power += w.facts.friction * w.facts.s_rate + w.facts.slide_loss
    if p.is_held > 0:
        power += p.spring.damping * w.facts.spring_rate**2
    if p.constraint == ROLLERS:
        power += _loss_of_rollers(p, w.facts.gap, w.facts.gap_rate)
    return power


@inlined
def _loss_of_rollers(p: BeamParameters, gap: float, rate: float) -> float:
    """Power that the joint dissipates, W: that of its force, less that of the same rollers without loss."""
    force = joint_force(gap, rate, p.plus, p.minus, p.plus_from, p.minus_from, p.contact_loss, p.joint_damping)
    return rate * (force - joint_force(gap, 0.0, p.plus, p.minus, p.plus_from, p.minus_from, 0.0, 0.0))


@inner
def find_forces(p: BeamParameters, t: BeamTables, w: BeamWorkspace, y: State) -> None:
    """To the facts: the slider's force on the follower, and the torque of the drive, or the base's where its motion is prescribed."""
    f = w.facts
    moment = _moment_about_pivot(p, t, w)
    f.normal, f.slider_force, f.slider_moment, f.torque = 0.0, 0j, 0.0, moment
    if p.constraint != BASE:
        _slider_force(p, t, w, moment)
        f.torque = _drive_torque(p, w, y)


@inner
def _moment_about_pivot(p: BeamParameters, t: BeamTables, w: BeamWorkspace) -> float:
    """Moment about P (N m) that the motion of follower, base and tip body requires (equation 5.4).

    The beam damping acts between beam and base and drops out. Also, to `a`: accelerations of points and bodies, less gravity.
    """
    N, f = t.points, w.facts
    bodies, end = 2 * N, t.tip
    for j in range(0, len(w.a), 4):
        acceleration = load(w.bias, j)
        for k in range(p.speeds):
            acceleration = plus(acceleration, w.acceleration[k], load(w.V[k], j))
        store(w.a, j, acceleration)
    moment = p.base_inertia * w.a[bodies + BASE_TURN] + pivot_torque(p, w) + p.tip_inertia * w.a[bodies + TIP_TURN]
    for j in range(N):
        moment += w.mass[j] * (w.z[j] * w.a[N + j] - w.z[N + j] * w.a[j])
    if p.is_held > 0:
        moment -= cross(f.spring_place, f.spring_force)
    tip, acceleration = point(w.z, end, N), complex(w.a[bodies + TIP_1], w.a[bodies + TIP_2])
    return moment - cross(tip, f.tip_force) + p.tip_mass * cross(tip + f.tip_arm, acceleration)


@inner
def power_of_tool(p: BeamParameters, t: BeamTables, w: BeamWorkspace) -> float:
    """Power of the force on the tip without the friction of the tool's slide, W (equation 4.9)."""
    return dot(w.facts.tip_force, _tip_velocity(t, w)) + w.facts.slide_loss


@inner
def _slider_force(p: BeamParameters, t: BeamTables, w: BeamWorkspace, moment: float) -> None:
    """To the facts: force (N) and moment (N m) of the slider on the follower, from `_moment_about_pivot` (equations 5.5, 5.6)."""
    f = w.facts
    f.slider_moment = -p.slider_inertia * w.a[2 * t.points + SLIDER_TURN] / (1.0 - f.gap * f.curvature)
    f.tangential = -f.slider_moment * f.curvature
    rubbing = f.friction / (1.0 - f.gap * f.curvature)
    f.tangential += rubbing
    f.slider_moment -= f.gap * rubbing
    f.normal = f.force
    if p.constraint == ELIMINATED:
        f.normal = (moment - f.slider_moment - f.tangential * cross(f.foot, f.tangent)) / dot(f.foot, f.tangent)
    f.slider_force = (1j * f.normal + f.tangential) * f.tangent


@inner
def _drive_torque(p: BeamParameters, w: BeamWorkspace, y: State) -> float:
    """Torque of the drive, N m: given, or what a prescribed motion takes (equation 5.7)."""
    if p.first == 0:
        return given_torque(p, y.u[0])[0]
    # the opposite of the slider's force acts on the crank tip, and no moment: the slider turns freely on it
    return p.LA * cross(w.facts.arm, w.facts.slider_force) - crank_weight(p, w) + p.crank_inertia * w.acceleration[0]
