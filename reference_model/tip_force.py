"""The force of the tool on the tip over the crank's turn, and the friction of its slide (DERIVATION.md, equations 4.9, 4.11 and 4.12)."""

import math
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from quickreturn.reference_model.tip import ROUNDING, ForceTable, Tip

Array = NDArray[np.float64]
#: Smallest part of the turn (rad) that counts as the whole turn, over which the force is constant.
WHOLE: Final = 2.0 * math.pi - ROUNDING
#: Part of `friction_speed` below which the direction of a velocity does not matter: the friction is then zero to twelve digits.
STILL: Final = 1e-12


def tool_force(
    crank_angle: float, first: float, second: float, begin: float, span: float, ramp: float, table: Array
) -> tuple[float, float, float]:
    """Fraction of the force that acts at a crank angle, and the force in full, N, in its frame; each model compiles it.

    The fraction rises and falls by a polynomial and is twice continuously differentiable. A table acts in full; its force is continuously
    differentiable.

    Args:
        crank_angle: rad.
        first: constant force, N, along the first axis of its frame.
        second: along the second.
        begin: crank angle at which the force, or the table, begins, rad.
        span: crank angle over which it acts, rad.
        ramp: crank angle over which it rises, and over which it falls, rad.
        table: see `constants`; without rows for a constant force.
    """
    if len(table) == 0 and span >= WHOLE:
        return 1.0, first, second
    turned = (crank_angle - begin) % (2.0 * math.pi)
    if len(table) > 0:
        low, high = 0, len(table)
        while high - low > 1:
            middle = (low + high) // 2
            if table[middle, 0] <= turned:
                low = middle
            else:
                high = middle
        u = turned - table[low, 0]
        first = ((table[low, 1] * u + table[low, 2]) * u + table[low, 3]) * u + table[low, 4]
        return 1.0, first, ((table[low, 5] * u + table[low, 6]) * u + table[low, 7]) * u + table[low, 8]
    u = min(turned, span - turned) / ramp
    if u >= 1.0:
        return 1.0, first, second
    return u * u * u * (10.0 + u * (6.0 * u - 15.0)) if u > 0.0 else 0.0, first, second


def constants(tip: Tip) -> dict[str, Any]:
    """The constants of the force for the equations of motion, by their symbols: N and rad.

    `force_table`, shape (points, 9), has the angle of each point from the first one, and for either component the coefficients of the
    cubic behind it by powers of the angle from there, the third power first; (0, 9) without a table.
    """
    table = tip.force_table
    return {
        "force_1": tip.force_scale * tip.components[0],
        "force_2": tip.force_scale * tip.components[1],
        "force_begin": tip.force_from if table is None else table.angles[0],
        "force_span": tip.force_to - tip.force_from,
        "force_ramp": tip.force_ramp,
        "force_table": np.zeros((0, 9)) if table is None else _pieces(table, tip.force_scale),
    }


def _pieces(table: ForceTable, scale: float) -> Array:
    """See `constants`: the monotone cubics of Fritsch and Butland (equation 4.11)."""
    angles = np.array(table.angles) - table.angles[0]
    values = scale * np.array([table.first, table.second])
    gap = np.diff(np.append(angles, 2.0 * math.pi))
    rise = (np.roll(values, -1, axis=1) - values) / gap
    gap_before, rise_before = np.roll(gap, 1), np.roll(rise, 1, axis=1)
    same_way = rise * rise_before > 0.0  # the force rises, or falls, through the point; elsewhere the point is its peak
    divisor = np.where(same_way, rise, 1.0), np.where(same_way, rise_before, 1.0)
    mean = 3.0 * (gap + gap_before) / ((gap + 2.0 * gap_before) / divisor[0] + (2.0 * gap + gap_before) / divisor[1])
    slope = np.where(same_way, mean, 0.0)
    slope_behind = np.roll(slope, -1, axis=1)
    cubic = (slope + slope_behind - 2.0 * rise) / gap**2
    square = (3.0 * rise - 2.0 * slope - slope_behind) / gap
    powers = np.stack([cubic, square, slope, values], axis=2)  # of either component, point by point
    return np.ascontiguousarray(np.column_stack([angles, *powers]))


def tip_force(tip: Tip, crank_angle: Array, end_angle: Array | float) -> NDArray[np.complex128]:
    """The force of the tool in the fixed frame, N, along n1 + i n2; shape as the angles.

    Args:
        tip: says what acts.
        crank_angle: rad.
        end_angle: of the follower's tangent at its flexible end, from n1, rad.
    """
    if not tip.is_forced:
        return np.zeros(np.shape(crank_angle), dtype=np.complex128)
    given = constants(tip).values()
    at = np.array([tool_force(angle, *given) for angle in np.ravel(crank_angle)]).reshape(*np.shape(crank_angle), 3)
    force = at[..., 0] * (at[..., 1] + 1j * at[..., 2])
    return np.asarray(np.exp(1j * np.asarray(end_angle)) * force if tip.follows else force)


def slide_friction(tip: Tip, velocity: NDArray[Any]) -> NDArray[np.complex128]:
    """Friction on the tip that moves at a velocity (m/s, along n1 + i n2), N, likewise (equation 4.12)."""
    speed = np.abs(velocity) + STILL * tip.friction_speed
    return np.asarray(-tip.friction_force * np.tanh(speed / tip.friction_speed) / speed * velocity)
