"""Follows the fixed points of a map along a parameter, through folds (DERIVATION.md, section 10).

Pseudo-arclength continuation: E. L. Allgower and K. Georg, Introduction to Numerical Continuation Methods, 2003, chapters 2 and 6.
"""

import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from typing import Final

import numpy as np
from scipy.optimize import brentq, minimize_scalar

from quickreturn.reference_model.arrays import Array
from quickreturn.reference_model.cycles.fixed_points import (
    BranchPoint,
    Family,
    Limits,
    NotConverged,
    along,
    corrected,
    differentiated,
    first_point,
    matrix_ahead,
    moved,
    rescaled_tangent,
    towards,
)
from quickreturn.reference_model.cycles.poincare import CycleBroken

#: First, smallest and largest arclength (scaled, equation 10.9) between two points. Where the smallest fails, the branch ends.
FIRST_STEP: Final = 0.02
LEAST_STEP: Final = 1e-5
LONGEST_STEP: Final = 0.4
#: Angle (rad) between the tangents at two successive points: the one aimed at, and the largest accepted.
TURN: Final = 0.25
MOST_TURN: Final = 0.6
#: Precision of a special point over the step; and largest value of a test function over those at the step's ends that is a zero, no jump.
LOCATED: Final = 1e-5
ZERO: Final = 1e-3
MOST_POINTS: Final = 5000


@dataclass(frozen=True)
class Ending:
    """Why a branch ends within its range."""

    parameter: float  # of the last point
    tolerance: float  # by how much the parameter changes in the step that failed
    left: bool  # whether the slider leaves the follower
    reason: str  # a clause


@dataclass(frozen=True)
class Branch:
    """Points in order of arclength, special points among them; and why the branch ends on either side, None where the range does."""

    points: tuple[BranchPoint, ...]
    endings: tuple[Ending | None, Ending | None]


def branch(family: Family, point: Array, parameter: float, low: float, high: float) -> Branch:
    """The branch through the fixed point near x = `point`, shape (m,), both ways, until a leaves its range from `low` to `high`.

    Raises:
        CycleBroken, NotConverged: no fixed point is near the given point.
    """
    limits = Limits.of(low, high)
    begin = first_point(family, point, parameter, limits)
    forward = stretch(family, towards(begin, 1.0), limits)
    backward = UNMOVED if forward.closed else stretch(family, towards(begin, -1.0), limits)
    return Branch((*map(turned, reversed(backward.points)), begin, *forward.points), (backward.ending, forward.ending))


@dataclass(frozen=True)
class Stretch:
    """Successive points of a branch after a given one, and how it goes on."""

    points: tuple[BranchPoint, ...]
    step: float | None  # arclength to go on with; None: the branch ends here
    ending: Ending | None = None  # why it ends; None where the range ends, the branch is closed, or it goes on
    closed: bool = False  # whether the branch came back to its first point


UNMOVED: Final = Stretch((), None)


def stretch(
    family: Family,
    here: BranchPoint,
    limits: Limits,
    step: float = FIRST_STEP,
    most: int = MOST_POINTS,
    first: BranchPoint | None = None,
) -> Stretch:
    """The points after `here` in the direction of its tangent.

    Args:
        family: the map.
        here: a point of the branch; not a special one between two others.
        limits: the parameter's range and scale.
        step: arclength to begin with.
        most: number of steps.
        first: the point with which the branch began, if it is another one.
    """
    walk = _Walk(family, limits)
    if here.parameter == limits[0 if here.tangent[-1] < 0.0 else 1] and first is None:
        return UNMOVED
    points = tuple(walk.points(here, step, most, first or here))
    ending = walk.ending
    if walk.step is not None and most == MOST_POINTS:
        ending = enough((points or (here,))[-1])
    return Stretch(points, walk.step, ending, walk.closed)


def between(family: Family, here: BranchPoint, there: BranchPoint, place: float) -> tuple[Array, float]:
    """The branch's point, and its parameter, between two successive ones: in the plane across the tangent of `here`, `place` from it.

    Raises:
        CycleBroken, NotConverged: the corrections do not converge.
    """
    whole = there.arclength - here.arclength
    point, parameter = moved(here, place)
    straight, beyond = moved(here, whole)
    bent = (place / whole) ** 2
    guess = point + bent * (there.point - straight), parameter + bent * (there.parameter - beyond)
    return corrected(family, here, *guess, here.tangent)


def enough(here: BranchPoint) -> Ending:
    """The end of a branch that is followed no further."""
    return Ending(here.parameter, 0.0, False, f"{MOST_POINTS} points are enough")


def turned(point: BranchPoint) -> BranchPoint:
    """A point that was passed against the arclength, as it is along it."""
    return replace(point, arclength=-point.arclength, tangent=-point.tangent)


class _Walk:
    """Walks along the branch, from a point in the direction of its tangent."""

    def __init__(self, family: Family, limits: Limits) -> None:
        self._family = family
        self._limits = limits
        self.ending: Ending | None = None  # afterwards why the walk ended; None where the range did, or the branch is closed
        self.closed = False  # afterwards whether the walk came back to its first point
        self.step: float | None = None  # afterwards the arclength to go on with; None where the walk ended

    def points(self, here: BranchPoint, step: float, most: int, first: BranchPoint) -> Iterator[BranchPoint]:
        """The points after `here` in at most so many steps, with the special ones between them."""
        before: BranchPoint | None = None
        for _ in range(most):
            try:
                there = self._step(here, step, before)
                special = list(self._special(here, there))
            except (CycleBroken, NotConverged) as failed:
                step *= 0.5
                if step < LEAST_STEP:
                    tolerance = abs(2.0 * step * here.tangent[-1]) * here.width
                    self.ending = Ending(here.parameter, tolerance, getattr(failed, "left", False), str(failed))
                    return
                continue
            yield from special
            low, high, _ = self._limits
            if not low < there.parameter < high:
                if low == there.parameter or there.parameter == high:
                    yield there
                return
            yield there
            self.closed = _returned(here, there, first)
            if self.closed:
                return
            made = max(there.arclength - here.arclength, LEAST_STEP)
            step = min(made * min(2.0, TURN / max(_turn(here, there), 1e-3)), LONGEST_STEP)
            before, here = here, there
        self.step = step

    def _step(self, here: BranchPoint, step: float, before: BranchPoint | None) -> BranchPoint:
        """The next point, on the range's limit if the step would pass it. Raises CycleBroken; NotConverged, also for too sharp a turn."""
        point, parameter = moved(here, step, before)
        near = here if before is None else replace(here, matrix=matrix_ahead(here, step, before))
        point, parameter = corrected(self._family, near, point, parameter, here.tangent)
        limited = min(max(parameter, self._limits[0]), self._limits[1])
        if limited != parameter:
            part = (limited - here.parameter) / (parameter - here.parameter)
            step *= part
            point = here.point + part * (point - here.point)
            point, parameter = corrected(self._family, here, point, limited, np.append(np.zeros(len(point)), 1.0))
            parameter = limited
        there = along(here, differentiated(self._family, point, parameter, self._limits), step)
        if _turn(here, there) > MOST_TURN and step > 2.0 * LEAST_STEP:
            raise NotConverged("the branch turns too sharply")
        return there

    def _special(self, here: BranchPoint, there: BranchPoint) -> Iterator[BranchPoint]:
        """Special points between two points, in order of arclength."""
        located = []
        if here.tangent[-1] * there.tangent[-1] < 0.0:
            located.append((self._fold(here, there), "fold"))
        for kind, test in (("period doubling", _doubling_test), ("torus", _torus_test)):
            if test(here) * test(there) < 0.0 and (place := self._zero(here, there, test)) is not None:
                located.append((place, kind))
        for place, kind in sorted(located):
            point, parameter = between(self._family, here, there, place)
            yield replace(along(here, differentiated(self._family, point, parameter, self._limits), place), special=kind)

    def _fold(self, here: BranchPoint, there: BranchPoint) -> float:
        """Distance from `here` at which the parameter turns back, by a search without derivatives (equation 10.11)."""
        whole, sign = there.arclength - here.arclength, -math.copysign(1.0, here.tangent[-1])
        extreme = minimize_scalar(
            lambda place: sign * between(self._family, here, there, place)[1],
            bounds=(0.0, whole),
            method="bounded",
            options={"xatol": LOCATED * whole},
        )
        return float(extreme.x)

    def _zero(self, here: BranchPoint, there: BranchPoint, test: Callable[[BranchPoint], float]) -> float | None:
        """Distance from `here` at which a test function is zero; None where it jumps from one sign to the other."""
        whole = there.arclength - here.arclength
        values = {0.0: test(here), whole: test(there)}

        def test_at(place: float) -> float:
            if place not in values:
                point, parameter = between(self._family, here, there, place)
                values[place] = test(differentiated(self._family, point, parameter, self._limits))
            return values[place]

        place = float(brentq(test_at, 0.0, whole, xtol=LOCATED * whole))
        return place if abs(test_at(place)) < ZERO * max(abs(values[0.0]), abs(values[whole]), 1.0) else None


def _doubling_test(here: BranchPoint) -> float:
    """Zero where a multiplier is -1 (equation 10.12)."""
    return float(np.prod(1.0 + here.multipliers).real)


def _torus_test(here: BranchPoint) -> float:
    """Zero where the largest pair of complex multipliers lies on the unit circle (equation 10.12)."""
    pairs = here.multipliers[here.multipliers.imag != 0.0]
    return float(np.abs(pairs[0])) - 1.0 if len(pairs) else -1.0


def _turn(before: BranchPoint, here: BranchPoint) -> float:
    """Angle between the tangents at two points, rad."""
    return math.acos(min(1.0, abs(float(here.tangent @ rescaled_tangent(before, here)))))


def _returned(here: BranchPoint, there: BranchPoint, first: BranchPoint) -> bool:
    """Whether a closed branch passes its first point between `here` and `there`."""
    if here is first:
        return False
    ahead = here.scaled(first.point, first.parameter)
    step = there.arclength - here.arclength
    return bool(np.linalg.norm(ahead) < step and ahead @ here.tangent > 0.0 and rescaled_tangent(first, here) @ here.tangent > 0.5)
