"""The time loop: MuJoCo's steps, the correction that closes the gap after each, and the rows of the table."""

import math
from typing import Any

import numba
import numpy as np
from numba import types

from quickreturn.engines.mujoco.centre_line import by_table, crank_of, find_slider, link_directions, rate_of, row_of_gap
from quickreturn.engines.mujoco.context import (
    ADDRESS,
    CONTEXTS,
    TIME_AND_USERDATA,
    VECTOR,
    Context,
    compiled,
    entry,
    mj_euler,
    mj_forward,
    mj_get_state,
    mj_solve_mass,
    numbers,
)
from quickreturn.engines.mujoco.hook import base_motion
from quickreturn.engines.mujoco.record import record
from quickreturn.reference_model.arrays import Array
from quickreturn.reference_model.columns import ROW

GOOD, SLIDER_LEFT, NOT_FINITE = 0, 1, 2

_LARGEST_RATE = 1e7  # rad in the scene's unit of time: above, a run has diverged; MuJoCo itself warns at 1e10
_ROWS = numba.from_dtype(ROW)[::1]


@compiled
def _project(model: int, data: int, ctx: Context) -> None:
    """Remove the gap and its rate after a step, along M⁻¹Gᵀ (M of the last stage); for a follower alone set the base's motion."""
    n = ctx.coordinates
    qpos, qvel = numbers(ctx.qpos, n), numbers(ctx.qvel, n)
    time_and_context = np.empty(2)
    mj_get_state(model, data, time_and_context.ctypes.data, TIME_AND_USERDATA)
    if ctx.base_is_prescribed:  # the difference is the error of the step
        qpos[0], qvel[0], _ = base_motion(ctx.spin_up_speed, ctx.spin_up_time, time_and_context[0])
        return
    direction = np.empty(n)
    for iteration in range(6):
        crank_arm, _, crank_speed, _ = crank_of(ctx, time_and_context[0], qpos, qvel)
        e = link_directions(ctx, qpos)
        c0, _, _, tangent, gap = find_slider(ctx, e, crank_arm)
        row, crank_row = row_of_gap(ctx, e, c0, tangent, crank_arm)
        if iteration == 0:
            mj_solve_mass(model, data, direction.ctypes.data, row.ctypes.data, 1)
        elif not abs(gap) > 1e-15 * ctx.follower_length:
            break
        qpos -= direction * (gap / np.dot(row, direction))
    qvel -= direction * (rate_of(ctx, row, qvel, crank_row, crank_speed) / np.dot(row, direction))


@compiled
def _state(ctx: Context) -> int:
    """GOOD, SLIDER_LEFT or NOT_FINITE for the present state."""
    qvel = numbers(ctx.qvel, ctx.coordinates)
    if not np.max(np.abs(qvel)) < _LARGEST_RATE or not math.isfinite(ctx.slider_position):
        return NOT_FINITE
    if not 0.0 <= ctx.slider_position <= ctx.follower_length:
        return SLIDER_LEFT
    return GOOD


@compiled
def _turn_crank(ctx: Context) -> None:
    """Advance a crank whose speed is a table over its angle by a step of the classical Runge-Kutta method."""
    begin, total, speed = ctx.prescribed_angle, 0.0, 0.0
    for share, weight in ((0.0, 1.0), (0.5, 2.0), (0.5, 2.0), (1.0, 1.0)):
        speed = by_table(ctx, ctx.drive_way * (begin + share * ctx.step * speed - ctx.drive_begin))[0]
        total += weight * speed
    ctx.prescribed_angle = begin + ctx.step / 6.0 * total


@compiled
def _step(model: int, data: int, ctx: Context, past: Array) -> None:
    """One step h of the leapfrog method, of second order, from the accelerations a(t) of the last `mj_forward`.

        u(t + h/2) = u(t - h/2) + h a(t),  q(t + h) = q(t) + h u(t + h/2),  v(t + h) = u(t + h/2) + h/8 (7 a(t) - 3 a(t - h))

    The first two are MuJoCo's semi-implicit Euler method with rates u that lag by half a step. The third extrapolates the rates, of which
    the accelerations need a small part only. Then the slider is brought back to the centre line.

    Args:
        model: address of MuJoCo's model.
        data: address of its data, with q and v.
        ctx: the simulation, with its step.
        past: u(t - h/2) and a(t - h), shape (2, coordinates), which advance as well.
    """
    n, h = ctx.coordinates, ctx.step
    qpos, qvel = numbers(ctx.qpos, n), numbers(ctx.qvel, n)
    acceleration = numbers(ctx.qacc, n).copy()
    dissipation, drive_power = ctx.dissipation, ctx.drive_power
    qvel[:] = past[0]
    mj_euler(model, data)
    if ctx.drive_way != 0.0:
        _turn_crank(ctx)
    past[0] = qvel
    qvel += h / 8.0 * (7.0 * acceleration - 3.0 * past[1])
    past[1] = acceleration
    if not ctx.joint_is_compliant:
        place = qpos.copy()
        _project(model, data, ctx)
        past[0] += (qpos - place) / h
    mj_forward(model, data)
    ctx.dissipated += 0.5 * h * (dissipation + ctx.dissipation)
    ctx.drive_work += 0.5 * h * (drive_power + ctx.drive_power)


@entry(types.UniTuple(types.intp, 2)(ADDRESS, ADDRESS, CONTEXTS, types.float64[:, ::1], types.float64, types.intp, VECTOR, _ROWS))
def advance(model: int, data: int, context: Any, past: Array, step: float, steps: int, gauges: Array, table: Any) -> tuple[int, int]:
    """Fill `table` (`columns.ROW`, shape (rows,)): the present state, then one row after every `steps` steps of `step` (s).

    `past`: see `_step`; it goes from call to call.

    Returns:
        Number of rows filled, all good ones; and `GOOD`, or the state that ended the run.
    """
    ctx = context[0]
    mj_forward(model, data)
    if step != ctx.step:  # the first one
        ctx.step = step
        past[1] = numbers(ctx.qacc, ctx.coordinates)
        past[0] = numbers(ctx.qvel, ctx.coordinates) - 0.5 * step * past[1]
    for k in range(len(table)):
        for _ in range(steps if k > 0 else 0):
            _step(model, data, ctx, past)
            state = _state(ctx)
            if state != GOOD:
                return k, state
        record(model, data, ctx, gauges, table[k])
        if not math.isfinite(
            table[k].slider_position + table[k].tip_acceleration
        ):  # not the strains, which are nan in a scene without gauges
            return k, NOT_FINITE
    return len(table), GOOD


@entry(types.float64(CONTEXTS, VECTOR, VECTOR, types.float64, types.float64))
def assemble(context: Any, qpos: Array, qvel: Array, crank_angle: float, crank_speed: float) -> float:
    """Turn the base until the slider lies on the centre line, and set its rate to match; hinges and crank keep their angles and rates.

    Returns:
        The remaining gap, m.
    """
    ctx = context[0]
    base = ctx.coordinates - ctx.hinges - 1
    crank_arm = ctx.crank_length * complex(math.cos(crank_angle), math.sin(crank_angle))
    gap = 0.0
    for _ in range(30):
        e = link_directions(ctx, qpos)
        c0, _, _, tangent, gap = find_slider(ctx, e, crank_arm)
        row, crank_row = row_of_gap(ctx, e, c0, tangent, crank_arm)
        if not abs(gap) > 1e-15 * ctx.follower_length:
            break
        qpos[base] -= gap / row[base]
    qvel[base] = -(crank_row * crank_speed + np.dot(row[base + 1 :], qvel[base + 1 :])) / row[base]
    return gap
