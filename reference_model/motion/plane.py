"""Vectors of the plane as complex numbers, as in DERIVATION.md. A row holds N of them: N real parts, then N imaginary parts."""

import numpy as np
from numpy.typing import NDArray

from quickreturn.reference_model.native.compilation import inlined


@inlined
def point(row: NDArray[np.float64], j: int, N: int) -> complex:
    """The vector at point j of N."""
    return complex(row[j], row[N + j])


@inlined
def dot(a: complex, b: complex) -> float:
    """Scalar product."""
    return a.real * b.real + a.imag * b.imag


@inlined
def cross(a: complex, b: complex) -> float:
    """The component of the vector product across the plane: the moment of b at the place a."""
    return a.real * b.imag - a.imag * b.real
