"""Display of objects in several rows: as text in a terminal and as HTML in a notebook, from the same rows."""

from abc import ABC, abstractmethod
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from html import escape
from typing import Union

#: A cell of a row: a text, or rows of its own.
Cell = Union[str, "Rows"]

_LEFT = ' style="text-align: left; vertical-align: top"'  # a notebook would align cells to the right


@dataclass(frozen=True)
class Rows:
    """Rows of texts."""

    rows: Sequence[Sequence[Cell]]  # all of the same length
    heads: Sequence[str] = ()  # of the columns; may be empty

    def text(self) -> str:
        """The rows as text, in left-aligned columns two blanks apart."""
        rows: list[Sequence[Cell]] = [self.heads, *self.rows] if self.heads else [*self.rows]
        blocks = [[cell.split("\n") if isinstance(cell, str) else cell.text().split("\n") for cell in row] for row in rows]
        widths = [max(len(line) for lines in column for line in lines) for column in zip(*blocks, strict=True)]
        return "\n".join(_aligned(block, widths) for block in blocks)

    def html(self) -> str:
        """The rows as an HTML table."""
        heads = "".join(f"<th{_LEFT}>{escape(head)}</th>" for head in self.heads)
        rows = "".join(f"<tr>{''.join(f'<td{_LEFT}>{_in_html(cell)}</td>' for cell in row)}</tr>" for row in self.rows)
        return f"<table>{f'<thead><tr>{heads}</tr></thead>' if heads else ''}<tbody>{rows}</tbody></table>"


class Printable(ABC):
    """Base class of objects that are displayed by their parts: lines of text, and rows."""

    @abstractmethod
    def _parts(self) -> Iterable[Cell]:
        """Lines of text and rows, from top to bottom."""

    def __repr__(self) -> str:
        return in_lines(self._parts())

    def _repr_html_(self) -> str:
        """The HTML that a notebook shows: well-formed, every text escaped, no script."""
        return f"<div>{''.join(_in_html(part) if isinstance(part, Rows) else _line(part) for part in self._parts())}</div>"


def in_lines(parts: Iterable[Cell]) -> str:
    """Lines of text and rows below each other, as a terminal shows them."""
    return "\n".join(part if isinstance(part, str) else part.text() for part in parts)


def _aligned(block: Sequence[Sequence[str]], widths: Sequence[int]) -> str:
    """One row, whose cells may have several lines."""
    height = max(map(len, block))
    lines = [[cell[number] if number < len(cell) else "" for cell in block] for number in range(height)]
    return "\n".join("  ".join(text.ljust(width) for text, width in zip(line, widths, strict=True)).rstrip() for line in lines)


def _line(text: str) -> str:
    return f'<p style="white-space: pre-wrap; margin: 0">{escape(text)}</p>'


def _in_html(cell: Cell) -> str:
    return escape(cell).replace("\n", "<br/>") if isinstance(cell, str) else cell.html()
