"""A chapter of the page: its heading with the finding, and the facts that its template lays out."""

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from typing import Any

from quickreturn.reports.page.plot import Plot, plots_in
from quickreturn.reports.tables.table import Table


@dataclass(frozen=True)
class Chapter:
    """A chapter."""

    id: str  # its anchor in the page, and the name of its template: `chapters/ID.html`, whose macro `body` takes the facts
    name: str  # name in the heading
    finding: str  # what the results say, in the heading: a sentence without its full stop
    facts: Mapping[str, Any]  # tables, plots, numbers and sentences by name. Each table is also written as a CSV file

    @property
    def tables(self) -> Iterator[Table]:
        """All tables among the facts, in their order."""
        return tables_in(self.facts.values())

    @property
    def plots(self) -> Iterator[Plot]:
        """All plots among the facts."""
        return plots_in(self.facts.values())


#: A function that makes a chapter of a page from its content; None where a report has no such chapter.
MakeChapter = Callable[[Any], Chapter | None]


def tables_in(values: Any) -> Iterator[Table]:
    """Tables that have rows, among values and in lists of values."""
    for value in values:
        if isinstance(value, Table):
            yield from [value] if value.rows else []
        elif isinstance(value, (list, tuple)):
            yield from tables_in(value)
