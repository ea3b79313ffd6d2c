"""The chapters of a report, in their order, and the last one, which lists all files. Templates are in `reports/chapters/`."""

from collections.abc import Iterator, Mapping, Sequence
from typing import Final

from quickreturn.reports.chapters.agreement import agreement
from quickreturn.reports.chapters.drive import drive
from quickreturn.reports.chapters.own import next_steps, strength, turn
from quickreturn.reports.chapters.provenance import provenance
from quickreturn.reports.chapters.recorded import recorded
from quickreturn.reports.chapters.runs import run_by_run, runs
from quickreturn.reports.page.chapter import Chapter, MakeChapter
from quickreturn.reports.page.content import Content
from quickreturn.reports.page.part import parts
from quickreturn.reports.tables.table import Column, Table
from quickreturn.reports.words import counted

#: Chapters of the core with their ranks, by which the page orders them, and those of plugins: first the user's own machine, and the next
#: steps; a chapter of a subject may have another rank there (`Content.ranks`).
CHAPTERS: Final[Mapping[MakeChapter, float]] = {
    strength: 10,
    turn: 11,
    drive: 12,
    run_by_run: 20,
    runs: 21,
    recorded: 22,
    next_steps: 30,
    agreement: 40,
    provenance: 90,
}


def chapters_of(content: Content) -> Iterator[Chapter]:
    """The chapters of a report, in their order; the last one lists all files."""
    ranked = {**CHAPTERS, **content.chapters}
    for part in parts():
        ranked |= part.chapters
    tables = list[Table]()
    for make in sorted(ranked, key=lambda make: content.ranks.get(make.__name__, ranked[make])):
        if chapter := make(content):
            tables += chapter.tables
            yield chapter
    yield files(content, tables)


def files(content: Content, tables: Sequence[Table]) -> Chapter:
    """The chapter on the tables of all other chapters."""
    about = {"date": content.facts.get("date", ""), "code": content.code}
    return Chapter("files", "Tables as files", files_finding(len(tables)), {"table": catalogue(tables, about)})


def files_finding(tables: int) -> str:
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
