"""What a table is: a data frame in SI units, and how its columns and cells are shown. Page and CSV file are made from the same cells."""

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, Final, Literal

import pandas as pd

from reports.words import HALF, QUANTITY, case_label, channel_name, number

Value = str | int | float | bool | None
Mark = Literal["", "good", "missed", "open", "failed"]

#: A sign before a marked value, so that no mark rests on colour alone.
SIGNS: Final = {"": "", "good": "", "missed": "✗ ", "open": "", "failed": "✗ "}

#: Letters of a text that is kept on one line.
LONGEST_LINE: Final = 26

_NOTE: Final = " remark"


@dataclass(frozen=True)
class Cell:
    """A value with what a reader should know about it.

    Attributes:
        value: in SI units, as it goes into the CSV file; None where there is none.
        text: what the page shows instead of the formatted value.
        note: a remark: in the page where the pointer rests, in the CSV file in a column of its own.
        mark: "missed" a tolerance, "failed", "open" (no answer, for a reason), "good".
        run: case that it opens on the first screen.
    """

    value: Value
    text: str = ""
    note: str = ""
    mark: Mark = ""
    run: str = ""


@dataclass(frozen=True)
class Column:
    """A column.

    Attributes:
        key: heading in the CSV file, without the unit.
        head: heading in the page.
        unit: of the values in the CSV file; "" for texts and counts.
        form: format of numbers in the page, e.g. ".3f".
        shown_unit: unit in the page, if another one.
        factor: value in the page / value in the CSV file.
        in_page: whether the page shows it; the CSV file has it anyway.
        uncertainty: key of the column that is shown behind this one's values, after ±.
        group: heading above this and its neighbours of the same group.
        meaning: shown where the pointer rests on the heading.
        words: value -> what the page shows in its place.
    """

    key: str
    head: str
    unit: str = ""
    form: str = ""
    shown_unit: str | None = None
    factor: float = 1.0
    in_page: bool = True
    uncertainty: str = ""
    group: str = ""
    meaning: str = ""
    words: Callable[[Any], str] | None = None

    @property
    def page_unit(self) -> str:
        """Unit in the page."""
        unit = self.unit if self.shown_unit is None else self.shown_unit
        return "" if unit == "1" else unit

    @property
    def csv_head(self) -> str:
        """Heading in the CSV file."""
        return f"{self.key} [{self.unit}]" if self.unit else self.key

    def text(self, cell: Cell) -> str:
        """A cell as the page shows it, without its sign and uncertainty."""
        if cell.text:
            return cell.text
        value = cell.value
        if self.words:
            return self.words(value)
        if value is None:
            return "–"
        if isinstance(value, bool):
            return "yes" if value else "no"
        if isinstance(value, str) or not self.form:
            return str(value)
        return number(value if self.factor == 1.0 else value * self.factor, self.form)  # counts stay whole

    @property
    def is_text(self) -> bool:
        """Whether the column holds words: they are aligned left."""
        return not self.form


#: Columns that many tables have.
CASE: Final = Column("case", "run", words=case_label)
QUANTITY_COLUMN: Final = Column("quantity", "quantity", words=QUANTITY.__getitem__)
HALF_COLUMN: Final = Column("half", "half", words=HALF.__getitem__)
CHANNEL: Final = Column("channel", "channel", words=channel_name)


@dataclass(frozen=True)
class Table:
    """A table of the report.

    Attributes:
        name: of the CSV file, without ".csv".
        caption: one or two sentences, with what the numbers are relative to.
        columns: at least one.
        rows: each with one cell per column; plain values are taken as cells.
        in_page: False for a table that is offered as a file only.
    """

    name: str
    caption: str
    columns: tuple[Column, ...]
    rows: tuple[tuple[Cell, ...], ...]
    in_page: bool = True

    @property
    def file(self) -> str:
        """Name of the CSV file."""
        return f"{self.name}.csv"

    @property
    def shown(self) -> tuple[int, ...]:
        """Indices of the columns that the page shows."""
        return tuple(index for index, column in enumerate(self.columns) if column.in_page)

    @property
    def heads(self) -> list[tuple[str, int]]:
        """Groups of the shown columns with their widths, in order; empty if no column has a group."""
        spans: list[tuple[str, int]] = []
        for index in self.shown:
            group = self.columns[index].group
            if spans and group and spans[-1][0] == group:
                spans[-1] = (group, spans[-1][1] + 1)
            else:
                spans.append((group, 1))
        return spans if any(group for group, _ in spans) else []

    def looks(self, index: int) -> str:
        """How a column is set: "" numbers, "words" texts that stay on a line, "words prose" texts that need several."""
        if not self.columns[index].is_text:
            return ""
        longest = max((len(self.columns[index].text(row[index])) for row in self.rows), default=0)
        return "words prose" if longest > LONGEST_LINE else "words"

    def page_text(self, row: Sequence[Cell], index: int) -> str:
        """A cell as the page shows it."""
        column, cell = self.columns[index], row[index]
        text = SIGNS[cell.mark] + column.text(cell)
        if column.uncertainty and cell.value is not None and not cell.text:
            position = [other.key for other in self.columns].index(column.uncertainty)
            half_width = row[position].value
            if isinstance(half_width, (int, float)):
                text += f" ± {number(half_width * column.factor, column.form)}"
        return text

    @property
    def frame(self) -> pd.DataFrame:
        """Every column in SI units under its heading with the unit, and a column of remarks beside each that has any."""
        columns: dict[str, list[Value]] = {}
        for index, column in enumerate(self.columns):
            columns[column.csv_head] = [row[index].value for row in self.rows]
            if any(row[index].note for row in self.rows):
                columns[column.key + _NOTE] = [row[index].note for row in self.rows]
        found = pd.DataFrame(columns, dtype=object)
        found.attrs |= {"caption": self.caption, "units": {column.csv_head: column.unit for column in self.columns}}
        return found

    def csv(self) -> str:
        """The CSV file: numbers in full precision."""
        return self.frame.map(csv_text).to_csv(index=False, lineterminator="\n")


def csv_text(value: Value) -> str:
    """A value as the CSV file has it: numbers so that they read back as the same number."""
    if value is None or (isinstance(value, float) and math.isnan(value)):
        return ""
    return repr(float(value)) if isinstance(value, float) else str(value)


@dataclass
class TableBuilder:
    """Collects rows given as plain values or cells."""

    name: str
    caption: str
    columns: Sequence[Column]
    in_page: bool = True
    rows: list[tuple[Cell, ...]] = field(default_factory=list)

    def add(self, row: object = None, /, **values: Value | Cell) -> None:
        """Add a row; columns that are not named hold what `row` has under their key, an attribute or an item, or nothing.

        Raises:
            KeyError: a name that is no column.
        """
        known = [column.key for column in self.columns]
        unknown = set(values) - set(known)
        if unknown:
            raise KeyError(f"table {self.name} has no column {sorted(unknown)[0]}")
        of_row = row if isinstance(row, Mapping) else {key: getattr(row, key, None) for key in known}
        cells = [values[key] if key in values else of_row.get(key) for key in known]
        self.rows.append(tuple(cell if isinstance(cell, Cell) else Cell(cell) for cell in cells))

    def table(self) -> Table:
        """The finished table."""
        return Table(self.name, self.caption, tuple(self.columns), tuple(self.rows), self.in_page)
