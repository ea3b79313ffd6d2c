"""The equations of motion, compiled (sections 3 to 5 of DERIVATION.md).

The state (equation 5.1) has no place of the slider, which the crank's angle gives.
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

from numpy.typing import NDArray

from quickreturn.plugins.methods.moving_boundaries import tables as t
from quickreturn.reference_model.compiled_state import state_without_slider_at
from quickreturn.reference_model.native.compilation import inner
from quickreturn.reference_model.native.memory import Cube, Matrix, Vector
from quickreturn.reference_model.native.pointers import reader
from quickreturn.reference_model.state import BY_DRIVE, DISSIPATED
from quickreturn.reference_model.tip import tool_force

Array = NDArray[Any]

tool_at = inner(tool_force)

#: Entries of a signal: value, derivative by l at fixed amplitudes, rate, and second rate (equation 4.1).
VALUE, BY_L, RATE, ACCELERATION = range(4)
#: Entries of `MovingBoundariesWorkspace.facts`: force of the slider, torque of the drive, kinetic and strain energy.
FORCE, TORQUE, KINETIC, STRAIN = range(4)


class MovingBoundariesParameters(NamedTuple):
    """Constants of the equations, SI; read-only in compiled code."""

    n: int  # shapes
    d: float
    LA: float
    L: float
    rhoA: float
    EI: float
    inertia: float  # kg m^2, of the straight follower about P, with base block and tip body
    moment: float  # kg m, its first moment about P
    crank_inertia: float
    crank_moment: float
    base_damping: float
    beam_damping: float
    force_1: float  # N, on the tip, along n1 and n2
    force_2: float
    force_begin: float  # rad, of the crank
    force_span: float
    force_ramp: float
    force_table: Matrix  # without rows: a table is not modelled
    gravity_1: float
    gravity_2: float
    low: float  # m, range of l in the table
    high: float
    coefficients: Cube  # (intervals, powers, length of a row), see `tables.Shapes`


class MovingBoundariesWorkspace(NamedTuple):
    """Intermediate results for the state evaluated last."""

    rows: Matrix  # (3, length of a row) the table's row and its first two derivatives by l
    signals: Matrix  # (VECTORS + MATRICES, 4) of the table's vectors, and of half its quadratic forms (symmetric matrices only)
    facts: Vector  # (4,)
    watched: Vector  # (2,) read by the integrator: arc length of the slider, m; highest angular frequency, rad/s


parameters_at, workspace_at = reader(MovingBoundariesParameters), reader(MovingBoundariesWorkspace)


@inner
def interpolate(p: Any, rows: Array, distance: float) -> None:
    """To `rows`: the table's row at l, and its first two derivatives by l."""
    intervals = len(p.coefficients)
    step = (p.high - p.low) / intervals
    interval = max(0, min(int((distance - p.low) / step), intervals - 1))
    u = (distance - p.low) / step - interval
    for k in range(rows.shape[1]):
        value = by_u = half_by_uu = 0.0
        for power in range(p.coefficients.shape[1]):
            half_by_uu = half_by_uu * u + by_u
            by_u = by_u * u + value
            value = value * u + p.coefficients[interval, power, k]
        rows[0, k], rows[1, k], rows[2, k] = value, by_u / step, 2.0 * half_by_uu / (step * step)


@inner
def dot(row: Array, kind: int, x: Array) -> float:
    """Scalar product of vector number `kind` of a row with x."""
    total = 0.0
    for i in range(len(x)):
        total += row[kind * len(x) + i] * x[i]
    return total


@inner
def form(row: Array, kind: int, x: Array, y: Array) -> float:
    """x^T A y, with A matrix number `kind` of a row."""
    n, total = len(x), 0.0
    for i in range(n):
        for j in range(n):
            total += x[i] * row[t.VECTORS * n + (kind * n + i) * n + j] * y[j]
    return total


@inner
def follow(rows: Array, signals: Array, l_rate: float, l_acceleration: float, eta: Array, eta_rate: Array, eta_acceleration: Array) -> None:
    """To `signals`: those of the table's vectors and symmetric matrices (equation 4.1)."""
    for kind in range(t.VECTORS):
        s = signals[kind]
        s[VALUE], s[BY_L] = dot(rows[0], kind, eta), dot(rows[1], kind, eta)
        s[RATE] = dot(rows[0], kind, eta_rate) + l_rate * s[BY_L]
        s[ACCELERATION] = dot(rows[0], kind, eta_acceleration) + 2.0 * l_rate * dot(rows[1], kind, eta_rate)
        s[ACCELERATION] += l_acceleration * s[BY_L] + l_rate * l_rate * dot(rows[2], kind, eta)
    for kind in range(t.SYMMETRIC, t.MATRICES):
        s = signals[t.VECTORS + kind]
        s[VALUE], s[BY_L] = 0.5 * form(rows[0], kind, eta, eta), 0.5 * form(rows[1], kind, eta, eta)
        s[RATE] = form(rows[0], kind, eta_rate, eta) + l_rate * s[BY_L]
        s[ACCELERATION] = form(rows[0], kind, eta_acceleration, eta) + form(rows[0], kind, eta_rate, eta_rate)
        s[ACCELERATION] += 2.0 * l_rate * form(rows[1], kind, eta_rate, eta) + l_acceleration * s[BY_L]
        s[ACCELERATION] += 0.5 * l_rate * l_rate * form(rows[2], kind, eta, eta)


def kernel(parameters: int, workspace: int, state: int, rate: int) -> int:
    """Write dy/dt of a state to `rate`; the arguments are addresses.

    Returns:
        1; or 0 if the support is outside the table.
    """
    p, w = parameters_at(parameters), workspace_at(workspace)
    n, rows, signals, facts = p.n, w.rows, w.signals, w.facts
    y, y_rate = state_without_slider_at(state, n, n + 1), state_without_slider_at(rate, n, n + 1)
    eta, eta_rate, eta_acceleration = y.eta, y.eta_rate, y_rate.eta_rate
    q1, q1_rate = y.q[0], y.u[0]

    # the line from P to C (equations 1.1 and 1.2), gravity and the force on the tip along and across it
    v1, v2 = p.LA * math.cos(q1) - p.d, p.LA * math.sin(q1)
    distance, theta = math.hypot(v1, v2), math.pi + math.atan2(-v2, -v1)
    if not (p.low <= distance <= p.high and abs(q1) < 1e9):
        return 0
    turn_by_q1, l_by_q1 = p.LA * math.cos(q1 - theta) / distance, -p.LA * math.sin(q1 - theta)
    turn, l_rate = turn_by_q1 * q1_rate, l_by_q1 * q1_rate
    l_acceleration = distance * turn * turn - distance * turn_by_q1 * q1_rate * q1_rate
    turn_rate = (l_by_q1 * q1_rate * q1_rate - 2.0 * l_rate * turn) / distance
    cosine, sine = math.cos(theta), math.sin(theta)
    g1, g2 = cosine * p.gravity_1 + sine * p.gravity_2, cosine * p.gravity_2 - sine * p.gravity_1
    acting, h1, h2 = tool_at(q1, p.force_1, p.force_2, p.force_begin, p.force_span, p.force_ramp, p.force_table)
    f1, f2 = acting * (cosine * h1 + sine * h2), acting * (cosine * h2 - sine * h1)

    # accelerations of the amplitudes (equations 3.5 and 3.6, by the energies of equations 3.1 to 3.4)
    interpolate(p, rows, distance)
    row, row_l = rows[0], rows[1]
    base_rate = turn + dot(row, t.BASE, eta_rate) + l_rate * dot(row_l, t.BASE, eta)
    for i in range(n):
        total = g2 * row[t.WEIGHT * n + i] + f2 * row[t.END * n + i] - turn_rate * row[t.TURNING * n + i]
        total -= row[t.SQUARES * n + i] * eta[i] + p.base_damping * row[t.BASE * n + i] * base_rate
        for j in range(n):
            at = t.VECTORS * n + i * n + j
            carried = row[at + t.CARRIED * n * n]
            stiffness = g1 * row[at + t.HANGING * n * n] + f1 * row[at + t.PULLED * n * n] - turn * turn * row[at + t.ROTATED * n * n]
            stiffness += l_rate * l_rate * (row_l[at + t.CARRIED * n * n] - row[at + t.CARRIED_TWICE * n * n])
            stiffness += l_acceleration * carried + p.beam_damping * l_rate * row[at + t.DRAG_CARRIED * n * n]
            total -= stiffness * eta[j] + (2.0 * l_rate * carried + p.beam_damping * row[at + t.DRAG * n * n]) * eta_rate[j]
        eta_acceleration[i] = total

    # moment about P and force along the line that the line's motion requires (equations 4.2 and 4.3)
    follow(rows, signals, l_rate, l_acceleration, eta, eta_rate, eta_acceleration)
    turning, across, end, base = signals[t.TURNING], signals[t.WEIGHT], signals[t.END], signals[t.BASE]
    carried_twice, rotated = signals[t.VECTORS + t.CARRIED_TWICE], signals[t.VECTORS + t.ROTATED]
    hanging, pulled = signals[t.VECTORS + t.HANGING], signals[t.VECTORS + t.PULLED]
    moment = (p.inertia + 2.0 * rotated[VALUE]) * turn_rate + 2.0 * turn * rotated[RATE] + turning[ACCELERATION]
    moment += p.base_damping * base_rate - (p.moment - hanging[VALUE]) * g2 + across[VALUE] * g1
    moment -= (p.L - pulled[VALUE]) * f2 - end[VALUE] * f1
    drag, drag_twice = form(row, t.DRAG_CARRIED, eta_rate, eta), form(row, t.DRAG_CARRIED_TWICE, eta, eta)
    along = form(row, t.CARRIED, eta_acceleration, eta) + 2.0 * (l_rate * carried_twice[RATE] + l_acceleration * carried_twice[VALUE])
    along += turn_rate * turning[BY_L] - l_rate * l_rate * carried_twice[BY_L] - turn * turn * rotated[BY_L]
    along += g1 * hanging[BY_L] + f1 * pulled[BY_L] - g2 * across[BY_L] - f2 * end[BY_L]
    along += p.base_damping * base_rate * base[BY_L] + p.beam_damping * (drag + l_rate * drag_twice)
    facts[KINETIC] = 0.5 * p.crank_inertia * q1_rate * q1_rate + (0.5 * p.inertia + rotated[VALUE]) * turn * turn + turning[RATE] * turn
    facts[KINETIC] += l_rate * form(row, t.CARRIED, eta_rate, eta) + l_rate * l_rate * carried_twice[VALUE]
    facts[STRAIN] = 0.0
    for i in range(n):
        facts[KINETIC] += 0.5 * eta_rate[i] * eta_rate[i]
        facts[STRAIN] += 0.5 * row[t.SQUARES * n + i] * eta[i] * eta[i]
        along += 0.5 * row_l[t.SQUARES * n + i] * eta[i] * eta[i]

    # force of the slider and torque of the drive (equations 4.4 and 4.5)
    weight = p.crank_moment * (math.cos(q1) * p.gravity_2 - math.sin(q1) * p.gravity_1)
    facts[FORCE], facts[TORQUE] = moment / distance, moment * turn_by_q1 + along * l_by_q1 - weight
    w.watched[0] = distance + signals[t.VECTORS + t.SHORTENED, VALUE]
    w.watched[1] = math.sqrt(row[t.SQUARES * n + n - 1]) if n else 0.0

    # dissipation, and the work of the drive and of the force on the tip (equations 5.2 and 5.3)
    lost = form(row, t.DRAG, eta_rate, eta_rate) + l_rate * (2.0 * drag + l_rate * drag_twice)
    tool = f2 * (turn * (p.L - pulled[VALUE]) + end[RATE]) - f1 * (turn * end[VALUE] + pulled[RATE])
    for i in range(n):
        y_rate.eta[i] = eta_rate[i]
    y_rate.q[0], y_rate.u[0] = q1_rate, 0.0
    y_rate.work[DISSIPATED] = p.base_damping * base_rate * base_rate + p.beam_damping * lost
    y_rate.work[BY_DRIVE] = facts[TORQUE] * q1_rate + tool
    return 1
