"""What a plugin adds to the page of a report."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cache

from quickreturn.cases.files.case import Case
from quickreturn.engines.plugins import found, places
from quickreturn.reports.page.chapter import MakeChapter
from quickreturn.reports.page.content import Content
from quickreturn.reports.page.first_screen import Figure, FirstScreen


@dataclass(frozen=True, kw_only=True)
class Part:
    """What a plugin adds. Each function but `content` gets the content of the page.

    Attributes:
        chapters: function that makes a chapter -> its rank; the page has its chapters by rank (`reports.page.chapters.CHAPTERS`).
        templates: packages with the chapters' templates.
        content: class of the content for some cases, if these are a subject of the plugin; otherwise None.
        figure: a number in large type for the first screen with its meaning, or None.
        machines: case -> what the first screen says of it, if these are the user's own machines; otherwise empty.
        of_engines: heading of a column in the table of engines -> for each engine a text.
    """

    chapters: Mapping[MakeChapter, float] = field(default_factory=dict)
    templates: Sequence[str] = ()
    content: Callable[[Sequence[Case]], type[Content] | None] | None = None
    figure: Callable[[Content], Figure | None] | None = None
    machines: Callable[[Content], Mapping[str, FirstScreen]] | None = None
    of_engines: Mapping[str, Callable[[Content], Mapping[str, str]]] = field(default_factory=dict)


@cache
def parts() -> tuple[Part, ...]:
    """The parts of the installed plugins."""
    return tuple(map(found, places("page")))
