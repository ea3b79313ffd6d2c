"""Follows the fixed points of a map along a parameter, through folds (DERIVATION.md, section 10).

Pseudo-arclength continuation: E. L. Allgower and K. Georg, Introduction to Numerical Continuation Methods, 2003, chapters 2 and 6. The
map's Jacobian is taken at every point, because the multipliers, which decide on stability, are its eigenvalues. It then serves as the
matrix of all corrections on the way to the next point, so that a correction costs one application of the map.
"""

import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Final, Protocol

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import brentq, minimize_scalar

from quickreturn.reference_model.periodic import eigenvalues, instability
from quickreturn.reference_model.poincare import CycleBroken

Array = NDArray[np.float64]

#: First, smallest and largest arclength (scaled, equation 10.9) between two points. Where the smallest fails, the branch ends.
FIRST_STEP: Final = 0.02
LEAST_STEP: Final = 1e-5
LONGEST_STEP: Final = 0.2
#: Angle (rad) between the tangents at two successive points: the one aimed at, and the largest accepted.
TURN: Final = 0.25
MOST_TURN: Final = 0.6
#: Disturbance for derivatives over a quantity's size, of the order of their error; at least `LEAST_DISTURBANCE` times the image's error.
DISTURBANCE: Final = 1e-4
LEAST_DISTURBANCE: Final = 1e3
#: Corrections end at the length `CORRECTED` (scaled variables), and fail where one is longer than `CONTRACTION` times the previous one.
CORRECTED: Final = 1e-6
CONTRACTION: Final = 0.5
MOST_CORRECTIONS: Final = 8
#: Precision of a special point over the step; and largest value of a test function over those at the step's ends that is a zero, no jump.
LOCATED: Final = 1e-5
ZERO: Final = 1e-3
MOST_POINTS: Final = 5000


class NotConverged(Exception):
    """The corrections towards a fixed point did not converge."""


@dataclass(frozen=True)
class Image:
    """The image of a point x under the map."""

    point: Array  # P(x), shape (m,)
    sizes: Array  # scale of each quantity, by which differences are divided, shape (m,)
    noise: Array  # error of the image, shape (m,)


class Family(Protocol):
    """A map P(x, a) that depends smoothly on a parameter, and whose fixed points form curves (equation 10.8)."""

    def image(self, point: Array, parameter: float) -> Image:
        """The image of x for the parameter a. Raises CycleBroken: there is none."""


@dataclass(frozen=True)
class BranchPoint:
    """A fixed point on the branch."""

    parameter: float  # a
    point: Array  # x, shape (m,)
    arclength: float  # from the branch's first point, in the scaled variables; negative on the other side of it
    sizes: Array  # scale of each quantity in x, shape (m,)
    width: float  # of the parameter's range: the scale of a
    jacobian: Array  # of the map, shape (m, m)
    matrix: Array  # scaled derivatives (equation 10.9), shape (m, m + 1)
    tangent: Array  # of the branch in the scaled variables, shape (m + 1,), towards growing arclength
    special: str = ""  # "" or what happens here: "fold", "period doubling", "torus"

    @cached_property
    def multipliers(self) -> NDArray[np.complex128]:
        """Floquet multipliers (equation 10.7), largest modulus first."""
        return eigenvalues(self.jacobian)

    @property
    def instability(self) -> str:
        """How the point is unstable, see `periodic.instability`; "" for a stable point."""
        return instability(self.multipliers)


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
    begin = first_point(family, point, parameter, (low, high))
    forward = stretch(family, towards(begin, 1.0), (low, high))
    backward = UNMOVED if forward.closed else stretch(family, towards(begin, -1.0), (low, high))
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
    limits: tuple[float, float],
    step: float = FIRST_STEP,
    most: int = MOST_POINTS,
    first: BranchPoint | None = None,
) -> Stretch:
    """The points after `here` in the direction of its tangent.

    Args:
        family: the map.
        here: a point of the branch; not a special one between two others.
        limits: the parameter's range.
        step: arclength to begin with.
        most: number of steps.
        first: the point with which the branch began, if it is another one.
    """
    walk = _Walk(family, *limits)
    if here.parameter == limits[0 if here.tangent[-1] < 0.0 else 1] and first is None:
        return UNMOVED
    points = tuple(walk.points(here, step, most, first or here))
    ending = walk.ending
    if walk.step is not None and most == MOST_POINTS:
        ending = enough((points or (here,))[-1])
    return Stretch(points, walk.step, ending, walk.closed)


def enough(here: BranchPoint) -> Ending:
    """The end of a branch that is followed no further."""
    return Ending(here.parameter, 0.0, False, f"{MOST_POINTS} points are enough")


def turned(point: BranchPoint) -> BranchPoint:
    """A point that was passed against the arclength, as it is along it."""
    return replace(point, arclength=-point.arclength, tangent=-point.tangent)


def first_point(family: Family, point: Array, parameter: float, limits: tuple[float, float]) -> BranchPoint:
    """The fixed point at a given parameter near a point; `limits`: the parameter's range. Raises CycleBroken, NotConverged."""
    start = _differentiated(family, point, parameter, limits)
    border = np.append(np.zeros(len(point)), 1.0)
    fixed, _ = corrected(family, start, point, parameter, border)
    return towards(_differentiated(family, fixed, parameter, limits), 1.0)


def corrected(
    family: Family, at: BranchPoint, point: Array, parameter: float, border: Array, tolerance: float = CORRECTED
) -> tuple[Array, float]:
    """The fixed point in a hyperplane through a given point, and its parameter, by Broyden's method (equation 10.10).

    Args:
        family: the map.
        at: a point of the branch near by, whose matrix the method begins with.
        point: x to begin with, shape (m,).
        parameter: a to begin with.
        border: normal of the hyperplane in the scaled variables, shape (m + 1,).
        tolerance: length of the last correction in the scaled variables.

    Raises:
        CycleBroken, NotConverged: the corrections do not converge.
    """
    inverse = np.linalg.inv(np.vstack([at.matrix, border]))
    last, missed, step = math.inf, np.empty(0), np.empty(0)
    for _ in range(MOST_CORRECTIONS):
        image = family.image(point, parameter)
        before, missed = missed, np.append((image.point - point) / at.sizes, 0.0)
        if len(before):  # Broyden's update by the change that the last step has caused
            change = inverse @ (missed - before)
            inverse = inverse + np.outer(step - change, step @ inverse) / (step @ change)
        step = -inverse @ missed
        point, parameter = point + step[:-1] * at.sizes, parameter + float(step[-1]) * at.width
        length = float(np.max(np.abs(step)))
        if length < max(tolerance, float(np.max(image.noise / at.sizes))):
            return point, parameter
        if not length < CONTRACTION * last:
            break
        last = length
    raise NotConverged(f"the corrections ended at {last:.1g} of the motion's size")


class _Walk:
    """Walks along the branch, from a point in the direction of its tangent."""

    def __init__(self, family: Family, low: float, high: float) -> None:
        self._family = family
        self._limits = low, high
        self.ending: Ending | None = None  # afterwards why the walk ended; None where the range did, or the branch is closed
        self.closed = False  # afterwards whether the walk came back to its first point
        self.step: float | None = None  # afterwards the arclength to go on with; None where the walk ended

    def points(self, here: BranchPoint, step: float, most: int, first: BranchPoint) -> Iterator[BranchPoint]:
        """The points after `here` in at most so many steps, with the special ones between them."""
        for _ in range(most):
            try:
                there = self._step(here, step)
                special = list(self._special(here, there))
            except (CycleBroken, NotConverged) as failed:
                step *= 0.5
                if step < LEAST_STEP:
                    tolerance = abs(2.0 * step * here.tangent[-1]) * here.width
                    self.ending = Ending(here.parameter, tolerance, getattr(failed, "left", False), str(failed))
                    return
                continue
            yield from special
            low, high = self._limits
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
            here = there
        self.step = step

    def _step(self, here: BranchPoint, step: float) -> BranchPoint:
        """The next point, on the range's limit if the step would pass it. Raises CycleBroken; NotConverged, also for too sharp a turn."""
        point, parameter = _moved(here, step)
        point, parameter = corrected(self._family, here, point, parameter, here.tangent)
        limited = min(max(parameter, self._limits[0]), self._limits[1])
        if limited != parameter:
            part = (limited - here.parameter) / (parameter - here.parameter)
            step *= part
            point = here.point + part * (point - here.point)
            point, parameter = corrected(self._family, here, point, limited, np.append(np.zeros(len(point)), 1.0))
            parameter = limited
        there = _along(here, _differentiated(self._family, point, parameter, self._limits), step)
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
            point, parameter = self._between(here, there, place)
            yield replace(_along(here, _differentiated(self._family, point, parameter, self._limits), place), special=kind)

    def _between(self, here: BranchPoint, there: BranchPoint, place: float) -> tuple[Array, float]:
        """The branch's point, and its parameter, in the plane across the tangent of `here` at the distance `place` from it."""
        whole = there.arclength - here.arclength
        point, parameter = _moved(here, place)
        straight, beyond = _moved(here, whole)
        bent = (place / whole) ** 2
        return corrected(
            self._family, here, point + bent * (there.point - straight), parameter + bent * (there.parameter - beyond), here.tangent
        )

    def _fold(self, here: BranchPoint, there: BranchPoint) -> float:
        """Distance from `here` at which the parameter turns back, by a search without derivatives (equation 10.11)."""
        whole, sign = there.arclength - here.arclength, -math.copysign(1.0, here.tangent[-1])
        extreme = minimize_scalar(
            lambda place: sign * self._between(here, there, place)[1],
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
                point, parameter = self._between(here, there, place)
                values[place] = test(_differentiated(self._family, point, parameter, self._limits))
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


def _differentiated(family: Family, point: Array, parameter: float, limits: tuple[float, float]) -> BranchPoint:
    """A fixed point with its derivatives, and with a tangent in either of the two directions (equations 10.5 and 10.9)."""
    low, high = limits
    image = family.image(point, parameter)
    columns = []
    for i, disturbance in enumerate(np.maximum(DISTURBANCE * image.sizes, LEAST_DISTURBANCE * image.noise)):
        moved = point.copy()
        moved[i] += disturbance
        columns.append((family.image(moved, parameter).point - image.point) / disturbance)
    change = math.copysign(DISTURBANCE * (high - low), 0.5 * (low + high) - parameter)  # into the range: beyond it there may be no machine
    by_parameter = (family.image(point, parameter + change).point - image.point) / change
    jacobian, m = np.column_stack(columns), len(point)
    matrix = np.empty((m, m + 1))
    matrix[:, :m] = (jacobian - np.eye(m)) * image.sizes / image.sizes[:, None]
    matrix[:, m] = by_parameter * (high - low) / image.sizes
    tangent = np.linalg.svd(matrix)[2][-1]
    return BranchPoint(parameter, point, 0.0, image.sizes, high - low, jacobian, matrix, tangent)


def towards(here: BranchPoint, sign: float) -> BranchPoint:
    """The point with its tangent towards a growing (1) or falling (-1) parameter."""
    return replace(here, tangent=here.tangent * math.copysign(sign, sign * here.tangent[-1]))


def _along(before: BranchPoint, here: BranchPoint, step: float) -> BranchPoint:
    """The point `here` at an arclength `step` after `before`, with its tangent in the direction of that point's."""
    sign = math.copysign(1.0, float(here.tangent @ _rescaled_tangent(before, here)))
    return replace(here, arclength=before.arclength + step, tangent=sign * here.tangent)


def _rescaled_tangent(before: BranchPoint, here: BranchPoint) -> Array:
    """The unit tangent at `before` in the scaled variables of `here`."""
    tangent = before.tangent * np.append(before.sizes / here.sizes, 1.0)
    return np.asarray(tangent / np.linalg.norm(tangent))


def _turn(before: BranchPoint, here: BranchPoint) -> float:
    """Angle between the tangents at two points, rad."""
    return math.acos(min(1.0, abs(float(here.tangent @ _rescaled_tangent(before, here)))))


def _moved(here: BranchPoint, step: float) -> tuple[Array, float]:
    """Point and parameter at a distance `step` from a point along its tangent."""
    return here.point + step * here.tangent[:-1] * here.sizes, here.parameter + step * float(here.tangent[-1]) * here.width


def _returned(here: BranchPoint, there: BranchPoint, first: BranchPoint) -> bool:
    """Whether a closed branch passes its first point between `here` and `there`."""
    if here is first:
        return False
    ahead = np.append((first.point - here.point) / here.sizes, (first.parameter - here.parameter) / here.width)
    step = there.arclength - here.arclength
    return bool(np.linalg.norm(ahead) < step and ahead @ here.tangent > 0.0 and _rescaled_tangent(first, here) @ here.tangent > 0.5)
