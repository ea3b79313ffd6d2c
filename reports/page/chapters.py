"""The chapters of a report and the facts behind them. Their texts are in `templates/chapters/`.

A chapter is a template with two macros, `finding` for its heading and `body`, which both take the chapter's facts. Tables and plots are
among the facts; each table is also written as a CSV file beside the page.
"""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Any, Final

from quickreturn.reports.page.content import Chapters, Content
from quickreturn.reports.page.facts import agreement, classes, methods, own, resonance, runs, strength, studies
from quickreturn.reports.page.plot import Plot, plots_in
from quickreturn.reports.tables.table import Table

Facts = Mapping[str, Any]


@dataclass(frozen=True)
class Chapter:
    """A chapter with its facts; the template is named by its `id`."""

    id: str
    name: str
    facts: Facts

    @property
    def tables(self) -> Iterator[Table]:
        """All tables among the facts, in their order."""
        return tables_in(self.facts.values())

    @property
    def plots(self) -> Iterator[Plot]:
        """All plots among the facts."""
        return plots_in(self.facts.values())


def tables_in(values: Any) -> Iterator[Table]:
    """Tables that have rows, among values and in lists of values."""
    for value in values:
        if isinstance(value, Table):
            yield from [value] if value.rows else []
        elif isinstance(value, (list, tuple)):
            yield from tables_in(value)


#: The chapters of a report on the user's own machine, in their order: first the machine itself, and the next steps.
CHAPTERS: Final[Chapters] = {
    "strength": ("Will it hold?", strength.strength),
    "resonance": ("How near is a resonance?", resonance.resonance),
    "each": ("Run by run", runs.run_by_run),
    "runs": ("Every run on every engine", runs.runs),
    "recorded": ("Recorded tables", runs.recorded),
    "next": ("What to do next", own.next_steps),
    "agreement": ("Who agrees with whom", agreement.agreement),
    "methods": ("Which method excels", methods.methods),
    "classes": ("Which method, where", classes.classes),
    "accuracy": ("Accuracy and cost", studies.accuracy),
    "hard": ("Hard scenes", methods.hard_scenes),
    "provenance": ("Provenance", own.provenance),
}


def chapters_of(content: Content) -> list[Chapter]:
    """The chapters with facts, in their order; the last one lists all files."""
    all_facts = ((name, title, make(content)) for name, (title, make) in (content.chapters or CHAPTERS).items())
    chapters = [Chapter(name, title, facts) for name, title, facts in all_facts if facts is not None]
    file_facts = own.files(content, [table for chapter in chapters for table in chapter.tables])
    return [*chapters, Chapter("files", "Tables as files", file_facts)]
