"""Everything that runs compiled: the smooth centre line, the sliding constraint in MuJoCo's control hook, and the time loop.

A follower alone has a torque on its base in place of the constraint. One file on purpose: numba's cache notices a change of the file that
a function is in, not of the files whose functions it calls.

Points of the plane are complex numbers seen from P; link i = 0 .. N has the direction e_i = exp(i α_i), link 0 is the base.

The centre line is the quadratic B-spline (C1, uniform) whose control points lie beside the hinges V_j,
    Ṽ_j = V_j - h/24 (e_j - e_{j-1}),
    p(x) = Σ c_i(x) e_i, control points mirrored at P and at the end so that the line begins and ends there.
With Ṽ = V the line would lie h²/24 W'' beside the beam that the chain stands for: hinges of stiffness EI/h and rods of inertia
ρA h³/12 make angles α(1 + k²h²/24) and link centres W(1 - k²h²/24) of a beam bent with wave number k.
"""

import math
from collections.abc import Callable
from typing import Any, TypeVar

import numba
import numpy as np
from numba import carray, cfunc, njit, types  # type: ignore[attr-defined]
from numpy.typing import NDArray

from quickreturn.engines.mujoco.native import (
    mj_energy_position,
    mj_energy_velocity,
    mj_forward,
    mj_get_state,
    mj_solve_mass,
    mj_step,
    pointer,
)
from quickreturn.reference_model import joint
from quickreturn.reference_model.columns import PLACES, ROW
from quickreturn.reference_model.spin_up import base_motion as motion_of_base
from quickreturn.reference_model.tip_force import share as share_of_force

#: One simulation as compiled code sees it. Lengths in m, angles in rad.
CONTEXT = np.dtype(
    [
        # addresses of arrays of MjData, and the number of its coordinates
        ("qpos", "i8"),
        ("qvel", "i8"),
        ("qacc", "i8"),
        ("force_bias", "i8"),
        ("force_passive", "i8"),
        ("force_applied", "i8"),
        ("energy", "i8"),
        ("coordinates", "i8"),
        # the scene
        ("hinges", "i8"),
        ("link_length", "f8"),
        ("follower_length", "f8"),
        ("bending_stiffness", "f8"),  # N m^2, 0 for a rigid follower
        ("half_thickness", "f8"),
        ("beam_damping", "f8"),  # N s/m^2
        ("material_damping", "f8"),  # s
        ("base_damping", "f8"),  # N m s/rad
        ("base_friction", "f8"),  # N m
        ("pivot_distance", "f8"),
        ("crank_length", "f8"),
        ("crank_is_free", "i8"),
        ("crank_torque", "f8"),  # N m
        ("crank_damping", "f8"),  # N m s/rad
        ("prescribed_angle", "f8"),  # at time 0
        ("prescribed_speed", "f8"),
        ("prescribed_inertia", "f8"),  # kg m^2 about O, crank and slider
        ("prescribed_weight_1", "f8"),  # N m, gravity's potential energy of crank and slider is w1 cos q1 + w2 sin q1
        ("prescribed_weight_2", "f8"),
        ("crank_mass", "f8"),  # kg, with the slider
        ("crank_moment", "f8"),  # kg m, the same times its distance from O
        ("mass_per_length", "f8"),  # kg/m
        ("tip_mass", "f8"),
        ("tip_offset", "f8"),  # of its centre beyond the end
        ("gravity", "c16"),  # m/s^2, along n1 + i n2
        ("tip_force", "c16"),  # N
        ("force_begin", "f8"),  # of the crank's turn
        ("force_span", "f8"),
        ("force_ramp", "f8"),
        ("base_is_prescribed", "i8"),  # then there is neither crank nor slider
        ("spin_up_speed", "f8"),
        ("spin_up_time", "f8"),  # s
        ("joint_is_compliant", "i8"),
        ("plus", "f8"),  # this and the next five: see `joint.Rollers`
        ("minus", "f8"),
        ("plus_from", "f8"),
        ("minus_from", "f8"),
        ("contact_loss", "f8"),
        ("joint_damping", "f8"),
        ("friction", "f8"),  # 1
        ("friction_force", "f8"),  # N
        ("friction_speed", "f8"),  # m/s
        # the slider now
        ("slider_position", "f8"),
        ("slider_speed", "f8"),
        ("slider_force", "f8"),  # N, on the follower
        ("tangential_force", "f8"),  # N, the same
        ("slider_couple", "f8"),  # N m, the same: friction acts at the crank tip, which is beside the line
        ("gap", "f8"),
        # the crank's motor and the dampings: now, and integrated with the weights of the Runge-Kutta stages
        ("drive_torque", "f8"),
        ("stage", "i8"),
        ("mean_drive_power", "f8"),
        ("mean_dissipation", "f8"),
        ("drive_work", "f8"),
        ("dissipated", "f8"),
    ]
)

GOOD, SLIDER_LEFT, NOT_FINITE = 0, 1, 2

_TIME_AND_USERDATA = (1 << 0) | (1 << 12)  # mjSTATE_TIME | mjSTATE_USERDATA
_STAGE_WEIGHTS = (1.0 / 6.0, 1.0 / 3.0, 1.0 / 3.0, 1.0 / 6.0)
_LARGEST_RATE = 1e7  # rad/s: beyond, nothing is a motion any more; MuJoCo itself warns at 1e10

_context_record = numba.from_dtype(CONTEXT)

Context = Any  # a record of CONTEXT: numba gives its fields as attributes
Array = NDArray[np.float64]
Points = NDArray[np.complex128]
Function = TypeVar("Function", bound=Callable[..., Any])

_address, _vector, _contexts, _rows = types.intp, types.float64[::1], _context_record[::1], numba.from_dtype(ROW)[::1]


def _compiled(function: Function) -> Function:
    """Compile into callers."""
    return njit(function)


def _entry(signature: Any) -> Callable[[Function], Function]:
    """Compile at import, or load what an earlier process compiled: no first call is slower than the next."""
    return njit(signature, cache=True)


share, base_motion = _compiled(share_of_force), _compiled(motion_of_base)
joint_force, joint_energy, friction_share = _compiled(joint.joint_force), _compiled(joint.joint_energy), _compiled(joint.friction_share)


@_compiled
def _array(address: int, length: int) -> Array:
    """MuJoCo's numbers in place."""
    return carray(pointer(address), length, np.float64)


@_compiled
def _dot(a: complex, b: complex) -> float:
    return a.real * b.real + a.imag * b.imag


@_entry(_vector(types.float64, types.intp, types.float64, types.intp))
def centre_line_coefficients(x: float, hinges: int, link_length: float, order: int) -> Array:
    """c_i (order 0) or its derivative by x (order 1 or 2), i = 0 .. N, for p(x) = Σ c_i(x) e_i; shape (N + 1,)."""
    h, c = link_length, np.zeros(hinges + 1)
    if hinges == 0:
        c[0] = (x, 1.0, 0.0)[order]
        return c
    segment = min(max(int(x / h), 0), hinges - 1)  # [segment h, (segment + 1) h] around hinge segment + 1
    u = x / h - segment
    if order == 0:
        before, at, after = 0.5 * (1.0 - u) ** 2, 0.5 + u - u**2, 0.5 * u**2
        c[0] = 0.5 * h
        c[1 : segment + 1] = h
        c[segment] -= h * before
        c[segment + 1] += h * after
    elif order == 1:
        before, at, after = u - 1.0, 1.0 - 2.0 * u, u
        c[segment], c[segment + 1] = -before, after
        h = 1.0
    else:
        before, at, after = 1.0, -2.0, 1.0
        c[segment], c[segment + 1] = -1.0 / h, 1.0 / h
        h = 1.0 / h
    for offset, weight in ((0, before), (1, at), (2, after)):
        j, sign = segment + offset, 1.0
        if j == 0:
            j, sign = 1, -1.0
        elif j == hinges + 1:
            j, sign = hinges, -1.0
        c[j] -= sign * weight * h / 24.0
        c[j - 1] += sign * weight * h / 24.0
    return c


@_compiled
def _directions(ctx: Context, qpos: Array) -> Points:
    """e_0 .. e_N."""
    e = np.empty(ctx.hinges + 1, np.complex128)
    angle = 0.0
    for i in range(ctx.hinges + 1):
        angle += qpos[ctx.coordinates - ctx.hinges - 1 + i]
        e[i] = complex(math.cos(angle), math.sin(angle))
    return e


@_compiled
def _rates(ctx: Context, qvel: Array) -> Array:
    """Rates of α_0 .. α_N."""
    return np.cumsum(qvel[ctx.coordinates - ctx.hinges - 1 :])


@_compiled
def _find_slider(ctx: Context, e: Points, crank_arm: complex) -> tuple[Array, Array, Array, complex, float]:
    """The foot of the crank tip on the centre line: (c, c', c'', tangent, gap) there; moves `ctx.slider_position`."""
    place = crank_arm - ctx.pivot_distance
    x = ctx.slider_position
    for _ in range(20):
        c0 = centre_line_coefficients(x, ctx.hinges, ctx.link_length, 0)
        c1 = centre_line_coefficients(x, ctx.hinges, ctx.link_length, 1)
        c2 = centre_line_coefficients(x, ctx.hinges, ctx.link_length, 2)
        away, slope, bend = place - (c0 * e).sum(), (c1 * e).sum(), (c2 * e).sum()
        change = _dot(away, slope) / (_dot(slope, slope) - _dot(away, bend))
        if not abs(change) > 1e-14 * ctx.follower_length:
            break
        x += change
    ctx.slider_position = x
    tangent = slope / abs(slope)
    return c0, c1, c2, tangent, _dot(1j * tangent, away)


@_compiled
def _constraint_row(ctx: Context, e: Points, c0: Array, tangent: complex, crank_arm: complex) -> tuple[Array, float]:
    """(G, G_crank): rate of the gap is G q̇ + G_crank q̇1; in G, too, if the crank is free. G has shape (coordinates,)."""
    crank = _dot(1j * tangent, 1j * crank_arm)
    row = np.empty(ctx.coordinates)
    if ctx.crank_is_free:
        row[0] = crank
    outboard = 0.0
    for i in range(ctx.hinges, -1, -1):
        outboard -= c0[i] * _dot(tangent, e[i])
        row[ctx.coordinates - ctx.hinges - 1 + i] = outboard
    return row, crank


@_compiled
def _sliding_row(ctx: Context, e: Points, at: tuple[Array, Array, Array, complex], crank_arm: complex) -> tuple[Array, float, float]:
    """(S, S_crank, 1/(1 - gap curvature)): rate of the foot's arc length is S q̇ + S_crank q̇1, as with `_constraint_row`.

    Args:
        ctx: the simulation, with its gap.
        e: directions of the links.
        at: c, c', c'' and the tangent there, see `_find_slider`.
        crank_arm: from O to the crank tip.
    """
    c0, c1, c2, tangent = at
    normal, slope = 1j * tangent, abs((c1 * e).sum())
    share = 1.0 / (1.0 - ctx.gap * _dot(normal, (c2 * e).sum()) / slope**2)
    crank = share * _dot(tangent, 1j * crank_arm)
    row = np.empty(ctx.coordinates)
    if ctx.crank_is_free:
        row[0] = crank
    outboard = 0.0
    for i in range(ctx.hinges, -1, -1):
        outboard += share * (c0[i] * _dot(normal, e[i]) + ctx.gap / slope * c1[i] * _dot(tangent, e[i]))
        row[ctx.coordinates - ctx.hinges - 1 + i] = outboard
    return row, crank, share


@_compiled
def _crank(ctx: Context, time: float, qpos: Array, qvel: Array) -> tuple[complex, float, float]:
    """(arm from O to the slider, angle, speed)."""
    if ctx.crank_is_free:
        angle, speed = qpos[0], qvel[0]
    else:
        angle, speed = ctx.prescribed_angle + ctx.prescribed_speed * time, ctx.prescribed_speed
    return ctx.crank_length * complex(math.cos(angle), math.sin(angle)), angle, speed


@_compiled
def _damp_beam(ctx: Context, e: Points, rates: Array, force: Array) -> float:
    """Add the forces of the distributed damping to the hinges' share of `force`; returns the power taken, W.

    It acts on the link centres' velocity relative to the base frame, so it does no work on a turn of the whole follower.
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
        power += ctx.beam_damping * length * _dot(center, center)
        velocity += length * turning
    outboard, moment = 0j, 0.0
    for i in range(n, 0, -1):
        length = h if i < n else 0.5 * h
        moment += _dot(1j * e[i], length * (0.5 * resistance[i] + outboard))
        outboard += resistance[i]
        force[first + i] += moment
    return power


@_compiled
def _damp_hinges(ctx: Context, qvel: Array) -> float:
    """Power that the material takes in the hinges, W; MuJoCo's joints have the moments of it."""
    if ctx.material_damping == 0.0:
        return 0.0
    rates = qvel[ctx.coordinates - ctx.hinges :]
    return ctx.material_damping * ctx.bending_stiffness / ctx.link_length * np.sum(rates**2)


@_compiled
def _rub_pivot(ctx: Context, rate: float, force: Array) -> float:
    """Add the friction of the pivot to the base's share of `force`; returns the power taken, W."""
    if ctx.base_friction == 0.0:
        return 0.0
    moment = ctx.base_friction * friction_share(rate, joint.PIVOT_FRICTION_RATE)
    force[ctx.coordinates - ctx.hinges - 1] -= moment
    return moment * rate


@_compiled
def _hold(model: int, data: int, ctx: Context, rows: tuple[Array, Array], remaining: float, sliding: float, applied: Array) -> float:
    """Multiplier of a rigid joint: the gap's acceleration vanishes. The slider's friction is in proportion to it, and so found with it.

    Args:
        model: by address; `data` alike.
        data: see `model`.
        ctx: the simulation.
        rows: of `_constraint_row` and `_sliding_row`.
        remaining: the gap's acceleration without that of the coordinates, m/s^2.
        sliding: share of the friction that acts, with its sign.
        applied: forces without the joint's.
    """
    n, row = ctx.coordinates, rows[0]
    count = 2 if ctx.friction == 0.0 else 3
    known, solved = np.empty((count, n)), np.empty((count, n))
    known[0] = _array(ctx.force_passive, n) - _array(ctx.force_bias, n) + applied
    known[1] = row
    if ctx.friction > 0.0:
        known[2] = rows[1]
    mj_solve_mass(model, data, solved.ctypes.data, known.ctypes.data, count)
    asked, held = -(np.dot(row, solved[0]) + remaining), np.dot(row, solved[1])
    if ctx.friction > 0.0:
        held -= math.copysign(ctx.friction, asked) * sliding * np.dot(row, solved[2])
        if not held > 0.0:  # the friction jams the slider
            return math.nan
    return asked / held


@_compiled
def _pushes(ctx: Context, crank_angle: float) -> complex:
    """The force on the tip, N, along n1 + i n2."""
    if ctx.tip_force == 0.0:
        return 0j
    return ctx.tip_force * share(crank_angle, ctx.force_begin, ctx.force_span, ctx.force_ramp)


@_compiled
def _push_tip(ctx: Context, crank_angle: float, e: Points, rates: Array, force: Array) -> float:
    """Add the force on the tip, the centre line's end; returns its power, W."""
    pushed = _pushes(ctx, crank_angle)
    if pushed == 0.0:
        return 0.0
    first = ctx.coordinates - ctx.hinges - 1
    at_tip = centre_line_coefficients(ctx.follower_length, ctx.hinges, ctx.link_length, 0)
    moment = power = 0.0
    for i in range(ctx.hinges, -1, -1):
        part = at_tip[i] * _dot(1j * e[i], pushed)
        moment += part
        force[first + i] += moment
        power += part * rates[i]
    return power


@_compiled
def _rate(ctx: Context, row: Array, qvel: Array, crank_row: float, crank_speed: float) -> float:
    """Rate that a row of the coordinates' rates, and of the crank's, describes."""
    along = np.dot(row, qvel)
    return along if ctx.crank_is_free else along + crank_row * crank_speed


@_compiled
def _constrain(model: int, data: int, ctx: Context, time: float) -> None:
    """The hook's work: drive and damping, and the slider force, into `force_applied`.

    A rigid joint's force keeps the gap's acceleration zero, a compliant one's follows from gap and gap rate.
    """
    n = ctx.coordinates
    qpos, qvel, applied = _array(ctx.qpos, n), _array(ctx.qvel, n), _array(ctx.force_applied, n)

    e, rates = _directions(ctx, qpos), _rates(ctx, qvel)
    crank_arm, angle, crank_speed = _crank(ctx, time, qpos, qvel)
    c0, c1, c2, tangent, ctx.gap = _find_slider(ctx, e, crank_arm)
    normal = 1j * tangent
    row, crank_row = _constraint_row(ctx, e, c0, tangent, crank_arm)

    turning = 1j * rates * e
    slope = (c1 * e).sum()
    ctx.slider_speed = _dot(tangent, 1j * crank_arm * crank_speed - (c0 * turning).sum()) / abs(slope)
    follower = -(c0 * rates**2 * e).sum() + 2.0 * ctx.slider_speed * (c1 * turning).sum() + ctx.slider_speed**2 * (c2 * e).sum()
    remaining = _dot(normal, -crank_arm * crank_speed**2 - follower)

    applied[:] = 0.0
    if ctx.crank_is_free:
        applied[0] = ctx.crank_torque
    dissipation = ctx.crank_damping * crank_speed**2 + ctx.base_damping * rates[0] ** 2
    dissipation += _damp_beam(ctx, e, rates, applied) + _damp_hinges(ctx, qvel) + _rub_pivot(ctx, rates[0], applied)
    tool_power = _push_tip(ctx, angle, e, rates, applied)

    rubs = ctx.friction > 0.0 or ctx.friction_force > 0.0
    sliding, sliding_speed, sliding_row, crank_sliding, share_at_foot = 0.0, 0.0, row, 0.0, 1.0
    if rubs:
        sliding_row, crank_sliding, share_at_foot = _sliding_row(ctx, e, (c0, c1, c2, tangent), crank_arm)
        sliding_speed = _rate(ctx, sliding_row, qvel, crank_sliding, crank_speed)
        sliding = friction_share(sliding_speed, ctx.friction_speed)
        applied -= ctx.friction_force * sliding * sliding_row
    if ctx.joint_is_compliant:
        gap_rate = _rate(ctx, row, qvel, crank_row, crank_speed)
        law = ctx.plus, ctx.minus, ctx.plus_from, ctx.minus_from
        multiplier = -joint_force(ctx.gap, gap_rate, *law, ctx.contact_loss, ctx.joint_damping)
        dissipation -= gap_rate * (multiplier + joint_force(ctx.gap, 0.0, *law, 0.0, 0.0))
    else:
        multiplier = _hold(model, data, ctx, (row, sliding_row), remaining, sliding, applied)
    applied += multiplier * row
    ctx.slider_force = -multiplier
    ctx.drive_torque = ctx.crank_torque
    if not ctx.crank_is_free:
        weight = ctx.prescribed_weight_2 * math.cos(angle) - ctx.prescribed_weight_1 * math.sin(angle)
        ctx.drive_torque = weight - multiplier * crank_row
    if rubs:
        with_force = ctx.friction * abs(multiplier) * sliding
        applied -= with_force * sliding_row
        along = ctx.friction_force * sliding + with_force
        dissipation += along * sliding_speed
        ctx.tangential_force = along * share_at_foot
        ctx.slider_couple = -ctx.gap * ctx.tangential_force
        if not ctx.crank_is_free:
            ctx.drive_torque += along * crank_sliding
    if ctx.stage < 4:
        ctx.mean_dissipation += _STAGE_WEIGHTS[ctx.stage] * dissipation
        ctx.mean_drive_power += _STAGE_WEIGHTS[ctx.stage] * (ctx.drive_torque * crank_speed + tool_power)
        ctx.stage += 1


@_compiled
def _turn_base(model: int, data: int, ctx: Context, time: float) -> None:
    """The hook's work without crank and slider: the damping, and the torque on the base that gives it the prescribed acceleration."""
    n = ctx.coordinates
    qpos, qvel, applied = _array(ctx.qpos, n), _array(ctx.qvel, n), _array(ctx.force_applied, n)
    rates = _rates(ctx, qvel)
    applied[:] = 0.0
    dissipation = ctx.base_damping * rates[0] ** 2 + _damp_beam(ctx, _directions(ctx, qpos), rates, applied)
    dissipation += _damp_hinges(ctx, qvel) + _rub_pivot(ctx, rates[0], applied)
    known, solved = np.zeros((2, n)), np.empty((2, n))
    known[0] = _array(ctx.force_passive, n) - _array(ctx.force_bias, n) + applied
    known[1, 0] = 1.0
    mj_solve_mass(model, data, solved.ctypes.data, known.ctypes.data, 2)
    ctx.drive_torque = (base_motion(ctx.spin_up_speed, ctx.spin_up_time, time)[2] - solved[0, 0]) / solved[1, 0]
    applied[0] += ctx.drive_torque
    if ctx.stage < 4:
        ctx.mean_dissipation += _STAGE_WEIGHTS[ctx.stage] * dissipation
        ctx.mean_drive_power += _STAGE_WEIGHTS[ctx.stage] * ctx.drive_torque * rates[0]
        ctx.stage += 1


@cfunc(types.void(types.intp, types.intp), cache=True)
def control_hook(model: int, data: int) -> None:
    """MuJoCo's `mjcb_control`: called in every stage of a step, when the mass matrix and all other forces are known."""
    time_and_context = np.empty(2)
    mj_get_state(model, data, time_and_context.ctypes.data, _TIME_AND_USERDATA)
    context = carray(pointer(int(time_and_context[1])), 1, CONTEXT)
    if context[0].base_is_prescribed:
        _turn_base(model, data, context[0], time_and_context[0])
    else:
        _constrain(model, data, context[0], time_and_context[0])


@_compiled
def _project(model: int, data: int, ctx: Context) -> None:
    """Close the gap that the step left, and its rate, along M⁻¹Gᵀ (M of the last stage)."""
    n = ctx.coordinates
    qpos, qvel = _array(ctx.qpos, n), _array(ctx.qvel, n)
    time_and_context = np.empty(2)
    mj_get_state(model, data, time_and_context.ctypes.data, _TIME_AND_USERDATA)
    if ctx.base_is_prescribed:  # what the step left is its own error
        qpos[0], qvel[0], _ = base_motion(ctx.spin_up_speed, ctx.spin_up_time, time_and_context[0])
        return
    direction = np.empty(n)
    for iteration in range(6):
        crank_arm, _, crank_speed = _crank(ctx, time_and_context[0], qpos, qvel)
        e = _directions(ctx, qpos)
        c0, _, _, tangent, gap = _find_slider(ctx, e, crank_arm)
        row, crank_row = _constraint_row(ctx, e, c0, tangent, crank_arm)
        if iteration == 0:
            mj_solve_mass(model, data, direction.ctypes.data, row.ctypes.data, 1)
        elif not abs(gap) > 1e-15 * ctx.follower_length:
            break
        qpos -= direction * (gap / np.dot(row, direction))
    qvel -= direction * (_rate(ctx, row, qvel, crank_row, crank_speed) / np.dot(row, direction))


@_compiled
def _smooth_moments(ctx: Context, qpos: Array, qvel: Array) -> Array:
    """Bending moment over EI at the hinges, 1/m, without the kink and the jump that the slider makes; shape (N,).

    The slider force F bends hinge j by F b_j, b_j = Σ_{i >= j} c_i; the beam by the ramp F (s - x) inboard of the slider. Its couple acts
    with the derivatives of the c_i.
    """
    smooth = np.empty(ctx.hinges)
    if ctx.hinges == 0:
        return smooth
    kink, jump = ctx.slider_force / ctx.bending_stiffness, ctx.slider_couple / ctx.bending_stiffness
    c0 = centre_line_coefficients(ctx.slider_position, ctx.hinges, ctx.link_length, 0)
    c1 = centre_line_coefficients(ctx.slider_position, ctx.hinges, ctx.link_length, 1)
    lever = turned = 0.0
    for j in range(ctx.hinges, 0, -1):
        lever += c0[j]
        turned += c1[j]
        k = ctx.coordinates - ctx.hinges - 1 + j
        bent = qpos[k] + ctx.material_damping * qvel[k]
        smooth[j - 1] = bent / ctx.link_length - kink * lever - jump * turned
    return smooth


@_compiled
def _at_place(ctx: Context, smooth: Array, x: float) -> float:
    """A field at the arc length x by the cubic through the four nearest hinges; 0 where there is no hinge."""
    if ctx.hinges == 0:
        return 0.0
    if not math.isfinite(x):
        return math.nan
    points = min(4, ctx.hinges)
    place = x / ctx.link_length - 0.5  # in links from the first hinge
    left = min(max(math.floor(place) - 1, 0), ctx.hinges - points)
    value = 0.0
    for j in range(left, left + points):
        weight = 1.0
        for k in range(left, left + points):
            if k != j:
                weight *= (place - k) / (j - k)
        value += weight * smooth[j]
    return value


@_compiled
def _moment(ctx: Context, smooth: Array, x: float) -> float:
    """Bending moment over EI at the arc length x, 1/m, kink and jump included; at the slider the outboard one."""
    if ctx.hinges == 0:
        return 0.0
    jump = ctx.slider_couple / ctx.bending_stiffness if x < ctx.slider_position else 0.0
    return _at_place(ctx, smooth, x) + ctx.slider_force / ctx.bending_stiffness * max(0.0, ctx.slider_position - x) + jump


@_compiled
def _follower_inertia(ctx: Context, e: Points, rates: Array, accelerations: Array) -> complex:
    """Rate of the momentum of all links and the tip body, less their weight, N, along n1 + i n2."""
    n, h, at_hinge, total = ctx.hinges, ctx.link_length, 0j, 0j
    for i in range(n + 1):
        length = h if 0 < i < n else (0.5 * h if n else ctx.follower_length)
        turning = (1j * accelerations[i] - rates[i] ** 2) * e[i]
        total += ctx.mass_per_length * length * (at_hinge + 0.5 * length * turning - ctx.gravity)
        at_hinge += length * turning
    return total + ctx.tip_mass * (at_hinge + ctx.tip_offset * turning - ctx.gravity)


@_compiled
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
    pivot = _follower_inertia(ctx, e, rates, accelerations) - _pushes(ctx, angle) - on_follower
    swing = (1j * acceleration - speed**2) * complex(math.cos(angle), math.sin(angle))
    return pivot, ctx.crank_moment * swing - ctx.crank_mass * ctx.gravity + on_follower


@_compiled
def _record(model: int, data: int, ctx: Context, gauges: Array, row: Any) -> None:
    """Fill a `columns.ROW` from the present state. Gauges: arc lengths, (3,)."""
    n, hinges = ctx.coordinates, ctx.hinges
    qpos, qvel = _array(ctx.qpos, n), _array(ctx.qvel, n)
    qacc, energy = _array(ctx.qacc, n), _array(ctx.energy, 2)
    ctx.stage = 4  # no stage of a step
    mj_forward(model, data)
    mj_energy_position(model, data)
    mj_energy_velocity(model, data)

    time_and_context = np.empty(2)
    mj_get_state(model, data, time_and_context.ctypes.data, _TIME_AND_USERDATA)
    _, angle, crank_speed = _crank(ctx, time_and_context[0], qpos, qvel)
    first = n - hinges - 1
    e, rates, accelerations = _directions(ctx, qpos), _rates(ctx, qvel), np.cumsum(qacc[first:])
    at_tip = centre_line_coefficients(ctx.follower_length, hinges, ctx.link_length, 0)
    tip = (at_tip * e).sum()
    tip_acceleration = (at_tip * (1j * accelerations - rates**2) * e).sum()
    base_angle = qpos[first]
    if hinges >= 2:
        base_angle += (qpos[first + 2] - qpos[first + 1]) / 24.0  # the beam's tangent, h²/24 dκ/dx beside the link's
    strain_energy = 0.5 * ctx.bending_stiffness / ctx.link_length * np.sum(qpos[first + 1 :] ** 2)
    smooth, bending_rates = _smooth_moments(ctx, qpos, qvel), qvel[first + 1 :] / ctx.link_length
    gravity = energy[0] - strain_energy
    strain_energy += joint_energy(ctx.gap, ctx.plus, ctx.minus, ctx.plus_from, ctx.minus_from)
    gravity += ctx.prescribed_weight_1 * math.cos(angle) + ctx.prescribed_weight_2 * math.sin(angle)

    row.crank_angle, row.crank_speed = angle, crank_speed
    row.follower_angle, row.slider_position = base_angle, ctx.slider_position
    row.tip_x, row.tip_y = ctx.pivot_distance + tip.real, tip.imag
    across = 1j * complex(math.cos(base_angle), math.sin(base_angle))
    row.tip_deflection = _dot(across, tip)
    for place in range(1, PLACES + 1):
        x = place * ctx.follower_length / (PLACES + 1)
        line = centre_line_coefficients(x, hinges, ctx.link_length, 0)
        row.shapes[place - 1] = _dot(across, (line * e).sum())
        row.moments[place - 1] = ctx.bending_stiffness * _moment(ctx, smooth, x)
    row.moment_slider = ctx.bending_stiffness * _moment(ctx, smooth, ctx.slider_position)
    row.tip_acceleration = _dot(1j * e[hinges], tip_acceleration)
    for gauge in range(3):
        curvature = _moment(ctx, smooth, gauges[gauge])
        if ctx.material_damping > 0.0:
            curvature -= ctx.material_damping * _at_place(ctx, bending_rates, gauges[gauge])
        row.strains[gauge] = ctx.half_thickness * curvature
    crank = angle, crank_speed, qacc[0] if ctx.crank_is_free else 0.0
    pivot, at_crank = _bearing_forces(ctx, crank, e, rates, accelerations)
    row.pivot_force_x, row.pivot_force_y = pivot.real, pivot.imag
    row.crank_force_x, row.crank_force_y = at_crank.real, at_crank.imag
    row.slider_force, row.crank_torque = ctx.slider_force, ctx.drive_torque
    row.kinetic_energy = energy[1] + 0.5 * ctx.prescribed_inertia * ctx.prescribed_speed**2
    row.strain_energy, row.dissipated_energy, row.constraint_gap = strain_energy, ctx.dissipated, abs(ctx.gap)
    row.gravity_energy, row.drive_work = gravity, ctx.drive_work


@_compiled
def _state(ctx: Context) -> int:
    """GOOD, or what is wrong with the present state."""
    qvel = _array(ctx.qvel, ctx.coordinates)
    if not np.max(np.abs(qvel)) < _LARGEST_RATE or not math.isfinite(ctx.slider_position):
        return NOT_FINITE
    if not 0.0 <= ctx.slider_position <= ctx.follower_length:
        return SLIDER_LEFT
    return GOOD


@_entry(types.UniTuple(types.intp, 2)(_address, _address, _contexts, types.float64, types.intp, _vector, _rows))
def advance(model: int, data: int, context: Any, step: float, steps: int, gauges: Array, table: Any) -> tuple[int, int]:
    """Fill `table` (`columns.ROW`, shape (rows,)): the present state, then one row after every `steps` steps of `step` (s).

    Returns:
        (rows filled, GOOD or why it ended early). Good rows only.
    """
    ctx = context[0]
    for k in range(len(table)):
        for _ in range(steps if k > 0 else 0):
            ctx.stage, ctx.mean_dissipation, ctx.mean_drive_power = 0, 0.0, 0.0
            mj_step(model, data)
            if not ctx.joint_is_compliant:
                _project(model, data, ctx)
            ctx.dissipated += step * ctx.mean_dissipation
            ctx.drive_work += step * ctx.mean_drive_power
            state = _state(ctx)
            if state != GOOD:
                return k, state
        _record(model, data, ctx, gauges, table[k])
        if not math.isfinite(table[k].slider_position + table[k].tip_acceleration):  # strains of a scene without gauges are no numbers
            return k, NOT_FINITE
    return len(table), GOOD


@_entry(types.float64(_contexts, _vector, _vector, types.float64, types.float64))
def assemble(context: Any, qpos: Array, qvel: Array, crank_angle: float, crank_speed: float) -> float:
    """Turn the base until the slider lies on the centre line, and set its rate likewise; hinges and crank stay as they are.

    Returns:
        The gap that is left, m.
    """
    ctx = context[0]
    base = ctx.coordinates - ctx.hinges - 1
    crank_arm = ctx.crank_length * complex(math.cos(crank_angle), math.sin(crank_angle))
    gap = 0.0
    for _ in range(30):
        e = _directions(ctx, qpos)
        c0, _, _, tangent, gap = _find_slider(ctx, e, crank_arm)
        row, crank_row = _constraint_row(ctx, e, c0, tangent, crank_arm)
        if not abs(gap) > 1e-15 * ctx.follower_length:
            break
        qpos[base] -= gap / row[base]
    qvel[base] = -(crank_row * crank_speed + np.dot(row[base + 1 :], qvel[base + 1 :])) / row[base]
    return gap
