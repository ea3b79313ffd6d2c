"""Reads quantities such as "4 in" and "0.6 lbf*in*s/rad" into SI, with an unambiguous grammar.

A quantity is one plain decimal number (exponent allowed), one space, one unit expression. A unit expression is names joined by `*`
and `/`, each with an optional whole exponent (`in^2`, `s**-1`). Only single names reach pint, so it can neither read "4,5 in" as 45 in nor
spend hours on "m^9999999". The radian is a dimension of its own: 180 without a unit is not an angle, and 16.6 Hz is not an angular speed.

Arithmetic is decimal with 50 digits and exact definitions (1 in = 0.0254 m, 1 lbf = 4.4482216152605 N): a result is the double
nearest to the quantity written.
"""

import functools
import math
import re
from dataclasses import dataclass
from decimal import Context, Decimal
from types import MappingProxyType
from typing import Any, Final

from quickreturn.cases.files.errors import as_written

#: A plain decimal number.
NUMBER: Final = r"[+-]?(?:[0-9]+\.?[0-9]*|\.[0-9]+)(?:[eE][+-]?[0-9]+)?"
_LONGEST: Final = 100  # characters of a quantity

Exponents = tuple[int, int, int, int]  # of metre, kilogram, second, radian

_FACTOR: Final = r"([^\W\d]\w*)(?:(?:\^|\*\*)(-?[1-9]))?"  # a name and, if any, its exponent
_UNIT: Final = re.compile(rf"{_FACTOR}(?:[*/]{_FACTOR})*")
_UNIT_RULE: Final = " (names joined by * and /, whole exponents from -9 to 9 as in in^2)"
_BASE_UNITS: Final = ("meter", "kilogram", "second", "radian")
_LARGEST_EXPONENT: Final = 400  # of ten in a number; the SI value of a larger one is out of the range of doubles
_SMALLEST, _LARGEST = 1e-60, 1e60  # range of SI magnitudes: products of a few remain ordinary doubles
RANGE: Final = f"magnitudes from {_SMALLEST:g} to {_LARGEST:g} in SI units and zero are accepted"
_DECIMAL: Final = Context(prec=50)


class QuantityError(ValueError):
    """A text is not an acceptable quantity: what is wrong, and what is accepted."""

    def __init__(self, problem: str, accepted: str) -> None:
        super().__init__(f"{problem}; {accepted}")
        self.problem = problem
        self.accepted = accepted


@dataclass(frozen=True)
class Dimension:
    """The dimension of a quantity."""

    name: str  # with its article, as in "a length is needed"
    exponents: Exponents  # of metre, kilogram, second and radian
    si_unit: str  # the unit in which parsed values are given
    examples: tuple[str, ...]  # accepted units, the first one to be shown with a number
    per_radian_optional: bool = False  # whether a quantity per radian may be written without "/rad"

    @property
    def example(self) -> str:
        """An example of a quantity in a case file, with its quotes."""
        return self.example_in("")

    def example_in(self, unit: str) -> str:
        """An example in a unit; "": in the first of `examples`."""
        return '"1.5"' if self is PURE else f'"{180 if self is ANGLE else 2} {unit or self.examples[0]}"'

    def advice(self, unit: str = "") -> str:
        """What to write, with an example in a unit (see `example_in`) and others that are accepted."""
        others = [other for other in self.examples if other != (unit or self.examples[0])]
        return f"write one plain number, one space and a unit, such as {self.example_in(unit)} (other units: {', '.join(others)})"

    def accepts(self, exponents: Exponents) -> bool:
        """Whether a unit with these exponents measures this."""
        with_radian = (*self.exponents[:3], self.exponents[3] - 1) if self.per_radian_optional else self.exponents
        return exponents in (self.exponents, with_radian)


LENGTH: Final = Dimension("a length", (1, 0, 0, 0), "m", ("in", "mm", "m"))
MASS: Final = Dimension("a mass", (0, 1, 0, 0), "kg", ("kg", "lbf*s^2/in"))
TIME: Final = Dimension("a time", (0, 0, 1, 0), "s", ("s", "ms"))
ANGLE: Final = Dimension("an angle", (0, 0, 0, 1), "rad", ("deg", "rad"))
ANGULAR_SPEED: Final = Dimension("an angular speed", (0, 0, -1, 1), "rad/s", ("rad/s", "deg/s", "rpm"))
ANGULAR_ACCELERATION: Final = Dimension("an angular acceleration", (0, 0, -2, 1), "rad/s^2", ("rad/s^2", "deg/s^2"))
ACCELERATION: Final = Dimension("an acceleration", (1, 0, -2, 0), "m/s^2", ("m/s^2", "in/s^2"))
TORQUE: Final = Dimension("a torque", (2, 1, -2, 0), "N*m", ("lbf*in", "N*m"))
MOMENT_OF_INERTIA: Final = Dimension("a moment of inertia", (2, 1, 0, 0), "kg*m^2", ("kg*m^2", "lbf*s^2*in"))
ROTARY_DAMPING: Final = Dimension("a rotary damping", (2, 1, -1, 0), "N*m*s/rad", ("lbf*in*s/rad", "N*m*s/rad"), True)
MASS_PER_LENGTH: Final = Dimension("a mass per length", (-1, 1, 0, 0), "kg/m", ("kg/m", "lbf*s^2/in^2"))
BENDING_STIFFNESS: Final = Dimension("a bending stiffness", (3, 1, -2, 0), "N*m^2", ("lbf*in^2", "N*m^2"))
DAMPING_PER_LENGTH: Final = Dimension("a damping per length", (-1, 1, -1, 0), "N*s/m^2", ("lbf*s/in^2", "N*s/m^2"))
STIFFNESS: Final = Dimension("a stiffness", (0, 1, -2, 0), "N/m", ("N/m", "lbf/in"))
DAMPING: Final = Dimension("a damping", (0, 1, -1, 0), "N*s/m", ("N*s/m", "lbf*s/in"))

VELOCITY: Final = Dimension("a velocity", (1, 0, -1, 0), "m/s", ("m/s", "in/s"))
CONTACT_DAMPING: Final = Dimension("a contact damping", (-1, 0, 1, 0), "s/m", ("s/m", "s/in"))
#: A pure number has no unit in a case file, but one of these in the heading of a table.
PURE: Final = Dimension("a pure number", (0, 0, 0, 0), "1", ("percent", "microstrain", "um/m"))
#: Units of a pure number, which pint does not treat as units of a mechanical quantity.
PURE_UNITS: Final = MappingProxyType({"1": 1.0, "strain": 1.0, "percent": 0.01, "microstrain": 1e-6})
ENERGY: Final = Dimension("an energy", (2, 1, -2, 0), "J", ("J", "lbf*in"))
FORCE: Final = Dimension("a force", (1, 1, -2, 0), "N", ("N", "lbf"))
ELASTIC_MODULUS: Final = Dimension("an elastic modulus", (-1, 1, -2, 0), "Pa", ("GPa", "N/mm^2", "psi"))
DENSITY: Final = Dimension("a density", (-3, 1, 0, 0), "kg/m^3", ("kg/m^3", "g/cm^3", "lbf*s^2/in^4"))

_NEEDED: Final = (
    LENGTH, MASS, TIME, ANGLE, ANGULAR_SPEED, ANGULAR_ACCELERATION, ACCELERATION, ENERGY, TORQUE, MOMENT_OF_INERTIA, ROTARY_DAMPING,
    MASS_PER_LENGTH, BENDING_STIFFNESS, DAMPING_PER_LENGTH, STIFFNESS, DAMPING, VELOCITY, CONTACT_DAMPING, FORCE, ELASTIC_MODULUS,
    DENSITY, PURE,
)  # fmt: skip
#: By the SI unit with which a quantity is declared.
DIMENSIONS: Final = MappingProxyType({dimension.si_unit: dimension for dimension in _NEEDED})
_FREQUENCY: Final = (0, 0, -1, 0)
#: Names of dimensions that are given by mistake, by exponents.
_NAMES: Final = {dimension.exponents: dimension.name for dimension in _NEEDED} | {
    _FREQUENCY: "a frequency",
    (2, 0, 0, 0): "an area",
    (3, 0, 0, 0): "a volume",
    (2, 1, -3, 0): "a power",
    (0, 0, -2, 1): "an angular acceleration",
    (2, 1, -1, -1): "a rotary damping",
}


def parse_quantity(text: str, dimension: Dimension, *, infinity_accepted: bool = False) -> float:
    """The quantity in SI units.

    Args:
        text: e.g. "4.5 in".
        dimension: its dimension.
        infinity_accepted: whether "inf", without a unit, stands for a rigid part.

    Raises:
        QuantityError: not one plain number, one space and one unit expression of this dimension, or out of range.
    """
    accepted = dimension.advice() + (', or "inf"' if infinity_accepted else "")
    if text == "inf" and infinity_accepted:
        return math.inf
    if dimension is PURE:
        if (value := plain_number(text)) is None or not math.isfinite(value):
            raise QuantityError("is not a pure number", f"write one plain number without a unit, such as {PURE.example}")
        return value
    if problem := _misfit(text):
        raise QuantityError(problem, accepted)
    number, _, unit = text.partition(" ")
    return _to_si(number, _factor(unit, dimension, accepted))


def _misfit(text: str) -> str:
    """What is wrong with a text that is not one plain number, one space and a unit, as a clause; "" if it is."""
    if re.fullmatch(rf"{NUMBER} \S.*(?<!\s)", text, re.DOTALL) and len(text) <= _LONGEST:
        return ""
    if plain_number(text) is not None:
        return "has no unit"
    if re.match(r"[+-]?[0-9.]*,[0-9]", text):
        return "has a comma in its number (the decimal sign is a point)"
    return f"is longer than {_LONGEST} characters" if len(text) > _LONGEST else "cannot be read"


def is_in_range(value: float) -> bool:
    """Whether a magnitude in SI that is not zero is accepted."""
    return _SMALLEST <= abs(value) <= _LARGEST


def unit_size(unit: str, dimension: Dimension) -> float:
    """A unit expression, such as "in/s^2", in SI units. QuantityError: no unit expression of this dimension."""
    return float(_factor(unit, dimension, f"write a unit such as {' or '.join(dimension.examples)}"))


@functools.cache
def in_si(unit: str) -> float:
    """A unit that the code names, in SI units: `in_si("rpm")` is pi / 30 rad/s."""
    return PURE_UNITS[unit] if unit in PURE_UNITS else float(_read_unit(unit)[0])


def _factor(unit: str, dimension: Dimension, accepted: str) -> Decimal:
    """The SI value of a unit of a dimension."""
    try:
        factor, exponents = _read_unit(unit)
    except _UnitError as wrong:
        raise QuantityError(str(wrong), accepted) from None
    if not dimension.accepts(exponents):
        raise QuantityError(f"is {_name(exponents)}, but {dimension.name} is needed", accepted)
    return factor


def plain_number(text: str) -> float | None:
    """The value of a plain decimal number without a unit, infinite beyond the range of doubles; None for any other text."""
    return float(text) if re.fullmatch(NUMBER, text) else None


class _UnitError(Exception):
    """A unit expression cannot be read: what is wrong."""


def _read_unit(unit: str) -> tuple[Decimal, Exponents]:
    """Factor to SI and exponents of a unit expression. Raises _UnitError."""
    if not _UNIT.fullmatch(unit):
        raise _UnitError(f"has the unreadable unit {as_written(unit)}{_UNIT_RULE}")
    factor, exponents = Decimal(1), (0, 0, 0, 0)
    for sign, name, exponent in re.findall(rf"(^|[*/]){_FACTOR}", unit):
        known_unit = _unit(name)
        if known_unit is None:
            raise _UnitError(f"has the unknown unit {as_written(name)}")
        power = int(exponent or 1) * (-1 if sign == "/" else 1)
        factor = _DECIMAL.multiply(factor, _DECIMAL.power(known_unit[0], power))
        length, mass, time, angle = (total + power * one for total, one in zip(exponents, known_unit[1], strict=True))
        exponents = (length, mass, time, angle)
    return factor, exponents


def measures(unit: str, dimension: Dimension) -> bool:
    """Whether a text is a unit expression of a dimension."""
    try:
        return dimension.accepts(_read_unit(unit)[1])
    except _UnitError:
        return False


#: The commonest units, as pint has them: factor to SI and exponents. A file with no others does not load pint, which takes 0.4 s.
COMMON_UNITS: Final = MappingProxyType(
    {
        "m": ("1", (1, 0, 0, 0)),
        "mm": ("0.001", (1, 0, 0, 0)),
        "cm": ("0.01", (1, 0, 0, 0)),
        "in": ("0.0254", (1, 0, 0, 0)),
        "ft": ("0.3048", (1, 0, 0, 0)),
        "kg": ("1", (0, 1, 0, 0)),
        "g": ("0.001", (0, 1, 0, 0)),
        "lb": ("0.45359237", (0, 1, 0, 0)),
        "s": ("1", (0, 0, 1, 0)),
        "ms": ("0.001", (0, 0, 1, 0)),
        "us": ("0.000001", (0, 0, 1, 0)),
        "min": ("60", (0, 0, 1, 0)),
        "g0": ("9.80665", (1, 0, -2, 0)),  # standard gravity
        "N": ("1", (1, 1, -2, 0)),
        "mN": ("0.001", (1, 1, -2, 0)),
        "kN": ("1000", (1, 1, -2, 0)),
        "lbf": ("4.4482216152605", (1, 1, -2, 0)),
        "mJ": ("0.001", (2, 1, -2, 0)),
        "MPa": ("1000000", (-1, 1, -2, 0)),
        "GPa": ("1000000000", (-1, 1, -2, 0)),
        "psi": ("6894.757293168361336722673443", (-1, 1, -2, 0)),
        "hp": ("745.69987158227022", (2, 1, -3, 0)),
        "Hz": ("1", (0, 0, -1, 0)),
        "kHz": ("1000", (0, 0, -1, 0)),
        "rad": ("1", (0, 0, 0, 1)),
        "deg": ("0.01745329251994329576923690768", (0, 0, 0, 1)),
        "turn": ("6.283185307179586476925286766", (0, 0, 0, 1)),
        "rpm": ("0.1047197551196597746154214461", (0, 0, -1, 1)),
    }
)


@functools.cache
def _unit(name: str) -> tuple[Decimal, Exponents] | None:
    """Factor to SI and exponents of one named unit, or None if it is no unit of a mechanical quantity."""
    if name in COMMON_UNITS:
        factor, exponents = COMMON_UNITS[name]
        return Decimal(factor), exponents
    return unit_of_pint(name)


def unit_of_pint(name: str) -> tuple[Decimal, Exponents] | None:
    """Factor to SI and exponents of one named unit by pint alone."""
    registry = _registry()
    if not registry.parse_unit_name(name):
        return None
    factor, base = registry.get_base_units(name)
    powers = dict(registry.Quantity(1, base).unit_items())
    if not powers or not set(powers) <= set(_BASE_UNITS) or any(power != int(power) for power in powers.values()):
        return None
    length, mass, time, angle = (int(powers.get(unit, 0)) for unit in _BASE_UNITS)
    return Decimal(factor), (length, mass, time, angle)


@functools.cache
def _registry() -> Any:
    """Pint's units with exact decimal factors; built for the first unit that is not in `COMMON_UNITS`."""
    import pint

    return pint.UnitRegistry(non_int_type=Decimal)


def _name(exponents: Exponents) -> str:
    """A dimension in words, with its SI unit."""
    length, mass, time, angle = exponents
    powers = {"kg": mass, "m": length, "s": time, "rad": angle}
    written = {unit: unit + (f"^{abs(power)}" if abs(power) > 1 else "") for unit, power in powers.items()}
    numerator = "*".join(written[unit] for unit, power in powers.items() if power > 0)
    si_unit = (numerator or "1") + "".join(f"/{written[unit]}" for unit, power in powers.items() if power < 0)
    return f"{_NAMES[exponents]} ({si_unit})" if exponents in _NAMES else f"a quantity in {si_unit}"


def _to_si(number: str, factor: Decimal) -> float:
    mantissa, _, exponent = number.lower().partition("e")
    if exponent and abs(int(exponent)) > _LARGEST_EXPONENT:
        raise QuantityError("is out of range", RANGE)
    value = float(_DECIMAL.multiply(_DECIMAL.create_decimal(number), factor))
    if value == 0.0 and not mantissa.strip("+-0."):
        return 0.0
    if not is_in_range(value):
        raise QuantityError("is out of range", RANGE)
    return value
