"""Rows of numbers below one line of headings, each a name with its unit in brackets, and messages that name the place of a mistake."""

import csv
import io
import math
import re
from collections.abc import Mapping, Sequence
from itertools import islice
from typing import Final

import numpy as np
from numpy.typing import NDArray

from quickreturn.cases.errors import CaseError, as_written, shortened
from quickreturn.cases.units import DIMENSIONS, PURE_UNITS, QuantityError, in_si, plain_number, unit_size

Array = NDArray[np.float64]

#: SI unit -> units that pint does not know, or knows as something else -> the same as `in_si` reads it.
_OTHER_UNITS: Final[Mapping[str, Mapping[str, str]]] = {
    "1": {"-": "1", "": "1", "%": "percent", **dict.fromkeys(("µε", "με", "ustrain"), "microstrain")} | {unit: unit for unit in PURE_UNITS},
    "m/s^2": {"g": "g0"},
}
#: Characters in the units of headings, as printed -> as `in_si` reads them.
_PRINTED: Final[Mapping[str, str]] = {"°": "deg", "²": "^2", "³": "^3", "·": "*", "⋅": "*"}
#: Units that are hardly meant as pint reads them -> what to write: a thousand million radians, 1/400 of a turn, a thousand kilometres.
_TWO_MEANINGS: Final[Mapping[str, str]] = {
    **dict.fromkeys(("Grad", "grad"), 'write "deg" for 1/360 of a turn, "gon" for 1/400'),
    "Mm": 'write "mm" for millimetres',
}
#: Pattern in a text that is not a number -> advice; the first that fits is given.
_HINTS: Final = {
    r"\d{4}-\d\d?-\d\d?|\d\d?[./]\d\d?[./]\d{2,4}": "it is a date: write seconds from the first row",
    r"^\d+:\d\d": "of a clock: write hours, minutes and seconds, or seconds",
    r"\d;": "semicolons separate it: use commas, and decimal points",
    r"\d,\d{3}(,\d{3})*\.": "leave out the separators of thousands",
    r"\d,|,\d": "the decimal sign is a point",
    r"\d[dD][-+]?\d": "write e for D",
}
_HEADING: Final = re.compile(r"\s*([^\[\]()]*?)\s*(?:[\[(]([^\[\]()]*)[\])]\s*)?")


def name_and_unit(source: str, place: str, heading: str, example: str) -> tuple[str, str | None]:
    """The name and the unit in a heading; None for no unit. CaseError: it is a number."""
    match = _HEADING.fullmatch(heading)
    name, unit = (match[1], match[2]) if match else (heading, None)
    if plain_number(name.strip()) is not None:
        raise CaseError(source, place, as_written(heading), "is a number where a heading is due", f'begin with one such as "{example}"')
    return name, unit if unit is None else unit.strip()


def unit_factor(source: str, place: str, si_unit: str, unit: str) -> float:
    """The SI value of a unit in a heading, for a column whose SI unit is `si_unit`. CaseError: no such unit, or one that means two."""
    others, unit = _OTHER_UNITS.get(si_unit, {}), _as_here(unit)
    if unit in _TWO_MEANINGS:
        raise CaseError(source, place, as_written(unit), "can be read in two ways", _TWO_MEANINGS[unit])
    if unit in others:
        return in_si(others[unit])
    try:
        return unit_size(unit, DIMENSIONS[si_unit])
    except QuantityError as wrong:
        raise CaseError(source, place, as_written(unit), wrong.problem, wrong.accepted) from None


def _as_here(unit: str) -> str:
    for printed, here in _PRINTED.items():
        unit = unit.replace(printed, here)
    return unit


def numbers_in(source: str, names: Sequence[str], lines: Sequence[str], first: int, rising: str, doubled: bool = False) -> Array:
    """The numbers in the lines from `first` on, shape (rows, columns).

    CaseError: the first mistake; the column `rising` must rise, or must not fall if the same value may be `doubled` in the next row.
    """
    if not any(line.strip() for line in lines[first:]):
        raise CaseError(source, None, None, "has no rows below its heading", "a whole turn of the crank is needed")
    try:
        values = np.loadtxt(io.StringIO("\n".join(lines[first:])), delimiter=",", ndmin=2, comments=None, quotechar='"')
    except ValueError:
        values = None
    if (
        values is None
        or values.shape[1] != len(names)
        or not np.all(np.isfinite(values))
        or late_row(values[:, names.index(rising)], doubled) is not None
    ):
        raise _bad_row(source, names, lines, first, rising, doubled)
    return values


def late_row(values: Array, doubled: bool = False) -> int | None:
    """Index of the first row whose value is smaller than that of the row before, or equal unless it may be `doubled`; None: no row."""
    steps = np.diff(values)
    late = np.flatnonzero(steps < 0.0 if doubled else steps <= 0.0)
    return int(late[0]) + 1 if late.size else None


def does_not_rise(source: str, place: str, value: float, accepted: str = "sort the rows and drop doubles") -> CaseError:
    """The mistake of a value that is not larger than that of the row before."""
    return CaseError(source, place, f"{value:.12g}", "does not rise", accepted)


def line_of(lines: Sequence[str], first: int, row: int) -> int:
    """Number of the line, counted from 1, that holds a row, counted from 0; rows begin at index `first`."""
    return next(islice((number for number in range(first, len(lines)) if lines[number].strip()), row, None)) + 1


def _bad_row(source: str, names: Sequence[str], lines: Sequence[str], first: int, rising: str, doubled: bool) -> CaseError:
    """The mistake in the first row that is not one finite number for each column, or does not rise."""
    before = -math.inf
    for number, line in enumerate(lines[first:], first + 1):
        if not line.strip():
            continue
        place, row = f"line {number}", f'"{shortened(line)}"'
        cells = next(csv.reader([line], skipinitialspace=True))
        if not any(re.match(r"\s*[+-]?\.?[0-9]", cell) for cell in cells):
            accepted = "after the one line of headings, with units in their brackets, come rows of numbers alone"
            return CaseError(source, place, row, "is no row of numbers", accepted)
        for name, cell in zip(names, cells, strict=False):
            value = plain_number(cell.strip())
            if value is None or not np.isfinite(value):
                hint = next((f" ({told})" for pattern, told in _HINTS.items() if re.search(pattern, cell)), "")
                problem = f"is no plain number{hint}" if cell.strip() else "is empty"
                accepted = "leave out rows that lack a number, or columns that were not recorded"
                return CaseError(source, f"{place}, {name}", as_written(cell), problem, accepted)
            if name == rising:
                if not (value > before or (doubled and value == before)):
                    return does_not_rise(source, f"{place}, {name}", value)
                before = value
        if len(cells) != len(names):
            problem = f"has {len(cells)} numbers, the heading {len(names)} columns"
            accepted = f"give one number for each column{'; decimals need a point, not a comma' if len(cells) > len(names) else ''}"
            return CaseError(source, place, row, problem, accepted)
    return CaseError(source, None, None, "cannot be read as rows of numbers", "give one plain number for each column")
