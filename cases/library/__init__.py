"""The case library: the 24 runs of the thesis, generated from its tables, and every case file of this folder.

A new case needs no code: drop `NAME.toml` here (its `name` must be NAME).
"""

import functools
import tomllib
from dataclasses import dataclass
from importlib.resources import files

from cases.library.inconsistencies import Inconsistency, inconsistencies
from cases.library.thesis import RUNS, run_name, run_text

__all__ = ["Entry", "Inconsistency", "case_names", "case_notes", "case_text", "catalogue", "inconsistencies"]


@dataclass(frozen=True)
class Entry:
    """A line of the catalogue."""

    name: str
    tags: tuple[str, ...]
    title: str


@functools.cache
def case_names() -> tuple[str, ...]:
    """Names of all cases: the thesis' runs, then the files in alphabetical order."""
    return (*(run_name(run) for run in RUNS), *_file_names())


@functools.cache
def case_text(name: str) -> str:
    """The TOML text of a case of the library. Raises KeyError for a name that is not in `case_names`."""
    if name in _file_names():
        return (files(__name__) / f"{name}.toml").read_text("utf-8")
    return run_text(_run_of(name))


@functools.cache
def case_notes(name: str) -> tuple[str, ...]:
    """What a reader of a case's results must know of published inconsistencies; empty for cases that are no run of the thesis."""
    if name in _file_names():
        return ()
    run = _run_of(name)
    return tuple(found.sentence for found in inconsistencies() if run in found.runs)


def catalogue(tag: str | None = None) -> tuple[Entry, ...]:
    """Name, tags and title of all cases, or of those with a tag."""
    entries = tuple(_entry(name) for name in case_names())
    return tuple(entry for entry in entries if tag is None or tag in entry.tags)


@functools.cache
def _file_names() -> tuple[str, ...]:
    return tuple(sorted(file.name.removesuffix(".toml") for file in files(__name__).iterdir() if file.name.endswith(".toml")))


def _run_of(name: str) -> int:
    return {run_name(run): run for run in RUNS}[name]


@functools.cache
def _entry(name: str) -> Entry:
    content = tomllib.loads(case_text(name))
    return Entry(name, tuple(content.get("tags", ())), content.get("title", name))
