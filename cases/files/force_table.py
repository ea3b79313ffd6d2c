"""Reads the table of a tool's force: a CSV file that a case file names, or its text in the case file itself."""

import math
import os
from collections.abc import Sequence
from typing import Final

import numpy as np

from quickreturn.cases.files.errors import CaseError, as_written, path_shown
from quickreturn.cases.files.number_rows import name_and_unit, table_text, unit_factor
from quickreturn.cases.files.text_file import read_text
from quickreturn.reference_model.arrays import Array
from quickreturn.reference_model.tip import ROUNDING, ForceTable

ANGLE: Final = "crank_angle"
#: Columns of a force in the fixed frame, and of one that turns with the follower's end.
FIXED: Final = ("force_n1", "force_n2")
FOLLOWING: Final = ("force_along", "force_normal")
FEWEST: Final = 4  # points; fewer say nothing about a turn
_LARGEST: Final = 32_000  # bytes of a table, so that a case file can hold its text
_ACCEPTED: Final = '"crank_angle [deg], force_n1 [N], force_n2 [N]", or force_along and force_normal in place of the last two'


def read_force_table(written: str, source: str, key: str, folder: str) -> ForceTable:
    """The table at a key of a case file.

    Args:
        written: path of a CSV file; or the text of the table, which has several lines.
        source: name of the case file, for messages.
        key: dotted key, for messages.
        folder: where a relative path begins.

    Raises:
        CaseError: the file cannot be read, or is no table of a force.
    """
    if "\n" in written:
        return _table(written, f"{source}: {key}", "")
    path = os.path.join(folder, written)
    try:
        text = read_text(path, "a table of forces", _LARGEST)
    except CaseError as unread:
        accepted = unread.accepted if unread.accepted.startswith("did you mean") else f"give a CSV file that begins with {_ACCEPTED}"
        raise CaseError(source, key, as_written(written), unread.problem, accepted) from None
    return _table(text, f"{path_shown(path)} ({key})", os.path.basename(written))


def text_of_table(table: ForceTable) -> str:
    """The text of a table as it was written, or with all digits in SI."""
    rows = zip(table.angles, table.first, table.second, strict=True)
    heading = ", ".join((f"{ANGLE} [rad]", *(f"{name} [N]" for name in (FOLLOWING if table.follows else FIXED))))
    return table.text or "\n".join([heading, *(", ".join(map(repr, row)) for row in rows)])


def _table(text: str, source: str, file: str) -> ForceTable:
    written = table_text(source, text, advice=f"begin with {_ACCEPTED}; write decimals with a point, and thousands without a sign")
    if written.headings is None:
        raise CaseError(source, written.place, None, "has numbers where a heading is due", f"begin with the headings {_ACCEPTED}")
    names, factors = _columns(source, written.place, written.headings)
    found = written.numbers(names, range(len(names)), ANGLE)
    if found.lacking:
        raise CaseError(source, None, None, f"lacks a number in {found.lacking} of its rows", "give one number for each column")
    values = found.values * np.array(factors)
    forces = FOLLOWING if FOLLOWING[0] in names else FIXED
    angles, *components = (values[:, names.index(name)] for name in (ANGLE, *forces))
    angles, both = _of_a_turn(source, found.lines, forces, angles, np.column_stack(components))
    kept = [", ".join(written.headings), *(", ".join(map(repr, row)) for row in found.values.tolist())]
    first, second = (tuple(each.tolist()) for each in both.T)
    return ForceTable(tuple(angles.tolist()), first, second, forces == FOLLOWING, file, "\n".join(kept))


def _columns(source: str, place: str, headings: Sequence[str]) -> tuple[list[str], list[float]]:
    """Names of the three columns in their order, and the SI values of their units."""
    names, factors = list[str](), list[float]()
    for heading in headings:
        name, unit = name_and_unit(heading)
        if name not in (ANGLE, *FIXED, *FOLLOWING):
            raise CaseError(source, place, as_written(heading), "is no column of a table of forces", f"write {_ACCEPTED}")
        if name in names:
            raise CaseError(source, place, as_written(heading), f"gives {name} a second time", "keep one of the two columns")
        if not unit:
            accepted = f'write it in brackets, such as "{name} [{"deg" if name == ANGLE else "N"}]"'
            raise CaseError(source, place, as_written(heading), "has no unit", accepted)
        names.append(name)
        factors.append(unit_factor(source, f"{place}, {name}", "rad" if name == ANGLE else "N", unit))
    if set(names) not in ({ANGLE, *FIXED}, {ANGLE, *FOLLOWING}):
        told = "has not the three columns of a table of forces"
        raise CaseError(source, place, as_written(", ".join(headings)), told, f"write {_ACCEPTED}")
    return names, factors


def _of_a_turn(source: str, numbers: Sequence[int], names: Sequence[str], angles: Array, forces: Array) -> tuple[Array, Array]:
    """The rows without the last one if that is the first one again, a turn later; `numbers`: of their lines, `names`: of the forces."""
    beyond = angles - angles[0] - 2.0 * math.pi
    for row in np.flatnonzero(beyond > ROUNDING)[:1].tolist():
        place = f"line {numbers[row]}, {ANGLE}"
        value, turned = f"{math.degrees(angles[row]):.9g} deg", math.degrees(beyond[row])
        raise CaseError(source, place, value, f"lies {turned:.6g} deg beyond a turn from the first row", "give one turn of the crank")
    if beyond[-1] >= -ROUNDING:
        for column in np.flatnonzero(forces[-1] != forces[0])[:1].tolist():
            place, value = f"line {numbers[-1]}, {names[column]}", f"{forces[-1, column]:.9g} N"
            problem = f"differs from {forces[0, column]:.9g} N a turn before (line {numbers[0]}): the table does not close"
            raise CaseError(source, place, value, problem, "give both rows the same force, or leave out the last one")
        angles, forces = angles[:-1], forces[:-1]
    if len(angles) < FEWEST:
        raise CaseError(
            source, None, None, f"has {len(angles)} points", f"at least {FEWEST} are needed, and a row every few degrees is good"
        )
    return angles, forces
