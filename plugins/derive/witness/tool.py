"""The tool's force over the crank's turn, described for `quickreturn.derive`: part of a turn, and rows of a table."""

from math import pi
from typing import Any

import casadi as ca
import numpy as np
from scipy.interpolate import PchipInterpolator

from quickreturn.plugins.derive.tables import Table
from quickreturn.reference_model.arrays import Array
from quickreturn.reference_model.table import ROUNDING
from quickreturn.reference_model.table import Table as ForceTable


class ForceRows(Table):
    """A tool's force over the crank's turn, by scipy's monotone cubics through the points of three turns."""

    def __init__(self, index: int, unit: str, away: ca.SX) -> None:
        super().__init__(index, unit, away, -1e9, 2e9, np.zeros((1, 4, 2)))
        self.curve, self.begin = PchipInterpolator([0.0, 2.0 * pi], np.zeros((2, 2))), 0.0

    def follow(self, table: ForceTable, scale: float) -> None:
        """Give the force that a table holds."""
        points = [(angle, scale * a, scale * b) for angle, a, b in table.rows]
        turns = np.array([(angle + turn * 2.0 * pi, *force) for turn in (-1, 0, 1) for angle, *force in points])
        self.curve, self.begin = PchipInterpolator(turns[:, 0], turns[:, 1:]), points[0][0]

    def at(self, s: float, slope: bool = False) -> Array:
        """Both components at a crank angle, or their derivatives by it."""
        return np.asarray(self.curve(self.begin + (s - self.begin) % (2.0 * pi), int(slope)))


def share_of_turn(crank_angle: ca.SX, p: Any) -> ca.SX:
    """Part of the tip force that acts at a crank angle. It rises and falls as a polynomial of the fifth degree."""
    whole = 2.0 * pi
    turned_by = crank_angle - p.force_from
    turned_by -= whole * ca.floor(turned_by / whole)
    u = ca.fmax(0.0, ca.fmin(1.0, ca.fmin(turned_by, p.force_span - turned_by) / p.force_ramp))
    return ca.if_else(p.force_span >= whole - ROUNDING, 1.0, u**3 * (10.0 - 15.0 * u + 6.0 * u**2))
