"""Functions by numbers: columns that are looked up outside the equations, and curves through points inside them."""

from collections.abc import Callable, Sequence
from functools import reduce
from itertools import pairwise
from typing import Any

import casadi as ca
import numpy as np
from scipy.interpolate import CubicSpline, PchipInterpolator

from quickreturn.plugins.derive.units import Array, DescriptionError, is_number


class Table:
    """Columns that are cubic in a coordinate s on intervals of equal length; the equations use their values at the present s.

    Args:
        index: the coordinate's place among the coordinates.
        unit: unit of the coordinate.
        away: s minus its frozen value: its value is 0, its derivative by s is 1.
        low: smallest s, in SI.
        step: length of the intervals, in SI.
        coefficients: shape (intervals, 4, columns), of powers of s minus the beginning of the interval, the highest first.
    """

    def __init__(self, index: int, unit: str, away: ca.SX, low: float, step: float, coefficients: Any) -> None:
        self.index, self._unit = index, unit
        self.put(low, step, coefficients)
        self.row = ca.SX.sym("row", self.coefficients.shape[2])
        self.row_slope = ca.SX.sym("row slope", self.coefficients.shape[2])
        self.units: dict[int, str] = {}  # column in use -> unit
        self._away = away

    def put(self, low: float, step: float, coefficients: Any) -> None:
        """Replace the numbers by others with the same columns: compiled equations need no change. The arguments are those of the class."""
        self.low, self.step = low, step
        self.coefficients: Array = np.ascontiguousarray(coefficients, dtype=np.float64)
        self.high = low + step * len(self.coefficients)

    def function(self, unit: str, columns: Sequence[int], first: Sequence[int] = (), second: Sequence[int] = ()) -> ca.SX:
        """f(s) = f0 + f1 d + f2 d^2 / 2 as a column; d is s minus its present value, so f's derivatives by s are those of the table.

        Args:
            unit: unit of f, in SI.
            columns: columns of the table that hold f0.
            first: columns that hold the first derivative of each by s; none: f does not depend on s.
            second: columns that hold the second derivative.
        """
        values = ca.SX.zeros(len(columns))
        for power, more in enumerate((columns, first, second)):
            if len(more):
                values += self.row[list(more)] * self._away**power / max(power, 1)
                self.units |= dict.fromkeys(more, f"({unit})/({self._unit})**{power}")
        return values

    def at(self, s: float, slope: bool = False) -> Array:
        """The row at a place, or its derivative by s; NaN outside the table, which makes an integrator take shorter steps."""
        if not self.low <= s <= self.high:
            return np.full(self.row.numel(), np.nan)
        k = min(int((s - self.low) / self.step), len(self.coefficients) - 1)
        h = s - self.low - k * self.step
        powers = np.array([3.0 * h * h, 2.0 * h, 1.0, 0.0] if slope else [h**3, h * h, h, 1.0])
        return powers @ self.coefficients[k]


def curve_through(what: str, x: Sequence[float], y: Sequence[float], smooth: bool) -> Callable[[ca.SX], ca.SX]:
    """The cubics of `System.table` through points; `what` names them in a message.

    Raises:
        DescriptionError: there are not two points, they do not ascend, or they are no finite numbers.
    """
    for axis, numbers in (("x", x), ("y", y)):
        if wrong := [each for each in numbers if not is_number(each)] if np.iterable(numbers) else [numbers]:
            raise DescriptionError(f"{axis} of {what} contains {wrong[0]!r}; give two or more finite numbers")
    places, values = np.array(x, np.float64), np.array(y, np.float64)
    if len(places) != len(values) or len(places) < 2:
        raise DescriptionError(f"{what} has {len(places)} x and {len(values)} y; give two or more, as many of one as of the other")
    if len(falls := np.flatnonzero(np.diff(places) <= 0.0)):
        before, after = places[falls[0] : falls[0] + 2]
        raise DescriptionError(f"x of {what} does not ascend: {after:g} follows {before:g}; sort the points, and keep one of those alike")
    curve = (CubicSpline if smooth else PchipInterpolator)(places, values)
    pieces = np.zeros((len(places) + 1, 5))  # beginning of each piece, and the coefficients of its cubic, the highest first
    pieces[1:, 0], pieces[1:-1, 1:], pieces[[0, -1], 4] = places, curve.c.T, values[[0, -1]]

    def value(u: ca.SX) -> ca.SX:
        reached: list[Any] = [1, *(u >= float(place) for place in places[:-1]), u > float(places[-1]), 0]
        within = [one - other for one, other in pairwise(reached)]  # 1 for the piece that counts, 0 for others
        begin, *cubic = (sum(float(c) * here for c, here in zip(each, within, strict=True)) for each in pieces.T)
        return reduce(lambda sum_, c: sum_ * (u - begin) + c, cubic)

    return value
