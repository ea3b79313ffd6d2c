"""A chapter of the page: its heading with the finding, and the facts that its template lays out."""

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass
from typing import Any, TypeVar

from quickreturn.reports.tables import Table

T = TypeVar("T")


@dataclass(frozen=True)
class Series:
    """Points of one source.

    Attributes:
        name: name in the legend.
        of: engine, signal or other name whose look it has; an engine's checkbox shows and hides its series.
        x: values on the horizontal axis.
        y: values on the vertical axis, as many; None in both: a gap in the line.
        text: remark on each point, shown after the name when the point is touched; one per point, or nothing.
        hollow: whether its marks are hollow, as those of variants.
        line: whether the points are joined.
        broad: whether it is the broad band behind the others.
        marked: whether each point has a mark.
    """

    name: str
    of: str
    x: Sequence[float | str | None]
    y: Sequence[float | None]
    text: Sequence[str] = ()
    hollow: bool = False
    line: bool = True
    broad: bool = False
    marked: bool = True


@dataclass(frozen=True)
class Plot:
    """A plot."""

    file: str  # CSV file of the table with these numbers
    x: str  # label of the horizontal axis, with its unit
    y: str  # label of the vertical axis, with its unit
    series: Sequence[Series]  # what is drawn, later ones on top
    log: str = ""  # which axes are logarithmic: "", "x", "y" or "xy"
    below: float | None = None  # value on the vertical axis below which numbers mean nothing; that range is shaded
    categories: Sequence[str] = ()  # texts of an axis that has rows instead of numbers; `y` then belongs to the horizontal axis
    limit: tuple[float, str] | None = None  # a value that is marked by a line across the rows, and its meaning

    @property
    def document(self) -> dict[str, Any]:
        """The plot as data for the script."""
        return asdict(self)


def found_in(kind: type[T], values: Any) -> Iterator[T]:
    """Values of a type among others, also those in lists, tuples and dictionaries."""
    for value in values:
        if isinstance(value, kind):
            yield value
        elif isinstance(value, (list, tuple)):
            yield from found_in(kind, value)
        elif isinstance(value, Mapping):
            yield from found_in(kind, value.values())


@dataclass(frozen=True)
class Chapter:
    """A chapter."""

    id: str  # its anchor in the page, and the name of its template: `chapters/ID.html`, whose macro `body` takes the facts
    name: str  # name in the heading
    finding: str  # what the results say, in the heading: a sentence without its full stop
    facts: Mapping[str, Any]  # tables, plots, numbers and sentences by name. Each table is also written as a CSV file

    @property
    def tables(self) -> Iterator[Table]:
        """All tables with rows among the facts, in their order."""
        return (table for table in found_in(Table, self.facts.values()) if table.rows)

    @property
    def plots(self) -> Iterator[Plot]:
        """All plots among the facts."""
        return found_in(Plot, self.facts.values())


#: A function that makes a chapter of a page from its content; None where a report has no such chapter.
MakeChapter = Callable[[Any], Chapter | None]
