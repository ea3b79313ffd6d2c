"""A table of the report: one set of cells, in SI units, from which both the page and the CSV file are written.

Below it are the columns and cells that tables of several chapters share.
"""

import math
import re
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import groupby
from typing import TYPE_CHECKING, Any, Final, Literal

from quickreturn.cases.comparison.engines import CaseResult
from quickreturn.cases.comparison.pair import Difference
from quickreturn.cases.files.case import Case
from quickreturn.cases.files.shown import Unit, Units
from quickreturn.cases.motion.catalogue import IN_TABLES, MEASURES, numbers
from quickreturn.cases.motion.endings import Ending
from quickreturn.cases.motion.request import Run
from quickreturn.reports.engine_differences import outward
from quickreturn.reports.words import HALF, QUANTITY, case_label, channel_name, number, per_unit, quantity

if TYPE_CHECKING:
    import pandas as pd

Value = str | int | float | bool | None
Mark = Literal["", "good", "missed", "open", "failed", "model"]

#: Unit of the page -> unit of the CSV file, if it differs.
_SI: Final = {
    "%": "1", "% of range": "1", "10⁻⁶": "1", "mm": "m", "ms": "s", "µs": "s", "kN/m": "N/m", "MPa": "Pa", "°": "rad", "rpm": "rad/s",
}  # fmt: skip
#: Largest number of letters of a text that is kept on one line.
LONGEST_LINE: Final = 26


@dataclass(frozen=True)
class Cell:
    """A value with its remark and presentation."""

    value: Value  # in SI units, as in the CSV file; None if there is none
    text: str = ""  # what the page shows instead of the formatted value
    note: str = ""  # a remark: a click in the page shows it, the CSV file has it in a column of its own
    # "good"; "missed": beyond a tolerance; "failed"; "open": no answer, for a reason; "model": the error is that of the engine's model
    mark: Mark = ""
    run: str = ""  # case that a click opens on the first screen


Row = Mapping[str, Cell]


@dataclass(frozen=True)
class Column:
    """A column."""

    key: str  # heading in the CSV file, without the unit
    head: str = ""  # heading in the page; by default the key in words
    unit: str = ""  # in the page; "" for texts and counts, "1" is not shown, and a unit in brackets is shown in each cell
    form: str = ""  # format of numbers in the page, e.g. ".3f"; "" for texts, which are aligned left
    in_page: bool = True  # whether the page shows it; the CSV file always has it
    uncertainty: str = ""  # key of the column that is shown after this one's values, after ±
    group: str = ""  # heading above this and its neighbours of the same group
    meaning: str = ""  # shown above the table
    words: Callable[[Any], str] | None = None  # value -> the text that the page shows for it
    shown: Unit | None = None  # unit in which the page shows numbers whose `unit` is that of the CSV file, see `shown_in`

    def shown_in(self, units: Units) -> "Column":
        """The column, whose `unit` is SI as the page shows it in the units of a case."""
        return replace(self, unit=Unit(self.unit).sign, form=units.form(self.unit, self.form), shown=units.column(self.unit))

    @property
    def page_head(self) -> str:
        """Heading in the page."""
        return self.head or self.key.replace("_", " ")

    @property
    def page_unit(self) -> str:
        """Unit beside the heading in the page."""
        if self.shown is not None:
            return self.shown.sign
        return "" if self.unit == "1" or self.unit.startswith("[") else self.unit

    @property
    def csv_unit(self) -> str:
        """Unit in the CSV file."""
        return _SI.get(self.unit, self.unit.strip("[]"))

    @property
    def csv_head(self) -> str:
        """Heading in the CSV file."""
        return f"{self.key} [{self.csv_unit}]" if self.unit else self.key

    def text(self, cell: Cell) -> str:
        """A cell as the page shows it, without its sign and uncertainty."""
        value = cell.value
        if cell.text:
            return cell.text
        if self.words:
            return self.words(value)
        if value is None:
            return "–"
        if isinstance(value, bool):
            return "yes" if value else "no"
        return str(value) if isinstance(value, str) or not self.form else self.number(value)

    def number(self, value: float) -> str:
        """A number of the CSV file as the page shows it."""
        if self.shown is not None:
            return number(value / self.shown.size, self.form)
        return number(value * per_unit(self.unit.removesuffix(" of range")) if self.unit in _SI else value, self.form)  # counts stay whole


#: A column of a table; a text is the key of a column of texts.
ColumnList = Sequence[Column | str]


class Table:
    """A table of the report.

    Args:
        name: name of the CSV file without ".csv".
        caption: what the table shows, in the page and in the list of files; line breaks with the blanks about them are one blank.
        columns: at least one.
        in_page: False for a table that exists as a file only.
    """

    def __init__(self, name: str, caption: str, columns: ColumnList, in_page: bool = True) -> None:
        self.name = name
        self.caption = re.sub(r" *\n *", " ", caption.strip())
        self.columns = [Column(column) if isinstance(column, str) else column for column in columns]
        self.in_page = in_page
        self.rows: list[Row] = []

    def add(self, row: object = None, /, **values: Value | Cell) -> None:
        """Add a row; other columns take the attribute or item of `row` with their key, or nothing.

        Raises:
            KeyError: a name is not a column.
        """
        keys = [column.key for column in self.columns]
        if unknown := sorted(set(values) - set(keys)):
            raise KeyError(f"table {self.name} has no column {unknown[0]}")
        of_row = row if isinstance(row, Mapping) else {key: getattr(row, key, None) for key in keys}
        cells = {key: values[key] if key in values else of_row.get(key) for key in keys}
        self.rows.append({key: cell if isinstance(cell, Cell) else Cell(cell) for key, cell in cells.items()})

    @property
    def file(self) -> str:
        """Name of the CSV file."""
        return f"{self.name}.csv"

    @property
    def shown(self) -> list[Column]:
        """The columns that the page shows."""
        return [column for column in self.columns if column.in_page]

    @property
    def meanings(self) -> dict[str, str]:
        """Headings of the shown columns that need an explanation -> the explanation."""
        return {column.page_head: column.meaning for column in self.shown if column.meaning}

    @property
    def heads(self) -> list[tuple[str, int]]:
        """Groups of the shown columns with their widths, in order; empty if no column has a group."""
        groups = groupby(self.shown, lambda column: (column.group, "" if column.group else column.key))
        spans = [(group, len(list(columns))) for (group, _), columns in groups]
        return spans if any(group for group, _ in spans) else []

    def looks(self, column: Column) -> str:
        """Style of a column: "" for numbers, "words" for texts on one line, "words prose" for texts on several lines."""
        if column.form:
            return ""
        longest = max((len(line) for row in self.rows for line in column.text(row[column.key]).splitlines()), default=0)
        return "words prose" if longest > LONGEST_LINE else "words"

    def page_text(self, row: Row, column: Column) -> str:
        """A cell as the page shows it, with a sign, so that no mark depends on colour alone."""
        cell = row[column.key]
        text = ("✗ " if cell.mark in ("missed", "failed") else "") + column.text(cell)
        if column.uncertainty and cell.value is not None and not cell.text:
            half_width = row[column.uncertainty].value
            if isinstance(half_width, (int, float)):
                text += f" ± {column.number(half_width)}"
        return text

    @property
    def frame(self) -> "pd.DataFrame":
        """Every column in SI units under its heading with the unit, and a column of remarks beside each column that has some."""
        import pandas as pd

        columns: dict[str, list[Value]] = {}
        for column in self.columns:
            cells = [row[column.key] for row in self.rows]
            columns[column.csv_head] = [cell.value for cell in cells]
            if any(cell.note for cell in cells):
                columns[f"{column.key} remark"] = [cell.note for cell in cells]
        frame = pd.DataFrame(columns, dtype=object)
        frame.attrs |= {"caption": self.caption, "units": {column.csv_head: column.csv_unit for column in self.columns}}
        return frame

    def csv(self) -> str:
        """The CSV file: numbers in full precision."""
        return self.frame.map(csv_text).to_csv(index=False, lineterminator="\n")


def csv_text(value: Value) -> str:
    """A value as text for the CSV file: numbers read back as the same number."""
    if value is None or (isinstance(value, float) and math.isnan(value)):
        return ""
    return repr(float(value)) if isinstance(value, float) else str(value)


CASE: Final = Column("case", "run", words=case_label)
QUANTITY_COLUMN: Final = Column("quantity", words=QUANTITY.__getitem__)
HALF_COLUMN: Final = Column("half", words=HALF.__getitem__)
CHANNEL: Final = Column("channel", words=channel_name)
#: Columns of a comparison of two numbers.
COMPARISON: Final = (
    CASE,
    Column("engine"),
    Column("other", "against"),
    QUANTITY_COLUMN,
    HALF_COLUMN,
    CHANNEL,
    Column("value", unit="[SI]", form=".4g"),
    Column("other_value", unit="[SI]", form=".4g"),
    Column("difference", unit="%", form="+.2f"),
    Column("tolerance", unit="%", form=".2f"),
)
#: The text of a number that cannot be measured.
UNRESOLVABLE: Final = "n. r."


def measure_column(name: str, units: Units) -> Column:
    """The column of a measure that the tables of a run show."""
    shown = IN_TABLES[name]
    column = Column(shown.key or name.replace(".", "_"), shown.head, shown.unit or MEASURES[name].unit, shown.form, group=shown.group)
    return column if shown.unit else column.shown_in(units)


def measure_cells(case: Case, run: Run) -> dict[str, Cell]:
    """The cells of all these measures; empty of a run without a usable cycle."""
    cells = {}
    for name, found in numbers(case.mechanism, run, IN_TABLES).items():
        why = "no channel resolves the first mode" if MEASURES[name].vibration else "it cannot be measured"
        cells[measure_column(name, case.units).key] = (
            Cell(None, UNRESOLVABLE, why, "open") if math.isnan(found.value) else Cell(found.value)
        )
    return cells


def compared(result: CaseResult, check: Difference) -> dict[str, Any]:
    """The cells of `COMPARISON` that are not fields of the comparison itself."""
    unit = result.case.units.column(check.unit)
    return {
        "case": result.case.name,
        "value": Cell(check.number.value, quantity(check.number.value, unit)),
        "other_value": Cell(check.other_number.value, quantity(check.other_number.value, unit)),
        "difference": outward(check.quantity, check.difference) / check.scale,
        "tolerance": check.tolerance / check.scale,
    }


def status_cell(run: Run) -> Cell:
    """How a run ended, with the engine's remark."""
    return Cell(run.status, note=run.remark, mark="open" if run.status == Ending.INACCURATE else "" if run.usable else "failed")
