"""Fixed points of a map that depends on a parameter, and the derivatives of the map there (DERIVATION.md, section 10).

The map's Jacobian is taken at every point, because the multipliers, which decide on stability, are its eigenvalues. It then serves as the
matrix of all corrections on the way to the next point, so that a correction costs one application of the map.
"""

import math
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Final, NamedTuple, Protocol

import numpy as np
from numpy.typing import NDArray

from quickreturn.reference_model.arrays import Array
from quickreturn.reference_model.cycles.periodic import eigenvalues, instability

#: Disturbance for derivatives over a quantity's size, of the order of their error; at least `LEAST_DISTURBANCE` times the image's error.
DISTURBANCE: Final = 1e-4
LEAST_DISTURBANCE: Final = 1e3
#: Corrections end at the length `CORRECTED` (scaled variables), and fail where the k-th after the first is longer than `CONTRACTION`**k
#: times the first, or `NEAR` if that is shorter: from a good guess the first is short by accident, and says little of the next.
CORRECTED: Final = 1e-6
CONTRACTION: Final = 0.5
NEAR: Final = 0.01
MOST_CORRECTIONS: Final = 8


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


class Limits(NamedTuple):
    """The range of the parameter, and its scale."""

    low: float
    high: float
    width: float  # change over which the fixed point turns once at most; the whole range where it does not

    @classmethod
    def of(cls, low: float, high: float, waves: float = 1.0) -> "Limits":
        """A range over which the fixed point moves to and fro so many times."""
        return cls(low, high, (high - low) / max(waves, 1.0))


@dataclass(frozen=True)
class BranchPoint:
    """A fixed point on the branch."""

    parameter: float  # a
    point: Array  # x, shape (m,)
    arclength: float  # from the branch's first point, in the scaled variables; negative on the other side of it
    sizes: Array  # scale of each quantity in x, shape (m,)
    width: float  # scale of a, see `Limits`
    jacobian: Array  # of the map, shape (m, m)
    matrix: Array  # scaled derivatives (equation 10.9), shape (m, m + 1)
    tangent: Array  # of the branch in the scaled variables, shape (m + 1,), towards growing arclength
    special: str = ""  # "" or what happens here: "fold", "period doubling", "torus"

    @cached_property
    def multipliers(self) -> NDArray[np.complex128]:
        """Floquet multipliers (equation 10.7), largest modulus first."""
        return eigenvalues(self.jacobian)

    def displaced(self, way: Array) -> tuple[Array, float]:
        """The point, and its parameter, that lies by `way` (scaled variables, shape (m + 1,)) from this one."""
        return self.point + way[:-1] * self.sizes, self.parameter + float(way[-1]) * self.width

    def scaled(self, point: Array, parameter: float) -> Array:
        """Where another point lies from this one, in the scaled variables, shape (m + 1,)."""
        return np.append((point - self.point) / self.sizes, (parameter - self.parameter) / self.width)

    @property
    def instability(self) -> str:
        """How the point is unstable, see `periodic.instability`; "" for a stable point."""
        return instability(self.multipliers)


def first_point(family: Family, point: Array, parameter: float, limits: Limits) -> BranchPoint:
    """The fixed point at a given parameter near a point; `limits`: the parameter's range. Raises CycleBroken, NotConverged."""
    start = differentiated(family, point, parameter, limits)
    border = np.append(np.zeros(len(point)), 1.0)
    fixed, _ = corrected(family, start, point, parameter, border)
    return towards(differentiated(family, fixed, parameter, limits), 1.0)


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
    first, length, missed, step = math.inf, math.inf, np.empty(0), np.empty(0)
    for count in range(MOST_CORRECTIONS):
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
        first = max(length, NEAR) if count == 0 else first
        if not length <= CONTRACTION**count * first:
            break
    raise NotConverged(f"the corrections ended at {length:.1g} of the motion's size")


def differentiated(family: Family, point: Array, parameter: float, limits: Limits) -> BranchPoint:
    """A fixed point with its derivatives, and with a tangent in either of the two directions (equations 10.5 and 10.9)."""
    low, high, width = limits
    image = family.image(point, parameter)
    columns = []
    for i, disturbance in enumerate(np.maximum(DISTURBANCE * image.sizes, LEAST_DISTURBANCE * image.noise)):
        disturbed = point.copy()
        disturbed[i] += disturbance
        columns.append((family.image(disturbed, parameter).point - image.point) / disturbance)
    change = math.copysign(DISTURBANCE * width, 0.5 * (low + high) - parameter)  # into the range: beyond it there may be no machine
    by_parameter = (family.image(point, parameter + change).point - image.point) / change
    jacobian, m = np.column_stack(columns), len(point)
    matrix = np.empty((m, m + 1))
    matrix[:, :m] = (jacobian - np.eye(m)) * image.sizes / image.sizes[:, None]
    matrix[:, m] = by_parameter * width / image.sizes
    tangent = np.linalg.svd(matrix)[2][-1]
    return BranchPoint(parameter, point, 0.0, image.sizes, width, jacobian, matrix, tangent)


def towards(here: BranchPoint, sign: float) -> BranchPoint:
    """The point with its tangent towards a growing (1) or falling (-1) parameter."""
    return replace(here, tangent=here.tangent * math.copysign(sign, sign * here.tangent[-1]))


def along(before: BranchPoint, here: BranchPoint, step: float) -> BranchPoint:
    """The point `here` at an arclength `step` after `before`, with its tangent in the direction of that point's."""
    sign = math.copysign(1.0, float(here.tangent @ rescaled_tangent(before, here)))
    return replace(here, arclength=before.arclength + step, tangent=sign * here.tangent)


def rescaled_tangent(before: BranchPoint, here: BranchPoint) -> Array:
    """The unit tangent at `before` in the scaled variables of `here`."""
    tangent = before.tangent * np.append(before.sizes / here.sizes, 1.0)
    return np.asarray(tangent / np.linalg.norm(tangent))


def matrix_ahead(here: BranchPoint, step: float, before: BranchPoint) -> Array:
    """The scaled derivatives at a distance `step` from a point, from those there and at the point `before` (equation 10.15)."""
    scales = np.append(here.sizes / before.sizes, 1.0)
    change = here.matrix - before.matrix / scales[:-1, None] * scales
    return here.matrix + step / float(np.linalg.norm(here.scaled(before.point, before.parameter))) * change


def moved(here: BranchPoint, step: float, before: BranchPoint | None = None) -> tuple[Array, float]:
    """Point and parameter at a distance `step` from a point along its tangent, bent like the branch since `before` (equation 10.15)."""
    way = step * here.tangent
    if before is not None:
        chord = here.scaled(before.point, before.parameter)
        length = float(np.linalg.norm(chord))
        gap, change = length * here.tangent + chord, length * (here.tangent - rescaled_tangent(before, here))
        part = step / length
        bend = part**2 * (3.0 * gap - change) + part**3 * (2.0 * gap - change)
        way = way + bend - (bend @ here.tangent) * here.tangent
    return here.displaced(way)
