"""Vectors of the plane as complex numbers, as in DERIVATION.md. A row holds N of them: N real parts, then N imaginary parts."""

import math

from quickreturn.reference_model.arrays import Array
from quickreturn.reference_model.native.compilation import inner


@inner
def point(row: Array, j: int, N: int) -> complex:
    """The vector at point j of N."""
    return complex(row[j], row[N + j])


@inner
def direction(angle: float) -> complex:
    """exp(i angle)."""
    return complex(math.cos(angle), math.sin(angle))


@inner
def angle_of(vector: complex) -> float:
    """Angle of the vector, -pi to pi."""
    return math.atan2(vector.imag, vector.real)


@inner
def dot(a: complex, b: complex) -> float:
    """Scalar product."""
    return a.real * b.real + a.imag * b.imag


@inner
def cross(a: complex, b: complex) -> float:
    """The component of the vector product across the plane: the moment of b at the place a."""
    return a.real * b.imag - a.imag * b.real
