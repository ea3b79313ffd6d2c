"""Recorded tables of another tool, an earlier version or a test rig: CSV files with units in their headings.

The heading names columns of the trajectory, each with its unit in brackets: `time [ms], crank_angle [deg], tip_deflection [mm]`. A heading
without a unit means SI, so the project's own trajectory files are also recorded tables. Lines `# key = value` above the heading describe
the table. Only units are converted: no shift, no filter, no fit.
"""

import os
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Final

import numpy as np
from numpy.typing import ArrayLike, NDArray

from quickreturn.cases.errors import CaseError, as_written, nearest, nearest_or_all, path_shown, printable
from quickreturn.cases.text.number_rows import does_not_rise, headings_in, late_row, name_and_unit, numbers_in, unit_factor
from quickreturn.cases.text.text_file import read_text
from quickreturn.reference_model.columns import COLUMNS

Array = NDArray[np.float64]

MOST_ROWS: Final = 1_000_000
_MOST_BYTES: Final = 100_000_000

#: Declarations above the heading with their accepted values; without values any text.
DECLARATIONS: Final[Mapping[str, tuple[str, ...]]] = {
    "case": (),
    "version": (),
    "origin": ("simulated", "measured", "digitised", "synthetic"),
    "source": (),
}


@dataclass(frozen=True)
class RecordedTable:
    """A table as it was recorded, in SI units."""

    name: str  # name of the file, safe to print; the table's name among the engines
    path: str
    # names as in `reference_model.columns` -> values, each of shape (n,); "time" and at least one other
    columns: Mapping[str, Array] = field(repr=False)
    bare: frozenset[str] = frozenset()  # columns whose headings have no unit
    declared: Mapping[str, str] = field(default_factory=dict)  # declarations of the file: some of `DECLARATIONS`
    of_experiment: bool = False  # whether it lies in the folder of the experiment's recordings

    @property
    def shown(self) -> str:
        """The path, safe to print."""
        return path_shown(self.path)


def is_table(name: str) -> bool:
    """Whether the name given for an engine is the path of a recorded table."""
    return name.lower().endswith(".csv")


def read_table(path: str) -> RecordedTable:
    """A recorded table from a file. CaseError: the file cannot be read, or is not such a table."""
    shown, text = path_shown(path), read_text(path, "a recorded table", _MOST_BYTES)
    lines = text.splitlines()
    declared, at = _declarations(shown, lines)
    if at == len(lines):
        what = "has no heading" if text.strip() else "is empty"
        raise CaseError(shown, None, None, what, 'write one such as "time [s],crank_angle [deg]"')
    headings = headings_in(shown, f"line {at + 1}", lines[at])
    factors = _unit_factors(shown, f"line {at + 1}", headings)
    if (rows := len(lines) - at - 1) > MOST_ROWS:
        raise CaseError(shown, None, None, f"has {rows} rows", f"at most {MOST_ROWS} are accepted")
    values = dict(zip(factors, numbers_in(shown, list(factors), lines, at + 1, "time").T, strict=True))
    return _table(printable(os.path.basename(path)), path, factors, values, declared)


def table_of(columns: Mapping[str, ArrayLike], name: str = "table", case: str | None = None) -> RecordedTable:
    """A table of columns that are in memory, headed as in a file: `"tip_deflection [mm]"`, or without a unit for SI.

    Args:
        columns: heading -> numbers, shape (n,); a pandas DataFrame, or a dictionary of arrays.
        name: the table's name among engines.
        case: its case; None: not declared.

    Raises:
        CaseError: a heading or a column that a file must not have either; of several rows with a mistake the first is named.
    """
    factors = _unit_factors(name, "heading", [str(heading) for heading in columns])
    values, wrong = dict[str, Array](), list[tuple[int, CaseError]]()
    cells = {column: np.asarray(columns[heading], dtype=object) for column, heading in zip(factors, columns, strict=True)}
    for column, given in cells.items():
        if given.ndim != 1 or given.shape != next(iter(cells.values())).shape:
            raise CaseError(name, column, None, f"has the shape {given.shape}", "give one number for each row, as in the other columns")
        values[column], first = _numbers(given)
        if first is not None:
            cell, accepted = as_written(given[first]), "give one plain number for each row"
            wrong.append((first, CaseError(name, f"row {first}, {column}", cell, "is no number", accepted)))
        for row in np.flatnonzero(~np.isfinite(values[column]))[:1].tolist():
            value, accepted = str(values[column][row]), "leave out rows that lack a number"
            wrong.append((row, CaseError(name, f"row {row}, {column}", value, "is not finite", accepted)))
        if column == "time" and (late := late_row(values[column])) is not None:
            wrong.append((late, does_not_rise(name, f"row {late}, time", values[column][late])))
    if wrong:
        raise min(wrong, key=lambda mistake: mistake[0])[1]
    return _table(name, name, factors, values, {} if case is None else {"case": case})


def _numbers(cells: NDArray[np.object_]) -> tuple[Array, int | None]:
    """The numbers of a column, shape (n,), down to its first cell that is none, and the row of that cell; None where all are numbers."""
    try:
        return np.asarray(cells, dtype=np.float64), None
    except (TypeError, ValueError):
        numbers = list[float]()
        for cell in cells:
            try:
                numbers.append(float(cell))
            except (TypeError, ValueError):
                break
        return np.array(numbers), len(numbers)


def _table(
    name: str, path: str, factors: Mapping[str, float | None], values: Mapping[str, Array], declared: Mapping[str, str]
) -> RecordedTable:
    """A table from values in the units of their headings; `factors` are those of `_unit_factors`."""
    columns = {name: values[name] if factor is None else factor * values[name] for name, factor in factors.items()}
    bare = frozenset(name for name, factor in factors.items() if factor is None)
    return RecordedTable(name, path, columns, bare, declared)


def tables_of(paths: Iterable[str], cases: Sequence[str]) -> dict[str, list[RecordedTable]]:
    """Recorded tables by the name of the case that each declares; with a single case the declaration is optional.

    Raises:
        CaseError: a table cannot be read, or is of none of the cases; or two have the same name.
    """
    tables: dict[str, list[RecordedTable]] = {}
    for path in paths:
        table = read_table(path)
        if "case" not in table.declared and len(cases) > 1:
            accepted = f'write "# case = ..." above its heading, with one of {", ".join(cases)}'
            raise CaseError(table.shown, "case", None, "is not declared, and there are several cases", accepted)
        case = table.declared.get("case", cases[0])
        if case not in cases:
            raise CaseError(table.shown, "case", as_written(case), "is not among the cases", f"these are {', '.join(cases)}")
        if any(table.name == other.name for other in tables.get(case, ())):
            raise CaseError(table.shown, None, None, f"is the second table called {table.name}", "give each file a name of its own")
        tables.setdefault(case, []).append(table)
    return tables


def _declarations(source: str, lines: Sequence[str]) -> tuple[dict[str, str], int]:
    """The declarations, and the index of the heading among the lines; the number of lines if there is none."""
    declared: dict[str, str] = {}
    for at, line in enumerate(lines):
        if not line.strip():
            continue
        if not line.startswith("#"):
            return declared, at
        key, _, value = (part.strip() for part in line.lstrip("#").partition("="))
        values = DECLARATIONS.get(key)
        if not value:
            told = line, "declares nothing", 'write "# key = value"'
        elif values is None:
            told = key, "is no known key", nearest_or_all(key, tuple(DECLARATIONS))
        elif key in declared:
            told = key, "is declared twice", "declare each key once"
        elif values and value not in values:
            told = value, "is not accepted", f"give {' or '.join(values)}"
        else:
            declared[key] = value
            continue
        place = f"line {at + 1}" if values is None else f"line {at + 1}, {key}"
        raise CaseError(source, place, as_written(told[0]), *told[1:])
    return declared, len(lines)


def _unit_factors(source: str, place: str, headings: Sequence[str]) -> dict[str, float | None]:
    """The names of the columns with the SI values of their units, None where a heading has none."""
    factors: dict[str, float | None] = {}
    for heading in headings:
        name, unit = name_and_unit(source, place, heading, "time [s]")
        if name not in COLUMNS:
            near = f"the nearest one is {nearest(name, COLUMNS)}, and `quickreturn show CASE --for-other-tools` lists all; leave others out"
            raise CaseError(source, place, as_written(heading), "is no column of a trajectory", near)
        if name in factors:
            raise CaseError(source, place, as_written(heading), f"gives {name} a second time", "keep one of the two columns")
        si_unit = COLUMNS[name].unit.replace(" ", "*") if unit is not None else ""
        factors[name] = None if unit is None else unit_factor(source, f"{place}, {name}", si_unit, unit)
    if "time" not in factors or len(factors) < 2:
        lacks = "has no column time" if "time" not in factors else "holds time alone"
        raise CaseError(source, place, None, lacks, "give time and what was recorded, e.g. crank_angle and tip_deflection")
    return factors
