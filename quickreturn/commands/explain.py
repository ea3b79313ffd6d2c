"""`quickreturn explain`: what happens in a turn of a machine."""

from collections.abc import Sequence

import click

from quickreturn.commands import console, options
from quickreturn.commands.console import ExitCode
from quickreturn.computing import Computing
from quickreturn.reports.output import print_json


@click.command(name="explain")
@options.case
@options.single("--engine", metavar="E", default="reference", show_default=True, help="Engine, see `quickreturn engines`.")
@options.accuracy
@options.assignments
@options.of_workshop
@options.json
@options.computing
def explain(case: str, engine: str, accuracy: float | None, assignments: Sequence[str], as_json: bool, computing: Computing) -> int:
    """Say in about ten sentences what happens in a turn of CASE in its steady state, with numbers.

    Each sentence is read off the settled motion that `run` stores; none has a number whose claimed error is as large as itself. The JSON
    document is a list of objects with topic, sentence and numbers in SI. Exit code 3: the engine has no settled turn, or misses its
    accuracy.
    """
    from quickreturn.explanation import explanation

    overrides, settings = options.read_assignments(assignments)
    loaded = options.load(case, overrides)
    options.refuse_missing([engine])
    options.tell_slow([loaded])
    found = explanation(loaded, engine, settings, accuracy, computing)
    if as_json:
        print_json(found.statements)
    else:
        click.echo(repr(found))
    if found.run.ending.delivered:
        return ExitCode.GOOD
    console.tell(f"{loaded.name}: engine {engine} {found.run.status}: {found.run.remark}")
    return ExitCode.ENGINE_TROUBLE
