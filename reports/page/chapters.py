"""The chapters of a report, in their order, and two of them: what to do next, and the files. Templates are in `reports/chapters/`."""

import shlex
from collections.abc import Iterator, Mapping, Sequence
from typing import Final

from quickreturn.reports.chapters.agreement import agreement
from quickreturn.reports.chapters.provenance import provenance
from quickreturn.reports.chapters.recorded import recorded
from quickreturn.reports.chapters.runs import run_by_run, runs
from quickreturn.reports.page.chapter import Chapter, MakeChapter
from quickreturn.reports.page.content import Content
from quickreturn.reports.page.part import parts
from quickreturn.reports.tables import Column, Table
from quickreturn.reports.words import counted, listed


def next_steps(content: Content) -> Chapter | None:
    """What to do next; None where the report is not about the user's own machines."""
    if not content.is_own:
        return None
    case = content.results[0].case
    failures = [f"{result.case.name}, {run.engine}: {run.remark or run.status}" for result in content.results for run in result.failures]
    departing = [result.case.name for result in content.results if result.missed]
    facts = {
        "file": shlex.quote(case.source if case.source not in ("", "library") else case.name),
        "shorter": case.units.of("m").text(0.9 * case.mechanism.crank.length),
        "failures": failures,
        "departing": departing,
    }
    return Chapter("next", "What to do next", next_finding(len(failures), departing), facts)


def next_finding(failures: int, departing: Sequence[str]) -> str:
    """The number of simulations that failed, or the cases in which engines disagree, or what can be done."""
    if failures:
        return f"{counted(failures, 'simulation')} did not deliver"
    return f"Engines disagree in {listed(departing)}" if departing else "Change a value, measure the cost, take the data"


#: Chapters of the core with their ranks, by which the page orders them, and those of plugins: first the user's own machine, and the next
#: steps; a chapter of a subject may have another rank there (`Content.ranks`).
CHAPTERS: Final[Mapping[MakeChapter, float]] = {run_by_run: 20, runs: 21, recorded: 22, next_steps: 30, agreement: 40, provenance: 90}


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
