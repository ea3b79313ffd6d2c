"""The chapters of a report and the facts behind them. Their texts are in `templates/chapters/`.

A chapter is a template with two macros, `finding` for its heading and `body`, both made from the chapter's facts. Tables and plots are
among the facts; each table is also written as a CSV file beside the page.
"""

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from typing import Any, Final

from quickreturn.reports.page.content import Content
from quickreturn.reports.page.facts import agreement, classes, methods, own, resonance, runs, strength, studies, thesis
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
    """Tables that have rows, also those in lists."""
    for value in values:
        if isinstance(value, Table):
            yield from [value] if value.rows else []
        elif isinstance(value, (list, tuple)):
            yield from tables_in(value)


#: Chapter, its name, and the function that returns its facts, None if a report has none.
_CHAPTERS: tuple[tuple[str, str, Callable[[Content], Facts | None]], ...] = (
    ("strength", "Will it hold?", strength.strength),
    ("resonance", "How near is a resonance?", resonance.resonance),
    ("agreement", "Who agrees with whom", agreement.agreement),
    ("runs", "Every run on every engine", runs.runs),
    ("recorded", "Recorded tables", runs.recorded),
    ("methods", "Which method excels", methods.methods),
    ("classes", "Which method, where", classes.classes),
    ("thesis", "What the thesis saw", thesis.thesis),
    ("accuracy", "Accuracy and cost", studies.accuracy),
    ("hard", "Hard scenes", methods.hard_scenes),
    ("experiment", "The experiment", thesis.experiment),
    ("inconsistencies", "Published inconsistencies", thesis.inconsistencies_found),
    ("each", "Run by run", runs.run_by_run),
    ("next", "What to do next", own.next_steps),
    ("provenance", "Provenance", own.provenance),
)


#: First chapters of a report on the user's own machine: the machine itself, and the next steps. Agreement comes after them.
_OWN_FIRST: Final = ("strength", "resonance", "each", "runs", "recorded", "next")


def chapters_of(content: Content) -> list[Chapter]:
    """The chapters with facts, in their order; the last one lists all files."""
    order = sorted(_CHAPTERS, key=lambda chapter: _OWN_FIRST.index(chapter[0]) if chapter[0] in _OWN_FIRST else len(_OWN_FIRST))
    made = ((name, title, make(content)) for name, title, make in (order if content.is_own else _CHAPTERS))
    chapters = [Chapter(name, title, facts) for name, title, facts in made if facts is not None]
    listed = own.files(content, [table for chapter in chapters for table in chapter.tables])
    return [*chapters, Chapter("files", "Tables as files", listed)]
