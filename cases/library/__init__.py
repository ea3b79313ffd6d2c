"""The case library: the thesis' 24 runs and hard scenes made from one of them, both generated, and every case file of this folder.

A new case needs no code: drop `NAME.toml` here (its `name` must be NAME).
"""

import functools
from dataclasses import dataclass
from pathlib import Path
from typing import Final

from cases.document import header_of, read_document
from cases.errors import CaseError
from cases.library import hard
from cases.library.inconsistencies import Inconsistency, inconsistencies
from cases.library.thesis import RUNS, run_name, run_text
from cases.text_file import read_text

__all__ = ["Entry", "Inconsistency", "case_names", "case_notes", "case_text", "catalogue", "impossible_names", "inconsistencies"]

_FOLDER: Final = Path(__file__).parent


@dataclass(frozen=True)
class Entry:
    """A line of the catalogue."""

    name: str
    tags: tuple[str, ...]
    title: str


@functools.cache
def case_names() -> tuple[str, ...]:
    """Names of all cases: the thesis' runs, then the files in alphabetical order, then the hard scenes."""
    return (*(run_name(run) for run in RUNS), *_file_names(), *(name for name in hard.SCENES if name not in hard.IMPOSSIBLE))


def impossible_names() -> tuple[str, ...]:
    """Names of scenes that have a text but cannot be: loading one is refused with a sentence that is known beforehand."""
    return tuple(hard.IMPOSSIBLE)


@functools.cache
def case_text(name: str) -> str:
    """The TOML text of a case of the library or of an impossible one.

    Raises:
        KeyError: a name that is neither in `case_names` nor in `impossible_names`.
        CaseError: a broken file.
    """
    if name in _file_names():
        return read_text(str(_FOLDER / f"{name}.toml"))
    if name in hard.SCENES:
        return hard.scene_text(name)
    return run_text(_runs_by_name()[name])


@functools.cache
def case_notes(name: str) -> tuple[str, ...]:
    """What a reader of a case's results must know of published inconsistencies; empty for cases that are no run of the thesis."""
    run = _runs_by_name().get(name)
    return tuple(found.sentence for found in inconsistencies() if run in found.runs)


def catalogue(tag: str | None = None) -> tuple[Entry, ...]:
    """Name, tags and title of all cases, or of those with a tag. Raises CaseError for a broken file in the folder."""
    entries = tuple(_entry(name) for name in case_names())
    return tuple(entry for entry in entries if tag is None or tag in entry.tags)


@functools.cache
def _file_names() -> tuple[str, ...]:
    return tuple(sorted(path.stem for path in _FOLDER.glob("*.toml")))


def _runs_by_name() -> dict[str, int]:
    return {run_name(run): run for run in RUNS}


@functools.cache
def _entry(name: str) -> Entry:
    written, title, tags = header_of(read_document(case_text(name), name))
    if written != name:
        raise CaseError(f"{name}.toml", "name", f'"{written}"', "differs from the file's name", f'in this folder write name = "{name}"')
    return Entry(name, tags, title)
