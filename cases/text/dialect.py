"""Recognises how a program wrote a table: separator, decimal sign, comments, headings, units. It refuses ambiguous numbers."""

import csv
import re
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Final

from quickreturn.cases.errors import CaseError, as_written, shortened
from quickreturn.cases.mistakes.quantity_texts import NUMBER

#: Separator -> its name.
SEPARATORS: Final = {",": "commas", ";": "semicolons", "\t": "tabulators", " ": "blanks"}
#: Beginnings of a comment line: Python and Exudyn; MATLAB and TeX; Fortran.
COMMENTS: Final = ("#", "%", "!")
_NUMBER: Final = re.compile(r"[+-]?(\d[\d.,]*|[.,]\d+)([eEdD][+-]?\d+)?")
_THOUSANDS: Final = re.compile(r"[+-]?[1-9]\d{0,2}(,\d{3})+")
_POINTED_THOUSANDS: Final = re.compile(r"[+-]?[1-9]\d{0,2}(\.\d{3})+")
_DURATION: Final = re.compile(rf"({NUMBER})\s+([^\W\d]+)")
_CLOCK: Final = re.compile(r"(\d+):([0-5]\d):([0-5]\d(?:\.\d*)?)")
_UNIT: Final = re.compile(r"[\[(]?[^\W\d%]*[-%*/^.\w·²]*[\])]?")


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
        if self.separator == "," and list(wanted) == list(range(self.width)) and not _has_units(self._cells(self.first)):
            return self.lines
        lines = list(self.lines)
        units = [duration[2] if (duration := _DURATION.fullmatch(cell)) else "" for cell in self._cells(self.first)]
        for at in range(self.first, len(lines)):
            if not lines[at].strip():
                continue
            cells = self._cells(at)
            if len(cells) < self.width or any(cells[self.width :]):
                problem = f"has {len(cells)} numbers, the heading {self.width} columns"
                decimals = "; decimals need a point, not a comma" if self.separator == "," and len(cells) > self.width else ""
                accepted = f"give one number for each column{decimals}"
                raise CaseError(source, f"line {at + 1}", f'"{shortened(lines[at])}"', problem, accepted)
            lines[at] = ",".join(_quoted(_plain(cells[column], units[column])) for column in wanted)
        return lines

    def _cells(self, at: int) -> list[str]:
        cells = split(self.lines[at], self.separator)
        if self.separator == ",":
            return cells
        return [_with_point(cell, self.decimal) for cell in cells]


def dialect_of(source: str, text: str, decimal: str | None = None) -> Dialect:
    """How a table is written; `decimal`: its decimal sign, if it is known. CaseError: it is empty, or ambiguous."""
    lines = text.splitlines()
    told = list[str]()
    comments = list[tuple[int, str]]()
    at, forced = 0, ""
    while at < len(lines) and (not (line := lines[at].strip()) or line.startswith(COMMENTS) or re.fullmatch(r'"?sep=.?"?', lines[at])):
        if line.startswith(COMMENTS):
            comments.append((at, lines[at]))
        elif line:
            forced, lines[at] = lines[at].strip('"')[4:], ""
        at += 1
    if at == len(lines):
        what = "has no heading" if text.strip() else "is empty"
        raise CaseError(source, None, None, what, 'write one such as "time [s],crank_angle [deg]"')
    first = next((number for number in range(at, len(lines)) if lines[number].strip() and number > at), len(lines))
    bare = _is_row(lines[at])
    sample = lines[at] if bare or first == len(lines) else lines[first]
    separator = forced or _separator("" if bare else lines[at], sample)
    if separator != ",":
        told.append(SEPARATORS.get(separator, f'"{separator}"'))
    headings, place, units = None, f"line {at + 1}", list[str]()
    if not bare:
        headings = split(lines[at], separator)
        if first < len(lines) and _is_units(cells := split(lines[first], separator), len(headings)):
            units = [cell.strip("[]() ") for cell in cells]
            first = next((number for number in range(first + 1, len(lines)) if lines[number].strip()), len(lines))
    else:
        first = at
        width = len(split(lines[at], separator))
        if comments and len(inside := split(comments[-1][1].lstrip("".join(COMMENTS)).strip(), _separator(comments[-1][1], ""))) == width:
            headings, place = inside, f"line {comments.pop()[0] + 1}"
    if headings and not headings[-1]:  # each line ends with a separator
        headings.pop()
    sign = "." if separator == "," else _decimal_sign(source, lines, first, separator, decimal)
    if sign == ",":
        told.append("decimal comma")
    if headings is not None and bare:
        told.append("heading in a comment")
    if units and headings is not None:
        told.append("units in the second row")
        headings = [_headed(source, place, *pair) for pair in zip(headings, units, strict=False)]
    if headings is not None and first < len(lines):
        cells = [_with_point(cell, sign) if separator != "," else cell for cell in split(lines[first], separator)]
        if _has_units(cells):
            told.append("durations")
            of_cells = [match[2] if (match := _DURATION.fullmatch(cell)) else "s" if _CLOCK.fullmatch(cell) else "" for cell in cells]
            pairs = zip(headings, of_cells, strict=False)
            headings = [_headed(source, place, *pair) if pair[1] else pair[0] for pair in pairs]
    if comments and any("=" not in line for _, line in comments):
        told.append(f"{len(comments)} comment line{'s' * (len(comments) > 1)}")
    return Dialect(None if headings is None else tuple(headings), place, lines, first, tuple(comments), tuple(told), separator, sign)


def split(line: str, separator: str) -> list[str]:
    """The cells of a line, without quotes and blanks around them; a unit in brackets belongs to the name before it."""
    if separator == " ":
        return [cell.strip('"') for cell in re.findall(r'"[^"]*"|[^\s"]+(?:\s+[\[(][^\])]*[\])])*', line)]
    return [cell.strip() for cell in next(csv.reader([line], delimiter=separator, skipinitialspace=True), [])]


def _separator(heading: str, row: str) -> str:
    """The separator of a line of headings, or of a row of numbers where there is none ("")."""
    line = re.sub(r'"[^"]*"|[\[(][^\])]*[\])]', "x", heading) or row
    for sign in (";", "\t"):
        if sign in line.strip():
            return sign
    if heading:
        return "," if "," in line or len(row.split()) < 2 or ("," in row and not _all_numbers(row.split())) else " "
    return "," if "," in line and not (len(line.split()) > 1 and _all_numbers(line.split())) else " " if len(line.split()) > 1 else ","


def _all_numbers(cells: Sequence[str]) -> bool:
    return all(_NUMBER.fullmatch(cell) for cell in cells)


def _is_row(line: str) -> bool:
    """Whether a line consists of numbers alone."""
    cells = [cell.strip().strip('"') for cell in re.split(r"[;\t,\s]+", line.strip()) if cell]
    return bool(cells) and _all_numbers(cells)


def _is_units(cells: Sequence[str], width: int) -> bool:
    """Whether a row below the headings holds units: no numbers, as many as there are columns, and each the form of a unit."""
    return (
        len(cells) == width
        and any(cells)
        and not any(cell in ("nan", "inf", "NaN", "Inf") or re.match(r"[+-]?[.,]?\d", cell) for cell in cells)
        and all(_UNIT.fullmatch(cell) for cell in cells)
    )


def _headed(source: str, place: str, heading: str, unit: str) -> str:
    """A heading with the unit that stands below it. CaseError: it has one already."""
    if re.search(r"[\[(][^\])]*[\])]\s*$", heading):
        if unit and unit not in heading:
            told = f'is followed by the unit "{unit}"'
            raise CaseError(source, place, as_written(heading), told, "give one unit, in the heading or below it")
        return heading
    return f"{heading} [{unit}]" if unit else heading


def _decimal_sign(source: str, lines: Sequence[str], first: int, separator: str, known: str | None) -> str:
    """The decimal sign of the numbers from line `first` on. CaseError: they can be read in two ways."""
    if known is not None:
        return known
    if not any("," in line for line in lines[first:]):
        _refuse_pointed_thousands(source, lines, first, separator)
        return "."
    plain = ambiguous = None
    decimal = grouped = False
    for number, line in enumerate(lines[first:], first + 1):
        for cell in split(line, separator):
            comma, point = cell.rfind(","), cell.rfind(".")
            if comma < 0:
                plain = plain or ((number, cell) if point >= 0 and _NUMBER.fullmatch(cell) else None)
            elif point > comma or cell.count(",") > 1:
                grouped = True
            elif point >= 0 or not _THOUSANDS.fullmatch(cell):
                decimal = True
            else:
                ambiguous = ambiguous or (number, cell)
    if decimal and (grouped or plain):
        at, cell = plain or (first + 1, "")
        told = "stands in a table that has decimal commas too"
        raise CaseError(source, f"line {at}", as_written(cell), told, "use one decimal sign throughout")
    if not (decimal or grouped or plain) and ambiguous:
        at, cell = ambiguous
        thousand, broken = cell.replace(",", ""), cell.replace(",", ".")
        asked = f"is it {thousand} or {broken}? Give --decimal . or --decimal , (decimal= in Python)"
        raise CaseError(source, f"line {at}", as_written(cell), "can be read in two ways", asked)
    return "," if decimal else "."


def _refuse_pointed_thousands(source: str, lines: Sequence[str], first: int, separator: str) -> None:
    """Raise the CaseError of points that may separate thousands.

    A program that writes decimals gives all numbers of a column a point, or numbers of decimals that differ. So the points can be
    thousands where each has three digits behind it, and one column holds whole numbers of at most three digits as well.
    """
    pointed, whole = dict[int, tuple[int, str]](), set[int]()
    for number, line in enumerate(lines[first:], first + 1):
        for column, cell in enumerate(split(line, separator)):
            if _POINTED_THOUSANDS.fullmatch(cell):
                pointed.setdefault(column, (number, cell))
            elif re.fullmatch(r"[+-]?\d{1,3}", cell):
                whole.add(column)
            elif _NUMBER.fullmatch(cell):
                return
    for column in sorted(whole & set(pointed)):
        at, cell = pointed[column]
        asked = f"is it {cell.replace('.', '')} or {cell}? Give --decimal , or --decimal . (decimal= in Python)"
        raise CaseError(source, f"line {at}", as_written(cell), "can be read in two ways", asked)


def _with_point(cell: str, decimal: str) -> str:
    """A cell with a decimal point and without thousands separators."""
    if decimal == "," and _POINTED_THOUSANDS.fullmatch(cell):
        return cell.replace(".", "")
    if "," not in cell or not re.match(r"[+-]?[\d.,]", cell):
        return cell
    if decimal == ",":
        return cell.replace(".", "").replace(",", ".") if re.fullmatch(r"[+-]?\d{1,3}(\.\d{3})+,.*", cell) else cell.replace(",", ".")
    return cell.replace(",", "") if re.match(r"[+-]?\d{1,3}(,\d{3})+(?!\d)", cell) else cell


def _has_units(cells: Sequence[str]) -> bool:
    return any(_DURATION.fullmatch(cell) or _CLOCK.fullmatch(cell) for cell in cells)


def _plain(cell: str, unit: str) -> str:
    """A cell without the unit behind its number, if that is `unit`; hours, minutes and seconds as seconds."""
    if clock := _CLOCK.fullmatch(cell):
        return repr(3600 * int(clock[1]) + 60 * int(clock[2]) + float(clock[3]))
    duration = _DURATION.fullmatch(cell) if unit else None
    return duration[1] if duration and duration[2] == unit else cell


def _quoted(cell: str) -> str:
    return f'"{cell}"' if "," in cell or not cell else cell
