"""The columns of a trajectory that a file of another program gives, by its headings and a mapping."""

import re
from collections.abc import Iterable, Sequence
from dataclasses import replace
from typing import Final

from quickreturn.cases.errors import CaseError, as_written, path_shown, similar_name
from quickreturn.cases.text.column_mapping import IGNORED, ColumnMapping, Target, mapping_file, near_column, unit_in
from quickreturn.cases.text.dialect import Dialect
from quickreturn.cases.text.number_rows import name_and_unit, unit_factor
from quickreturn.reference_model.columns import COLUMNS

_COUNTERS: Final = ("sample", "samples", "index", "row", "n", "no", "no.", "nr", "nr.", "#", "scan", "point")  # headings of row numbers

_NUMBER: Final = re.compile(r"\d+$")


def own_name(shown: str, place: str, heading: str, headings: Sequence[str]) -> Target | None:
    """The column that a heading names, however it writes capitals and blanks; None: none of a trajectory."""
    name, unit = name_and_unit(shown, place, heading, "time [s]")
    column = _as_column(name)
    if counts_from_zero(column, headings):
        column = _NUMBER.sub(lambda number: f"{int(number[0]) + 1:0{len(number[0])}d}", column)
    return Target(column, unit) if column in COLUMNS else None


def counts_from_zero(column: str, headings: Sequence[str]) -> bool:
    """Whether headings count the columns of a kind, such as strain_1 to strain_3, from 0."""
    first = _NUMBER.sub(lambda number: "0" * len(number[0]), column)
    return bool(_NUMBER.search(column)) and first in {_as_column(re.split(r"[\[(]", each)[0]) for each in headings}


def _as_column(name: str) -> str:
    return re.sub(r"[\s_-]+", "_", name.strip().lower())


def columns_used(shown: str, written: Dialect, mapping: ColumnMapping) -> tuple[list[tuple[Target, float | None]], list[str], list[int]]:
    """Columns that the table gives, with the SI value of their units (None: none is given), headings ignored, and places of the columns.

    CaseError: names all headings that are not understood, each with the nearest column.
    """
    headings = written.headings
    targets = dict(mapping.targets)
    if headings is None and not targets:
        write = "".join(f' --column "{number + 1} = {name}"' for number, name in enumerate(["time [s]", "crank_angle [deg]"]))
        accepted = f"name the columns by position:{write}, or write them into {path_shown(mapping_file(shown))} (--write-mapping)"
        raise CaseError(shown, written.place, None, "has numbers where a heading is due", accepted)
    used, ignored, unknown, places = list[tuple[Target, float | None]](), list[str](), list[str](), list[int]()
    for number in range(written.width):
        heading = str(number + 1) if headings is None else headings[number]
        name, unit = name_and_unit(shown, written.place, heading, "time [s]") if headings is not None else (heading, None)
        given = [targets.pop(each) for each in [*targets] if each in (heading, name, str(number + 1))]  # an option after the file
        target = given[-1] if given else own_name(shown, written.place, heading, headings) if headings is not None else None
        if target is None or target.column == IGNORED:
            (ignored if target is not None or headings is None or not _is_misspelt(name, heading, unit) else unknown).append(
                heading or f"column {number + 1}"
            )
            continue
        if any(target.column == other.column for other, _ in used):
            raise CaseError(
                shown, written.place, as_written(heading), f"gives {target.column} a second time", "keep one of the two columns"
            )
        unit = unit if target.unit is None else target.unit
        si_unit = COLUMNS[target.column].unit.replace(" ", "*")
        factor = None if unit is None else unit_factor(shown, f"{written.place}, {target.column}", si_unit, unit)
        used.append((replace(target, unit=unit), factor))
        places.append(number)
    if targets:
        heads = ", ".join(headings or [f"1 to {written.width}"])
        raise CaseError(shown, None, as_written(next(iter(targets))), "is no heading of this table", f"it has {heads}")
    names = [target.column for target, _ in used]
    if unknown or "time" not in names or len(names) < 2:
        _refuse(shown, written.place, names, unknown, ignored)
    return used, ignored, places


def _refuse(shown: str, place: str, names: Sequence[str], unknown: Sequence[str], ignored: Sequence[str]) -> None:
    """Raise the CaseError of a table that lacks time or all other columns, or has headings near to a column; it answers them all."""
    told = {each: near_column(each) for each in (*unknown, *(() if "time" in names and len(names) > 1 else ignored))}
    near = [as_written(each) + (f" (nearest: {_with_unit(each, column)})" if column else "") for each, column in told.items()]
    accepted = (
        'name them by --column "HEADING = column [unit]" or --write-mapping; `quickreturn show CASE --for-other-tools` lists all columns'
    )
    if "time" not in names and (counter := next((each for each in ignored if each.lower() in _COUNTERS), "")):
        accepted = f'if it counts rows, 1000 a second say, add --column "{counter} = 1000 * time [s]"; {accepted}'
    if near:
        lacks = "" if "time" in names and len(names) > 1 else ", and no column time" if "time" not in names else ", and time alone is left"
        verb = "is no column of a trajectory" if len(near) == 1 else "are no columns of a trajectory"
        raise CaseError(shown, place, None, f"{', '.join(near)} {verb}{lacks}", accepted)
    check_complete(shown, place, names)


def _with_unit(heading: str, column: str) -> str:
    """A column with the unit that a heading names, if it names one."""
    return f"{column} [{unit}]" if (unit := unit_in(heading, column)) else column


def _is_misspelt(name: str, heading: str, unit: str | None) -> bool:
    """Whether a heading is nearly the name of a column, in a unit of that column if it has one."""
    column = similar_name(name, tuple(COLUMNS))
    return bool(column) and (unit is None or bool(unit_in(heading, column)))


def check_complete(source: str, place: str, names: Iterable[str]) -> None:
    """Raise the CaseError of a table without time, or with time alone."""
    if "time" not in (given := list(names)) or len(given) < 2:
        lacks = "has no column time" if "time" not in given else "holds time alone"
        raise CaseError(source, place, None, lacks, "give time and what was recorded, e.g. crank_angle and tip_deflection")
