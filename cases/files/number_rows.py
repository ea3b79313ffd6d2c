"""Rows of numbers below a line of headings: how a table is written, its headings with their units, and its numbers.

Separator, decimal sign, comment lines, headings in the last comment and a row of units are recognised; a `Form` states what is not.
"""

import contextlib
import csv
import math
import re
from array import array
from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from datetime import date, datetime, time, timedelta
from typing import Final

import numpy as np

from quickreturn.cases.files.errors import CaseError, as_written, shortened
from quickreturn.cases.files.units import DIMENSIONS, PURE_UNITS, QuantityError, in_si, unit_size
from quickreturn.reference_model.arrays import Array

#: Separator -> its name.
SEPARATORS: Final = {",": "commas", ";": "semicolons", "\t": "tabulators", " ": "blanks"}
#: Names of separators that are hard to type.
NAMED: Final = {"tab": "\t", "blank": " "}
#: Beginnings of a comment line: Python and Exudyn; MATLAB and TeX; Fortran.
_COMMENTS: Final = ("#", "%", "!")
_DAY: Final = timedelta(days=1)
#: What to do about a table that cannot be read.
ADVICE: Final = "say how it is written by --separator, --decimal or --skip LINES (in Python separator=, decimal=, skip=)"
_NUMBER: Final = re.compile(r"[+-]?(\d+[.,]?\d*|[.,]\d+)([eE][+-]?\d+)?")
_BEGINS_AS_NUMBER: Final = re.compile(r"[+-]?[.,]?\d|[+-]?(nan|inf)", re.IGNORECASE)
#: A comma in a number that does not separate thousands, and one that may.
_DECIMAL_COMMA: Final = re.compile(r"(?<![\d.,])[+-]?(0\d*|\d{4,})?,\d|(?<=\d),(\d{1,2}|\d{4,})(?!\d)")
_COMMA: Final = re.compile(r"[+-]?\d+,\d+")
_HEADING: Final = re.compile(r"\s*([^\[\]()]*?)\s*(?:[\[(]([^\[\]()]*)[\])]\s*)?")
_UNIT_OF_HEADING: Final = re.compile(r"[\[(]([^\])]*)[\])]\s*$")

#: SI unit -> units that pint does not know, or knows as something else -> the same as `in_si` reads it.
_OTHER_UNITS: Final[Mapping[str, Mapping[str, str]]] = {
    "1": {"-": "1", "": "1", "%": "percent", **dict.fromkeys(("µε", "με", "ustrain"), "microstrain")} | {unit: unit for unit in PURE_UNITS},
    "m/s^2": {"g": "g0"},
}
#: Characters in the units of headings, as printed -> as `in_si` reads them.
_PRINTED: Final = str.maketrans({"°": "deg", "²": "^2", "³": "^3", "·": "*", "⋅": "*"})
#: Units that are hardly meant as pint reads them -> what to write: a thousand million radians, 1/400 of a turn, a thousand kilometres.
_TWO_MEANINGS: Final[Mapping[str, str]] = {
    **dict.fromkeys(("Grad", "grad"), 'write "deg" for 1/360 of a turn, "gon" for 1/400'),
    "Mm": 'write "mm" for millimetres',
}


@dataclass(frozen=True)
class Form:
    """How a table is written."""

    separator: str | None = None  # one of `SEPARATORS` or `NAMED`; None: recognised
    decimal: str | None = None  # "." or ","; None: recognised
    skip: int = 0  # number of lines above the headings that are left out


#: The form that is recognised.
PLAIN: Final = Form()


@dataclass(frozen=True)
class Numbers:
    """The numbers of a table."""

    values: Array  # shape (rows, columns)
    decimal: str  # the decimal sign
    lines: Sequence[int]  # the line of each row, counted from 1
    lacking: int  # number of rows that are left out, since a cell is empty or "nan"
    emptiest: str  # name of the column in which most of these lack a number; "" if none is left out
    begin: datetime | None  # the first date or time of day of the rising column, from which seconds count; None: it has plain numbers


@dataclass(frozen=True)
class TableText:
    """The parts of a table's text."""

    source: str  # name of the table, for messages
    headings: tuple[str, ...] | None  # one for each column, with its unit in brackets if it has one; None: the table has none
    place: str  # line of the headings, for messages
    rows: Sequence[tuple[int, str]] = field(default=(), repr=False)  # the lines of numbers, each with its number in the file
    comments: tuple[tuple[int, str], ...] = ()  # the comment lines above the headings, each with its number in the file
    told: tuple[str, ...] = ()  # what was recognised, as clauses; empty for commas and one line of headings
    separator: str = ","  # sign between columns
    decimal: str | None = "."  # the decimal sign; None: the numbers show it
    advice: str = ADVICE  # what to do if it cannot be read

    @property
    def width(self) -> int:
        """Number of columns."""
        return len(self.headings or _split(self.rows[0][1], self.separator))

    def numbers(self, names: Sequence[str], places: Sequence[int], rising: str, doubled: bool = False) -> Numbers:
        """The numbers of columns.

        Args:
            names: of the columns, for messages.
            places: of the columns, counted from 0.
            rising: name of the column that must rise; of `time` dates and times of day (ISO 8601) count in seconds from the first one.
            doubled: whether it may have the same value in two rows.

        Raises:
            CaseError: the first mistake.
        """
        values, lines, before, width = array("d"), list[int](), -math.inf, self.width
        left_out, empty, begin = 0, Counter[str](), None
        decimal, rises = self.decimal or _decimal(self.source, self.rows, self.advice), names.index(rising)
        swap = str.maketrans(",.", ".,") if decimal == "," else {}
        for number, line in self.rows:
            cells = _split(line, self.separator)
            if not any(cells):
                continue
            if len(cells) < width or any(cells[width:]):
                problem = f"has cells of {len(cells)} columns, the headings are those of {width}"
                raise CaseError(self.source, f"line {number}", f'"{shortened(line)}"', problem, self.advice)
            row = [_number(cells[place], swap) for place in places]
            if rising == "time" and math.isinf(row[rises]) and (instant := _instant(cells[places[rises]])) is not None:
                begin = begin or instant
                since = instant - begin
                if begin.date() == date.min and since.total_seconds() < before - 0.5 * _DAY.total_seconds():  # past midnight
                    since += _DAY
                row[rises] = since.total_seconds()
            for name, place, value in zip(names, places, row, strict=True):
                if math.isinf(value):
                    date_form = "; write dates as 2026-05-04T08:15:00.25" if name == "time" else ""
                    accepted = f"leave out the row or the column, or {self.advice}{date_form}"
                    raise CaseError(self.source, f"line {number}, {name}", as_written(cells[place]), "is no plain number", accepted)
            if math.isnan(sum(row)):
                left_out += 1
                empty.update(name for name, value in zip(names, row, strict=True) if math.isnan(value))
                continue
            if row[rises] < before or (row[rises] == before and not doubled):
                raise does_not_rise(self.source, f"line {number}, {rising}", row[rises])
            before = row[rises]
            values.extend(row)
            lines.append(number)
        emptiest = max(empty, key=empty.__getitem__, default="")
        if not lines and emptiest:
            accepted = f'ignore a column of another rate, such as --column "{emptiest} = -"'
            raise CaseError(self.source, None, None, "has an empty cell in each of its rows", accepted)
        if not lines:
            raise CaseError(self.source, None, None, "has no rows below its headings", "a whole turn of the crank is needed")
        return Numbers(np.frombuffer(values).reshape(-1, len(names)), decimal, lines, left_out, emptiest, begin)


def table_text(source: str, text: str, form: Form = PLAIN, advice: str = ADVICE) -> TableText:
    """The parts of a table's text.

    Args:
        source: name of the table, for messages.
        text: its text.
        form: how it is written, where that is known.
        advice: what to do if it cannot be read, for messages.

    Raises:
        CaseError: it has no headings and no rows, two units for a column, or numbers that can be read in two ways.
    """
    lines = [(number, line) for number, line in enumerate(text.splitlines(), 1) if number > form.skip and line.strip()]
    rows = [(number, line) for number, line in lines if not line.lstrip().startswith(_COMMENTS)]
    if any(len(line) > csv.field_size_limit() for _, line in rows):
        raise CaseError(source, None, None, "is no table of lines", advice)
    if not rows:
        problem = "has no headings" if lines else "is empty"
        raise CaseError(source, None, None, problem, 'write a line such as "time [s],crank_angle [deg]"')
    at, head = rows[0]
    comments = [(number, line) for number, line in lines if number < at and line.lstrip().startswith(_COMMENTS)]
    separator = NAMED.get(form.separator or "", form.separator) or _separator(head)
    cells, told = _split(head, separator), [SEPARATORS[separator]] if separator != "," else []
    headings, noted = list[str](), ""
    if not all(_NUMBER.fullmatch(cell) for cell in cells if cell):
        headings, rows = cells, rows[1:]
        if headings and not headings[-1]:  # each line ends with a separator
            headings.pop()
    elif comments and len(inside := _split(comments[-1][1].lstrip(" " + "".join(_COMMENTS)), separator)) == len(cells):
        (at, _), headings, noted = comments.pop(), inside, "heading in a comment"
    place = f"line {at}"
    below = _split(rows[0][1], separator) if rows else []
    if headings and any(below) and len(below) - len(headings) in (0, 1) and not any(_BEGINS_AS_NUMBER.match(cell) for cell in below):
        rows, noted = rows[1:], "units in the second row"
        headings = [_headed(source, place, heading, unit.strip("[]() ")) for heading, unit in zip(headings, below, strict=False)]
    told += [noted] * bool(noted)
    if any("=" not in line for _, line in comments):
        told.append(f"{len(comments)} comment line{'s' * (len(comments) > 1)}")
    decimal = "." if separator == "," else form.decimal
    return TableText(source, tuple(headings) or None, place, rows, tuple(comments), tuple(told), separator, decimal, advice)


def _separator(line: str) -> str:
    """The separator of a line of headings or numbers; signs in quotes and in brackets do not count."""
    outside = re.sub(r'"[^"]*"|[\[(][^\])]*[\])]', "x", line).strip()
    return next((sign for sign in ";\t, " if sign in outside), ",")


def _split(line: str, separator: str) -> list[str]:
    """The cells of a line, without quotes and blanks around them; among blanks, a unit in brackets belongs to the name before it."""
    if separator == " ":
        line = re.sub(r" (?=[\[(])", "", " ".join(line.split()))
    return [cell.strip() for cell in next(csv.reader([line], delimiter=separator, skipinitialspace=True), [])]


def _number(cell: str, swap: Mapping[int, int]) -> float:
    """The number in a cell: NaN if it is empty, infinite if it is no plain number. `swap`: what makes its decimal sign a point."""
    try:
        return float(cell.translate(swap).replace("_", "?") or math.nan)  # Python reads 1_0 as 10
    except ValueError:
        return math.inf


def _instant(cell: str) -> datetime | None:
    """The date, or time of day, in a cell; None if it is neither."""
    with contextlib.suppress(ValueError):
        instant = datetime.fromisoformat(cell)
        return (instant - (instant.utcoffset() or timedelta())).replace(tzinfo=None)
    with contextlib.suppress(ValueError):
        return datetime.combine(date.min, time.fromisoformat(cell).replace(tzinfo=None))
    return None


def _decimal(source: str, rows: Sequence[tuple[int, str]], advice: str) -> str:
    """The decimal sign of numbers that no commas separate. CaseError: it may be either."""
    commas = [(number, match[0]) for number, line in rows if "," in line and (match := _COMMA.search(line))]
    if not commas:
        return "."
    pointed = any(re.search(r"\d\.\d", line) for _, line in rows)
    if pointed or not any(_DECIMAL_COMMA.search(line) for _, line in rows if "," in line):
        problem = "stands in a table that has decimal points too" if pointed else "can be read in two ways"
        raise CaseError(source, f"line {commas[0][0]}", as_written(commas[0][1]), problem, advice)
    return ","


def _headed(source: str, place: str, heading: str, unit: str) -> str:
    """A heading with the unit that stands below it. CaseError: it has another one already."""
    own = _UNIT_OF_HEADING.search(heading)
    if own and unit and unit != own[1].strip():
        raise CaseError(
            source, place, as_written(heading), f'is followed by the unit "{unit}"', "give one unit, in the heading or below it"
        )
    return f"{heading} [{unit}]" if unit and not own else heading


def name_and_unit(heading: str) -> tuple[str, str | None]:
    """The name and the unit in a heading; None for no unit."""
    match = _HEADING.fullmatch(heading)
    name, unit = (match[1], match[2]) if match else (heading, None)
    return name, unit if unit is None else unit.strip()


def unit_factor(source: str, place: str, si_unit: str, unit: str) -> float:
    """The SI value of a unit in a heading, for a column whose SI unit is `si_unit`. CaseError: no such unit, or one that means two."""
    others, unit = _OTHER_UNITS.get(si_unit, {}), re.sub(r"(?<=\w) (?=\w)", "*", unit).translate(_PRINTED)
    if unit in _TWO_MEANINGS:
        raise CaseError(source, place, as_written(unit), "can be read in two ways", _TWO_MEANINGS[unit])
    if unit in others:
        return in_si(others[unit])
    try:
        return unit_size(unit, DIMENSIONS[si_unit])
    except QuantityError as wrong:
        raise CaseError(source, place, as_written(unit), wrong.problem, wrong.accepted) from None


def does_not_rise(source: str, place: str, value: float, accepted: str = "sort the rows and drop doubles") -> CaseError:
    """The mistake of a value that is not larger than that of the row before."""
    return CaseError(source, place, f"{value:.12g}", "does not rise", accepted)
