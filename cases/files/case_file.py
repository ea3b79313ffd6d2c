"""Loads cases by name, from the library or from a user's file."""

import math
import os
from collections.abc import Mapping
from dataclasses import replace
from numbers import Real

from quickreturn.cases.files.case import Case, case_of
from quickreturn.cases.files.document import Document, read_document
from quickreturn.cases.files.errors import CaseError, as_written, nearest, path_shown
from quickreturn.cases.files.plausibility import doubts
from quickreturn.cases.files.reading import misfit
from quickreturn.cases.files.text_file import read_text, similar_file
from quickreturn.cases.library import case_names, library_case, library_document
from quickreturn.cases.library.hard import IMPOSSIBLE


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
    return name in case_names() or name in IMPOSSIBLE


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
