"""`quickreturn new`: a case file to begin with."""

import shlex
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Final

import click

from quickreturn.commands import options
from quickreturn.reports.output import write_file

if TYPE_CHECKING:
    from quickreturn.cases.case import Case

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
    overrides = options.read_overrides(assignments)
    from quickreturn.commands.new_case import header_for, text_of

    header = header_for(file)
    original = options.load(origin or EXAMPLE, overrides)
    write_file(Path(file), text_of(original, header, copied=bool(origin)).encode())
    options.tell_doubts([replace(original, name=header["name"])])
    _print_what_next(file, original)


def _print_what_next(file: str, case: "Case") -> None:
    click.echo(f"{file} is written. Change its values, then try")
    tried = {"show": "", "plot": ".png", "simulate": ".csv", "run": ""}
    if case.scene.crank is None:
        tried = {"show": "", "simulate": ".csv"}
    for command, ending in tried.items():
        output = ["--output", str(Path(file).with_suffix(ending))] if ending else []
        click.echo(f"  {shlex.join(['quickreturn', command, file, *output])}")
