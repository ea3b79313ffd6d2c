"""The chapters of a report, in their order. Each is a module and a template in `reports/chapters/`."""

from collections.abc import Iterator
from typing import Final

from quickreturn.reports.chapters.accuracy import accuracy
from quickreturn.reports.chapters.agreement import agreement
from quickreturn.reports.chapters.as_built import as_built
from quickreturn.reports.chapters.classes import classes
from quickreturn.reports.chapters.drive import drive
from quickreturn.reports.chapters.each import run_by_run
from quickreturn.reports.chapters.files import files
from quickreturn.reports.chapters.hard import hard_scenes
from quickreturn.reports.chapters.methods import methods
from quickreturn.reports.chapters.next import next_steps
from quickreturn.reports.chapters.provenance import provenance
from quickreturn.reports.chapters.recorded import recorded
from quickreturn.reports.chapters.resonance import resonance
from quickreturn.reports.chapters.runs import runs
from quickreturn.reports.chapters.strength import strength
from quickreturn.reports.chapters.turn import turn
from quickreturn.reports.page.chapter import Chapter, MakeChapter
from quickreturn.reports.page.content import Content
from quickreturn.reports.tables.table import Table

#: All chapters but those of a subject (`Content.placed`): first the user's own machine, and the next steps.
CHAPTERS: Final[tuple[MakeChapter, ...]] = (
    strength,
    turn,
    drive,
    resonance,
    run_by_run,
    runs,
    recorded,
    next_steps,
    agreement,
    methods,
    classes,
    accuracy,
    hard_scenes,
    as_built,
    provenance,
)


def chapters_of(content: Content) -> Iterator[Chapter]:
    """The chapters of a report, in their order; the last one lists all files."""
    placed = {make for makes in content.placed.values() for make in makes}
    order = [*content.placed.get(None, ())]
    for make in CHAPTERS:
        order += [*([] if make in placed else [make]), *content.placed.get(make, ())]
    tables = list[Table]()
    for make in order:
        if chapter := make(content):
            tables += chapter.tables
            yield chapter
    yield files(content, tables)
