"""The decimal sign of a table's numbers, or the question which of two it is."""

import re
from collections.abc import Sequence
from typing import Final

from quickreturn.cases.errors import CaseError, as_written
from quickreturn.cases.text.cells import POINTED_THOUSANDS, is_number, split

#: What to do about numbers of a recorded table that can be read in two ways.
ASKED: Final = "Give --decimal . or --decimal , (decimal= in Python)"
_THOUSANDS: Final = re.compile(r"[+-]?[1-9]\d{0,2}(,\d{3})+")


def decimal_sign(source: str, lines: Sequence[str], first: int, separator: str, known: str | None, asked: str) -> str:
    """The decimal sign of the numbers from line `first` on. CaseError, which ends with `asked`: they can be read in two ways."""
    if known is not None:
        return known
    if not any("," in line for line in lines[first:]):
        _refuse_pointed_thousands(source, lines, first, separator, asked)
        return "."
    plain = ambiguous = None
    decimal = grouped = False
    for number, line in enumerate(lines[first:], first + 1):
        for cell in split(line, separator):
            comma, point = cell.rfind(","), cell.rfind(".")
            if comma < 0:
                plain = plain or ((number, cell) if point >= 0 and is_number(cell) else None)
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
        raise CaseError(source, f"line {at}", as_written(cell), "can be read in two ways", f"is it {thousand} or {broken}? {asked}")
    return "," if decimal else "."


def _refuse_pointed_thousands(source: str, lines: Sequence[str], first: int, separator: str, asked: str) -> None:
    """Raise the CaseError of points that may separate thousands.

    A program that writes decimals gives all numbers of a column a point, or numbers of decimals that differ. So the points can be
    thousands where each has three digits behind it, and one column holds whole numbers of at most three digits as well.
    """
    pointed, whole = dict[int, tuple[int, str]](), set[int]()
    for number, line in enumerate(lines[first:], first + 1):
        for column, cell in enumerate(split(line, separator)):
            if POINTED_THOUSANDS.fullmatch(cell):
                pointed.setdefault(column, (number, cell))
            elif re.fullmatch(r"[+-]?\d{1,3}", cell):
                whole.add(column)
            elif is_number(cell):
                return
    for column in sorted(whole & set(pointed)):
        at, cell = pointed[column]
        accepted = f"is it {cell.replace('.', '')} or {cell}? {asked}"
        raise CaseError(source, f"line {at}", as_written(cell), "can be read in two ways", accepted)
