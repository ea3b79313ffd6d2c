"""`quickreturn advise`: which method for a machine, by the recorded map of classes."""

from dataclasses import asdict
from typing import Final

from quickreturn.commands import options
from quickreturn.commands.console import Call, tell_doubts
from quickreturn.computing import HIGHEST, LOWEST
from quickreturn.plugins.methods.advice import advise as advice

#: What the document says of an engine.
_KEYS: Final = ("scene", "engine", "level", "status", "solve_seconds", "waited_seconds", "error", "remark")


@options.command(
    options.cases,
    options.tag,
    options.accuracy_of(default="0.01", show_default=True, help=f"Wanted relative error of the tip deflection, {HIGHEST:g} to {LOWEST:g}."),
    options.case_assignments,
    options.json,
)
def advise(call: Call) -> None:
    """Say where CASE lies on the map of classes, and which methods were the fastest there to an error.

    The map was recorded: one turn of the crank from the standard start, by every engine, in scenes that cover the dimensionless groups.
    Nothing is simulated. The output names each quantity that lies outside the map. With several cases the JSON document is a list.
    """
    loaded = call.loaded()
    found = [advice(case, call.accuracy or 0.01) for case in loaded]
    tell_doubts(loaded)
    documents = [asdict(each) | {"reaches": [{key: getattr(trial, key) for key in _KEYS} for trial in each.reaches]} for each in found]
    call.show_each(documents, "\n\n".join(map(str, found)))
