"""The case library: every case file of this folder, generated hard scenes, and the cases that packages beside the core register.

A new case needs no code: put `NAME.toml` here (its `name` must be NAME). A package registers its generated cases, a mapping from name to
`Entry`, by the entry-point group `quickreturn.cases`.
"""

import functools
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from importlib.metadata import entry_points
from pathlib import Path
from typing import Final

from quickreturn.cases.case import Case, case_of
from quickreturn.cases.errors import CaseError
from quickreturn.cases.library import hard
from quickreturn.cases.text.document import Document, header_of, read_document
from quickreturn.cases.text.text_file import read_text

__all__ = ["CatalogueLine", "Entry", "case_names", "catalogue", "library_case", "library_document", "registered"]

GROUP: Final = "quickreturn.cases"
_FOLDER: Final = Path(__file__).parent


@dataclass(frozen=True, kw_only=True)
class Entry:
    """A generated case that a package registers."""

    title: str
    tags: tuple[str, ...]
    document: Callable[[], Document]  # its values as in a case file
    notes: Callable[[], tuple[str, ...]]  # sentences on where its values come from; the values are not doubted
    number: str  # by which tables call it: "run 24"
    group: str  # heading of those that the page lists together


@dataclass(frozen=True)
class CatalogueLine:
    """A line of the catalogue: name, tags and title of a case."""

    name: str
    tags: tuple[str, ...]
    title: str


@functools.cache
def case_names() -> tuple[str, ...]:
    """Names of all cases: the registered ones, then the files in alphabetical order, then the hard scenes."""
    return (*registered(), *_file_names(), *(name for name in hard.SCENES if name not in hard.IMPOSSIBLE))


@functools.cache
def library_case(name: str) -> Case:
    """A case of the library. Its values are not doubted.

    Raises:
        CaseError: a name that is neither in `case_names` nor in `hard.IMPOSSIBLE`, a broken file, or an impossible scene.
    """
    notes = registered()[name].notes() if name in registered() else ()
    return replace(case_of(library_document(name)), notes=notes, source="library")


def library_document(name: str) -> Document:
    """The values of a case of the library as they are written in its file or, of the generated ones, in their source.

    Raises:
        CaseError: a name that is neither in `case_names` nor in `hard.IMPOSSIBLE`, or a broken file.
    """
    if name in registered():
        return registered()[name].document()
    if name in hard.SCENES:
        return hard.scene_document(name, library_document(hard.ORIGINAL))
    return read_document(_file_text(name), name, str(_FOLDER))


def catalogue(tag: str | None = None) -> tuple[CatalogueLine, ...]:
    """Name, tags and title of all cases, or of those with a tag. Raises CaseError for a broken file in the folder."""
    lines = (_line(name) for name in case_names())
    return tuple(line for line in lines if tag is None or tag in line.tags)


@functools.cache
def registered() -> Mapping[str, Entry]:
    """Name -> registered case, of all packages."""
    return {name: entry for point in entry_points(group=GROUP) for name, entry in point.load().items()}


@functools.cache
def _file_names() -> tuple[str, ...]:
    return tuple(sorted(path.stem for path in _FOLDER.glob("*.toml")))


def _file_text(name: str) -> str:
    return read_text(str(_FOLDER / f"{name}.toml"))


@functools.cache
def _line(name: str) -> CatalogueLine:
    """A line of the catalogue without the case itself, because reading units takes time."""
    if name in hard.SCENES:
        return CatalogueLine(name, (hard.TAG,), hard.scene_title(name))
    if name in registered():
        return CatalogueLine(name, registered()[name].tags, registered()[name].title)
    written, title, tags = header_of(read_document(_file_text(name), name, str(_FOLDER)))
    if written != name:
        raise CaseError(f"{name}.toml", "name", f'"{written}"', "differs from the file's name", f'in this folder write name = "{name}"')
    return CatalogueLine(name, tags, title)
