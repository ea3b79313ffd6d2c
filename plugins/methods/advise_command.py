"""`quickreturn advise`: which method for a machine, by the recorded map of classes."""

from collections.abc import Sequence
from dataclasses import asdict
from typing import Final

import click

from quickreturn.accuracy import HIGHEST, LOWEST
from quickreturn.commands import options
from quickreturn.plugins.methods.advice import advise as advice
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
    found = [advice(case, accuracy) for case in loaded]
    options.tell_doubts(loaded)
    if as_json:
        documents = [asdict(each) | {"reaches": [{key: getattr(trial, key) for key in _KEYS} for trial in each.reaches]} for each in found]
        print_json(documents[0] if len(documents) == 1 else documents)
    else:
        click.echo("\n\n".join(map(str, found)))
