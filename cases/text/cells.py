"""Cells of a table's lines as programs write them: separators, numbers in any dress, durations and clock times."""

import csv
import re
from collections.abc import Sequence
from typing import Final

from quickreturn.cases.mistakes.quantity_texts import NUMBER

_NUMBER: Final = re.compile(r"[+-]?(\d[\d.,]*|[.,]\d+)([eEdD][+-]?\d+)?")
POINTED_THOUSANDS: Final = re.compile(r"[+-]?[1-9]\d{0,2}(\.\d{3})+")
_SPACED_THOUSANDS: Final = re.compile(r"[+-]?[1-9]\d{0,2}( \d{3})+([.,]\d*)?")
_DURATION: Final = re.compile(rf"({NUMBER})\s+([^\W\d]+)")
_CLOCK: Final = re.compile(r"(\d+):([0-5]\d):([0-5]\d(?:\.\d*)?)")
_UNIT: Final = re.compile(r"[\[(]?[^\W\d%]*[-%*/^.\w·²³°‰]*[\])]?")
#: Signs of typography between the thousands of a number: narrow and unbreakable blanks, apostrophes.
_GROUPED: Final = re.compile("(?<=[0-9])[\u00a0\u2009\u202f'\u2019](?=[0-9]{3}(?![0-9]))")


def as_typed(text: str) -> tuple[str, bool]:
    """A text without signs between thousands and with plain blanks and minus signs, and whether there were such thousands."""
    if text.isascii() and "'" not in text:
        return text, False
    plain, groups = _GROUPED.subn("", text)
    return re.sub("[\u00a0\u2009\u202f]", " ", plain).replace("\u2212", "-"), bool(groups)


def split(line: str, separator: str) -> list[str]:
    """The cells of a line, without quotes and blanks around them; a unit in brackets belongs to the name before it."""
    if separator == " ":
        return [cell.strip('"') for cell in re.findall(r'"[^"]*"|[^\s"]+(?:\s+[\[(][^\])]*[\])])*', line)]
    return [cell.strip() for cell in next(csv.reader([line], delimiter=separator, skipinitialspace=True), [])]


def separator_of(heading: str, row: str) -> str:
    """The separator of a line of headings, or of a row of numbers where there is none ("")."""
    line = re.sub(r'"[^"]*"|[\[(][^\])]*[\])]', "x", heading) or row
    for sign in (";", "\t"):
        if sign in line.strip():
            return sign
    if heading:
        return "," if "," in line or len(row.split()) < 2 or ("," in row and not _all_numbers(row.split())) else " "
    return "," if "," in line and not (len(line.split()) > 1 and _all_numbers(line.split())) else " " if len(line.split()) > 1 else ","


def is_number(cell: str) -> bool:
    """Whether a cell is a number, with either decimal sign and with or without separators of thousands."""
    return bool(_NUMBER.fullmatch(cell))


def is_row(line: str) -> bool:
    """Whether a line consists of numbers alone."""
    cells = [cell.strip().strip('"') for cell in re.split(r"[;\t,\s]+", line.strip()) if cell]
    return bool(cells) and _all_numbers(cells)


def _all_numbers(cells: Sequence[str]) -> bool:
    return all(map(is_number, cells))


def are_units(cells: Sequence[str], width: int) -> bool:
    """Whether a row below the headings holds units: no numbers, as many as there are columns, and each the form of a unit."""
    return (
        len(cells) == width
        and any(cells)
        and not any(cell in ("nan", "inf", "NaN", "Inf") or re.match(r"[+-]?[.,]?\d", cell) for cell in cells)
        and all(_UNIT.fullmatch(cell) for cell in cells)
    )


def with_point(cell: str, decimal: str) -> str:
    """A cell with a decimal point and without thousands separators."""
    if decimal == "," and POINTED_THOUSANDS.fullmatch(cell):
        return cell.replace(".", "")
    if _SPACED_THOUSANDS.fullmatch(cell):
        cell = cell.replace(" ", "")
    if "," not in cell or not re.match(r"[+-]?[\d.,]", cell):
        return cell
    if decimal == ",":
        return cell.replace(".", "").replace(",", ".") if re.fullmatch(r"[+-]?\d{1,3}(\.\d{3})+,.*", cell) else cell.replace(",", ".")
    return cell.replace(",", "") if re.match(r"[+-]?\d{1,3}(,\d{3})+(?!\d)", cell) else cell


def unit_in_cell(cell: str) -> str:
    """The unit that a cell has behind its number, "s" of hours, minutes and seconds, otherwise ""."""
    return duration[2] if (duration := _DURATION.fullmatch(cell)) else "s" if _CLOCK.fullmatch(cell) else ""


def without_unit(cell: str, unit: str) -> str:
    """A cell without the unit behind its number, if that is `unit`; hours, minutes and seconds as seconds."""
    if not unit or unit_in_cell(cell) != unit:
        return cell
    if clock := _CLOCK.fullmatch(cell):
        return repr(3600 * int(clock[1]) + 60 * int(clock[2]) + float(clock[3]))
    return cell.split()[0]


def quoted(cell: str) -> str:
    """A cell for a line that commas separate."""
    return f'"{cell}"' if "," in cell or not cell else cell
