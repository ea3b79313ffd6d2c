"""A case: a scene with its simulation times, and the file that describes it."""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any

from quickreturn.cases.files.document import Document, check_mapping, header_of, in_words, name_of_copy
from quickreturn.cases.files.errors import CaseError
from quickreturn.cases.files.keys import PATHS, PLUS_MINUS, shown_value
from quickreturn.cases.files.reading import in_si, read
from quickreturn.cases.files.shown import Cell, Printable, Rows, Units, units_named, units_of
from quickreturn.cases.files.written import as_toml
from quickreturn.reference_model.mechanism import Mechanism, Scene
from quickreturn.reference_model.scene_values import Changes, changed_values, values_of
from quickreturn.reference_model.table import Table


@dataclass(frozen=True, kw_only=True, repr=False)
class Case(Printable):
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
        shown_in: name of the set of units in which its numbers are shown to people; "": those of its file.
    """

    name: str
    title: str
    tags: tuple[str, ...]
    scene: Scene
    duration: float
    output_step: float
    notes: tuple[str, ...] = ()
    source: str = ""
    document: Document | None = field(default=None, repr=False, compare=False)
    shown_in: str = field(default="", repr=False, compare=False)

    def _parts(self) -> Iterator[Cell]:
        """Name, title, notes, and a row for each value that is given or differs from its default: in SI, and as written."""
        yield f"{self.name}: {self.title}"
        yield from (f"note: {note}" for note in self.notes)
        si = {f"{section}.{key}": value for section, keys in self.values.items() for key, value in keys.items()}
        written = {f"{section}.{key}": value for section, keys in written_document(self).values.items() for key, value in keys.items()}
        si = {path: value for path, value in si.items() if path in written or value != PATHS[path].default}
        texts = {path: in_words(value) for path, value in written.items() if not isinstance(value, (float, tuple, Table))}
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

    @property
    def tolerances(self) -> dict[str, str]:
        """Values that the file gives with a tolerance: key, with the index in a list -> text, such as "6 mm +- 0.1 mm".

        Within a tolerance every value is equally likely. All but a study of uncertainty takes the value before it.
        """
        texts = dict[str, Any]()
        for section, keys in written_document(self).values.items():
            for key, value in keys.items():
                parts = enumerate(value, 1) if isinstance(value, (list, tuple)) else ()
                texts |= {f"{section}.{key}": value} | {f"{section}.{key}[{place}]": part for place, part in parts}
        return {key: text for key, text in texts.items() if isinstance(text, str) and PLUS_MINUS in text}

    @cached_property
    def units(self) -> Units:
        """The units in which people read its numbers: those of its file, see `cases.files.shown`, or of the set that `in_units` chose."""
        if self.shown_in:
            return units_named(self.shown_in)
        return units_of({} if self.document is None else self.document.values, of_library=self.source == "library")

    def in_units(self, name: str) -> "Case":
        """The same case, whose numbers are shown to people in a set of units: "si", "mm" or "inch". CaseError: another name."""
        units_named(name)
        return replace(self, shown_in=name)

    def to_toml(self) -> str:
        """The text of a case file for the same case: values as written, or else in SI, each key with its meaning.

        Raises:
            CaseError: a file cannot hold a value, such as NaN.
        """
        return as_toml(replace(written_document(self), header={"name": self.name, "title": self.title, "tags": list(self.tags)}))

    @property
    def mechanism(self) -> Mechanism:
        """The scene as a mechanism. CaseError: it has no crank and slider."""
        if self.scene.crank is not None:
            return self.scene
        raise CaseError(
            self.name, "[crank]", None, "this case has no crank and no slider, but the command needs them", "use show or simulate"
        )

    def mechanism_with(self, changes: Changes) -> Mechanism:
        """The mechanism with other values in SI, by dotted key: what the case's file would describe with them.

        All studies vary a machine by this function. The scene alone would not do: stiffness and mass of a follower given by its material
        follow from its section, and the start of a crank without an initial speed follows from its torque.

        Raises:
            CaseError: the case has no crank, or the values cannot be; caused by an `ImpossibleMechanism` if they contradict each other.
        """
        _ = self.mechanism
        scene = read(self._in_si.changed(changes, self.name)).scene
        assert scene.crank is not None
        return scene

    @cached_property
    def _in_si(self) -> Document:
        """The file's values in SI."""
        return in_si(replace(written_document(self), overridden={}))

    def with_(self, overrides: Mapping[str, str] | None = None, *, name: str | None = None) -> "Case":
        """A copy with other values and another name; its title states the changes.

        Args:
            overrides: values as in a case file, by dotted key: {"crank.length": "5 in"}.
            name: name of the copy; None: this case's name and the changes, such as "press-crank.length-5-in".

        Raises:
            CaseError: a mistake in the overrides, or neither is given.
        """
        texts = check_mapping(overrides or {})
        document = written_document(self)
        before, new = case_of(document), case_of(document.overridden_by(texts, "overrides"))
        if name is None and not texts:
            raise CaseError(self.name, None, None, "a copy without a change needs a name", 'such as with_(name="shaper-2")')
        if name is None:
            earlier, later = ({} if one.document is None else one.document.overridden for one in (self, new))
            name = name_of_copy(self.name, earlier, {path: later[path] for path in texts})
        header_of(Document(f"copy of {self.name}", {"name": name}, {}))
        # notes on the case itself stay; doubts about numbers are given for the copy only if they were given for the case
        kept = [note for note in self.notes if note not in before.notes]
        doubted = [note for note in new.notes if note in self.notes or note not in before.notes]
        return replace(new, name=name, notes=(*kept, *doubted), source=self.source, shown_in=self.shown_in)


def case_of(document: Document) -> Case:
    """The case that a document describes. CaseError: as `text.reading.read`."""
    return Case(**read(document)._asdict(), source=document.source, document=document)


def document_of(case: Case) -> Document:
    """A case as a document, its values in SI."""
    return Document(case.name, {"name": case.name, "title": case.title, "tags": list(case.tags)}, case.values)


def written_document(case: Case) -> Document:
    """The document that the case was read from, with its present name, title and times; in SI if the scene was replaced since."""
    document = case.document
    if document is None or (read := case_of(document)).scene != case.scene:
        return document_of(case)
    document = replace(document, header={**document.header, "name": case.name})
    if read.title != case.title:
        document = replace(document, header={**document.header, "title": case.title}, overridden={})
    times = case.values["simulation"]
    if times == read.values["simulation"]:
        return document
    return replace(document, values=changed_values(document.values, {f"simulation.{key}": times[key] for key in times}))
