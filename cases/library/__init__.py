"""The case library: every case file of this folder, the 24 runs of the thesis, and generated hard scenes.

`load_case` takes a name of the library or the path of a user's file.
A new case needs no code: put `NAME.toml` here (its `name` must be NAME).
"""

import functools
import math
import os
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from functools import partial
from numbers import Real
from pathlib import Path
from typing import Final

from quickreturn.cases.files.case import Case, case_of
from quickreturn.cases.files.document import Document, header_of, read_document
from quickreturn.cases.files.errors import CaseError, as_written, nearest, path_shown
from quickreturn.cases.files.reading import doubts, misfit
from quickreturn.cases.files.text_file import read_text, similar_file
from quickreturn.cases.library import hard
from quickreturn.cases.library.thesis import RUNS, TAG, run_document, run_name, run_title
from quickreturn.cases.library.thesis.inconsistencies import inconsistencies


@dataclass(frozen=True, kw_only=True)
class Entry:
    """A generated case."""

    title: str
    tags: tuple[str, ...]
    document: Callable[[], Document]  # its values as in a case file
    notes: Callable[[], tuple[str, ...]]  # sentences on where its values come from; the values are not doubted
    number: str  # by which tables call it: "run 24"
    group: str  # heading of those that the page lists together


def _notes(number: int) -> tuple[str, ...]:
    """Sentences on the published inconsistencies of a run."""
    return tuple(each.sentence for each in inconsistencies() if number in each.runs)


#: Name -> entry of a run.
ENTRIES: Final[Mapping[str, Entry]] = {
    run_name(number): Entry(
        title=run_title(number),
        tags=(TAG,),
        document=partial(run_document, number),
        notes=partial(_notes, number),
        number=str(number),
        group=f"crank {run.crank_length} in",
    )
    for number, run in RUNS.items()
}


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


def load_case(name_or_path: str, overrides: Mapping[str, str] | None = None) -> Case:
    """The case of a library name or of a file.

    A name of the library wins over a file of the same name; write `./name` to mean the file.

    Args:
        name_or_path: e.g. "thesis-24" or "my/scene.toml".
        overrides: dotted key -> text as in the file, e.g. {"crank.length": "5 in"}; see `cases.files.document.Document.overridden_by`.

    Raises:
        CaseError: no such case, an unreadable file, or a mistake in the file or the overrides.
    """
    if not in_library(name_or_path):
        return case_of(_document(name_or_path).overridden_by(overrides or {}))
    original = library_case(name_or_path)
    if not overrides:
        return original
    changed = case_of(library_document(name_or_path).overridden_by(overrides))
    intended = tuple(doubts(original.scene))  # the library's own values
    return replace(changed, notes=(*original.notes, *(note for note in changed.notes if note not in intended)), source=original.source)


def _document(name_or_path: str) -> Document:
    """The values of a case outside the library as written; raises as `load_case`, except for impossible values."""
    if os.sep not in name_or_path and not name_or_path.endswith(".toml") and not os.path.lexists(name_or_path):
        raise _unknown(name_or_path)
    shown = path_shown(name_or_path)
    if name_or_path.lower().endswith(".csv") and os.path.isfile(name_or_path):
        raise CaseError(shown, None, None, "is a table, not a case file", "give its case; `plot` and `compare` also take tables")
    return read_document(read_text(name_or_path, library=case_names()), shown, os.path.dirname(name_or_path))


def in_library(name: str) -> bool:
    """Whether the library has a case of this name, even an impossible one."""
    return name in case_names() or name in hard.IMPOSSIBLE


def _unknown(name: str) -> CaseError:
    """The message for a name that the library does not have; it names a similar file if there is one."""
    near = nearest(name, case_names())
    accepted = f"the nearest one is {near} (`quickreturn cases` lists all); or give a path"
    if file := similar_file(f"{name}.toml"):
        accepted = f"did you mean the file {file}?"
    return CaseError(as_written(name), None, None, "no case of the library has this name", accepted)


def with_times(case: Case, duration: float | None = None, output_step: float | None = None) -> Case:
    """The case with other simulation times in s. CaseError: one is not positive, or the duration is no multiple of the output step."""
    for key, value in (("duration", duration), ("output_step", output_step)):
        number = isinstance(value, Real)
        if value is not None and not (number and 0.0 < value < math.inf):
            shown = f"{value:.6g}" if number else as_written(value)
            raise CaseError(case.name, key, shown, "is not a positive time in seconds", "such as 2 or 0.001")
    new = replace(case, duration=duration or case.duration, output_step=output_step or case.output_step)
    if problem := misfit(new.duration, new.output_step):
        key, value = ("duration", duration) if duration else ("output_step", new.output_step)
        raise CaseError(case.name, key, f"{value:.9g}", *problem)
    return new
