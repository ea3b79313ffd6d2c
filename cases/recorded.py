"""Recorded tables of another tool, an earlier version or a test rig: CSV files with units in their headings.

The heading names columns of the trajectory, each with its unit in brackets: `time [ms], crank_angle [deg], tip_deflection [mm]`. A heading
without a unit means SI, so the project's own trajectory files are also recorded tables. Lines `# key = value` above the heading describe
the table. Only units are converted: no shift, no filter, no fit.
"""

import csv
import io
import math
import os
import re
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Final

import numpy as np
from numpy.typing import ArrayLike, NDArray

from quickreturn.cases.errors import CaseError, as_written, nearest, nearest_or_all, path_shown, printable, shortened
from quickreturn.cases.text.text_file import read_text
from quickreturn.cases.units import DIMENSIONS, PURE_UNITS, QuantityError, in_si, plain_number, unit_size
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
#: SI unit -> units that pint does not know, or knows as something else -> the same as `in_si` reads it.
_OTHER_UNITS: Final[Mapping[str, Mapping[str, str]]] = {
    "1": {"-": "1", "": "1", "%": "percent", "µε": "microstrain", "με": "microstrain"} | {unit: unit for unit in PURE_UNITS},
    "m/s^2": {"g": "g0"},
}
#: Characters in a text that is not a number -> advice.
_HINTS: Final = {
    ";": "semicolons separate it: use commas, and decimal points",
    ",": "the decimal sign is a point",
    "D": "write e for D",
}
_HEADING: Final = re.compile(r"\s*([^\[\]()]*?)\s*(?:[\[(]([^\[\]()]*)[\])]\s*)?")


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
    headings = _headings(shown, f"line {at + 1}", lines[at])
    factors = _unit_factors(shown, f"line {at + 1}", headings)
    values = dict(zip(factors, _values(shown, list(factors), lines, at + 1).T, strict=True))
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
        if column == "time" and (late := _late_row(values[column])) is not None:
            wrong.append((late, _does_not_rise(name, f"row {late}, time", values[column][late])))
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


def _late_row(time: Array) -> int | None:
    """Index of the first row whose time is not later than that of the row before; None if there is none."""
    late = np.flatnonzero(np.diff(time) <= 0.0)
    return int(late[0]) + 1 if late.size else None


def _does_not_rise(source: str, place: str, value: float) -> CaseError:
    return CaseError(source, place, f"{value:.12g}", "does not rise", "sort the rows and drop doubles")


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


def _headings(source: str, place: str, line: str) -> list[str]:
    """The headings that a line holds."""
    for sign, word in ((";", "semicolons"), ("\t", "tabulators")):
        if sign in line:
            accepted = "separate columns by commas, decimals by points"
            raise CaseError(source, place, as_written(line), f"has {word} between its columns", accepted)
    return next(csv.reader([line], skipinitialspace=True))


def _unit_factors(source: str, place: str, headings: Sequence[str]) -> dict[str, float | None]:
    """The names of the columns with the SI values of their units, None where a heading has none."""
    factors: dict[str, float | None] = {}
    for heading in headings:
        match = _HEADING.fullmatch(heading)
        name, unit = (match[1], match[2]) if match else (heading, None)
        if plain_number(name.strip()) is not None:
            raise CaseError(source, place, as_written(heading), "is a number where a heading is due", 'begin with one such as "time [s]"')
        if name not in COLUMNS:
            near = f"the nearest one is {nearest(name, COLUMNS)}, and `quickreturn show CASE --for-other-tools` lists all; leave others out"
            raise CaseError(source, place, as_written(heading), "is no column of a trajectory", near)
        if name in factors:
            raise CaseError(source, place, as_written(heading), f"gives {name} a second time", "keep one of the two columns")
        factors[name] = None if unit is None else _unit_factor(source, place, name, unit.strip())
    if "time" not in factors or len(factors) < 2:
        lacks = "has no column time" if "time" not in factors else "holds time alone"
        raise CaseError(source, place, None, lacks, "give time and what was recorded, e.g. crank_angle and tip_deflection")
    return factors


def _unit_factor(source: str, place: str, column: str, unit: str) -> float:
    si_unit = COLUMNS[column].unit.replace(" ", "*")
    others = _OTHER_UNITS.get(si_unit, {})
    if unit in others:
        return in_si(others[unit])
    try:
        return unit_size(unit, DIMENSIONS[si_unit])
    except QuantityError as wrong:
        raise CaseError(source, f"{place}, {column}", as_written(unit), wrong.problem, wrong.accepted) from None


def _values(source: str, names: Sequence[str], lines: Sequence[str], first: int) -> Array:
    """The numbers below the heading, shape (rows, columns)."""
    if len(lines) - first > MOST_ROWS:
        raise CaseError(source, None, None, f"has {len(lines) - first} rows", f"at most {MOST_ROWS} are accepted")
    if not any(line.strip() for line in lines[first:]):
        raise CaseError(source, None, None, "has no rows below its heading", "a whole turn of the crank is needed")
    try:
        values = np.loadtxt(io.StringIO("\n".join(lines[first:])), delimiter=",", ndmin=2, comments=None, quotechar='"')
    except ValueError:
        values = None
    if (
        values is None
        or values.shape[1] != len(names)
        or not np.all(np.isfinite(values))
        or _late_row(values[:, names.index("time")]) is not None
    ):
        raise _bad_row(source, names, lines, first)
    return values


def _bad_row(source: str, names: Sequence[str], lines: Sequence[str], first: int) -> CaseError:
    """The mistake in the first row that is not one finite number for each column, or is not later than the row before."""
    before = -math.inf
    for number, line in enumerate(lines[first:], first + 1):
        if not line.strip():
            continue
        place, row = f"line {number}", f'"{shortened(line)}"'
        cells = next(csv.reader([line], skipinitialspace=True))
        if not any(re.match(r"\s*[+-]?\.?[0-9]", cell) for cell in cells):
            accepted = "after the one line of headings, with units in their brackets, come rows of numbers alone"
            return CaseError(source, place, row, "is no row of numbers", accepted)
        for name, cell in zip(names, cells, strict=False):
            value = plain_number(cell.strip())
            if value is None or not np.isfinite(value):
                hint = next((f" ({told})" for sign, told in _HINTS.items() if sign in cell.upper() and any(map(str.isdigit, cell))), "")
                problem = f"is no plain number{hint}" if cell.strip() else "is empty"
                accepted = "leave out rows that lack a number, or columns that were not recorded"
                return CaseError(source, f"{place}, {name}", as_written(cell), problem, accepted)
            if name == "time":
                if not value > before:
                    return _does_not_rise(source, f"{place}, time", value)
                before = value
        if len(cells) != len(names):
            problem = f"has {len(cells)} numbers, the heading {len(names)} columns"
            accepted = f"give one number for each column{'; decimals need a point, not a comma' if len(cells) > len(names) else ''}"
            return CaseError(source, place, row, problem, accepted)
    return CaseError(source, None, None, "cannot be read as rows of numbers", "give one plain number for each column")
