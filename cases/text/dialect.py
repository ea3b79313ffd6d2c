"""Recognises how a program wrote a table: separator, decimal sign, comments, headings, units. It refuses ambiguous numbers."""

import re
from collections.abc import Sequence
from dataclasses import dataclass, field
from itertools import zip_longest
from typing import Final, NamedTuple

from quickreturn.cases.errors import CaseError, as_written, shortened
from quickreturn.cases.text.cells import are_units, as_typed, is_row, quoted, separator_of, split, unit_in_cell, with_point, without_unit
from quickreturn.cases.text.decimal_sign import ASKED, decimal_sign
from quickreturn.cases.text.preamble import COMMENTS, MOST_LINES, Preamble, preamble

#: Separator -> its name.
SEPARATORS: Final = {",": "commas", ";": "semicolons", "\t": "tabulators", " ": "blanks"}
_UNIT_OF_HEADING: Final = re.compile(r"[\[(]([^\])]*)[\])]\s*$")
_EMPTY: Final = " \t;,\x1a"  # separators, and the end of a file of DOS
_OPEN: Final = re.compile(r'(?:^|[;,\t])\s*"[^"]*$')  # a quoted cell that goes on in the next line
#: A clock time in place of a unit, such as hh:mm:ss.fff.
_CLOCK_FORM: Final = re.compile(r"h+:m+:s+([.,]\w+)?", re.IGNORECASE)


@dataclass(frozen=True)
class Dialect:
    """The parts of a table's text.

    Attributes:
        headings: one for each column; None: the table has none.
        place: line of the headings, for messages.
        lines: the lines of the file, in which those of numbers are as `rows` needs them.
        first: index of the first line of numbers among `lines`.
        comments: the comment lines that are not the headings, with their indices.
        told: what was recognised, as clauses; empty for commas, decimal points and one line of headings.
        separator: between columns.
        decimal: the decimal sign.
    """

    headings: tuple[str, ...] | None
    place: str
    lines: Sequence[str] = field(repr=False)
    first: int
    comments: tuple[tuple[int, str], ...]
    told: tuple[str, ...]
    separator: str
    decimal: str

    @property
    def count(self) -> int:
        """Number of rows."""
        return sum(1 for line in self.lines[self.first :] if line.strip())

    @property
    def width(self) -> int:
        """Number of columns."""
        return len(self.headings) if self.headings is not None else len(split(self.lines[self.first], self.separator))

    def rows(self, source: str, wanted: Sequence[int]) -> Sequence[str]:
        """The lines with the wanted columns alone, separated by commas, with decimal points. CaseError: a row lacks a column."""
        if self.first >= len(self.lines):
            return self.lines
        units = [unit_in_cell(cell) for cell in cells_of(self.lines[self.first], self.separator, self.decimal)]
        if self.separator == "," and list(wanted) == list(range(self.width)) and len(units) <= self.width and not any(units):
            return self.lines
        lines = list(self.lines)
        for at in range(self.first, len(lines)):
            if not lines[at].strip():
                continue
            cells = cells_of(lines[at], self.separator, self.decimal)
            if len(cells) < self.width or any(cells[self.width :]):
                problem = f"has {len(cells)} numbers, the heading {self.width} columns"
                decimals = "; decimals need a point, not a comma" if self.separator == "," and len(cells) > self.width else ""
                accepted = f"give one number for each column{decimals}"
                raise CaseError(source, f"line {at + 1}", f'"{shortened(lines[at])}"', problem, accepted)
            lines[at] = ",".join(quoted(without_unit(cells[column], units[column])) for column in wanted)
        return lines


class _Head(NamedTuple):
    """Headings (None: there are none), their place, the index of the first row of numbers, comments left, and what was recognised."""

    headings: list[str] | None
    place: str
    first: int
    comments: tuple[tuple[int, str], ...]
    told: tuple[str, ...] = ()


def dialect_of(source: str, text: str, decimal: str | None = None, asked: str = ASKED) -> Dialect:
    """How a table is written. CaseError: it is empty, or ambiguous.

    Args:
        source: name of the table, for messages.
        text: its text.
        decimal: its decimal sign, if it is known.
        asked: what to do where numbers can be read in two ways, for messages.
    """
    text, grouped = as_typed(text)
    above = preamble(source, _lines(text))
    bare = is_row(above.lines[above.at])
    separator = above.separator or _separator(above, bare)
    head = _in_comment(above, separator) if bare else _above_rows(source, above, separator)
    sign = "." if separator == "," else decimal_sign(source, above.lines, head.first, separator, decimal or above.decimal, asked)
    headings, durations = _with_units_of_cells(source, head, above.lines, separator, sign)
    told = [SEPARATORS.get(separator, f'"{separator}"')] if separator != "," else []
    told += [*["decimal comma"] * (sign == ","), *["thousands in groups"] * grouped, *head.told, *["durations"] * durations, *above.told]
    if any("=" not in line for _, line in head.comments):
        told.append(f"{len(head.comments)} comment line{'s' * (len(head.comments) > 1)}")
    return Dialect(headings, head.place, above.lines, head.first, head.comments, tuple(told), separator, sign)


def _lines(text: str) -> list[str]:
    """The lines of a text, those of separators alone as blank ones; a heading of several lines in quotes is one line.

    Excel writes such headings, and such lines for empty rows. A blank line stands for each that was joined, so that numbers of lines stay.
    """
    lines = ["" if not line.strip(_EMPTY) else line for line in text.splitlines()]
    for at in range(min(len(lines), MOST_LINES) - 1):
        if _OPEN.search(lines[at]) and not lines[at].startswith(COMMENTS):
            lines[at : at + 2] = ["", f"{lines[at]} {lines[at + 1]}"]
    return lines


def cells_of(line: str, separator: str, decimal: str) -> list[str]:
    """The cells of a line, numbers with decimal points."""
    cells = split(line, separator)
    return cells if separator == "," else [with_point(cell, decimal) for cell in cells]


def _next_line(lines: Sequence[str], at: int) -> int:
    """Index of the first line from `at` on that is not blank; the number of lines if there is none."""
    return next((number for number in range(at, len(lines)) if lines[number].strip()), len(lines))


def _separator(above: Preamble, bare: bool) -> str:
    heading, below = above.lines[above.at], _next_line(above.lines, above.at + 1)
    return separator_of("" if bare else heading, heading if bare or below == len(above.lines) else above.lines[below])


def _in_comment(above: Preamble, separator: str) -> _Head:
    """The headings of a table whose first line consists of numbers: the last comment, if it has as many cells, or none."""
    *others, (at, line) = above.comments or ((0, ""),)
    inside = split(line.lstrip("".join(COMMENTS)).strip(), separator_of(line, ""))
    if not above.comments or len(inside) != len(split(above.lines[above.at], separator)):
        return _Head(None, f"line {above.at + 1}", above.at, above.comments)
    return _Head(inside, f"line {at + 1}", above.at, tuple(others), ("heading in a comment",))


def _above_rows(source: str, above: Preamble, separator: str) -> _Head:
    """The headings above the rows, with the units of a line below them."""
    headings, place = split(above.lines[above.at], separator), f"line {above.at + 1}"
    first, told = _next_line(above.lines, above.at + 1), tuple[str, ...]()
    units = split(above.lines[first], separator) if first < len(above.lines) else []
    if are_units(units, len(headings)):
        first, told = _next_line(above.lines, first + 1), ("units in the second row",)
        headings = [_headed(source, place, heading, unit.strip("[]() ")) for heading, unit in zip(headings, units, strict=True)]
    if headings and not headings[-1]:  # each line ends with a separator
        headings.pop()
    return _Head(headings, place, first, above.comments, told)


def _with_units_of_cells(
    source: str, head: _Head, lines: Sequence[str], separator: str, decimal: str
) -> tuple[tuple[str, ...] | None, bool]:
    """The headings with the units that stand in the cells of the first row, and whether there are such units."""
    if head.headings is None or head.first >= len(lines):
        return None if head.headings is None else tuple(head.headings), False
    units = [unit_in_cell(cell) for cell in cells_of(lines[head.first], separator, decimal)]
    pairs = zip_longest(head.headings, units[: len(head.headings)], fillvalue="")
    return tuple(_headed(source, head.place, heading, unit) for heading, unit in pairs), any(units)


def _headed(source: str, place: str, heading: str, unit: str) -> str:
    """A heading with the unit that stands below it. CaseError: it has another one already."""
    own = _UNIT_OF_HEADING.search(heading)
    if own and unit == "s" and _CLOCK_FORM.fullmatch(own[1].strip()):
        return f"{heading[: own.start()].strip()} [s]"
    if own and unit and unit != own[1].strip():
        told = f'is followed by the unit "{unit}"'
        raise CaseError(source, place, as_written(heading), told, "give one unit, in the heading or below it")
    return f"{heading} [{unit}]" if unit and not own else heading
