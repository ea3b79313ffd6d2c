"""Vectors of the plane as complex numbers, as in DERIVATION.md. A row holds N of them: N real parts, then N imaginary parts."""

import math

import numpy as np
from numpy.typing import NDArray

from quickreturn.reference_model.native.compilation import inner
from quickreturn.reference_model.native.lanes import lane_of, lanes_of, with_lane, zeros_like


@inner
def point(row: NDArray[np.float64], j: int, N: int) -> complex:
    """The vector at point j of N."""
    return complex(row[j], row[N + j])


@inner
def direction(angle: float) -> complex:
    """exp(i angle)."""
    cosine = sine = zeros_like(angle)
    for lane in range(lanes_of(angle)):
        cosine = with_lane(cosine, lane, math.cos(lane_of(angle, lane)))
        sine = with_lane(sine, lane, math.sin(lane_of(angle, lane)))
    return complex(cosine, sine)


@inner
def angle_of(vector: complex) -> float:
    """Angle of the vector, -pi to pi."""
    angle = zeros_like(vector.real)
    for lane in range(lanes_of(angle)):
        angle = with_lane(angle, lane, math.atan2(lane_of(vector.imag, lane), lane_of(vector.real, lane)))
    return angle


@inner
def dot(a: complex, b: complex) -> float:
    """Scalar product."""
    return a.real * b.real + a.imag * b.imag


@inner
def cross(a: complex, b: complex) -> float:
    """The component of the vector product across the plane: the moment of b at the place a."""
    return a.real * b.imag - a.imag * b.real
