"""Units of a description, read by pint; and the exception for a mistake in a description."""

from functools import lru_cache
from typing import Any

import numpy as np
import pint
from numpy.typing import NDArray

Array = NDArray[np.float64]

_REGISTRY: Any = pint.UnitRegistry()
_BASE = ("[mass]", "[length]", "[time]")


class DescriptionError(ValueError):
    """A mistake in the description of a system, or an impossible state, in one sentence."""


@lru_cache(maxsize=512)
def in_si(unit: str) -> tuple[float, tuple[float, ...]]:
    """The value of a unit in SI, and its exponents of mass, length and time; an angle has none.

    Raises:
        DescriptionError: pint does not know the unit, or it is not mechanical.
    """
    try:
        quantity = _REGISTRY.Quantity(1.0, unit or "1").to_base_units()
    except (pint.errors.PintError, AssertionError, TypeError, AttributeError) as error:
        raise DescriptionError(f"unit {unit!r} is not known; write it as in 'kg*m^2' or 'lbf*in*s/rad'") from error
    dimension = {name: float(power) for name, power in quantity.dimensionality.items()}
    if other := sorted(set(dimension) - set(_BASE)):
        raise DescriptionError(f"unit {unit!r} is not mechanical: it contains {other[0]}; use units of mass, length, time and angle")
    return float(quantity.magnitude), tuple(dimension.get(name, 0.0) for name in _BASE)


def per(unit: str, other: str) -> str:
    """The unit of a quotient."""
    first, second = (f"({each})" if set(each) & set("*/ ") else each for each in (unit, other))
    return f"{first}/{second}"
