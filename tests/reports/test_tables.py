"""A table's page and CSV form, from the same cells."""

import csv
import io
import math

from quickreturn.reports.tables import Cell, Column, Table
from quickreturn.reports.words import cost, counted, listed, number, percent, settings_words, size


def made(**cells: object) -> Table:
    """A table with one row."""
    columns = (
        "run",
        Column("frequency", "f", "Hz", ".2f", uncertainty="width"),
        Column("width", "±", "Hz", in_page=False),
        Column("strain", unit="10⁻⁶", form=".1f"),
        Column("cycles", form="d"),
    )
    table = Table("made_up", "A caption.", columns)
    table.add(run="a", **cells)  # type: ignore[arg-type]
    return table


def shown(table: Table) -> list[str]:
    return [table.page_text(table.rows[0], column) for column in table.shown]


def test_a_csv_file_has_every_column_in_full_precision_with_units() -> None:
    table = made(frequency=1.0 / 3.0, width=0.1, strain=1.23456789e-4, cycles=7)
    rows = list(csv.DictReader(io.StringIO(table.csv())))
    assert list(rows[0]) == ["run", "frequency [Hz]", "width [Hz]", "strain [1]", "cycles"]
    assert float(rows[0]["frequency [Hz]"]) == 1.0 / 3.0  # to the last bit
    assert rows[0]["cycles"] == "7"


def test_the_page_shows_units_of_its_own_uncertainties_and_whole_counts() -> None:
    assert shown(made(frequency=16.6667, width=0.1234, strain=1.2346e-4, cycles=7)) == ["a", "16.67 ± 0.12", "123.5", "7"]


def test_what_is_missing_is_a_dash_in_the_page_and_empty_in_the_file() -> None:
    table = made(frequency=Cell(None, "n. r.", "too, faint", "open"), strain=math.nan)
    assert shown(table) == ["a", "n. r.", "–", "–"]
    (row,) = csv.DictReader(io.StringIO(table.csv()))
    assert (row["frequency [Hz]"], row["frequency remark"], row["strain [1]"]) == ("", "too, faint", "")


def test_a_mark_does_not_rest_on_colour_alone() -> None:
    assert shown(made(frequency=Cell(1.0, mark="missed")))[1].startswith("✗ ")


def test_a_table_is_a_frame_with_units() -> None:
    frame = made(frequency=Cell(16.0, note="told")).frame
    assert frame.attrs["units"] == {"run": "", "frequency [Hz]": "Hz", "width [Hz]": "Hz", "strain [1]": "1", "cycles": ""}
    assert frame["frequency [Hz]"][0] == 16.0
    assert frame["frequency remark"][0] == "told"


def test_numbers_are_written_as_people_write_them() -> None:
    assert [cost(seconds) for seconds in (0.00123, 0.0478, 1.234, 1234.5)] == ["0.0012", "0.048", "1.23", "1234.50"]
    assert number(-1.5, ".1f") == "−1.5"
    assert number(-0.001, ".2f") == "0.00"  # no negative zero
    assert number(math.inf, ".1f") == "∞"
    assert [number(value, ".2g") for value in (123.4, 99.7, -1234.0, 1e6, 0.00123)] == ["120", "100", "−1200", "1000000", "0.0012"]
    assert [number(value, ".2g") for value in (1.4e-5, 1e-7, -2.5e9)] == ["1.4·10⁻⁵", "10⁻⁷", "−2.5·10⁹"]
    assert number(1234.0, "+.2g") == "+1200"
    assert settings_words({"tolerance": 1e-7, "time_step": 2.5e-12, "modes": 3}) == "tolerance 1e-7, time step 2.5e-12, modes 3"
    assert percent(0.0123) == "1.23\N{NO-BREAK SPACE}%"
    assert [size(share) for share in (0.123, -0.0123, 0.00123)] == [f"{text}\N{NO-BREAK SPACE}%" for text in ("12", "1.2", "0.12")]
    assert listed(["a", "b", "c"]) == "a, b and c"
    assert counted(1, "run") == "1\N{NO-BREAK SPACE}run"
    assert counted(2, "half", "halves") == "2\N{NO-BREAK SPACE}halves"
