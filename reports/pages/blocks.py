"""What a chapter is made of. The templates give each kind of block its looks."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from typing import ClassVar

from reports.plots.picture import Picture
from reports.tables.table import Table


@dataclass(frozen=True)
class Text:
    """A paragraph; `tone` is "", "note" or "warning"."""

    kind: ClassVar[str] = "text"
    text: str
    tone: str = ""


@dataclass(frozen=True)
class Points:
    """A list, numbered or not."""

    kind: ClassVar[str] = "points"
    items: Sequence[str]
    numbered: bool = False


@dataclass(frozen=True)
class Heading:
    """A heading within a chapter; `anchor` makes it a target of links, `short` is its name among the contents."""

    kind: ClassVar[str] = "heading"
    text: str
    anchor: str
    short: str = ""


@dataclass(frozen=True)
class Tabular:
    """A table with its CSV file, or a sentence that offers the file alone."""

    kind: ClassVar[str] = "table"
    table: Table


@dataclass(frozen=True)
class Figure:
    """A picture with its caption."""

    picture: Picture
    caption: str


@dataclass(frozen=True)
class Figures:
    """Pictures side by side where there is room."""

    kind: ClassVar[str] = "figures"
    figures: Sequence[Figure]


Block = Text | Points | Heading | Tabular | Figures


@dataclass
class Chapter:
    """A chapter; `short` is its name among the contents, `links` says whether its sections stand there, too."""

    anchor: str
    title: str
    short: str = ""
    links: bool = False
    blocks: list[Block] = field(default_factory=list)

    def text(self, text: str, tone: str = "") -> None:
        """Add a paragraph, unless it is empty."""
        if text:
            self.blocks.append(Text(text, tone))

    def points(self, items: Sequence[str], numbered: bool = False) -> None:
        """Add a list, unless it is empty."""
        if items:
            self.blocks.append(Points(items, numbered))

    def heading(self, text: str, anchor: str, short: str = "") -> None:
        """Begin a section."""
        self.blocks.append(Heading(text, anchor, short))

    def table(self, table: Table) -> None:
        """Add a table, unless it has no rows."""
        if table.rows:
            self.blocks.append(Tabular(table))

    def figures(self, *figures: tuple[Picture | None, str]) -> None:
        """Add pictures with their captions, as far as there are any."""
        shown = [Figure(picture, caption) for picture, caption in figures if picture is not None]
        if shown:
            self.blocks.append(Figures(shown))

    @property
    def tables(self) -> Iterator[Table]:
        """All tables of the chapter."""
        return (block.table for block in self.blocks if isinstance(block, Tabular))

    @property
    def headings(self) -> list[Heading]:
        """All headings of the chapter."""
        return [block for block in self.blocks if isinstance(block, Heading)]
