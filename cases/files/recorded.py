"""Recorded tables of another tool, an earlier version or a test rig: text files with units in their headings.

The heading names columns of the trajectory, each with its unit in brackets: `time [ms], crank_angle [deg], tip_deflection [mm]`. A heading
without a unit means SI, so the project's own trajectory files are also recorded tables. Lines `# key = value` above the heading describe
the table. `cases/files/number_rows.py` recognises how it is written, and a mapping names the columns of other programs. Only units are
converted, and angles that wrap are made continuous: no filter, no fit.
"""

import math
import os
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from datetime import datetime
from typing import Any, Final

import numpy as np
from numpy.typing import ArrayLike

from quickreturn.cases.files.column_mapping import IGNORED, ColumnMapping, Target, UsedColumn, columns_used, mapping_of, own_name, suggested
from quickreturn.cases.files.errors import CaseError, as_written, known_column, path_shown, printable
from quickreturn.cases.files.instants import gaps, single_instants
from quickreturn.cases.files.number_rows import Form, TableText, does_not_rise, table_text
from quickreturn.cases.files.text_file import OF_COLUMNS, read_table_text
from quickreturn.reference_model.arrays import Array
from quickreturn.reference_model.columns import COLUMNS

MOST_ROWS: Final = 1_000_000
_MOST_BYTES: Final = 100_000_000
_MOST_NAMED: Final = 6  # ignored headings in a message
_WRAPPING: Final = ("crank_angle", "follower_angle")  # angles that other programs wrap

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
    declared: Mapping[str, str] = field(default_factory=dict)  # declarations of the file: some of `DECLARATIONS`
    of_experiment: bool = False  # whether it lies in the folder of the experiment's recordings
    told: str = ""  # how the file was read, if it is not commas, decimal points and plain names
    unwrapped: frozenset[str] = frozenset()  # angles that wrapped, and were made continuous
    noted: tuple[str, ...] = ()  # clauses on its instants: doubled rows left out, and gaps
    # column -> its text of `--column` without an offset, such as "phi = crank_angle [deg]", and the SI value of a 1 in the file; none for a
    # table in memory
    written: Mapping[str, tuple[str, float]] = field(default_factory=dict, repr=False)
    begin: datetime | None = None  # date or time of day from which the time counts; None: the time was given as numbers

    def __getitem__(self, column: str) -> Array:
        """A column. UnknownColumn: there is none of this name."""
        return self.columns[known_column(column, self.columns)]

    @property
    def shown(self) -> str:
        """The path, safe to print."""
        return path_shown(self.path)

    def without(self, column: str, amount: float, of: str = "") -> str:
        """How to take an amount, in SI, off a column: for each second if `of` is "time"."""
        text, size = self.written.get(column, ("", 1.0))
        product = f" * {of}" if of else ""
        if not text:
            return f"subtract {amount:.12g}{product} from {column}"
        return f'add --column "{text} {"-" if amount < 0.0 else "+"} {abs(amount / size):.6g}{product}"'


def is_table(name: str) -> bool:
    """Whether the name given for an engine is the path of a recorded table."""
    return name.lower().endswith((".csv", *OF_COLUMNS))


def read_table(
    path: str | os.PathLike[str],
    columns: Sequence[str] | Mapping[str, str] = (),
    decimal: str | None = None,
    separator: str | None = None,
    skip: int = 0,
) -> RecordedTable:
    """A recorded table from a file of any program. Its attribute `told` says how the file was read, `columns` has the numbers in SI.

    Args:
        path: of the file. A mapping beside it, with the same name and the ending .toml, is used.
        columns: which heading is which column: "crank.phi = crank_angle [deg]", or a dictionary of such pairs; a number in
            place of a heading counts columns from 1.
        decimal: the decimal sign, "." or ","; None: it is recognised.
        separator: the sign between columns: ",", ";", "tab" or "blank"; None: it is recognised.
        skip: number of lines above the headings to leave out.

    Raises:
        CaseError: the file cannot be read, or is not such a table, or can be read in two ways.
    """
    if not isinstance(path, (str, os.PathLike)):
        accepted = "give the path of a file; `qr.compare` and `qr.difference` take a DataFrame or a dictionary of arrays as it is"
        raise CaseError("table", None, None, f"{type(path).__name__} is no path", accepted)
    path = os.fspath(path)
    shown, text = path_shown(path), read_table_text(path, "a recorded table", _MOST_BYTES)
    mapping = mapping_of(path, columns, Form(separator, decimal, skip))
    written = table_text(shown, text, mapping.form)
    declared = _declarations(shown, written.comments)
    if (rows := len(written.rows)) > MOST_ROWS:
        raise CaseError(shown, None, None, f"has {rows} rows", f"at most {MOST_ROWS} are accepted")
    used, ignored = columns_used(written, mapping)
    by_name = {each.target.column: each for each in used}
    found = written.numbers([*by_name], [each.place for each in used], "time", doubled=True)
    numbers = dict(zip(by_name, found.values.T, strict=True))
    sizes = {name: each.factor / each.target.factor for name, each in by_name.items()}
    sizes["time"] = sizes["time"] if found.begin is None else 1.0
    seconds = sizes["time"] * (numbers["time"] - by_name["time"].target.offset)
    values = {name: sizes[name] * (numbers[name] - target.offset - target.drift * seconds) for name, (_, target, _) in by_name.items()}

    def refusal(row: int, accepted: str) -> CaseError:
        return does_not_rise(shown, f"line {found.lines[row]}, time", float(numbers["time"][row]), accepted)

    table = _table(printable(os.path.basename(path)), path, values, declared, refusal)
    told = [*written.told, *["decimal comma"] * (found.decimal == ","), *([f"columns by {mapping.file}"] if mapping.file else [])]
    told += ["dates counted from the first row"] * (found.begin is not None)
    if found.lacking:
        told.append(f"{found.lacking:,} row{'s' * (found.lacking > 1)} with an empty cell left out, most for {found.emptiest}")
    told += [f"{name} made continuous" for name in sorted(table.unwrapped)]
    told += table.noted
    texts = {name: (_text(written, each), sizes[name]) for name, each in by_name.items()}
    return replace(table, told=_told(told, ignored, len(table.columns["time"])), written=texts, begin=found.begin)


def _told(clauses: Sequence[str], ignored: Sequence[str], rows: int) -> str:
    """How a table was read; `ignored`: its headings that are not used."""
    named = f"ignored: {', '.join(ignored[:_MOST_NAMED])}{' and others' * (len(ignored) > _MOST_NAMED)}"
    told = [*clauses, *[named] * bool(ignored)]
    return f"read as: {', '.join(told)}, {rows:,} rows" if told else ""


def _text(written: TableText, used: UsedColumn) -> str:
    """The text of `--column` for a column, without an offset."""
    heading = str(used.place + 1) if written.headings is None else written.headings[used.place].partition("[")[0].strip()
    unit = used.target.unit or COLUMNS[used.target.column].unit.replace(" ", "*")
    return f"{heading} = {_times(used.target)}{used.target.column} [{unit}]"


def _times(target: Target) -> str:
    return "" if target.factor == 1.0 else f"{target.factor!r} * "


def suggested_mapping(
    path: str, columns: Sequence[str] = (), decimal: str | None = None, separator: str | None = None, skip: int = 0
) -> str:
    """The text of a mapping file for a table: what is known of its headings, and the nearest columns of the others; see `read_table`."""
    mapping = mapping_of(path, columns, Form(separator, decimal, skip))
    written = table_text(path_shown(path), read_table_text(path, "a recorded table", _MOST_BYTES), mapping.form)
    headings = written.headings or [str(number + 1) for number in range(written.width)]
    known = dict[str, str]()
    for number, heading in enumerate(headings):
        target = mapping.targets.get(heading) or mapping.targets.get(str(number + 1)) if heading else None
        if target is None and written.headings is not None:
            target = own_name(heading)
        if target is not None and target.column != IGNORED:
            offset = f" {'-' if target.offset < 0 else '+'} {abs(target.offset)!r}" if target.offset else ""
            unit = f" [{target.unit}]" if target.unit is not None else ""
            known[heading] = f"{_times(target)}{target.column}{unit}{offset}"
    return suggested(headings, known, mapping.form)


def table_of(columns: Mapping[str, ArrayLike], name: str = "table", case: str | None = None) -> RecordedTable:
    """A table of columns that are in memory, headed as in a file: `"tip_deflection [mm]"`, or without a unit for SI.

    Args:
        columns: heading -> numbers, shape (n,); a pandas DataFrame, or a dictionary of arrays.
        name: the table's name among engines.
        case: its case; None: not declared.

    Raises:
        CaseError: a heading or a column that a file must not have either.
    """
    headings = [*columns]
    used, ignored = columns_used(TableText(name, tuple(map(str, headings)), "heading"), ColumnMapping())
    values = {each.target.column: _numbers(name, each.target.column, columns[headings[each.place]]) for each in used}
    for column, given in values.items():
        if given.ndim != 1 or given.shape != values["time"].shape:
            raise CaseError(name, column, None, f"has the shape {given.shape}", "give one number for each row, as in the other columns")

    def refusal(row: int, accepted: str) -> CaseError:
        return does_not_rise(name, f"row {row}, time", float(values["time"][row]), accepted)

    falls = np.flatnonzero(np.diff(values["time"]) < 0.0)
    if falls.size:
        raise refusal(int(falls[0]) + 1, "sort the rows and drop doubles")
    columns_in_si = {each.target.column: each.factor * values[each.target.column] for each in used}
    table = _table(name, name, columns_in_si, {} if case is None else {"case": case}, refusal)
    return replace(table, told=_told([], ignored, len(table.columns["time"])))


def _numbers(name: str, column: str, given: ArrayLike) -> Array:
    """A column as numbers. CaseError: a cell holds none."""
    cells = np.asarray(given)
    if cells.dtype.kind in "mM":  # durations and dates, which numpy would turn into nanoseconds
        origin = cells[:1] if cells.dtype.kind == "M" else np.timedelta64(0)
        cells = (cells - origin) / np.timedelta64(1, "s") if column == "time" else cells.astype(str)
    try:
        numbers = np.asarray(cells, dtype=np.float64)
    except (TypeError, ValueError):
        numbers = np.array([_number(cell) for cell in cells.ravel()])
    for row in np.flatnonzero(~np.isfinite(numbers))[:1].tolist():
        accepted = "give one plain number for each row, and leave out rows that lack one"
        raise CaseError(name, f"row {row}, {column}", as_written(cells.ravel()[row]), "is no plain number", accepted)
    return numbers


def _number(cell: Any) -> float:
    try:
        return float(cell)
    except (TypeError, ValueError):
        return math.nan


def _table(
    name: str, path: str, values: Mapping[str, Array], declared: Mapping[str, str], refusal: Callable[[int, str], CaseError]
) -> RecordedTable:
    """A table from values in SI; `refusal` as of `single_instants`."""
    columns = dict(values)
    unwrapped = frozenset(each for each in _WRAPPING if each in columns and _wraps(columns[each]))
    for each in unwrapped:
        columns[each] = np.unwrap(columns[each])
    if "follower_angle" in unwrapped:  # within a quarter of a turn of half a turn, as every engine has it
        columns["follower_angle"] -= 2.0 * math.pi * math.floor(float(np.mean(columns["follower_angle"])) / (2.0 * math.pi))
    columns, noted = single_instants(columns, refusal)
    if gap := gaps(columns["time"]):
        noted = (*noted, gap)
    return RecordedTable(name, path, columns, declared, unwrapped=unwrapped, noted=noted)


def _wraps(angle: Array) -> bool:
    """Whether an angle, rad, jumps by a whole turn wherever it jumps by more than half of one."""
    steps = np.abs(np.diff(angle))
    jumps = steps[steps > math.pi]
    return bool(jumps.size and jumps.size < 0.1 * steps.size and np.all(np.abs(jumps - 2.0 * math.pi) < 0.5 * math.pi))


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


def _declarations(source: str, comments: Iterable[tuple[int, str]]) -> dict[str, str]:
    """The declarations among comments above the heading. CaseError: one is wrong. Other comments are not ours."""
    declared: dict[str, str] = {}
    for number, line in comments:
        key, _, value = (part.strip() for part in line.lstrip("#").partition("="))
        values = DECLARATIONS.get(key)
        if values is None:
            continue
        if not value:
            told = line, "declares nothing", 'write "# key = value"'
        elif key in declared:
            told = key, "is declared twice", "declare each key once"
        elif values and value not in values:
            told = value, "is not accepted", f"give {' or '.join(values)}"
        else:
            declared[key] = value
            continue
        raise CaseError(source, f"line {number}, {key}", as_written(told[0]), *told[1:])
    return declared
