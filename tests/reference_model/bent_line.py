"""The bent centre line and the crank tip beside it, from their definition with numpy and scipy alone."""

import itertools
import math

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import brentq

from reference_model.mechanism import Mechanism
from reference_model.shapes import ShapeSet

Array = NDArray[np.float64]
_POINTS, _WEIGHTS = np.polynomial.legendre.leggauss(24)


def place(shapes: ShapeSet, eta: Array, x: float) -> Array:
    """(x - F, W) of arc length x in frame B: the tangent's angle has the sine W'."""
    edges = np.unique(np.append(shapes.edges[shapes.edges < x], [0.0, x]))
    total = 0.0
    for low, high in itertools.pairwise(edges):
        points = 0.5 * (low + high) + 0.5 * (high - low) * _POINTS
        total += 0.5 * (high - low) * _WEIGHTS @ np.sqrt(1.0 - (shapes.evaluate(points, 1) @ eta) ** 2)
    return np.array([total, float(shapes.evaluate(np.array([x]))[0] @ eta)])


def crank_tip(mechanism: Mechanism, q1: float, q2: float) -> Array:
    """From P, in frame B."""
    arm = mechanism.crank.length * np.array([math.cos(q1), math.sin(q1)]) - [mechanism.pivot_distance, 0.0]
    return np.array([[math.cos(q2), math.sin(q2)], [-math.sin(q2), math.cos(q2)]]) @ arm


def normal(shapes: ShapeSet, eta: Array, x: float) -> Array:
    slope = float(shapes.evaluate(np.array([x]), 1)[0] @ eta)
    return np.array([-slope, math.sqrt(1.0 - slope**2)])


def foot(mechanism: Mechanism, shapes: ShapeSet, q: Array) -> float:
    """Arc length at which the crank tip lies on the normal; q = (q1, q2, eta)."""
    tip, eta = crank_tip(mechanism, q[0], q[1]), q[2:]

    def along(x: float) -> float:
        n = normal(shapes, eta, x)
        return float((tip - place(shapes, eta, x)) @ [n[1], -n[0]])

    return float(brentq(along, 0.8 * tip[0], min(1.2 * tip[0], mechanism.follower.length), xtol=1e-15, rtol=1e-15))


def gap(mechanism: Mechanism, shapes: ShapeSet, q: Array) -> float:
    """Distance of the crank tip from the centre line along its normal."""
    s = foot(mechanism, shapes, q)
    return float((crank_tip(mechanism, q[0], q[1]) - place(shapes, q[2:], s)) @ normal(shapes, q[2:], s))


def chord_gap(mechanism: Mechanism, shapes: ShapeSet, q: Array, element: int) -> float:
    """Distance of the crank tip from the straight line through the nodes of an element."""
    left, right = (place(shapes, q[2:], x) if x > 0.0 else np.zeros(2) for x in shapes.edges[element : element + 2])
    t = (right - left) / np.linalg.norm(right - left)
    return float((crank_tip(mechanism, q[0], q[1]) - left) @ [-t[1], t[0]])


def gradient(function: object, q: Array, step: float = 1e-6) -> Array:
    """Central differences."""
    assert callable(function)
    unit = step * np.eye(len(q))
    return np.array([(function(q + e) - function(q - e)) / (2.0 * step) for e in unit])
