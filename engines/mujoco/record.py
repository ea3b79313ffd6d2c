"""Fills a row of observables from MuJoCo's present state."""

import math
from typing import Any

import numpy as np

from quickreturn.engines.mujoco.centre_line import centre_line_coefficients, crank_of, link_directions, link_rates
from quickreturn.engines.mujoco.context import (
    TIME_AND_USERDATA,
    Context,
    Points,
    compiled,
    dot,
    mj_energy_position,
    mj_energy_velocity,
    mj_get_state,
    numbers,
)
from quickreturn.engines.mujoco.hook import force_on_tip, pivot_friction
from quickreturn.reference_model import joint, spring
from quickreturn.reference_model.arrays import Array
from quickreturn.reference_model.columns import PLACES

joint_energy, spring_energy = compiled(joint.joint_energy), compiled(spring.spring_energy)


@compiled
def _pulled_across(ctx: Context, e: Points) -> float:
    """The spring's force across the centre line over EI, 1/m^2: the jump of the moment's slope there."""
    if not ctx.is_held or ctx.hinges == 0:
        return 0.0
    slope = (centre_line_coefficients(ctx.spring_place, ctx.hinges, ctx.link_length, 1) * e).sum()
    return dot(1j * slope, ctx.spring_force) / abs(slope) / ctx.bending_stiffness


@compiled
def _smooth_moments(ctx: Context, qpos: Array, qvel: Array, pulled: float, at_base: float, at_tip: float) -> Array:
    """Bending moment over EI at base, hinges and tip, 1/m, without kinks and jump at slider and spring (`_pulled_across`); shape (N + 2,).

    The moment of the slider force F in hinge j is F b_j, b_j = Σ_{i >= j} c_i; in the beam it is the ramp F (s - x) inboard of the slider.
    The moment of its couple has the derivatives of the c_i in their place. `at_base` and `at_tip` are the moments at the ends, N m.
    """
    n = ctx.hinges
    smooth = np.zeros(n + 2)
    if n == 0:
        return smooth
    kink, jump = ctx.slider_force / ctx.bending_stiffness, ctx.slider_couple / ctx.bending_stiffness
    c0 = centre_line_coefficients(ctx.slider_position, n, ctx.link_length, 0)
    c1 = centre_line_coefficients(ctx.slider_position, n, ctx.link_length, 1)
    at_spring = c0 if pulled == 0.0 else centre_line_coefficients(ctx.spring_place, n, ctx.link_length, 0)
    lever = lever_by_s = lever_of_spring = 0.0
    for j in range(n, 0, -1):
        lever += c0[j]
        lever_by_s += c1[j]
        lever_of_spring += at_spring[j]
        k = ctx.coordinates - n - 1 + j
        bent = qpos[k] + ctx.material_damping * qvel[k]
        smooth[j] = bent / ctx.link_length - kink * lever - jump * lever_by_s - pulled * lever_of_spring
    smooth[0] = at_base / ctx.bending_stiffness - kink * ctx.slider_position - jump - pulled * ctx.spring_place
    smooth[n + 1] = at_tip / ctx.bending_stiffness
    return smooth


@compiled
def _at_place(ctx: Context, values: Array, x: float, first: int, last: int) -> float:
    """A field at the arc length x by the cubic through the four nearest of its nodes `first` to `last`; 0 for a rigid follower.

    Nodes are the base, the hinges and the tip, in `values` of shape (N + 2,).
    """
    n = ctx.hinges
    if n == 0:
        return 0.0
    if not math.isfinite(x):
        return math.nan
    points = min(4, last - first + 1)
    place = x / ctx.link_length  # as those of the nodes: 0, 1/2, 3/2, ..., N - 1/2, N
    left = min(max(math.floor(place + 0.5) - 1, first), last + 1 - points)
    value = 0.0
    for j in range(left, left + points):
        at_j, weight = min(max(j - 0.5, 0.0), float(n)), 1.0
        for k in range(left, left + points):
            if k != j:
                at_k = min(max(k - 0.5, 0.0), float(n))
                weight *= (place - at_k) / (at_j - at_k)
        value += weight * values[j]
    return value


@compiled
def _moment(ctx: Context, smooth: Array, pulled: float, x: float) -> float:
    """Bending moment over EI at the arc length x, 1/m, with kinks and jump; at the slider that on the outboard side."""
    if ctx.hinges == 0:
        return 0.0
    jump = ctx.slider_couple / ctx.bending_stiffness if x < ctx.slider_position else 0.0
    kinks = ctx.slider_force / ctx.bending_stiffness * max(0.0, ctx.slider_position - x) + pulled * max(0.0, ctx.spring_place - x)
    return _at_place(ctx, smooth, x, 0, ctx.hinges + 1) + kinks + jump


@compiled
def _bending_rate(ctx: Context, qvel: Array, x: float) -> float:
    """Rate of the curvature at the arc length x, 1/(m s); it is zero at an end that carries no moment, and not known at others."""
    n = ctx.hinges
    rates = np.zeros(n + 2)
    rates[1 : n + 1] = qvel[ctx.coordinates - n :] / ctx.link_length
    held = ctx.base_is_prescribed or ctx.base_inertia > 0.0 or ctx.base_damping > 0.0 or ctx.base_friction > 0.0
    loaded = ctx.tip_mass > 0.0 or ctx.tip_inertia > 0.0
    return _at_place(ctx, rates, x, 1 if held else 0, n if loaded else n + 1)


@compiled
def _damping_about_pivot(ctx: Context, e: Points, rates: Array) -> float:
    """Moment about P of the beam's damping on the links, N m; see `hook.damp_beam`."""
    n, h, at_hinge, velocity, moment = ctx.hinges, ctx.link_length, 0j, 0j, 0.0
    for i in range(n + 1):
        length, turning = h if 0 < i < n else 0.5 * h, 1j * (rates[i] - rates[0]) * e[i]
        moment -= length * dot(1j * (at_hinge + 0.5 * length * e[i]), velocity + 0.5 * length * turning)
        at_hinge, velocity = at_hinge + length * e[i], velocity + length * turning
    return ctx.beam_damping * moment


@compiled
def _moment_at_base(ctx: Context, e: Points, rates: Array, accelerations: Array) -> float:
    """Bending moment at the base, N m, by Euler's law for the base block, to which the beam's damping is a reaction."""
    moment = ctx.base_inertia * accelerations[0] + ctx.base_damping * rates[0] + pivot_friction(ctx, rates[0])
    if ctx.base_is_prescribed:
        moment -= ctx.drive_torque
    return moment + _damping_about_pivot(ctx, e, rates)


@compiled
def _moment_at_tip(ctx: Context, along: complex, turning: float, acceleration: complex) -> float:
    """Bending moment at the flexible end, N m, by Newton's and Euler's laws for the tip body.

    Args:
        ctx: the simulation.
        along: direction of the last link.
        turning: its angular acceleration, rad/s^2.
        acceleration: of the flexible end, m/s^2; along the last link it does not count.
    """
    across = dot(1j * along, acceleration - ctx.gravity) + ctx.tip_offset * turning
    return -ctx.tip_inertia * turning - ctx.tip_mass * ctx.tip_offset * across


@compiled
def _follower_inertia(ctx: Context, e: Points, rates: Array, accelerations: Array) -> complex:
    """Rate of the momentum of all links and the tip body, less their weight, N, along n1 + i n2."""
    n, h, at_hinge, total = ctx.hinges, ctx.link_length, 0j, 0j
    for i in range(n + 1):
        length = h if 0 < i < n else (0.5 * h if n else ctx.follower_length)
        turning = (1j * accelerations[i] - rates[i] ** 2) * e[i]
        total += ctx.mass_per_length * length * (at_hinge + 0.5 * length * turning - ctx.gravity)
        at_hinge += length * turning
    return total + ctx.tip_mass * (at_hinge + ctx.tip_offset * turning - ctx.gravity)


@compiled
def _axial_forces(
    ctx: Context, angle: float, base: complex, e: Points, rates: Array, accelerations: Array
) -> tuple[float, float, float, float]:
    """Normal force in the arm at the base, inboard and outboard of the slider, and at the flexible end, N.

    Args:
        ctx: the simulation, with its slider's place and forces.
        angle: of the crank.
        base: direction of the base's tangent.
        e: directions of the links.
        rates: of their angles, rad/s.
        accelerations: of their angles, rad/s^2.
    """
    n, h, s, begin = ctx.hinges, ctx.link_length, ctx.slider_position, 0.0
    at_hinge = velocity = turning = total = outboard = 0j
    for i in range(n + 1):
        length = h if 0 < i < n else (0.5 * h if n else ctx.follower_length)
        turning, swing = (1j * accelerations[i] - rates[i] ** 2) * e[i], 1j * (rates[i] - rates[0]) * e[i]
        mass, damping = ctx.mass_per_length * (at_hinge - ctx.gravity), ctx.beam_damping * velocity
        square = 0.5 * (ctx.mass_per_length * turning + ctx.beam_damping * swing)
        inner = min(max(s - begin, 0.0), length)
        total -= length * (mass + damping) + length**2 * square
        outboard -= (length - inner) * (mass + damping) + (length**2 - inner**2) * square
        begin, at_hinge, velocity = begin + length, at_hinge + length * turning, velocity + length * swing
    tip = -ctx.tip_mass * (at_hinge + ctx.tip_offset * turning - ctx.gravity) + force_on_tip(ctx, angle, e, rates)[0]
    slope = (centre_line_coefficients(s, n, h, 1) * e).sum()
    along = slope / abs(slope)
    slider = complex(ctx.tangential_force, ctx.slider_force) * along
    if ctx.spring_place >= ctx.follower_length:
        tip += ctx.spring_force
    else:
        total += ctx.spring_force
        outboard += ctx.spring_force if s < ctx.spring_place else 0j
    beyond = dot(along, outboard + tip)
    return dot(base, total + tip + slider), beyond + ctx.tangential_force, beyond, dot(e[n], tip)


@compiled
def _bearing_forces(
    ctx: Context, motion: tuple[float, float, float], e: Points, rates: Array, accelerations: Array
) -> tuple[complex, complex]:
    """Forces of the ground on base and crank, N, along n1 + i n2, by Newton's law for follower and crank.

    Args:
        ctx: the simulation, with its slider's place and force.
        motion: angle (rad), speed and acceleration of the crank.
        e: directions of the links.
        rates: of their angles, rad/s.
        accelerations: of their angles, rad/s^2.
    """
    c1 = centre_line_coefficients(ctx.slider_position, ctx.hinges, ctx.link_length, 1)
    slope = (c1 * e).sum()
    on_follower = complex(ctx.tangential_force, ctx.slider_force) * slope / abs(slope)
    angle, speed, acceleration = motion
    pivot = _follower_inertia(ctx, e, rates, accelerations) - force_on_tip(ctx, angle, e, rates)[0] - ctx.spring_force - on_follower
    swing = (1j * acceleration - speed**2) * complex(math.cos(angle), math.sin(angle))
    return pivot, ctx.crank_moment * swing - ctx.crank_mass * ctx.gravity + on_follower


@compiled
def _tangent_at_base(values: Array, first: int) -> float:
    """Angle of the beam's tangent at the base, or its rate, from those of the hinges; `first` is that at the base.

    It differs from the first link's by h²/24 dκ/dx.
    """
    return values[first] + ((values[first + 2] - values[first + 1]) / 24.0 if len(values) - first > 2 else 0.0)


@compiled
def record(model: int, data: int, ctx: Context, gauges: Array, row: Any) -> None:
    """Fill a `columns.ROW` from the present state, after `mj_forward`. `gauges`: arc lengths of the strain gauges, m, shape (3,)."""
    n, hinges = ctx.coordinates, ctx.hinges
    qpos, qvel = numbers(ctx.qpos, n), numbers(ctx.qvel, n)
    qacc, energy = numbers(ctx.qacc, n), numbers(ctx.energy, 2)
    mj_energy_position(model, data)
    mj_energy_velocity(model, data)

    time_and_context = np.empty(2)
    mj_get_state(model, data, time_and_context.ctypes.data, TIME_AND_USERDATA)
    _, angle, crank_speed, crank_acceleration = crank_of(ctx, time_and_context[0], qpos, qvel)
    first = n - hinges - 1
    e, rates, accelerations = link_directions(ctx, qpos), link_rates(ctx, qvel), np.cumsum(qacc[first:])
    at_tip = centre_line_coefficients(ctx.follower_length, hinges, ctx.link_length, 0)
    tip = (at_tip * e).sum()
    tip_acceleration = (at_tip * (1j * accelerations - rates**2) * e).sum()
    base_angle = _tangent_at_base(qpos, first)
    strain_energy = 0.5 * ctx.bending_stiffness / ctx.link_length * np.sum(qpos[first + 1 :] ** 2)
    pulled = _pulled_across(ctx, e)
    at_base, at_end = _moment_at_base(ctx, e, rates, accelerations), _moment_at_tip(ctx, e[hinges], accelerations[hinges], tip_acceleration)
    smooth = _smooth_moments(ctx, qpos, qvel, pulled, at_base, at_end)
    gravity = energy[0] - strain_energy
    strain_energy += joint_energy(ctx.gap, ctx.plus, ctx.minus, ctx.plus_from, ctx.minus_from)
    if ctx.is_held:
        strain_energy += spring_energy(ctx.spring_length, ctx.spring)
    gravity += ctx.prescribed_weight_1 * math.cos(angle) + ctx.prescribed_weight_2 * math.sin(angle)

    row.crank_angle, row.crank_speed = angle, crank_speed
    row.follower_angle, row.slider_position = base_angle, ctx.slider_position
    # the acceleration is the base block's: the rest of the tangent's is far smaller than what the fastest hinges would make of it
    row.follower_rate, row.follower_acceleration = _tangent_at_base(qvel, first), accelerations[0]
    row.tip_x, row.tip_y = ctx.pivot_distance + tip.real, tip.imag
    along = complex(math.cos(base_angle), math.sin(base_angle))
    across = 1j * along
    row.tip_deflection = dot(across, tip) if hinges else 0.0  # not the round-off of a rigid one
    for place in range(1, PLACES + 1):
        x = place * ctx.follower_length / (PLACES + 1)
        line = centre_line_coefficients(x, hinges, ctx.link_length, 0)
        row.shapes[place - 1] = dot(across, (line * e).sum())
        row.moments[place - 1] = ctx.bending_stiffness * _moment(ctx, smooth, pulled, x)
    row.moment_slider = ctx.bending_stiffness * _moment(ctx, smooth, pulled, ctx.slider_position)
    row.moment_inboard = row.moment_slider + ctx.slider_couple
    row.moment_base, row.moment_tip = at_base, at_end
    row.axial_base, row.axial_inboard, row.axial_slider, row.axial_tip = _axial_forces(ctx, angle, along, e, rates, accelerations)
    row.tip_acceleration = dot(1j * e[hinges], tip_acceleration)
    for gauge in range(3):
        curvature = _moment(ctx, smooth, pulled, gauges[gauge])
        if ctx.material_damping > 0.0:
            curvature -= ctx.material_damping * _bending_rate(ctx, qvel, gauges[gauge])
        row.strains[gauge] = ctx.extreme_fibre * curvature
    crank = angle, crank_speed, qacc[0] if ctx.crank_is_free else crank_acceleration
    pivot, at_crank = _bearing_forces(ctx, crank, e, rates, accelerations)
    row.pivot_force_x, row.pivot_force_y = pivot.real, pivot.imag
    row.crank_force_x, row.crank_force_y = at_crank.real, at_crank.imag
    row.slider_force, row.crank_torque, row.spring_force = ctx.slider_force, ctx.drive_torque, ctx.tension
    row.kinetic_energy = energy[1] + 0.5 * ctx.prescribed_inertia * crank_speed**2
    row.strain_energy, row.dissipated_energy, row.constraint_gap = strain_energy, ctx.dissipated, abs(ctx.gap)
    row.gravity_energy, row.drive_work = gravity, ctx.drive_work
