"""Tables as files: the list of all CSV files beside the page."""

from collections.abc import Mapping, Sequence

from quickreturn.reports.page.chapter import Chapter
from quickreturn.reports.page.content import Content
from quickreturn.reports.tables.table import Column, Table
from quickreturn.reports.words import counted


def files(content: Content, tables: Sequence[Table]) -> Chapter:
    """The chapter on the tables of all other chapters."""
    about = {"date": content.facts.get("date", ""), "code": content.code}
    return Chapter("files", "Tables as files", finding(len(tables)), {"table": catalogue(tables, about)})


def finding(tables: int) -> str:
    """The number of files."""
    return f"{counted(tables, 'table')} as CSV beside this page, full precision, SI units"


def catalogue(tables: Sequence[Table], about: Mapping[str, str]) -> Table:
    """All CSV files beside the page; `about`: texts that each row of the file has, by heading."""
    table = Table(
        "tables",
        "Every table of this report as a CSV file beside this page, in full precision and SI units.",
        ("file", Column("rows", form="d"), "what", *(Column(key, in_page=False) for key in about)),
    )
    for each in tables:
        table.add(file=each.file, rows=len(each.rows), what=each.caption, **about)
    return table
