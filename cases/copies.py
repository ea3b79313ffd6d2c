"""Copies of a case with other values, and the names that they get."""

import contextlib
import hashlib
import re
from collections.abc import Callable, Iterator, Mapping
from dataclasses import replace
from typing import Any, Final

from quickreturn.cases.case import Case
from quickreturn.cases.document import OVERRIDE, Document, document_of, header_of, in_words
from quickreturn.cases.errors import CaseError, as_written, together
from quickreturn.cases.reading import case_of, in_si
from quickreturn.reference_model.mechanism import Mechanism

#: Largest number of characters of a name that `header_of` accepts.
LONGEST_NAME: Final = 64
#: Characters of the hash at the end of a shortened name: two copies share it with a probability of 2^-32.
_HASH: Final = 8


def changed(case: Case, overrides: Mapping[str, str]) -> Case:
    """The case with other values: dotted key -> text as in a case file. Name and source stay, the title states the changes.

    Raises:
        CaseError: a mistake in the overrides.
    """
    document = written_document(case)
    before, new = case_of(document), case_of(document.overridden_by(overrides))
    # Notes on the case itself stay; doubts about numbers are given for the copy only if they were given for the case.
    kept = [note for note in case.notes if note not in before.notes]
    doubted = [note for note in new.notes if note in case.notes or note not in before.notes]
    return replace(new, notes=(*kept, *doubted), source=case.source)


def scenes(case: Case) -> Callable[[Mapping[str, Any]], Mechanism]:
    """The scene of a case with other values by dotted key, texts of a case file, as a function of them.

    All studies vary a machine by this function. The scene alone would not do: stiffness and mass of a follower given by its material follow
    from its section, and the start of a crank without an initial speed follows from its torque.

    Raises:
        CaseError: the case, or the scene with its values (from the function), is none with a crank or cannot be; caused by an
            `ImpossibleMechanism` if values contradict each other.
    """
    _ = case.mechanism
    document = in_si(replace(written_document(case), overridden={}))

    def scene_with(values: Mapping[str, Any]) -> Mechanism:
        with reported_as(case.name):
            return case_of(document.overridden_by(values)).mechanism

    return scene_with


def copy_of(case: Case, overrides: Mapping[str, str], name: str | None = None) -> Case:
    """`changed` under another name; without `name` its name consists of the case's name and the changes.

    Raises:
        CaseError: a mistake in the overrides or the name, or neither is given.
    """
    with reported_as_overrides(overrides):
        new = changed(case, overrides)
    if name is None and not overrides:
        raise CaseError(case.name, None, None, "a copy without a change needs a name", 'such as with_(name="shaper-2")')
    before = {} if case.document is None else case.document.overridden
    after = {} if new.document is None else new.document.overridden
    new_name = _name_of_copy(case.name, before, {path: after[path] for path in overrides}) if name is None else name
    header_of(Document(f"copy of {case.name}", {"name": new_name}, {}))
    return replace(new, name=new_name)


@contextlib.contextmanager
def reported_as_overrides(overrides: Any) -> Iterator[None]:
    """`reported_as` "overrides", for calls from Python. CaseError: it is not a mapping."""
    if not isinstance(overrides, Mapping):
        raise CaseError("overrides", None, None, f"{as_written(overrides)} is not a dictionary", 'such as {"crank.length": "5 in"}')
    with reported_as("overrides"):
        yield


@contextlib.contextmanager
def reported_as(source: str) -> Iterator[None]:
    """Names a source in place of `--set` for mistakes in changes that come from elsewhere."""
    try:
        yield
    except CaseError as wrong:
        mistakes = [
            CaseError(source if one.source == OVERRIDE else one.source, one.key, one.value, one.problem, one.accepted)
            for one in (wrong, *wrong.further)
        ]
        raise together(mistakes) from wrong.__cause__


def written_document(case: Case) -> Document:
    """The document that the case was read from, with its present name, title and times; in SI if the scene was replaced since."""
    document = case.document
    if document is None or (read := case_of(document)).scene != case.scene:
        return document_of(case)
    document = replace(document, header={**document.header, "name": case.name})
    if read.title != case.title:
        document = replace(document, header={**document.header, "title": case.title}, overridden={})
    times = case.values["simulation"]
    return document if times == read.values["simulation"] else document.changed({f"simulation.{key}": times[key] for key in times})


def _name_of_copy(name: str, before: Mapping[str, Any], changes: Mapping[str, Any]) -> str:
    """The name with the changes; earlier changes of the same key are removed from it.

    A name that would be too long ends in a hash of the whole name.
    """
    for path in changes:
        if path in before:
            name = name.replace(_part(path, before[path]), "")
    full_name = name + "".join(_part(path, value) for path, value in changes.items())
    if len(full_name) <= LONGEST_NAME:
        return full_name
    return f"{full_name[: LONGEST_NAME - _HASH - 1]}-{hashlib.sha256(full_name.encode()).hexdigest()[:_HASH]}"


def _part(path: str, value: Any) -> str:
    """A change as a part of a name: "-crank.length-5-in". Characters that a name cannot have become hyphens."""
    return "-" + re.sub(r"[^A-Za-z0-9._-]", "-", f"{path}-{in_words(value)}".replace("+", ""))
