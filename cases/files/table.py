"""Reads a table of a machine: a CSV file that a case file names, or its text in the case file itself."""

import math
import os
from collections.abc import Mapping, Sequence
from typing import Final

import numpy as np

from quickreturn.cases.files.errors import CaseError, as_written, path_shown
from quickreturn.cases.files.number_rows import name_and_unit, table_text, unit_factor
from quickreturn.cases.files.text_file import read_text
from quickreturn.reference_model.arrays import Array
from quickreturn.reference_model.table import ROUNDING, UNITS, Table
from quickreturn.reference_model.tip import FIXED, FOLLOWING

#: Key of a table -> the columns that it may have, those of the points first.
COLUMNS: Final[Mapping[str, tuple[tuple[str, ...], ...]]] = {
    "tip.force_table": (FIXED, FOLLOWING),
    "crank.torque_table": (("crank_speed", "crank_torque"),),
    "crank.speed_table": (("time", "crank_speed"), ("crank_angle", "crank_speed")),
}
#: SI unit -> the unit that examples show.
_SHOWN: Final[Mapping[str, str]] = {"rad": "deg", "rad/s": "rpm"}
#: Fewest points of a table over a turn, and of another: fewer say nothing.
FEWEST: Final = 4
FEWEST_OPEN: Final = 2
_LARGEST: Final = 32_000  # bytes of a table, so that a case file can hold its text


def read_table(written: str, source: str, key: str, folder: str) -> Table:
    """The table at a key of a case file.

    Args:
        written: path of a CSV file; or the text of the table, which has several lines.
        source: name of the case file, for messages.
        key: dotted key, one of `COLUMNS`.
        folder: where a relative path begins.

    Raises:
        CaseError: the file cannot be read, or is no such table.
    """
    if "\n" in written:
        return _table(written, f"{source}: {key}", key, "")
    path = os.path.join(folder, written)
    try:
        text = read_text(path, "a table", _LARGEST)
    except CaseError as unread:
        accepted = unread.accepted if unread.accepted.startswith("did you mean") else f"give a CSV file that begins with {_accepted(key)}"
        raise CaseError(source, key, as_written(written), unread.problem, accepted) from None
    return _table(text, f"{path_shown(path)} ({key})", key, os.path.basename(written))


def text_of_table(table: Table) -> str:
    """The text of a table as it was written, or with all digits in SI."""
    heading = ", ".join(f"{name} [{UNITS[name]}]" for name in table.names)
    return table.text or "\n".join([heading, *(", ".join(map(repr, row)) for row in table.rows)])


def _accepted(key: str) -> str:
    """Headings that a table may have, in words."""
    return " or ".join(f'"{", ".join(f"{name} [{_shown(name)}]" for name in names)}"' for names in COLUMNS[key])


def _shown(name: str) -> str:
    return _SHOWN.get(UNITS[name], UNITS[name])


def _table(text: str, source: str, key: str, file: str) -> Table:
    accepted = _accepted(key)
    written = table_text(source, text, advice=f"begin with {accepted}; write decimals with a point, and thousands without a sign")
    if written.headings is None:
        raise CaseError(source, written.place, None, "has numbers where a heading is due", f"begin with the headings {accepted}")
    given, factors = _columns(source, written.place, written.headings, key)
    names = next(each for each in COLUMNS[key] if {*each} == {*given})
    found = written.numbers(given, range(len(given)), names[0])
    if found.lacking:
        raise CaseError(source, None, None, f"lacks a number in {found.lacking} of its rows", "give one number for each column")
    if found.begin is not None:
        raise CaseError(source, None, None, "has dates in place of a time", "write the time from the start of the run")
    values = found.values * np.array(factors)
    points, *columns = (values[:, given.index(name)] for name in names)
    both = np.column_stack(columns)
    if names[0] == "crank_angle":
        points, both = _of_a_turn(source, found.lines, names[1:], points, both)
    if len(points) < (fewest := FEWEST if names[0] == "crank_angle" else FEWEST_OPEN):
        raise CaseError(source, None, None, f"has {len(points)} points", f"at least {fewest} are needed")
    if key == "crank.speed_table":
        for row in np.flatnonzero(both[:, 0] * both[0, 0] <= 0.0)[:1].tolist():
            place, value = f"line {found.lines[row]}, {names[1]}", f"{both[row, 0]:.9g} rad/s"
            raise CaseError(source, place, value, "lets the crank stand still or turn back", "give speeds of one sign, without zero")
    kept = [", ".join(written.headings), *(", ".join(map(repr, row)) for row in found.values.tolist())]
    return Table(names, tuple(points.tolist()), tuple(tuple(each.tolist()) for each in both.T), file, "\n".join(kept))


def _columns(source: str, place: str, headings: Sequence[str], key: str) -> tuple[list[str], list[float]]:
    """Names of the columns in their order, and the SI values of their units."""
    names, factors, known = list[str](), list[float](), {name for each in COLUMNS[key] for name in each}
    for heading in headings:
        name, unit = name_and_unit(heading)
        if name not in known:
            raise CaseError(source, place, as_written(heading), "is no column of this table", f"write {_accepted(key)}")
        if name in names:
            raise CaseError(source, place, as_written(heading), f"gives {name} a second time", "keep one of the two columns")
        if not unit:
            raise CaseError(source, place, as_written(heading), "has no unit", f'write it in brackets, such as "{name} [{_shown(name)}]"')
        names.append(name)
        factors.append(unit_factor(source, f"{place}, {name}", UNITS[name], unit))
    if {*names} not in map(set, COLUMNS[key]):
        raise CaseError(source, place, as_written(", ".join(headings)), "has not the columns of this table", f"write {_accepted(key)}")
    return names, factors


def _of_a_turn(source: str, numbers: Sequence[int], names: Sequence[str], angles: Array, values: Array) -> tuple[Array, Array]:
    """The rows without the last one if that is the first one again, a turn later; `numbers`: of their lines, `names`: of the values."""
    beyond = angles - angles[0] - 2.0 * math.pi
    for row in np.flatnonzero(beyond > ROUNDING)[:1].tolist():
        place = f"line {numbers[row]}, crank_angle"
        value, turned = f"{math.degrees(angles[row]):.9g} deg", math.degrees(beyond[row])
        raise CaseError(source, place, value, f"lies {turned:.6g} deg beyond a turn from the first row", "give one turn of the crank")
    if beyond[-1] >= -ROUNDING:
        for column in np.flatnonzero(values[-1] != values[0])[:1].tolist():
            place, value = f"line {numbers[-1]}, {names[column]}", f"{values[-1, column]:.9g} {UNITS[names[column]]}"
            before = f"{values[0, column]:.9g} {UNITS[names[column]]} a turn before (line {numbers[0]})"
            problem = f"differs from {before}: the table does not close"
            raise CaseError(source, place, value, problem, "give both rows the same value, or leave out the last one")
        angles, values = angles[:-1], values[:-1]
    return angles, values
