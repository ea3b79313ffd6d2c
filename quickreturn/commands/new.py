"""`quickreturn new`: a case file to begin with."""

import os
import re
import shlex
from collections.abc import Iterator, Sequence
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Final

import click

from quickreturn.commands import options

if TYPE_CHECKING:
    from quickreturn.cases.case import Case

ENDING: Final = ".toml"
#: The library's case that has every key.
EXAMPLE: Final = "example"


@click.command(name="new")
@click.argument("file", metavar="FILE")
@options.single(
    "--from",
    "origin",
    metavar="CASE",
    shell_complete=options.complete_case,
    help="Case of the library, or case file, to copy; default: a small machine with every key.",
)
@options.case_assignments
def command(file: str, origin: str | None, assignments: Sequence[str]) -> None:
    """Write a case file of your own to FILE, with the meaning of every key beside it.

    The name of the case is that of the file without .toml. Keys that the machine does not use stand there as comments. A file that exists
    is never overwritten.
    """
    from quickreturn.cases.case import written_document
    from quickreturn.cases.case_file import load_case
    from quickreturn.cases.written import as_toml
    from quickreturn.reports.output import write_file

    overrides = options.read_overrides(assignments)
    header = _header(file)
    original = load_case(origin or EXAMPLE, overrides)
    document = replace(written_document(original), header=header)
    remarks = tuple(_origin(original)) if origin else ()
    write_file(Path(file), as_toml(document, remarks).encode())
    options.tell_doubts([replace(original, name=header["name"])])
    _print_what_next(file, original)


def _header(file: str) -> dict[str, str]:
    """Name and title of the case in a new file, after the file's name.

    Raises:
        CaseError: the file exists, or its name is invalid for a case or is that of a case of the library.
        UsageError: it cannot be written.
    """
    from quickreturn.cases.case_file import in_library
    from quickreturn.cases.document import NAME
    from quickreturn.cases.errors import CaseError, path_shown
    from quickreturn.reports.output import OutputError, check_writable

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


def _origin(case: "Case") -> Iterator[str]:
    """Comment lines in a copy that name the copied case and its notes."""
    from quickreturn.cases.doubts import doubts

    yield f"A copy of {case.name} ({case.title})."
    meant = tuple(doubts(case.scene))
    yield from (f"Note: {note}." for note in case.notes if note not in meant)


def _print_what_next(file: str, case: "Case") -> None:
    click.echo(f"{file} is written. Change its values, then try")
    tried = {"show": "", "plot": ".png", "simulate": ".csv", "run": ""}
    if case.scene.crank is None:
        tried = {"show": "", "simulate": ".csv"}
    for command, ending in tried.items():
        output = ["--output", str(Path(file).with_suffix(ending))] if ending else []
        click.echo(f"  {shlex.join(['quickreturn', command, file, *output])}")
