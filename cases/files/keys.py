"""Every key of a case file: the quantity that it names, as the dataclasses declare it, and its values in SI and as texts."""

import math
from collections import Counter
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from types import MappingProxyType
from typing import Any, Final, NamedTuple

from quickreturn.cases.files.errors import CaseError, as_written
from quickreturn.cases.files.units import (
    DIMENSIONS,
    RANGE,
    Dimension,
    QuantityError,
    is_in_range,
    measures,
    parse_quantity,
    plain_number,
    unit_size,
)
from quickreturn.reference_model.quantities import Quantity, quantities_of, quantity
from quickreturn.reference_model.scene_values import SECTIONS as SECTIONS_OF_SCENE
from quickreturn.reference_model.table import Table


@dataclass(frozen=True, kw_only=True)
class Times:
    """Times of a simulation."""

    duration: float = quantity("s", "time to simulate, a multiple of output_step", sign="positive")
    output_step: float = quantity("s", "between rows of a trajectory", sign="positive")


#: Section -> key -> quantity.
SECTIONS: Final[Mapping[str, Mapping[str, Quantity]]] = MappingProxyType(
    {**SECTIONS_OF_SCENE, "simulation": {key: declared for _, key, declared in quantities_of(Times)}}
)
#: Sign between a value and its tolerance.
PLUS_MINUS: Final = "+-"
#: Keys outside all sections.
HEADER: Final = ("name", "title", "tags")
#: Dotted path -> quantity, in the order of the file.
PATHS: Final = MappingProxyType({f"{section}.{key}": declared for section, keys in SECTIONS.items() for key, declared in keys.items()})


def shown_value(value: Any) -> str:
    """A number, or several, to nine digits; a table in words."""
    if isinstance(value, Table):
        return str(value)
    return ", ".join(map(shown_value, value)) if isinstance(value, (list, tuple)) else f"{value:.9g}"


class Written(float):
    """A number in SI that remembers the text from which it was read, for messages."""

    text: str

    def __new__(cls, value: float, text: str) -> "Written":
        """The value in SI of a text."""
        new = super().__new__(cls, value)
        new.text = text
        return new

    def __reduce__(self) -> tuple[type, tuple[float, str]]:
        return Written, (float(self), self.text)


def dimension_of(path: str) -> Dimension:
    """The dimension of the quantity at a dotted path."""
    return DIMENSIONS[PATHS[path].unit]


def value_at(path: str, given: str | float, *, finite: bool = False) -> float:
    """The SI value of a text, or of a number in SI, for the quantity at a dotted path; with `finite` not infinite.

    QuantityError: wrong text, wrong sign, or out of range.
    """
    quantity, dimension = PATHS[path], dimension_of(path)
    infinity = quantity.infinity and not finite
    if not isinstance(given, float):
        value = parse_quantity(given, dimension, infinity_accepted=infinity)
    elif given == 0.0 or is_in_range(given) or (infinity and given == math.inf):
        value = float(given)
    else:
        raise QuantityError("is out of range", RANGE)
    if quantity.sign == "positive" and value <= 0.0:
        raise QuantityError("is not positive", f"{dimension.name} greater than zero is accepted")
    if quantity.sign == "not negative" and value < 0.0:
        raise QuantityError("is negative", f"{dimension.name} of zero or more is accepted")
    return value


class Toleranced(NamedTuple):
    """A value with a tolerance: within it every value is equally likely. SI."""

    nominal: float
    low: float
    high: float


def toleranced(path: str, text: str) -> Toleranced:
    """The value and the ends of "6 mm +- 0.1 mm" or "6 mm +- 2 %", for the quantity at a dotted path. QuantityError: it is no such text."""
    dimension = dimension_of(path)
    accepted = f'write such as "{dimension.example.strip(chr(34))} +- 1 %", with one space on either side of +-'
    first, *widths = text.split(f" {PLUS_MINUS} ")
    if len(widths) != 1:
        raise QuantityError("has no tolerance that can be read", accepted)
    nominal, percent = value_at(path, first, finite=True), plain_number(widths[0].removesuffix(" %"))
    is_part = percent is not None and widths[0].endswith(" %")
    width = abs(nominal) * percent / 100.0 if percent is not None and is_part else parse_quantity(widths[0], dimension)
    if not 0.0 < width < math.inf:
        raise QuantityError("has a tolerance that is not positive", accepted)
    try:
        return Toleranced(nominal, *(value_at(path, end) for end in (nominal - width, nominal + width)))
    except QuantityError as wrong:
        raise QuantityError(f"has a tolerance beyond which it {wrong.problem}", wrong.accepted) from None


def si_text(path: str, value: float) -> str:
    """The shortest text of a case file that reads back as exactly this SI value of the quantity at a dotted path."""
    unit = PATHS[path].unit
    return "inf" if math.isinf(value) else f"{repr(float(value)).removesuffix('.0')} {unit}".removesuffix(" 1")


def text_of(path: str, value: Any) -> Any:
    """The text, or list of texts, that a case file has for a value in SI at a dotted path: as it was written if the value remembers it.

    A text or list of texts is returned as it is; of a table the name of its file.
    """
    if isinstance(value, Table):
        return value.file or "a table"
    if isinstance(value, tuple):
        return [text_of(path, each) for each in value]
    return value.text if isinstance(value, Written) else si_text(path, value) if isinstance(value, float) else value


def unit_in(text: str) -> str:
    """The unit in a text such as "6 mm" or "6 mm +- 0.1 mm"; "" if it has none."""
    return text.partition(PLUS_MINUS)[0].strip().partition(" ")[2]


def unit_given(path: str, texts: Iterable[str]) -> tuple[str, float]:
    """The unit in which values of the quantity at a dotted path are written, and its size in SI; the SI unit if they have several."""
    units = {unit for text in texts if (unit := unit_in(text))}
    unit = units.pop() if len(units) == 1 else PATHS[path].unit
    return unit, 1.0 if unit == "1" else unit_size(unit, dimension_of(path))


def usual_unit(path: str, values: Mapping[str, Any]) -> str:
    """The unit in which a file writes most quantities of the same dimension as that at a dotted path; "" if there is none.

    Args:
        path: of the quantity.
        values: section -> key -> text, list of texts, or anything else.
    """
    units, dimension = Counter[str](), dimension_of(path)
    for section, keys in values.items():
        for key, given in keys.items() if isinstance(keys, Mapping) else ():
            if (found := PATHS.get(f"{section}.{key}")) is not None and found.unit == dimension.si_unit:
                units.update(unit_in(text) for text in (given if isinstance(given, list) else [given]) if isinstance(text, str))
    return next((unit for unit, _ in units.most_common() if unit and measures(unit, dimension)), "")


def si_value(path: str, text: str, source: str, *, finite: bool = False) -> float:
    """As `value_at`, but a wrong text or sign is a CaseError about `source`."""
    try:
        return value_at(path, text, finite=finite)
    except QuantityError as wrong:
        raise CaseError(source, path, as_written(text), wrong.problem, wrong.accepted) from None
