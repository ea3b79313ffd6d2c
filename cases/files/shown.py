"""The units in which people read the numbers of a case. Files, JSON documents and datasets are in SI.

The case's own file decides: for each dimension the unit that it uses most. A dimension that it does not name follows its unit of length:
lbf, psi and in/s^2 go with inches, N, MPa and m/s^2 with all others. A case of the library takes no more than the unit of its speeds from
its file: the thesis gives its runs in inches, but documents, records and figures on them are in mm and MPa.
"""

import math
from abc import ABC, abstractmethod
from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from html import escape
from types import MappingProxyType
from typing import Any, Final, Union

from quickreturn.cases.files.errors import Argument, CaseError, as_written
from quickreturn.cases.files.keys import PATHS, unit_in
from quickreturn.cases.files.units import in_si

#: Name of a set of units -> SI unit -> the unit in which the set shows numbers, if that is another.
SETS: Final[Mapping[str, Mapping[str, str]]] = MappingProxyType(
    {
        "si": {},
        "mm": {"m": "mm", "m^2": "mm^2", "m^4": "mm^4", "Pa": "MPa", "rad": "deg", "rad/s": "rpm"},
        "inch": {
            "m": "in", "m^2": "in^2", "m^4": "in^4", "m/s": "in/s", "m/s^2": "in/s^2", "rad": "deg", "rad/s": "rpm", "kg": "lb",
            "N": "lbf", "N*m": "lbf*in", "J": "lbf*in", "W": "hp", "Pa": "psi", "kg*m^2": "lbf*s^2*in", "N*m*s/rad": "lbf*in*s/rad",
            "kg/m": "lbf*s^2/in^2", "N*m^2": "lbf*in^2", "N*s/m^2": "lbf*s/in^2", "N/m": "lbf/in", "N*s/m": "lbf*s/in", "s/m": "s/in",
            "kg/m^3": "lbf*s^2/in^4",
        },
    }
)  # fmt: skip
#: Units of length whose files are answered in the set "inch".
_INCHES: Final = ("in", "inch", "inches", "ft", "foot", "feet", "mil", "thou", "yd")
#: Keys, and SI units, that do not decide: gravity and material are written as tables give them, and times are shown in s.
_UNDECIDING: Final = ("mechanism.gravity", "follower.elastic_modulus", "follower.density")
_ALWAYS_SI: Final = "s"
#: Units for which formats of numbers are chosen, where they are not SI.
_OF_FORMATS: Final[Mapping[str, str]] = MappingProxyType({"m": "mm", "Pa": "MPa"})
#: Exponents as pages and pictures write them.
_RAISED: Final = {"^2": "²", "^3": "³", "^4": "⁴", "*": " "}


@dataclass(frozen=True)
class Unit:
    """A unit in which numbers are shown."""

    name: str  # as a case file has it: "m/s^2"
    size: float = 1.0  # in SI

    @property
    def sign(self) -> str:
        """The unit as pages and pictures write it: "m/s²"."""
        sign = self.name
        for written, shown in _RAISED.items():
            sign = sign.replace(written, shown)
        return sign

    def text(self, value: float, form: str = ".4g") -> str:
        """A number in SI as text in this unit, as a terminal shows it: "4.5 in"."""
        return f"{value / self.size:{form}} {self.name}".removesuffix(" 1").rstrip()


#: Strains on pages and in pictures.
MICROSTRAIN: Final = Unit("10⁻⁶", in_si("microstrain"))


@dataclass(frozen=True)
class Units:
    """The units in which the numbers of a case are shown."""

    chosen: Mapping[str, str]  # SI unit -> unit, if it is another

    def of(self, si: str) -> Unit:
        """The unit for numbers of an SI unit."""
        si = si.replace(" ", "*")
        name = self.chosen.get(si, si)
        return Unit(name) if name == si else Unit(name, in_si(name))

    def column(self, si: str) -> Unit:
        """The unit for a column of trajectories: as `of`, but strains are shown in 10⁻⁶."""
        return MICROSTRAIN if si == "1" else self.of(si)

    def form(self, si: str, form: str) -> str:
        """A format that shows as many digits in the unit for `si` as `form` does in mm, MPa and else in SI: ".0f" of mm is ".1f" of in."""
        if not form.endswith("f"):
            return form
        decades = math.log10(self.of(si).size / (in_si(_OF_FORMATS[si]) if si in _OF_FORMATS else 1.0))
        head, _, places = form.rstrip("f").rpartition(".")
        return f"{head}.{max(0, int(places) + round(decades))}f"


#: The units for numbers that belong to no case.
METRIC: Final = Units(SETS["mm"])


def units_named(name: str) -> Units:
    """The units of a set. CaseError: there is none of this name."""
    if name not in SETS:
        raise CaseError(Argument("units"), None, as_written(name), "is no set of units", f"accepted are {', '.join(SETS)}")
    return Units(SETS[name])


def units_of(values: Mapping[str, Mapping[str, Any]], *, of_library: bool) -> Units:
    """The units for a case by the texts of its file (section -> key -> text or list of texts); numbers in SI do not decide."""
    counts: dict[str, Counter[str]] = {}
    for section, keys in values.items():
        for path, given in ((f"{section}.{key}", given) for key, given in keys.items()):
            texts = [given] if isinstance(given, str) else given if isinstance(given, (list, tuple)) else []
            units = [unit for text in texts if isinstance(text, str) and (unit := unit_in(text))]
            if path not in _UNDECIDING and PATHS[path].unit != _ALWAYS_SI:
                counts.setdefault(PATHS[path].unit, Counter()).update(units)
    own = {si: count.most_common(1)[0][0] for si, count in counts.items() if count}
    if of_library:
        return Units({**SETS["mm"], **{si: unit for si, unit in own.items() if si == "rad/s"}})
    return Units({**SETS["inch" if own.get("m") in _INCHES else "mm"], **own})


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
