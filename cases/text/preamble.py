"""What stands above the headings of a table: comments, lines of a title, Excel's separator, and LabVIEW's blocks."""

import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Final

from quickreturn.cases.errors import CaseError, as_written
from quickreturn.cases.text.cells import are_units, is_number, is_row, separator_of, split
from quickreturn.cases.units import plain_number
from quickreturn.reference_model.columns import COLUMNS

#: Beginnings of a comment line: Python and Exudyn; MATLAB and TeX; Fortran.
COMMENTS: Final = ("#", "%", "!")
_EXCEL: Final = re.compile(r'"?sep=(.?)"?')
#: Largest number of lines above the numbers in which headings are searched.
MOST_LINES: Final = 200
_LABVIEW: Final = "***End_of_Header***"
_LABVIEW_TIME: Final = "X_Value"
_TIMED: Final = "time from X0 and Delta_X"


@dataclass(frozen=True)
class Preamble:
    """The lines of a table, and what those above its headings say.

    Attributes:
        lines: of the file.
        at: index of the line of headings; of the first row if that consists of numbers.
        comments: comment lines with their indices.
        separator: between columns, if it is declared, otherwise "".
        decimal: the decimal sign, if it is declared.
        told: what was recognised, as clauses.
    """

    lines: list[str]
    at: int
    comments: tuple[tuple[int, str], ...] = ()
    separator: str = ""
    decimal: str | None = None
    told: tuple[str, ...] = ()


def preamble(source: str, lines: list[str]) -> Preamble:
    """The preamble of a table. CaseError: there is nothing but a preamble, or LabVIEW's blocks hold more than one table."""
    if any(line.startswith(_LABVIEW) for line in lines[:MOST_LINES]):
        return _labview(source, lines)
    at, comments, separator = 0, list[tuple[int, str]](), ""
    while at < len(lines) and ((excel := _EXCEL.fullmatch(lines[at])) or not lines[at].strip() or _is_comment(lines[at])):
        if excel:
            separator = excel[1]
        elif lines[at].strip():
            comments.append((at, lines[at]))
        at += 1
    _check_heading(source, lines, at)
    above, at = range(at, heading := _heading(lines, at)), heading
    comments += [(number, lines[number]) for number in above if _is_comment(lines[number])]
    titles = sum(1 for number in above if lines[number].strip() and not _is_comment(lines[number]))
    for number in above:
        _check_title(source, lines, number, at)
    told = (f"{titles} line{'s' * (titles > 1)} above the headings left out",) if titles else ()
    return Preamble(lines, at, tuple(comments), separator, told=told)


def _is_comment(line: str) -> bool:
    return line.lstrip().startswith(COMMENTS)


def _check_heading(source: str, lines: Sequence[str], at: int) -> None:
    if at >= len(lines):
        what = "has no heading" if any(map(str.strip, lines)) else "is empty"
        raise CaseError(source, None, None, what, 'write one such as "time [s],crank_angle [deg]"')


def _heading(lines: Sequence[str], at: int) -> int:
    """Index of the line of headings: the first of as many cells as the numbers below have, which names a column if any of these does.

    It is the first line `at` where no line has as many, so that the message on the rows below names the difference.
    """
    numbers = next((number for number in range(at, min(len(lines), at + MOST_LINES)) if is_row(lines[number])), at)
    fitting = [number for number in range(at, numbers) if _fits(lines[number], lines[numbers])]
    named = [number for number in fitting if any(_names(cell) for cell in split(lines[number], separator_of(lines[number], "")))]
    return next(iter(named or fitting), at)


def _fits(line: str, row: str) -> bool:
    """Whether a line has as many cells as a row of numbers, which may end with a separator."""
    if not line.strip() or _is_comment(line):
        return False
    separator = separator_of(line, row)
    cells, numbers = (split(each.strip().rstrip(separator.strip() or None), separator) for each in (line, row))
    return len(cells) == len(numbers) > 1 and not is_number(cells[0])


def _check_title(source: str, lines: Sequence[str], number: int, heading: int) -> None:
    """Raise if a line above the headings may hold their units, which would be lost."""
    separator = separator_of(lines[heading], "")
    cells, headings = split(lines[number], separator), split(lines[heading], separator)
    if not _is_comment(lines[number]) and are_units(cells, len(headings)):
        accepted = "put units into a line below the headings, or delete the line"
        raise CaseError(source, f"line {number + 1}", as_written(lines[number]), "stands above the headings, and may hold units", accepted)


def _names(cell: str) -> bool:
    return re.sub(r"[\s_-]+", "_", re.split(r"[\[(]", cell)[0].strip().lower()) in COLUMNS


def _labview(source: str, lines: list[str]) -> Preamble:
    """The preamble of a measurement file of LabVIEW (.lvm): a block on the file, and one on the channels with their units.

    The column X_Value is the time. Where the file was written without it, it follows from X0 and Delta_X.
    """
    ends = [number for number, line in enumerate(lines) if line.startswith(_LABVIEW)]
    if len(ends) > 2:
        told = f"holds {len(ends) - 1} blocks of rows"
        raise CaseError(source, f"line {ends[2] + 1}", None, told, "keep one of them, with the two blocks above its headings")
    at = next((number for number in range(ends[-1] + 1, len(lines)) if lines[number].strip()), len(lines))
    _check_heading(source, lines, at)
    separator = "," if any(re.match(r"Separator\W+Comma", line) for line in lines[: ends[0]]) else "\t"
    block = {cells[0]: cells[1:] for line in lines[:at] if len(cells := split(line, separator)) > 1}
    decimal = block.get("Decimal_Separator", ["."])[0] or "."
    headings = [heading for heading in split(lines[at].rstrip(separator), separator) if heading != "Comment"]
    is_time = block.get("X_Dimension", ["Time"])[0] == "Time"
    units = dict(zip([each for each in headings if each != _LABVIEW_TIME], block.get("Y_Unit_Label", ()), strict=False))
    units |= {_LABVIEW_TIME: "s"} if is_time else {}
    named = [f"{_name(each, is_time)} [{units[each]}]" if units.get(each) and "[" not in each else each for each in headings]
    rows = [separator.join(line.split(separator)[: len(named)]) for line in lines[at + 1 :]]  # a comment stands in the last column
    found = Preamble([*[""] * at, separator.join(named), *rows], at, separator=separator, decimal=decimal, told=("header of LabVIEW",))
    if not (is_time and rows and rows[0].startswith(separator)):
        return found
    start, step = (_number(source, block, key, decimal) for key in ("X0", "Delta_X"))
    return replace(found, lines=[*found.lines[: at + 1], *_timed(rows, separator, decimal, start, step)], told=(*found.told, _TIMED))


def _name(heading: str, is_time: bool) -> str:
    return "time" if heading == _LABVIEW_TIME and is_time else heading


def _number(source: str, block: Mapping[str, Sequence[str]], key: str, decimal: str) -> float:
    """A number of LabVIEW's block on the channels. CaseError: there is none, or channels have different ones."""
    given = dict.fromkeys(each for each in block.get(key, ()) if each)
    value = plain_number(next(iter(given), "").replace(decimal, "."))
    if value is None or len(given) > 1:
        told = "is not one number for all channels, and the rows have no X_Value"
        raise CaseError(source, key, as_written(" ".join(given)), told, "export the table with its X values")
    return value


def _timed(rows: Sequence[str], separator: str, decimal: str, start: float, step: float) -> Iterator[str]:
    """Rows with the time in their first cell, which is empty in the file."""
    number = 0
    for row in rows:
        if row.strip():
            yield repr(start + number * step).replace(".", decimal) + separator + row.partition(separator)[2]
            number += 1
