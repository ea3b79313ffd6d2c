"""Observables of a state, recovered from equilibrium (DERIVATION.md, section 6).

Curvature, and with it base angle, deflection, slider and tip place, follow from the loads outboard, which is far more accurate with few
shapes. The cells end at the slider, so that the kink of the moment needs no special treatment.
"""

import math
from typing import Any

import numba

from quickreturn.reference_model.arrays import Array
from quickreturn.reference_model.columns import GAUGES, NUMBERS, PLACES, ROW
from quickreturn.reference_model.compiled_state import state_at
from quickreturn.reference_model.joint import BASE
from quickreturn.reference_model.joint import joint_energy as energy_of_joint
from quickreturn.reference_model.motion.equations import parameters_at, workspace_at
from quickreturn.reference_model.motion.fields import cumulate, cumulate_real, directions
from quickreturn.reference_model.motion.inertia import find_forces
from quickreturn.reference_model.motion.layout import BASE_TURN, TIP_1, TIP_2, TIP_TURN, BeamParameters, BeamTables, BeamWorkspace
from quickreturn.reference_model.motion.loop import joint_power, motion_of_base
from quickreturn.reference_model.motion.plane import angle_of, cross, dot, point
from quickreturn.reference_model.motion.spring import at_spring, number_at_spring, spring_energy
from quickreturn.reference_model.native.compilation import inner
from quickreturn.reference_model.native.pointers import array_at, call_equations, matrix_at, numbers_at
from quickreturn.reference_model.native.simd import load, plus, spread, store, total
from quickreturn.reference_model.state import BY_DRIVE, BY_JOINT, DISSIPATED, State

joint_energy = inner(energy_of_joint)
#: Rows by address, not as numbers seen as records: numba keeps that conversion as the first function that uses it in a process compiles it,
#: and of functions that count references it does not go into an object.
rows_at = array_at(numba.from_dtype(ROW))


@inner
def observe(p: BeamParameters, t: BeamTables, w: BeamWorkspace, y: State, row: Any) -> bool:
    """Fill a row of `columns.ROW` for the state evaluated last.

    False where the recovered line is bent too far.
    """
    f = w.facts
    if p.first == 0:  # the equations have found them where they ask for the drive's torque
        find_forces(p, t, w, y)
    slider_point = f.slider_point
    row.crank_angle, row.crank_speed, row.tip_acceleration = y.q[0], y.u[0], _tip_acceleration(p, t, w)
    row.follower_rate, row.follower_acceleration = f.q2_rate, w.a[2 * t.points + BASE_TURN]
    row.slider_force, row.crank_torque = f.normal, f.torque
    row.dissipated_energy, row.drive_work = y.work[DISSIPATED], y.work[BY_DRIVE]
    row.constraint_gap, row.gap_rate, row.joint_power, row.spring_force = f.unclosed, f.gap_rate, 0.0, f.tension
    if len(y.work) > BY_JOINT:
        row.joint_power = joint_power(p, w, y)
    _energies(p, t, w, y, slider_point, row)
    _bearing_forces(p, t, w, y, row)
    if p.is_held > 0:
        pulled = f.frame * f.spring_force
        row.pivot_force_x -= pulled.real
        row.pivot_force_y -= pulled.imag
    _bending_moment(p, t, w, slider_point, row)
    return _recover(p, t, w, y, slider_point, row)


@inner
def _tip_acceleration(p: BeamParameters, t: BeamTables, w: BeamWorkspace) -> float:
    """Absolute acceleration of x = L along the normal there (equation 6.1)."""
    return cross(point(w.e, t.tip, t.points), point(w.a, t.tip, t.points) + w.facts.gravity)


@inner
def _energies(p: BeamParameters, t: BeamTables, w: BeamWorkspace, y: State, slider_point: int, row: Any) -> None:
    """To the row: kinetic, strain and gravity energy (equations 6.2 to 6.4)."""
    n, N, f = p.n, t.points, w.facts
    end = t.tip
    q2_rate, q1_rate = f.q2_rate, y.u[0]
    kinetic = 0.5 * p.crank_inertia * q1_rate * q1_rate + 0.5 * p.base_inertia * q2_rate * q2_rate
    for j in range(N):
        v1, v2 = w.relative[j] - q2_rate * w.z[N + j], w.relative[N + j] + q2_rate * w.z[j]
        kinetic += 0.5 * w.mass[j] * (v1 * v1 + v2 * v2)
    tip = point(w.z, end, N)
    velocity = point(w.relative, end, N) + 1j * (q2_rate * tip + w.turn[end] * f.tip_arm)
    kinetic += 0.5 * p.tip_mass * dot(velocity, velocity) + 0.5 * p.tip_inertia * w.turn[end] ** 2
    kinetic += 0.5 * p.slider_inertia * (w.turn[slider_point] + f.curvature * f.s_rate) ** 2
    kinetic += 0.5 * p.joint_inertia * f.gap_rate**2
    strain = joint_energy(f.gap, p.plus, p.minus, p.plus_from, p.minus_from)
    if p.is_held > 0:
        strain += spring_energy(f.spring_length, p.spring)
    for i in range(n):
        strain += 0.5 * w.squares[i] * y.eta[i] ** 2
        kinetic += 0.5 * p.added_inertia[i] * y.eta_rate[i] ** 2
    moment = p.tip_mass * (tip + f.tip_arm)
    for j in range(N):
        moment += w.mass[j] * point(w.z, j, N)
    crank = p.crank_moment * f.frame * f.arm
    gravity = -dot(complex(p.gravity_1, p.gravity_2), (p.rhoA * p.L + p.tip_mass) * p.d + f.frame * moment + crank)
    row.kinetic_energy, row.strain_energy, row.gravity_energy = kinetic, strain, gravity


@inner
def _bearing_forces(p: BeamParameters, t: BeamTables, w: BeamWorkspace, y: State, row: Any) -> None:
    """To the row: forces of the ground on base and crank in frame N, by Newton's law for follower and crank (equations 6.10 and 6.11)."""
    N, f = t.points, w.facts
    bodies = 2 * N
    beam_1 = beam_2 = spread(0.0)
    for j in range(0, N, 4):
        beam_1 = plus(beam_1, load(w.mass, j), load(w.a, j))
        beam_2 = plus(beam_2, load(w.mass, N + j), load(w.a, N + j))
    tip = p.tip_mass * complex(w.a[bodies + TIP_1], w.a[bodies + TIP_2])
    pivot = f.frame * (complex(total(beam_1), total(beam_2)) + tip - f.tip_force - f.slider_force)
    crank = p.crank_moment * (1j * w.acceleration[0] - y.u[0] ** 2) * f.arm
    crank = f.frame * (crank + f.slider_force) - p.crank_mass * complex(p.gravity_1, p.gravity_2)
    row.pivot_force_x, row.pivot_force_y, row.crank_force_x, row.crank_force_y = pivot.real, pivot.imag, crank.real, crank.imag


@inner
def _bending_moment(p: BeamParameters, t: BeamTables, w: BeamWorkspace, slider_point: int, row: Any) -> None:
    """To `moment`: moment of the outboard forces at the points, N m (equations 6.5 and 6.6).

    To the row: at slider, base and tip, and there the part of the outboard forces along the tangent (equation 6.13).
    `moment` lacks the part of the spring, which has a kink at its place within a cell.
    """
    N, f = t.points, w.facts
    end, bodies = t.tip, 2 * N
    force, moment = w.load, w.load_moment
    for j in range(2 * N):
        force[j] = -p.rhoA * w.a[j] - p.beam_damping * w.relative[j]
    for j in range(N):
        moment[j] = w.z[j] * force[N + j] - w.z[N + j] * force[j]
    cumulate(t, w.length, force, w.inboard_force)
    cumulate_real(t, w.length, moment, w.inboard_moment)
    # force and moment about P of all loads on the follower but the slider's: tip body, tool and beam
    tip, of_body = point(w.z, end, N), -p.tip_mass * complex(w.a[bodies + TIP_1], w.a[bodies + TIP_2])
    outboard = of_body + f.tip_force + point(w.inboard_force, end, N)
    about_pivot = cross(tip + f.tip_arm, of_body) - p.tip_inertia * w.a[bodies + TIP_TURN] + w.inboard_moment[end] + cross(tip, f.tip_force)
    for j in range(N):
        w.moment[j] = about_pivot - w.inboard_moment[j] - cross(point(w.z, j, N), outboard - point(w.inboard_force, j, N))
    row.moment_base = about_pivot  # at the ends: equation 6.12
    row.axial_base, row.axial_tip = outboard.real, dot(point(w.e, end, N), of_body + f.tip_force)
    along = point(w.e, slider_point, N)
    row.axial_slider = row.axial_inboard = dot(along, outboard - point(w.inboard_force, slider_point, N))
    if p.constraint != BASE:
        row.axial_base += f.slider_force.real
        row.axial_inboard += dot(along, f.slider_force)
        pushed = f.slider_force
        of_slider = cross(point(w.z, slider_point, N), pushed) + f.slider_moment
        row.moment_base += of_slider
        # at the slider the moment jumps by the slider's moment, and the outboard side counts
        for j in range(slider_point):
            w.moment[j] += of_slider - cross(point(w.z, j, N), pushed)
    row.moment_slider = w.moment[slider_point]
    if p.is_held > 0:
        row.moment_base += cross(f.spring_place, f.spring_force)
        row.axial_base += f.spring_force.real
        if f.s <= p.spring_place:
            pulled = dot(along, f.spring_force)
            row.axial_slider += pulled
            row.axial_inboard += pulled
            row.moment_slider += _moment_of_spring(t, w, slider_point)
        if p.spring_place >= p.L:
            row.axial_tip += dot(point(w.e, end, N), f.spring_force)
    row.moment_inboard = row.moment_slider + f.slider_moment
    row.moment_tip = cross(f.tip_arm, of_body) - p.tip_inertia * w.a[bodies + TIP_TURN]


@inner
def _moment_of_spring(t: BeamTables, w: BeamWorkspace, j: int) -> float:
    """Moment of the spring's force at a point inboard of its place, N m."""
    return cross(w.facts.spring_place - point(w.z, j, t.points), w.facts.spring_force)


@inner
def _recover(p: BeamParameters, t: BeamTables, w: BeamWorkspace, y: State, slider_point: int, row: Any) -> bool:
    """To the row: moments and strains; shape, base angle, slider and tip place from the recovered curvature (equations 6.7 to 6.9).

    A spring's moment has a kink within a cell. On either side of it all fields are smooth, and each side is recovered with its own moment
    on the whole follower: the inboard one first, on which the outboard one goes on at the spring's place.
    """
    N, f = t.points, w.facts
    end = t.tip
    if p.is_held > 0:
        for j in range(N):
            w.moment[j] += _moment_of_spring(t, w, j)
        if not _bend(p, t, w, 0.0, complex(0.0, 0.0), False):
            return False
        _read(p, t, w, row, -1.0)
        place, tangent = point(w.recovered_place, slider_point, N), point(w.recovered_e, slider_point, N)
        angle, joint = number_at_spring(w, w.recovered_angle), at_spring(w, w.recovered_place, N)
        for j in range(N):
            w.moment[j] -= _moment_of_spring(t, w, j)
        if not _bend(p, t, w, angle, joint, True):
            return False
        _read(p, t, w, row, p.spring_place)
        if f.s > p.spring_place:
            place, tangent = point(w.recovered_place, slider_point, N), point(w.recovered_e, slider_point, N)
    else:
        if not _bend(p, t, w, 0.0, complex(0.0, 0.0), False):
            return False
        _read(p, t, w, row, -1.0)
        place, tangent = point(w.recovered_place, slider_point, N), point(w.recovered_e, slider_point, N)
    frame, ds = f.frame, 0.0
    if p.constraint == BASE:
        row.follower_angle = motion_of_base(p, y.q[0])[0]
    else:
        # the crank's tip lies off the line, by the gap along its normal
        hinge = place + 1j * f.gap * tangent
        crank = frame * f.arm
        crank_tip = p.LA * crank - p.d
        ds = 0.5 * (dot(crank_tip, crank_tip) - dot(hinge, hinge)) / dot(hinge, tangent)
        # exp(i q2) has the direction of crank_tip / hinge; both -crank_tip and hinge point forwards
        frame = crank_tip * (hinge + ds * tangent).conjugate()
        frame *= 1.0 / math.sqrt(dot(frame, frame))
        # continuous, as in equation 9.1: a follower that turns fully stays near the crank's angle
        if p.d < p.LA:
            row.follower_angle = y.q[0] + angle_of(frame * crank.conjugate())
        else:
            row.follower_angle = math.pi + angle_of(-frame)
    deflected = point(w.recovered_place, end, N)
    tip = p.d + frame * deflected
    row.slider_position, row.tip_deflection, row.tip_x, row.tip_y = f.s + ds, deflected.imag, tip.real, tip.imag
    return True


@inner
def _bend(p: BeamParameters, t: BeamTables, w: BeamWorkspace, angle: float, place: complex, goes_on: bool) -> bool:
    """To the fields `curvature` and `recovered_...`: the line with the moments `moment`; False where it is bent too far.

    If it `goes_on`, with this angle and this place where the spring is, otherwise from the base.
    """
    N, flexibility = t.points, 1.0 / p.EI
    for j in range(N):
        w.curvature[j] = flexibility * w.moment[j]
    if p.bending_damping > 0.0:
        for j in range(N):
            w.curvature[j] -= p.bending_damping * w.curvature_rate[j]
    cumulate_real(t, w.length, w.curvature, w.recovered_angle)
    if goes_on:
        turned = angle - number_at_spring(w, w.recovered_angle)
        for j in range(N):
            w.recovered_angle[j] += turned
    if not directions(w.recovered_angle, w.recovered_e):
        return False
    cumulate(t, w.length, w.recovered_e, w.recovered_place)
    if goes_on:
        moved = place - at_spring(w, w.recovered_place, N)
        for j in range(N):
            w.recovered_place[j] += moved.real
            w.recovered_place[N + j] += moved.imag
    return True


@inner
def _read(p: BeamParameters, t: BeamTables, w: BeamWorkspace, row: Any, beyond: float) -> None:
    """To the row: moments, shape and strains at its places beyond an arc length."""
    k = 0
    while k < PLACES:
        count = min(_at_places(t, w, w.moment, p.places, k), PLACES - k)
        for i in range(count):
            if p.places[k + i] > beyond:
                row.moments[k + i], row.shapes[k + i] = w.at_places[0, i], w.at_places[1, i]
        k += count
    while k < PLACES + GAUGES:
        count = _at_places(t, w, w.curvature, p.places, k)
        for i in range(count):
            if p.places[k + i] > beyond:
                row.strains[k + i - PLACES] = p.extreme_fibre * w.at_places[0, i]
        k += count


@inner
def _at_places(t: BeamTables, w: BeamWorkspace, field: Array, places: Array, k: int) -> int:
    """To `at_places`: a field (moment or curvature) and the deflection at four places, from number k on.

    They are on the polynomials through the points of the first place's cell (Lagrange's form).

    Returns:
        Number of places in that cell, before the first that is not.
    """
    cell, begin = 0, 0.0
    # with room for rounding; a cell beyond a slider that has left the follower has no length
    while cell < t.cells - 1 and w.length[cell + 1] > 0.0 and places[k] > begin + w.length[cell] * (1.0 + 1e-12):
        begin += w.length[cell]
        cell += 1
    first, length, count = cell * t.cell_size, w.length[cell], 1
    while count < 4 and begin < places[k + count] <= begin + length * (1.0 + 1e-12):
        count += 1
    none = spread(0.0)
    u = plus(none, 1.0 / length, plus(load(places, k), -1.0, spread(begin)))
    value, deflection, before = none, none, spread(1.0)  # product of the distances from the points passed
    for j in range(t.gauss_points):
        away, share = plus(u, -1.0, spread(t.u[j])), plus(none, t.lagrange[j], before)
        value = plus(plus(none, value, away), field[first + j], share)
        deflection = plus(plus(none, deflection, away), w.recovered_place[t.points + first + j], share)
        before = plus(none, before, away)
    store(w.at_places[0], 0, value)
    store(w.at_places[1], 0, deflection)
    return count


def observe_states(function: int, parameters: int, workspace: int, states: int, count: int, size: int, scratch: int, table: int) -> int:
    """Fill `table` (`NUMBERS`, count), a column for each row of `columns.ROW`, from `states` (count, size).

    `scratch` (size + `NUMBERS`,) is overwritten. `function` is the address of `equations.kernel`, the rest are those of arrays.

    Returns:
        Number of columns filled before a state that cannot be.
    """
    p, w, filled = parameters_at(parameters), workspace_at(workspace), matrix_at(table, NUMBERS, count)
    row, numbers = rows_at(scratch + 8 * size, 1)[0], numbers_at(scratch + 8 * size, NUMBERS)
    for k in range(count):
        state = states + 8 * size * k
        if call_equations(function, parameters, workspace, state, scratch) != 1:
            return k
        if not observe(p, p.tables, w, state_at(state, p.n, p.speeds), row):
            return k
        for i in range(NUMBERS):
            filled[i, k] = numbers[i]
    return count
