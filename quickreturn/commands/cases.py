"""`quickreturn cases`, `new` and `show`: the cases of the library, a case file to begin with, and a scene with the models of it."""

import shlex
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Final

import click

import quickreturn as qr
from quickreturn.cases.jobs.fork_server import DESCRIBING, get_ready
from quickreturn.commands import options
from quickreturn.reports.output import print_json, write_file

if TYPE_CHECKING:
    from quickreturn.cases.case import Case

#: The library's case that has every key.
EXAMPLE: Final = "example"


@click.command(name="cases")
@options.single("--tag", metavar="TAG", help="Only cases with this tag.")
@options.json
def cases(tag: str | None, as_json: bool) -> None:
    """List the cases of the library: name, tags, title."""
    found = qr.list_cases(tag)
    if as_json:
        print_json([{"name": case.name, "tags": case.tags, "title": case.title} for case in found])
    else:
        click.echo(repr(found))


@click.command(name="show")
@options.cases
@options.tag
@options.case_assignments
@click.option("--for-other-tools", "for_others", is_flag=True, help="Print instead what another tool needs to build the scene.")
@options.json
def show(cases: Sequence[str], tag: str | None, assignments: Sequence[str], for_others: bool, as_json: bool) -> None:
    """Show the scene of CASE and the parts, joints and degrees of freedom that each engine builds.

    The JSON document is in SI; with several cases it is a list.
    """
    overrides = options.read_overrides(assignments)
    if for_others and as_json:
        raise click.UsageError("--for-other-tools and --json are both given; what other tools need is a text, give one of them")
    if not for_others:
        get_ready((*DESCRIBING, "quickreturn.engines.exudyn.models"))
    loaded = options.load_all(cases, tag, overrides)
    if for_others:
        from quickreturn.reports.other_tools import for_other_tools

        click.echo("\n\n".join(for_other_tools(case, shlex.join(options.given_as(case, overrides))) for case in loaded))
        return
    from quickreturn.commands.case_document import document_of, models, print_document

    documents = [document_of(case) for case in loaded]
    if as_json:
        documents = [document | {"engines": [*models(case.scene)]} for case, document in zip(loaded, documents, strict=True)]
        print_json(documents[0] if len(documents) == 1 else documents)
        return
    for number, (case, document) in enumerate(zip(loaded, documents, strict=True)):
        click.echo("\n" * (number > 0), nl=False)
        print_document(document, case)


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
def new(file: str, origin: str | None, assignments: Sequence[str]) -> None:
    """Write a case file of your own to FILE, with the meaning of every key beside it.

    The name of the case is that of the file without .toml. Keys that the machine does not use stand there as comments. A file that exists
    is never overwritten.
    """
    overrides = options.read_overrides(assignments)
    from quickreturn.commands.case_document import header_for, text_of

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
