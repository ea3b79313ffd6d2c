"""The list of all CSV files."""

from quickreturn.reports.chapters.files import catalogue, finding

from quickreturn.reports.page.chapters import chapters_of
from quickreturn.reports.tables.table import Table
from tests.reports.pages import finding_of, one_run, plain


def test_the_heading_counts_the_files() -> None:
    assert plain(finding(1)) == "1 table as CSV beside this page, full precision, SI units"
    assert plain(finding(12)) == "12 tables as CSV beside this page, full precision, SI units"
    others = [table for chapter in list(chapters_of(one_run()))[:-1] for table in chapter.tables]
    assert finding_of(one_run(), "files").startswith(f"{len(others)} tables as CSV")


def test_each_file_is_listed_with_its_rows_and_caption() -> None:
    table = Table("made_up", "A caption.", ("a",))
    table.add(a="x")
    (row,) = catalogue([table], {"date": "today"}).rows
    assert {key: cell.value for key, cell in row.items()} == {"file": "made_up.csv", "rows": 1, "what": "A caption.", "date": "today"}
