"""Units of a description, read by pint; and the exception for a mistake in a description."""

import re
from collections.abc import Callable
from functools import lru_cache, wraps
from math import isfinite
from numbers import Real
from typing import Any, ParamSpec, TypeVar

import numpy as np
import pint
from numpy.typing import NDArray

Array = NDArray[np.float64]
_P = ParamSpec("_P")
_R = TypeVar("_R")

_REGISTRY: Any = pint.UnitRegistry()
_BASE = ("[mass]", "[length]", "[time]")


class DescriptionError(ValueError):
    """A mistake in the description of a system, or an impossible state, in one sentence."""

    def __init__(self, sentence: str) -> None:
        super().__init__(" ".join(sentence.split()))  # arrays are written in several lines


def told(what: str) -> Callable[[Callable[_P, _R]], Callable[_P, _R]]:
    """Let a function answer an error of CasADi with one sentence, a DescriptionError.

    Args:
        what: stands before the names of its part and system.
    """

    def decorate(function: Callable[_P, _R]) -> Callable[_P, _R]:
        @wraps(function)
        def telling(*arguments: _P.args, **named: _P.kwargs) -> _R:
            try:
                return function(*arguments, **named)
            except (RuntimeError, TypeError) as error:  # CasADi's, and Python's for operands of another kind
                names = [each if isinstance(each, str) else getattr(each, "name", None) for each in (*arguments, *named.values())][:3]
                of_which = " of ".join(repr(name) for name in dict.fromkeys(reversed(names)) if isinstance(name, str))
                said = re.sub(r".*?[ch]pp:\d+: ", "", str(error).strip().splitlines()[-1])
                said = re.sub(r".*You have: '(.*)'", r"CasADi does not take \1", said)
                raise DescriptionError(
                    f"{what} {of_which} cannot be formed from what is given ({said}); give numbers, or expressions of"
                    " constants and coordinates whose rows fit"
                ) from None

        return telling

    return decorate


@lru_cache(maxsize=512)
def in_si(unit: str) -> tuple[float, tuple[float, ...]]:
    """The value of a unit in SI, and its exponents of mass, length and time; an angle has none.

    Raises:
        DescriptionError: pint does not know the unit, or it is not mechanical.
    """
    try:
        quantity = _REGISTRY.Quantity(1.0, unit or "1").to_base_units()
    except (pint.errors.PintError, AssertionError, TypeError, AttributeError, ValueError) as error:
        raise DescriptionError(f"unit {unit!r} is not known; write it as in 'kg*m^2' or 'lbf*in*s/rad'") from error
    dimension = {name: float(power) for name, power in quantity.dimensionality.items()}
    if other := sorted(set(dimension) - set(_BASE)):
        raise DescriptionError(f"unit {unit!r} is not mechanical: it contains {other[0]}; use units of mass, length, time and angle")
    return float(quantity.magnitude), tuple(dimension.get(name, 0.0) for name in _BASE)


def per(unit: str, other: str) -> str:
    """The unit of a quotient."""
    first, second = (f"({each})" if set(each) & set("*/ ") else each for each in (unit, other))
    return f"{first}/{second}"


def is_number(value: Any) -> bool:
    """Whether a value is a finite real number."""
    return isinstance(value, Real) and isfinite(value)
