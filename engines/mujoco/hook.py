"""MuJoCo's control hook: drive, dampings, and the slider's force, which is a multiplier or follows from the law of the joint's rollers.

For a follower alone it has the torque on the base instead of the slider's force.
"""

import math
from functools import partial

import numpy as np
from numba import carray, types  # type: ignore[attr-defined]

from quickreturn.engines.mujoco.centre_line import (
    by_table,
    centre_line_coefficients,
    crank_of,
    find_slider,
    link_directions,
    link_rates,
    rate_of,
    row_of_gap,
    row_of_sliding,
)
from quickreturn.engines.mujoco.context import (
    CONTEXT,
    TIME_AND_USERDATA,
    Context,
    Points,
    compiled,
    dot,
    mj_get_state,
    mj_solve_mass,
    numbers,
    pointer,
)
from quickreturn.reference_model import joint, spring
from quickreturn.reference_model.arrays import Array
from quickreturn.reference_model.mechanism import base_motion as motion_of_base
from quickreturn.reference_model.native.compilation import callback
from quickreturn.reference_model.tip import STILL, tool_force

tool_at, base_motion = compiled(tool_force), compiled(motion_of_base)
joint_force, friction_share = compiled(joint.joint_force), compiled(joint.friction_share)
spring_tension = compiled(spring.spring_tension)


@compiled
def damp_beam(ctx: Context, e: Points, rates: Array, force: Array) -> float:
    """Add the forces of the distributed damping to the hinges' entries in `force`; returns the power dissipated, W.

    The damping opposes the link centres' velocities relative to the base frame, so that turning the whole follower costs no work.
    """
    n, h = ctx.hinges, ctx.link_length
    first = ctx.coordinates - n - 1
    resistance = np.empty(n + 1, np.complex128)  # on each link centre
    velocity, power = 0j, 0.0
    for i in range(1, n + 1):
        turning = 1j * (rates[i] - rates[0]) * e[i]
        length = h if i < n else 0.5 * h
        center = velocity + 0.5 * length * turning
        resistance[i] = -ctx.beam_damping * length * center
        power += ctx.beam_damping * length * dot(center, center)
        velocity += length * turning
    outboard, moment = 0j, 0.0
    for i in range(n, 0, -1):
        length = h if i < n else 0.5 * h
        moment += dot(1j * e[i], length * (0.5 * resistance[i] + outboard))
        outboard += resistance[i]
        force[first + i] += moment
    return power


@compiled
def _power_lost_in_hinges(ctx: Context, qvel: Array) -> float:
    """Power that the material's damping dissipates in the hinges, W; its moments belong to MuJoCo's joints."""
    if ctx.material_damping == 0.0:
        return 0.0
    rates = qvel[ctx.coordinates - ctx.hinges :]
    return ctx.material_damping * ctx.bending_stiffness / ctx.link_length * np.sum(rates**2)


@compiled
def pivot_friction(ctx: Context, rate: float) -> float:
    """Friction of the pivot against the base's rate (rad/s), N m."""
    return ctx.base_friction * friction_share(rate, ctx.base_friction_rate) if ctx.base_friction > 0.0 else 0.0


@compiled
def _rub_pivot(ctx: Context, rate: float, force: Array) -> float:
    """Add the friction of the pivot to the base's entry in `force`; returns the power dissipated, W."""
    if ctx.base_friction == 0.0:
        return 0.0
    moment = pivot_friction(ctx, rate)
    force[ctx.coordinates - ctx.hinges - 1] -= moment
    return moment * rate


@compiled
def _hold(model: int, data: int, ctx: Context, rows: tuple[Array, Array], bias: float, sliding: float, applied: Array) -> float:
    """Multiplier of a rigid joint (N): with it, and the friction in proportion to it, the gap's acceleration vanishes; nan if that jams.

    Args:
        model: address of MuJoCo's model.
        data: address of its data.
        ctx: the simulation.
        rows: the rows of `row_of_gap` and `row_of_sliding`.
        bias: the gap's acceleration with constant rates of the coordinates, m/s^2.
        sliding: fraction of the friction that acts, with the sign of the sliding speed.
        applied: generalised forces without the joint's.
    """
    n, row = ctx.coordinates, rows[0]
    count = 2 if ctx.friction == 0.0 else 3
    forces, accelerations = np.empty((count, n)), np.empty((count, n))
    forces[0] = numbers(ctx.force_passive, n) - numbers(ctx.force_bias, n) + applied
    forces[1] = row
    if ctx.friction > 0.0:
        forces[2] = rows[1]
    mj_solve_mass(model, data, accelerations.ctypes.data, forces.ctypes.data, count)
    needed, per_unit = -(np.dot(row, accelerations[0]) + bias), np.dot(row, accelerations[1])
    if ctx.friction > 0.0:
        per_unit -= math.copysign(ctx.friction, needed) * sliding * np.dot(row, accelerations[2])
        if not per_unit > 0.0:
            return math.nan
    return needed / per_unit


@compiled
def force_on_tip(ctx: Context, crank_angle: float, e: Points, rates: Array) -> tuple[complex, float]:
    """Force of the tool on the tip with the friction of its slide, N, along n1 + i n2; and the power that this dissipates, W."""
    force, loss = 0j, 0.0
    if ctx.force_1 != 0.0 or ctx.force_2 != 0.0 or ctx.force_points > 0:
        table = numbers(ctx.force_table, 9 * ctx.force_points).reshape((ctx.force_points, 9))
        share, first, second = tool_at(crank_angle, ctx.force_1, ctx.force_2, ctx.force_begin, ctx.force_span, ctx.force_ramp, table)
        force = complex(first, second) * share
        if ctx.force_follows:
            force *= e[ctx.hinges]
    if ctx.slide_friction > 0.0:
        velocity = (centre_line_coefficients(ctx.follower_length, ctx.hinges, ctx.link_length, 0) * 1j * rates * e).sum()
        speed = abs(velocity) + STILL * ctx.slide_speed
        resistance = ctx.slide_friction * friction_share(speed, ctx.slide_speed) / speed
        force -= resistance * velocity
        loss = resistance * dot(velocity, velocity)
    return force, loss


@compiled
def _push_tip(ctx: Context, crank_angle: float, e: Points, rates: Array, force: Array) -> tuple[float, float]:
    """Add the force on the tip, at the centre line's end, to `force`; returns the power of the tool and that lost by friction, W."""
    pushed, loss = force_on_tip(ctx, crank_angle, e, rates)
    if pushed == 0.0:
        return 0.0, 0.0
    first = ctx.coordinates - ctx.hinges - 1
    at_tip = centre_line_coefficients(ctx.follower_length, ctx.hinges, ctx.link_length, 0)
    moment = power = 0.0
    for i in range(ctx.hinges, -1, -1):
        part = at_tip[i] * dot(1j * e[i], pushed)
        moment += part
        force[first + i] += moment
        power += part * rates[i]
    return power + loss, loss


@compiled
def _pull(ctx: Context, e: Points, rates: Array, force: Array) -> float:
    """Add the spring's force, at a place of the centre line, to `force`; returns the power that it dissipates, W."""
    if not ctx.is_held:
        return 0.0
    first = ctx.coordinates - ctx.hinges - 1
    at_place = centre_line_coefficients(ctx.spring_place, ctx.hinges, ctx.link_length, 0)
    away = ctx.anchor - (at_place * e).sum()
    ctx.spring_length = abs(away)
    rate = -dot(away, (at_place * 1j * rates * e).sum()) / ctx.spring_length
    ctx.tension = spring_tension(ctx.spring_length, rate, ctx.spring)
    ctx.spring_force = ctx.tension / ctx.spring_length * away
    moment = 0.0
    for i in range(ctx.hinges, -1, -1):
        moment += at_place[i] * dot(1j * e[i], ctx.spring_force)
        force[first + i] += moment
    return ctx.spring.damping * rate**2


@compiled
def _constrain(model: int, data: int, ctx: Context, time: float) -> None:
    """To `force_applied`: drive, dampings, and the slider's force.

    The force of a rigid joint keeps the gap's acceleration zero, that of a compliant joint follows from the gap and its rate.
    """
    n = ctx.coordinates
    qpos, qvel, applied = numbers(ctx.qpos, n), numbers(ctx.qvel, n), numbers(ctx.force_applied, n)

    e, rates = link_directions(ctx, qpos), link_rates(ctx, qvel)
    crank_arm, angle, crank_speed, crank_acceleration = crank_of(ctx, time, qpos, qvel)
    c0, c1, c2, tangent, ctx.gap = find_slider(ctx, e, crank_arm)
    normal = 1j * tangent
    row, crank_row = row_of_gap(ctx, e, c0, tangent, crank_arm)

    turning = 1j * rates * e
    slope = (c1 * e).sum()
    ctx.slider_speed = dot(tangent, 1j * crank_arm * crank_speed - (c0 * turning).sum()) / abs(slope)
    follower = -(c0 * rates**2 * e).sum() + 2.0 * ctx.slider_speed * (c1 * turning).sum() + ctx.slider_speed**2 * (c2 * e).sum()
    bias = dot(normal, -crank_arm * crank_speed**2 - follower) + crank_row * crank_acceleration

    applied[:], torque = 0.0, ctx.crank_torque
    if ctx.crank_is_free:
        if ctx.drive_points > 0:
            torque = by_table(ctx, crank_speed)[0]
        applied[0] = torque
    dissipation = ctx.crank_damping * crank_speed**2 + ctx.base_damping * rates[0] ** 2
    dissipation += damp_beam(ctx, e, rates, applied) + _power_lost_in_hinges(ctx, qvel) + _rub_pivot(ctx, rates[0], applied)
    tool_power, slide_loss = _push_tip(ctx, angle, e, rates, applied)
    dissipation += slide_loss + _pull(ctx, e, rates, applied)

    rubs = ctx.friction > 0.0 or ctx.friction_force > 0.0
    sliding, sliding_speed, sliding_row, crank_sliding, share_at_foot = 0.0, 0.0, row, 0.0, 1.0
    if rubs:
        sliding_row, crank_sliding, share_at_foot = row_of_sliding(ctx, e, (c0, c1, c2, tangent), crank_arm)
        sliding_speed = rate_of(ctx, sliding_row, qvel, crank_sliding, crank_speed)
        sliding = friction_share(sliding_speed, ctx.friction_speed)
        applied -= ctx.friction_force * sliding * sliding_row
    if ctx.joint_is_compliant:
        gap_rate = rate_of(ctx, row, qvel, crank_row, crank_speed)
        law = ctx.plus, ctx.minus, ctx.plus_from, ctx.minus_from
        multiplier = -joint_force(ctx.gap, gap_rate, *law, ctx.contact_loss, ctx.joint_damping)
        dissipation -= gap_rate * (multiplier + joint_force(ctx.gap, 0.0, *law, 0.0, 0.0))
    else:
        multiplier = _hold(model, data, ctx, (row, sliding_row), bias, sliding, applied)
    applied += multiplier * row
    ctx.slider_force = -multiplier
    ctx.drive_torque = torque
    if not ctx.crank_is_free:
        weight = ctx.prescribed_weight_2 * math.cos(angle) - ctx.prescribed_weight_1 * math.sin(angle)
        ctx.drive_torque = weight - multiplier * crank_row + ctx.prescribed_inertia * crank_acceleration
    if rubs:
        coulomb = ctx.friction * abs(multiplier) * sliding
        applied -= coulomb * sliding_row
        along = ctx.friction_force * sliding + coulomb
        dissipation += along * sliding_speed
        ctx.tangential_force = along * share_at_foot
        ctx.slider_couple = -ctx.gap * ctx.tangential_force
        if not ctx.crank_is_free:
            ctx.drive_torque += along * crank_sliding
    ctx.dissipation, ctx.drive_power = dissipation, ctx.drive_torque * crank_speed + tool_power


@compiled
def _turn_base(model: int, data: int, ctx: Context, time: float) -> None:
    """To `force_applied`, for a follower alone: dampings, and the torque that gives the base its prescribed acceleration."""
    n = ctx.coordinates
    qpos, qvel, applied = numbers(ctx.qpos, n), numbers(ctx.qvel, n), numbers(ctx.force_applied, n)
    rates = link_rates(ctx, qvel)
    applied[:] = 0.0
    dissipation = ctx.base_damping * rates[0] ** 2 + damp_beam(ctx, link_directions(ctx, qpos), rates, applied)
    dissipation += _power_lost_in_hinges(ctx, qvel) + _rub_pivot(ctx, rates[0], applied)
    forces, accelerations = np.zeros((2, n)), np.empty((2, n))
    forces[0] = numbers(ctx.force_passive, n) - numbers(ctx.force_bias, n) + applied
    forces[1, 0] = 1.0
    mj_solve_mass(model, data, accelerations.ctypes.data, forces.ctypes.data, 2)
    ctx.drive_torque = (base_motion(ctx.spin_up_speed, ctx.spin_up_time, time)[2] - accelerations[0, 0]) / accelerations[1, 0]
    applied[0] += ctx.drive_torque
    ctx.dissipation, ctx.drive_power = dissipation, ctx.drive_torque * rates[0]


@partial(callback, signature=types.void(types.intp, types.intp))
def control_hook(model: int, data: int) -> None:
    """MuJoCo's `mjcb_control`: called by `mj_forward`, when the mass matrix and all other forces are known."""
    time_and_context = np.empty(2)
    mj_get_state(model, data, time_and_context.ctypes.data, TIME_AND_USERDATA)
    context = carray(pointer(int(time_and_context[1])), 1, CONTEXT)
    if context[0].base_is_prescribed:
        _turn_base(model, data, context[0], time_and_context[0])
    else:
        _constrain(model, data, context[0], time_and_context[0])
