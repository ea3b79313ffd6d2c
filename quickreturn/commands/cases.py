"""`quickreturn engines`, `cases`, `new` and `show`: what there is, a case file to begin with, and a scene with the models of it."""

import shlex
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Final

import click

import quickreturn as qr
from quickreturn.cases.running.fork_server import DESCRIBING, get_ready
from quickreturn.cases.running.job import Job
from quickreturn.commands import options
from quickreturn.commands.console import Call, tell_doubts, write

if TYPE_CHECKING:
    from quickreturn.cases.files.case import Case

#: The library's case that has every key.
EXAMPLE: Final = "example"


@options.command(click.argument("engine", required=False), options.json)
def engines(call: Call, engine: str | None) -> None:
    """List the engines: name, version, method, available or why not; for one ENGINE also its settings and default accuracy."""
    if engine is None:
        listed = qr.list_engines()
        call.show(listed, repr(listed))
        return
    from quickreturn.cases.files.shown import Rows
    from quickreturn.descriptions import outcomes, settings, value_of

    found = value_of(*outcomes([Job(engine, settings, (engine,))], engine))
    rows = Rows([(row.name, row.accepted, row.meaning) for row in found.settings], ("SETTING", "ACCEPTED", "MEANING"))
    call.show(
        found,
        f"{engine}: {found.method}; {found.version or f'not available: {found.reason}'}\n"
        f"estimates: {found.estimate}\n"
        f"finds settings for the accuracy asked, {found.default_accuracy:g} unless --accuracy says otherwise; --set fixes them:\n"
        f"{rows.text()}",
    )


@options.command(options.shared("--tag", metavar="TAG", help="Only cases with this tag."), options.json)
def cases(call: Call) -> None:
    """List the cases of the library: name, tags, title."""
    found = qr.list_cases(call.tag)
    call.show([{"name": case.name, "tags": case.tags, "title": case.title} for case in found], repr(found))


@options.command(
    options.cases,
    options.tag,
    options.case_assignments,
    click.option("--for-other-tools", "for_others", is_flag=True, help="Print instead what another tool needs to build the scene."),
    options.json,
)
def show(call: Call, for_others: bool) -> None:
    """Show the scene of CASE and the parts, joints and degrees of freedom that each engine builds.

    The JSON document is in SI; with several cases it is a list.
    """
    if for_others and call.as_json:
        raise click.UsageError("--for-other-tools and --json are both given; what other tools need is a text, give one of them")
    if not for_others:
        get_ready((*DESCRIBING, "quickreturn.engines.exudyn.models"))
    loaded = call.loaded()
    if for_others:
        from quickreturn.reports.other_tools import for_other_tools

        click.echo("\n\n".join(for_other_tools(case, shlex.join(call.arguments_for(case))) for case in loaded))
        return
    from quickreturn.commands.case_document import document_of, models, print_document

    documents = [document_of(case) for case in loaded]
    if call.as_json:
        call.show_each([each | {"engines": [*models(case.scene)]} for case, each in zip(loaded, documents, strict=True)], "")
        return
    for number, (case, document) in enumerate(zip(loaded, documents, strict=True)):
        click.echo("\n" * (number > 0), nl=False)
        print_document(document, case)


@options.command(
    click.argument("file", metavar="FILE"),
    options.single(
        "--from",
        "origin",
        metavar="CASE",
        shell_complete=options.complete_case,
        help="Case of the library, or case file, to copy; default: a small machine with every key.",
    ),
    options.case_assignments,
)
def new(call: Call, file: str, origin: str | None) -> None:
    """Write a case file of your own to FILE, with the meaning of every key beside it.

    The name of the case is that of the file without .toml. Keys that the machine does not use stand there as comments. A file that exists
    is never overwritten.
    """
    from quickreturn.commands.case_document import header_for, text_of

    header = header_for(file)
    original = call.case(origin or EXAMPLE)
    write(file, lambda ending: text_of(original, header, copied=bool(origin)).encode())
    tell_doubts([replace(original, name=header["name"])])
    click.echo("\n".join([f"{file} is written. Change its values, then try", *_next_commands(file, original)]))


def _next_commands(file: str, case: "Case") -> list[str]:
    tried = {"show": "", "plot": ".png", "simulate": ".csv", "run": ""}
    if case.scene.crank is None:
        tried = {"show": "", "simulate": ".csv"}
    outputs = {command: ["--output", str(Path(file).with_suffix(ending))] if ending else [] for command, ending in tried.items()}
    return [f"  {shlex.join(['quickreturn', command, file, *output])}" for command, output in outputs.items()]
