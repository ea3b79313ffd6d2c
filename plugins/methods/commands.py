"""`quickreturn benchmark`: the race of methods in a scene; and `advise`: which method, by the map of classes."""

from dataclasses import asdict
from itertools import product
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

import click

import quickreturn as qr
from quickreturn.commands import options
from quickreturn.commands.console import Call, ExitCode, tell, tell_doubts
from quickreturn.computing import HIGHEST, LOWEST, workshop
from quickreturn.reports.output import print_json, print_table

if TYPE_CHECKING:
    from quickreturn.plugins.methods.race import Race
    from quickreturn.plugins.methods.row import Row

#: Fields of a row in the document of `advise`.
_ADVISED: Final = ("scene", "engine", "variant", "settings", "level", "status", "solve_seconds", "error", "remark")


@options.command(
    options.cases,
    options.tag,
    options.engines_for(help="Engine to measure; may be given again. Default: the nine engines that the report compares."),
    options.single(
        "--runs",
        metavar="N",
        read=options.number(1, 1000, 40, whole=True),
        default="40",
        show_default=True,
        help="Runs for each combination of an engine's choices, at most.",
    ),
    options.single("--lines", metavar="FILE", help="File with settings that somebody signs, written like SIGNED.toml of this project."),
    options.case_assignments,
    options.limited,
    options.json,
)
def benchmark(call: Call, runs: int, lines: str | None) -> int:
    """Find what each method needs for an error, in seconds and evaluations, from the standard start of each CASE.

    A method is an engine with one of its choices of shapes, joint and integrator. The settings are searched for, with as many runs for each
    method as for any other. Without a CASE the scenes are those on which the report compares methods, and the settings chosen in the first
    one are tried in the others, too.

    Exit code 3: the solution that defines the error could not be computed, an engine died or was stopped at a limit, or a default
    engine is not installed; the others are still measured. Settings with which an engine reports a failure are listed, but are not an
    error.
    """
    from quickreturn.plugins.methods.race import Contest, Race
    from quickreturn.plugins.methods.signed import read_lines
    from quickreturn.plugins.methods.studies import ENGINES, SCENES, fronts

    wanted = Contest(tuple(call.engines or ENGINES), runs=runs, lines=read_lines(Path(lines)) if lines else ())
    loaded = call.loaded(otherwise=SCENES)
    call.refuse_missing()
    _ = [case.mechanism for case in loaded]  # a scene without crank is refused before anything runs
    races, failed = list[Race](), False
    with workshop(None, call.quiet, loaded, wanted.engines) as opened:
        for case, found in fronts(opened, wanted, loaded, carries=not (call.cases or call.tag)):
            if not isinstance(found, Race):  # there is no solution that defines errors; the other cases have their own
                tell(f"{case.name}: {found}")
                failed = True
                continue
            races.append(found)
            if not call.as_json:
                _print(found)
            for name, reason in found.failures.items():
                tell(f"{found.case}: engine {name} was left out: {reason}")
    if call.as_json:
        print_json({"benchmarks": [_as_document(found) for found in races]})
    if failed or any(found.failures for found in races):
        return ExitCode.ENGINE_TROUBLE
    return ExitCode.BAD_INPUT if call.lost else ExitCode.GOOD


def _print(found: "Race") -> None:
    from quickreturn.plugins.methods.chapters.methods import fastest, waiting
    from quickreturn.plugins.methods.fronts import CRITERIA

    other = found.confirmation
    agreed = f"agrees to {other.error:.1e} in the tip deflection" if other.error is not None else f"does not confirm it: {other.status}"
    click.echo(f"{found.case}: {other.engine} {agreed}")
    tables = {f"by {by}": fastest([found], by) for by in CRITERIA}
    tables["asked"] = waiting([row for row in found.rows if row.level is not None])
    for name, table in tables.items():
        shown = table.shown[1:]  # without the scene
        heads = [f"{column.page_head} {column.page_unit}".strip() for column in shown]
        print_table([[name, *(table.page_text(row, column) for column in shown)] for row in table.rows], ["", *heads])


def _as_document(found: "Race") -> dict[str, Any]:
    """The race as a document; `points` are its rows, `levels` the time of each method at each level of the error."""
    from quickreturn.plugins.methods.fronts import CRITERIA, standings
    from quickreturn.plugins.methods.row import LEVELS

    levels = [
        {"by": by, "level": level, "method": method, "seconds": at.seconds, "calls": at.calls, "first_below": asdict(at.row)}
        for by, level in product(CRITERIA, LEVELS)
        for method, at in standings(found.given, level, by).items()
    ]
    document = asdict(found)
    del document["rows"]
    return document | {"points": [{"method": row.method} | asdict(row) for row in found.rows], "levels": levels}


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
    found = [qr.advise(case, call.accuracy or 0.01) for case in loaded]
    tell_doubts(loaded)
    documents = [asdict(each) | {"reaches": [_reached(row) for row in each.reaches]} for each in found]
    call.show_each(documents, "\n\n".join(map(str, found)))


def _reached(row: "Row") -> dict[str, Any]:
    return {key: getattr(row, key) for key in _ADVISED} | {"waited_seconds": row.answer_seconds}
