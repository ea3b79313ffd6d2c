"""The smooth centre line of the chain, and where the crank tip meets it.

Vectors of the plane are complex numbers, places are relative to P; link i = 0 .. N has the direction e_i = exp(i α_i), link 0 is the base.

The centre line is the quadratic B-spline (C1, uniform) whose control points lie near the hinges V_j,
    Ṽ_j = V_j - h/24 (e_j - e_{j-1}),
    p(x) = Σ c_i(x) e_i, control points mirrored at P and at the end so that the line begins and ends there.
With Ṽ = V the line would be off the beam that the chain stands for by h²/24 W'': if the beam is bent with wave number k, a chain with
hinges of stiffness EI/h and rods of inertia ρA h³/12 has the angles α(1 + k²h²/24) and the link centres W(1 - k²h²/24).
"""

import math

import numpy as np
from numba import types

from quickreturn.engines.mujoco.context import VECTOR, Context, Points, compiled, dot, entry, numbers
from quickreturn.reference_model.arrays import Array
from quickreturn.reference_model.table import table_value

value_at = compiled(table_value)


@entry(VECTOR(types.float64, types.intp, types.float64, types.intp))
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


@compiled
def link_directions(ctx: Context, qpos: Array) -> Points:
    """Directions e_0 .. e_N of the links, shape (N + 1,)."""
    e = np.empty(ctx.hinges + 1, np.complex128)
    angle = 0.0
    for i in range(ctx.hinges + 1):
        angle += qpos[ctx.coordinates - ctx.hinges - 1 + i]
        e[i] = complex(math.cos(angle), math.sin(angle))
    return e


@compiled
def link_rates(ctx: Context, qvel: Array) -> Array:
    """Rates of the links' angles α_0 .. α_N, rad/s, shape (N + 1,)."""
    return np.cumsum(qvel[ctx.coordinates - ctx.hinges - 1 :])


@compiled
def find_slider(ctx: Context, e: Points, crank_arm: complex) -> tuple[Array, Array, Array, complex, float]:
    """The foot of the crank tip on the centre line: c, c', c'', tangent and gap (m) there; sets `ctx.slider_position` to it."""
    place = crank_arm - ctx.pivot_distance
    x = ctx.slider_position
    for _ in range(20):
        c0 = centre_line_coefficients(x, ctx.hinges, ctx.link_length, 0)
        c1 = centre_line_coefficients(x, ctx.hinges, ctx.link_length, 1)
        c2 = centre_line_coefficients(x, ctx.hinges, ctx.link_length, 2)
        away, slope, bend = place - (c0 * e).sum(), (c1 * e).sum(), (c2 * e).sum()
        change = dot(away, slope) / (dot(slope, slope) - dot(away, bend))
        if not abs(change) > 1e-14 * ctx.follower_length:
            break
        x += change
    ctx.slider_position = x
    tangent = slope / abs(slope)
    return c0, c1, c2, tangent, dot(1j * tangent, away)


@compiled
def row_of_gap(ctx: Context, e: Points, c0: Array, tangent: complex, crank_arm: complex) -> tuple[Array, float]:
    """G and G_crank: the rate of the gap is G q̇, plus G_crank q̇1 if the crank's speed is prescribed. G has shape (coordinates,)."""
    crank = dot(1j * tangent, 1j * crank_arm)
    row = np.empty(ctx.coordinates)
    if ctx.crank_is_free:
        row[0] = crank
    outboard = 0.0
    for i in range(ctx.hinges, -1, -1):
        outboard -= c0[i] * dot(tangent, e[i])
        row[ctx.coordinates - ctx.hinges - 1 + i] = outboard
    return row, crank


@compiled
def row_of_sliding(ctx: Context, e: Points, at: tuple[Array, Array, Array, complex], crank_arm: complex) -> tuple[Array, float, float]:
    """S, S_crank and 1/(1 - gap curvature): the rate of the foot's arc length is S q̇, plus S_crank q̇1 as in `row_of_gap`.

    Args:
        ctx: the simulation, with its gap.
        e: directions of the links.
        at: c, c', c'' and the tangent at the foot, see `find_slider`.
        crank_arm: from O to the crank tip, m.
    """
    c0, c1, c2, tangent = at
    normal, slope = 1j * tangent, abs((c1 * e).sum())
    share = 1.0 / (1.0 - ctx.gap * dot(normal, (c2 * e).sum()) / slope**2)
    crank = share * dot(tangent, 1j * crank_arm)
    row = np.empty(ctx.coordinates)
    if ctx.crank_is_free:
        row[0] = crank
    outboard = 0.0
    for i in range(ctx.hinges, -1, -1):
        outboard += share * (c0[i] * dot(normal, e[i]) + ctx.gap / slope * c1[i] * dot(tangent, e[i]))
        row[ctx.coordinates - ctx.hinges - 1 + i] = outboard
    return row, crank, share


@compiled
def by_table(ctx: Context, point: float) -> tuple[float, float]:
    """What the drive's table says at a point, and its slope."""
    return value_at(point, numbers(ctx.drive_table, 5 * ctx.drive_points).reshape((ctx.drive_points, 5)), ctx.drive_period)


@compiled
def crank_of(ctx: Context, time: float, qpos: Array, qvel: Array) -> tuple[complex, float, float, float]:
    """The crank's arm from O to the slider (m), angle (rad), speed (rad/s), and the acceleration that is prescribed (rad/s^2)."""
    acceleration = 0.0
    if ctx.crank_is_free:
        angle, speed = qpos[0], qvel[0]
    elif ctx.drive_points > 0:
        angle = ctx.prescribed_angle
        speed, slope = by_table(ctx, ctx.drive_way * (angle - ctx.drive_begin))
        acceleration = ctx.drive_way * slope * speed
    else:
        angle, speed = ctx.prescribed_angle + ctx.prescribed_speed * time, ctx.prescribed_speed
    return ctx.crank_length * complex(math.cos(angle), math.sin(angle)), angle, speed, acceleration


@compiled
def rate_of(ctx: Context, row: Array, qvel: Array, crank_row: float, crank_speed: float) -> float:
    """Rate that a row, such as `row_of_gap`, gives for the rates of the coordinates and the crank's speed."""
    rate = np.dot(row, qvel)
    return rate if ctx.crank_is_free else rate + crank_row * crank_speed
