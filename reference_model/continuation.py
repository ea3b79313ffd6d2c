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

#: First, smallest and largest arclength between two points (equation 10.9). Where the smallest fails, the branch ends.
FIRST_STEP: Final = 0.02
LEAST_STEP: Final = 1e-5
LONGEST_STEP: Final = 0.2
#: Angle between the tangents at two points: what is aimed at, and what is accepted (rad).
TURN: Final = 0.25
MOST_TURN: Final = 0.6
#: Relative disturbance from which derivatives are taken: what they miss is of this order. It is at least `LEAST_DISTURBANCE` local errors.
DISTURBANCE: Final = 1e-4
LEAST_DISTURBANCE: Final = 1e3
#: Length of the last correction, and what a correction may leave of the one before.
CORRECTED: Final = 1e-6
CONTRACTION: Final = 0.5
MOST_CORRECTIONS: Final = 8
#: Part of a step to which special points are located, and largest value of a test function that counts as a zero and not as a jump.
LOCATED: Final = 1e-5
ZERO: Final = 1e-3
MOST_POINTS: Final = 5000


class NotConverged(Exception):
    """A correction that did not converge."""


@dataclass(frozen=True)
class Image:
    """A point's image under the map."""

    point: Array  # P(x), shape (m,)
    sizes: Array  # of the quantities, by which differences are divided, shape (m,)
    noise: Array  # error of the image, shape (m,)


class Family(Protocol):
    """A map P(x, a) that depends smoothly on a parameter, and whose fixed points form curves (equation 10.8)."""

    def image(self, point: Array, parameter: float) -> Image:
        """P(x, a). Raises CycleBroken: there is none."""


@dataclass(frozen=True)
class BranchPoint:
    """A fixed point on the branch."""

    parameter: float  # a
    point: Array  # x, shape (m,)
    arclength: float  # from the branch's first point, in the scaled variables; negative on the other side of it
    sizes: Array  # of x, shape (m,)
    width: float  # of a
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
        """See `periodic.instability`; "" of a stable point."""
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
    """Points in order of arclength, special points among them, and why it ends at its begin and at its end; None: the range ends."""

    points: tuple[BranchPoint, ...]
    endings: tuple[Ending | None, Ending | None]


def branch(family: Family, point: Array, parameter: float, low: float, high: float) -> Branch:
    """The branch through a fixed point near a point, shape (m,), both ways, until the parameter leaves its range from `low` to `high`.

    Raises:
        CycleBroken, NotConverged: no fixed point is near the one given.
    """
    begin = first_point(family, point, parameter, (low, high))
    forward, backward = _Walk(family, low, high), _Walk(family, low, high)
    after = list(forward.points(_towards(begin, 1.0))) if parameter < high else []
    before = list(backward.points(_towards(begin, -1.0))) if parameter > low and not forward.closed else []
    turned = [replace(each, arclength=-each.arclength, tangent=-each.tangent) for each in reversed(before)]
    return Branch((*turned, begin, *after), (backward.ending, forward.ending))


def first_point(family: Family, point: Array, parameter: float, limits: tuple[float, float]) -> BranchPoint:
    """A fixed point at a given parameter, by Newton's method from a point near by. Raises CycleBroken, NotConverged."""
    start = _differentiated(family, point, parameter, limits)
    border = np.append(np.zeros(len(point)), 1.0)
    found, _ = corrected(family, start, point, parameter, border)
    return _towards(_differentiated(family, found, parameter, limits), 1.0)


def corrected(
    family: Family, at: BranchPoint, point: Array, parameter: float, border: Array, tolerance: float = CORRECTED
) -> tuple[Array, float]:
    """The fixed point in a hyperplane through a point, by Broyden's method from the matrix taken at `at` (equation 10.10).

    Args:
        family: the map.
        at: a point of the branch near by.
        point: x to begin with, shape (m,).
        parameter: a to begin with.
        border: normal of the hyperplane in the scaled variables, shape (m + 1,).
        tolerance: length of the last correction in the scaled variables.

    Raises:
        CycleBroken, NotConverged: it does not converge.
    """
    inverse = np.linalg.inv(np.vstack([at.matrix, border]))
    last, missed, step = math.inf, np.empty(0), np.empty(0)
    for _ in range(MOST_CORRECTIONS):
        image = family.image(point, parameter)
        before, missed = missed, np.append((image.point - point) / at.sizes, 0.0)
        if len(before):  # Broyden's update: the change that the last step made is known now
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
    """From a point along its tangent."""

    def __init__(self, family: Family, low: float, high: float) -> None:
        self._family = family
        self._limits = low, high
        self.ending: Ending | None = None  # afterwards why it ended; None where the range did, or the branch is closed
        self.closed = False  # afterwards whether it came back to its first point

    def points(self, here: BranchPoint) -> Iterator[BranchPoint]:
        """The points after `here`, with the special ones between them."""
        step, first = FIRST_STEP, here
        for _ in range(MOST_POINTS):
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
            step = min(max(there.arclength - here.arclength, LEAST_STEP) * min(2.0, TURN / max(_turn(here, there), 1e-3)), LONGEST_STEP)
            here = there
        self.ending = Ending(here.parameter, 0.0, False, f"{MOST_POINTS} points are enough")

    def _step(self, here: BranchPoint, step: float) -> BranchPoint:
        """The next point, on the range's limit where it would lie beyond. NotConverged: also where the branch turns too much."""
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
        """Special points between two points, in their order."""
        found = []
        if here.tangent[-1] * there.tangent[-1] < 0.0:
            found.append(("fold", self._extreme(here, there)))
        for kind, test in (("period doubling", doubling), ("torus", pair)):
            if test(here) * test(there) < 0.0 and (place := self._zero(here, there, test)) is not None:
                found.append((kind, place))
        for kind, place in sorted(found, key=lambda each: each[1]):
            point, parameter = self._between(here, there, place)
            yield replace(_along(here, _differentiated(self._family, point, parameter, self._limits), place), special=kind)

    def _between(self, here: BranchPoint, there: BranchPoint, place: float) -> tuple[Array, float]:
        """The branch's point in the plane across the first tangent, at a distance from the first point."""
        whole = there.arclength - here.arclength
        point, parameter = _moved(here, place)
        straight, beyond = _moved(here, whole)
        bent = (place / whole) ** 2
        return corrected(
            self._family, here, point + bent * (there.point - straight), parameter + bent * (there.parameter - beyond), here.tangent
        )

    def _extreme(self, here: BranchPoint, there: BranchPoint) -> float:
        """Where the parameter turns back, without derivatives (equation 10.11)."""
        whole, way = there.arclength - here.arclength, -math.copysign(1.0, here.tangent[-1])
        found = minimize_scalar(
            lambda place: way * self._between(here, there, place)[1],
            bounds=(0.0, whole),
            method="bounded",
            options={"xatol": LOCATED * whole},
        )
        return float(found.x)

    def _zero(self, here: BranchPoint, there: BranchPoint, test: Callable[[BranchPoint], float]) -> float | None:
        """Where a test function passes zero; None where it jumps past it."""
        whole = there.arclength - here.arclength
        known = {0.0: test(here), whole: test(there)}

        def at(place: float) -> float:
            if place not in known:
                point, parameter = self._between(here, there, place)
                known[place] = test(_differentiated(self._family, point, parameter, self._limits))
            return known[place]

        place = float(brentq(at, 0.0, whole, xtol=LOCATED * whole))
        return place if abs(at(place)) < ZERO * max(abs(known[0.0]), abs(known[whole]), 1.0) else None


def doubling(here: BranchPoint) -> float:
    """Zero where a multiplier is -1 (equation 10.12)."""
    return float(np.prod(1.0 + here.multipliers).real)


def pair(here: BranchPoint) -> float:
    """Zero where the largest pair of complex multipliers lies on the unit circle (equation 10.12)."""
    found = here.multipliers[here.multipliers.imag != 0.0]
    return float(np.abs(found[0])) - 1.0 if len(found) else -1.0


def _differentiated(family: Family, point: Array, parameter: float, limits: tuple[float, float]) -> BranchPoint:
    """A fixed point with its derivatives and a tangent of either direction (equations 10.5 and 10.9)."""
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


def _towards(here: BranchPoint, way: float) -> BranchPoint:
    """The point with its tangent towards a growing (1) or falling (-1) parameter."""
    return replace(here, tangent=here.tangent * math.copysign(way, way * here.tangent[-1]))


def _along(before: BranchPoint, here: BranchPoint, step: float) -> BranchPoint:
    """A point with its arclength, and its tangent in the direction of the one before."""
    way = math.copysign(1.0, float(here.tangent @ _seen(before, here)))
    return replace(here, arclength=before.arclength + step, tangent=way * here.tangent)


def _seen(before: BranchPoint, here: BranchPoint) -> Array:
    """The tangent of a point in another one's scaled variables, normed."""
    tangent = before.tangent * np.append(before.sizes / here.sizes, 1.0)
    return np.asarray(tangent / np.linalg.norm(tangent))


def _turn(before: BranchPoint, here: BranchPoint) -> float:
    return math.acos(min(1.0, abs(float(here.tangent @ _seen(before, here)))))


def _moved(here: BranchPoint, step: float) -> tuple[Array, float]:
    return here.point + step * here.tangent[:-1] * here.sizes, here.parameter + step * float(here.tangent[-1]) * here.width


def _returned(here: BranchPoint, there: BranchPoint, first: BranchPoint) -> bool:
    """Whether a closed branch passes its first point between two points."""
    if here is first:
        return False
    ahead = np.append((first.point - here.point) / here.sizes, (first.parameter - here.parameter) / here.width)
    step = there.arclength - here.arclength
    return bool(np.linalg.norm(ahead) < step and ahead @ here.tangent > 0.0 and _seen(first, here) @ here.tangent > 0.5)
