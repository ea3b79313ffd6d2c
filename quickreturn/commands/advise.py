"""`quickreturn advise` and `explain`: which method for a machine, by the recorded map of classes; what happens in a turn of it."""

from collections.abc import Sequence
from dataclasses import asdict
from typing import Final

import click

import quickreturn as qr
from quickreturn.accuracy import HIGHEST, LOWEST
from quickreturn.commands import console, options
from quickreturn.commands.console import ExitCode
from quickreturn.computing import Computing
from quickreturn.reports.output import print_json

#: What the document says of an engine.
_KEYS: Final = ("scene", "engine", "level", "status", "solve_seconds", "waited_seconds", "error", "remark")


@click.command(name="advise")
@options.cases
@options.tag
@options.accuracy_of(default="0.01", show_default=True, help=f"Wanted relative error of the tip deflection, {HIGHEST:g} to {LOWEST:g}.")
@options.case_assignments
@options.json
def advise(cases: Sequence[str], tag: str | None, accuracy: float, assignments: Sequence[str], as_json: bool) -> None:
    """Say where CASE lies on the map of classes, and which methods were the fastest there to an error.

    The map was recorded: one turn of the crank from the standard start, by every engine, in scenes that cover the dimensionless groups.
    Nothing is simulated. The output names each quantity that lies outside the map. With several cases the JSON document is a list.
    """
    loaded = options.load_all(cases, tag, options.read_overrides(assignments))
    found = [qr.advise(case, accuracy) for case in loaded]
    options.tell_doubts(loaded)
    if as_json:
        documents = [asdict(each) | {"reaches": [{key: getattr(trial, key) for key in _KEYS} for trial in each.reaches]} for each in found]
        print_json(documents[0] if len(documents) == 1 else documents)
    else:
        click.echo("\n\n".join(map(str, found)))


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
    from quickreturn.studies.explanation import explanation

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
