"""The case library: every case file of this folder, the 24 runs of the thesis, and generated hard scenes.

A new case needs no code: put `NAME.toml` here (its `name` must be NAME).
"""

import functools
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Final

from quickreturn.cases.files.case import Case, case_of
from quickreturn.cases.files.document import Document, header_of, read_document
from quickreturn.cases.files.errors import CaseError
from quickreturn.cases.files.text_file import read_text
from quickreturn.cases.library import hard
from quickreturn.cases.library.thesis.entries import ENTRIES

__all__ = ["ENTRIES", "CatalogueLine", "case_names", "catalogue", "library_case", "library_document"]

_FOLDER: Final = Path(__file__).parent


@dataclass(frozen=True)
class CatalogueLine:
    """A line of the catalogue: name, tags and title of a case."""

    name: str
    tags: tuple[str, ...]
    title: str


@functools.cache
def case_names() -> tuple[str, ...]:
    """Names of all cases: the runs of the thesis, then the files in alphabetical order, then the hard scenes."""
    return (*ENTRIES, *_file_names(), *(name for name in hard.SCENES if name not in hard.IMPOSSIBLE))


@functools.cache
def library_case(name: str) -> Case:
    """A case of the library. Its values are not doubted.

    Raises:
        CaseError: a name that is neither in `case_names` nor in `hard.IMPOSSIBLE`, a broken file, or an impossible scene.
    """
    notes = ENTRIES[name].notes() if name in ENTRIES else ()
    return replace(case_of(library_document(name)), notes=notes, source="library")


def library_document(name: str) -> Document:
    """The values of a case of the library as they are written in its file or, of the generated ones, in their source.

    Raises:
        CaseError: a name that is neither in `case_names` nor in `hard.IMPOSSIBLE`, or a broken file.
    """
    if name in ENTRIES:
        return ENTRIES[name].document()
    if name in hard.SCENES:
        return hard.scene_document(name, library_document(hard.ORIGINAL))
    return read_document(_file_text(name), name, str(_FOLDER))


def catalogue(tag: str | None = None) -> tuple[CatalogueLine, ...]:
    """Name, tags and title of all cases, or of those with a tag. Raises CaseError for a broken file in the folder."""
    lines = (_line(name) for name in case_names())
    return tuple(line for line in lines if tag is None or tag in line.tags)


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
    if name in ENTRIES:
        return CatalogueLine(name, ENTRIES[name].tags, ENTRIES[name].title)
    written, title, tags = header_of(read_document(_file_text(name), name, str(_FOLDER)))
    if written != name:
        raise CaseError(f"{name}.toml", "name", f'"{written}"', "differs from the file's name", f'in this folder write name = "{name}"')
    return CatalogueLine(name, tags, title)
