"""A case: a scene with its simulation times; and every key of its file, as `reference_model.mechanism` and `Case` declare them."""

import math
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, field, replace
from types import MappingProxyType
from typing import TYPE_CHECKING, Any, Final

from quickreturn.cases.errors import CaseError, as_written
from quickreturn.cases.shown import Cell, Rows, Shown
from quickreturn.cases.units import DIMENSIONS, Dimension, QuantityError, parse_quantity, unit_size
from quickreturn.reference_model.mechanism import Mechanism, Scene
from quickreturn.reference_model.quantities import Quantity, quantities_of, quantity
from quickreturn.reference_model.scene_values import SECTIONS as SECTIONS_OF_SCENE
from quickreturn.reference_model.scene_values import values_of

if TYPE_CHECKING:
    from quickreturn.cases.document import Document


@dataclass(frozen=True, kw_only=True, repr=False)
class Case(Shown):
    """A named scene in SI units with its simulation times.

    Attributes:
        name: as used on the command line.
        title: one line for people.
        tags: groups that the case belongs to, e.g. "thesis".
        scene: the mechanism, or a follower alone.
        duration: s, a whole multiple of `output_step`.
        output_step: s, the time between two rows of a result.
        notes: remarks for a reader of results, e.g. which published value was replaced and why, or which value is doubtful.
        source: the file's path, or "library".
        document: the values as they were written, with their units; None if the case was made from numbers.
    """

    name: str
    title: str
    tags: tuple[str, ...]
    scene: Scene
    duration: float = quantity("s", "time to simulate, a multiple of output_step", sign="positive")
    output_step: float = quantity("s", "between rows of a trajectory", sign="positive")
    notes: tuple[str, ...] = ()
    source: str = ""
    document: "Document | None" = field(default=None, repr=False, compare=False)

    def _parts(self) -> Iterator[Cell]:
        """Name, title, notes, and a row for each value that is given or differs from its default: in SI, and as written."""
        from quickreturn.cases.copies import written_document
        from quickreturn.cases.document import in_words

        yield f"{self.name}: {self.title}"
        yield from (f"note: {note}" for note in self.notes)
        si = {f"{section}.{key}": value for section, keys in self.values.items() for key, value in keys.items()}
        written = {f"{section}.{key}": value for section, keys in written_document(self).values.items() for key, value in keys.items()}
        si = {path: value for path, value in si.items() if path in written or value != PATHS[path].default}
        texts = {path: in_words(value) for path, value in written.items() if not isinstance(value, (float, tuple))}
        yield Rows(
            [
                (path, shown_value(si[path]) if path in si else "", quantity.unit if path in si else "", texts.get(path, ""))
                for path, quantity in PATHS.items()
                if path in si or path in texts
            ],
            ("value", "in SI", "unit", "as written"),
        )

    @property
    def values(self) -> dict[str, dict[str, Any]]:
        """Values in SI by section and key of the case file; sections and keys that the scene lacks are left out."""
        return {**values_of(self.scene), "simulation": {"duration": self.duration, "output_step": self.output_step}}

    def to_toml(self) -> str:
        """The text of a case file for the same case: values as written, or else in SI, each key with its meaning.

        Raises:
            CaseError: a file cannot hold a value, such as NaN.
        """
        from quickreturn.cases.copies import written_document
        from quickreturn.cases.written import as_toml

        return as_toml(replace(written_document(self), header={"name": self.name, "title": self.title, "tags": list(self.tags)}))

    @property
    def mechanism(self) -> Mechanism:
        """The scene as a mechanism. CaseError: it has no crank and slider."""
        if self.scene.crank is not None:
            return self.scene
        raise CaseError(
            self.name, "[crank]", None, "this case has no crank and no slider, but the command needs them", "use show or simulate"
        )

    def with_(self, overrides: Mapping[str, str] | None = None, *, name: str | None = None) -> "Case":
        """A copy with other values and another name; its title states the changes.

        Args:
            overrides: values as in a case file, by dotted key: {"crank.length": "5 in"}.
            name: name of the copy; None: this case's name and the changes, such as "press-crank.length-5-in".

        Raises:
            CaseError: a mistake in the overrides, or neither is given.
        """
        from quickreturn.cases.copies import copy_of

        return copy_of(self, overrides or {}, name)


def shown_value(value: Any) -> str:
    """A number, or several, to nine digits."""
    return ", ".join(map(shown_value, value)) if isinstance(value, (list, tuple)) else f"{value:.9g}"


#: Section -> key -> quantity.
SECTIONS: Final[Mapping[str, Mapping[str, Quantity]]] = MappingProxyType(
    {**SECTIONS_OF_SCENE, "simulation": {key: declared for _, key, declared in quantities_of(Case)}}
)
#: Keys outside all sections.
HEADER: Final = ("name", "title", "tags")
#: Dotted path -> quantity, in the order of the file.
PATHS: Final = MappingProxyType({f"{section}.{key}": declared for section, keys in SECTIONS.items() for key, declared in keys.items()})


def dimension_of(path: str) -> Dimension:
    """The dimension of the quantity at a dotted path."""
    return DIMENSIONS[PATHS[path].unit]


def value_at(path: str, text: str, *, finite: bool = False) -> float:
    """The SI value of a text for the quantity at a dotted path; with `finite` not "inf". QuantityError: wrong text, or wrong sign."""
    quantity, dimension = PATHS[path], dimension_of(path)
    value = parse_quantity(text, dimension, infinity_accepted=quantity.infinity and not finite)
    if quantity.sign == "positive" and value <= 0.0:
        raise QuantityError("is not positive", f"{dimension.name} greater than zero is accepted")
    if quantity.sign == "not negative" and value < 0.0:
        raise QuantityError("is negative", f"{dimension.name} of zero or more is accepted")
    return value


def si_text(path: str, value: float) -> str:
    """The shortest text of a case file that reads back as exactly this SI value of the quantity at a dotted path."""
    unit = PATHS[path].unit
    return "inf" if math.isinf(value) else f"{repr(float(value)).removesuffix('.0')} {unit}".removesuffix(" 1")


def unit_given(path: str, texts: Iterable[str]) -> tuple[str, float]:
    """The unit in which values of the quantity at a dotted path are written, and its size in SI; the SI unit if they have several."""
    units = {unit for text in texts if (unit := text.strip().partition(" ")[2])}
    unit = units.pop() if len(units) == 1 else PATHS[path].unit
    return unit, 1.0 if unit == "1" else unit_size(unit, dimension_of(path))


def si_value(path: str, text: str, source: str, *, finite: bool = False) -> float:
    """As `value_at`, but a wrong text or sign is a CaseError about `source`."""
    try:
        return value_at(path, text, finite=finite)
    except QuantityError as wrong:
        raise CaseError(source, path, as_written(text), wrong.problem, wrong.accepted) from None
