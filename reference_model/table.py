"""A table of a machine: a force over the crank's turn, a torque over the crank's speed, or a speed over time or over the turn.

Between two points runs a cubic that stays between both (DERIVATION.md, equation 4.11): the quantity is continuously differentiable.
"""

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from functools import lru_cache
from typing import Final

import numpy as np

from quickreturn.reference_model.arrays import Array

TURN: Final = 2.0 * math.pi
#: Two angles count as one turn apart if their difference misses a turn by no more than this (rad): a file may give few digits.
ROUNDING: Final = 1e-6
#: Column -> SI unit.
UNITS: Final[Mapping[str, str]] = {
    "crank_angle": "rad", "crank_speed": "rad/s", "time": "s", "crank_torque": "N*m",
    **dict.fromkeys(("force_n1", "force_n2", "force_along", "force_normal"), "N"),
}  # fmt: skip


@dataclass(frozen=True)
class Table:
    """Quantities at ascending points: over the crank angle, crank speed or time.

    Over the crank angle the first point comes again after the last one, a turn later. Over its speed a table continues straight beyond its
    ends, over time it levels out at its ends and stays there.
    """

    names: tuple[str, ...]  # of the columns, that of the points first: keys of `UNITS`
    points: tuple[float, ...]  # SI
    values: tuple[tuple[float, ...], ...]  # of each other column, SI
    file: str = field(default="", compare=False)  # that it comes from; "" if a case file holds it
    text: str = field(default="", compare=False)  # the table as it was written, heading and rows

    @property
    def over_turn(self) -> bool:
        """Whether it is over the turn of the crank, and so repeats."""
        return self.names[0] == "crank_angle"

    @property
    def rows(self) -> list[tuple[float, ...]]:
        """The points with their quantities, SI."""
        return list(zip(self.points, *self.values, strict=True))

    @property
    def largest(self) -> float:
        """Largest size of the quantity at the points: of a force, of its two components together."""
        return max(math.hypot(*each) for _, *each in self.rows)

    def in_units(self, size: Callable[[str], float]) -> "Table":
        """The same table in units that have these SI sizes."""
        points, *values = (
            tuple(each / size(UNITS[name]) for each in column) for name, column in zip(self.names, (self.points, *self.values), strict=True)
        )
        return replace(self, points=points, values=tuple(values))

    def at(self, point: Array, slope: bool = False) -> Array:
        """The first quantity at points, or its slope there; shape as the points."""
        begin, period = (self.points[0], TURN) if self.over_turn else (0.0, 0.0)
        found = [table_value(each - begin, pieces(self), period)[slope] for each in np.ravel(point).tolist()]
        return np.reshape(found, np.shape(point))

    def __str__(self) -> str:
        named = zip(self.names[1:], self.values, strict=True)
        ranges = (f"{name} {min(each):.9g} to {max(each):.9g} {UNITS[name]}" for name, each in named)
        return f"{self.file or 'a table'} of {len(self.points)} points: {', '.join(ranges)}"


@lru_cache(maxsize=64)
def pieces(table: Table, scale: float = 1.0) -> Array:
    """The monotone cubics of Fritsch and Butland (equation 4.11), shape (pieces, 1 + 4 columns).

    A row has the point where a piece begins, over the turn as the angle from the first point, and for each column, times `scale`, the
    coefficients by powers of the distance from there, the third power first. A table that is not over the turn has a piece on either side.
    """
    points, values = np.array(table.points), scale * np.array(table.values)
    if table.over_turn:
        points = points - points[0]
        gap = np.diff(np.append(points, TURN))
        rise = (np.roll(values, -1, axis=1) - values) / gap
        slope = _slope(np.roll(gap, 1), gap, np.roll(rise, 1, axis=1), rise)
        slope_behind = np.roll(slope, -1, axis=1)
    else:
        gap, rise = np.diff(points), np.diff(values) / np.diff(points)
        ends = rise[:, [0, -1]] * (table.names[0] != "time")
        within = _slope(gap[:-1], gap[1:], rise[:, :-1], rise[:, 1:])
        slopes = np.column_stack([ends[:, :1], within, ends[:, 1:]])
        slope, slope_behind = slopes[:, :-1], slopes[:, 1:]
    rows = _cubics(points, values, rise, slope, slope_behind, gap)
    if table.over_turn:
        return rows
    before, behind = (np.stack([0.0 * ends[:, i], 0.0 * ends[:, i], ends[:, i], values[:, -i]], axis=1) for i in (0, 1))
    before[:, 3] -= ends[:, 0] * gap[0]
    return np.vstack([np.append(points[0] - gap[0], before), rows, np.append(points[-1], behind)])


def _cubics(points: Array, values: Array, rise: Array, slope: Array, slope_behind: Array, gap: Array) -> Array:
    """Rows of `pieces` from values, rises, and slopes at either end of each piece."""
    cubic = (slope + slope_behind - 2.0 * rise) / gap**2
    square = (3.0 * rise - 2.0 * slope - slope_behind) / gap
    powers = np.stack([cubic, square, slope, values[:, : len(gap)]], axis=2)  # of each column, point by point
    return np.ascontiguousarray(np.column_stack([points[: len(gap)], *powers]))


def hermite(points: Array, values: Array, slopes: Array, gap: Array) -> Array:
    """Rows of `pieces` for values and slopes at points; `gap`: between the points."""
    return _cubics(points, values[None], np.diff(values)[None] / gap, slopes[None, :-1], slopes[None, 1:], gap)


def _slope(gap_before: Array, gap: Array, rise_before: Array, rise: Array) -> Array:
    """Slope at points between two pieces: a weighted harmonic mean of theirs."""
    same_way = rise * rise_before > 0.0  # the quantity rises, or falls, through the point; elsewhere the point is its peak
    divisor = np.where(same_way, rise, 1.0), np.where(same_way, rise_before, 1.0)
    mean = 3.0 * (gap + gap_before) / ((gap + 2.0 * gap_before) / divisor[0] + (2.0 * gap + gap_before) / divisor[1])
    return np.where(same_way, mean, 0.0)


def table_value(point: float, table: Array, period: float) -> tuple[float, float]:
    """The quantity of a table of one column at a point, and its slope there; each model compiles it.

    Args:
        point: over the turn, the angle from the first point.
        table: see `pieces`.
        period: after which the table comes again; 0 for none.
    """
    if period > 0.0:
        point %= period
    piece = table[max(int(np.searchsorted(table[:, 0], point, side="right")) - 1, 0)]
    u = point - piece[0]
    slope = (3.0 * piece[1] * u + 2.0 * piece[2]) * u + piece[3]
    return ((piece[1] * u + piece[2]) * u + piece[3]) * u + piece[4], slope
