"""The content of a new case file."""

import os
import re
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import Final

import click

from quickreturn.cases.case import Case, written_document
from quickreturn.cases.case_file import in_library
from quickreturn.cases.errors import CaseError, path_shown
from quickreturn.cases.plausibility import doubts
from quickreturn.cases.text.document import NAME
from quickreturn.cases.text.written import as_toml
from quickreturn.reports.output import OutputError, check_writable

ENDING: Final = ".toml"


def text_of(original: Case, header: dict[str, str], *, copied: bool) -> str:
    """The text of a file with the values of a case under another name and title; `copied`: comments name the case."""
    return as_toml(replace(written_document(original), header=header), tuple(_origin(original)) if copied else ())


def header_for(file: str) -> dict[str, str]:
    """Name and title of the case in a new file, after the file's name.

    Raises:
        CaseError: the file exists, or its name is invalid for a case or is that of a case of the library.
        UsageError: it cannot be written.
    """
    if os.path.lexists(file) and not os.path.isdir(file):
        raise CaseError(path_shown(file), None, None, "this file exists and is not overwritten", "give another name")
    try:
        check_writable(Path(file), "", ENDING)
    except OutputError as wrong:
        raise click.UsageError(str(wrong)) from None
    name = Path(file).stem
    if not NAME.fullmatch(name):
        usable = re.sub(r"[^A-Za-z0-9._-]+", "-", name).strip("._-")[:64] or "my-machine"
        accepted = f"up to 64 letters from a to z, digits, points, hyphens and underscores are accepted, such as {usable}{ENDING}"
        raise CaseError(path_shown(file), None, None, "its name is also that of the case, and cannot be one", accepted)
    if in_library(name):
        raise CaseError(path_shown(file), None, None, f"the library has a case {name}", f"give another name, such as my-{name}{ENDING}")
    title = name.replace("-", " ").replace("_", " ")
    return {"name": name, "title": title[:1].upper() + title[1:]}


def _origin(case: Case) -> Iterator[str]:
    """Comment lines in a copy that name the copied case and its notes."""
    yield f"A copy of {case.name} ({case.title})."
    meant = tuple(doubts(case.scene))
    yield from (f"Note: {note}." for note in case.notes if note not in meant)
