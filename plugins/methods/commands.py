"""`quickreturn benchmark`: the race of methods in a scene; and `advise`: which method, by the map of classes."""

from collections.abc import Iterator
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
    from quickreturn.plugins.methods.fronts import Standing
    from quickreturn.plugins.methods.race import Race

#: Fields of a row in the document of `advise`.
_ADVISED: Final = ("scene", "engine", "variant", "settings", "level", "status", "solve_seconds", "error", "remark")


@options.command(
    options.cases,
    options.tag,
    options.engines_for(help="Engine to measure; may be given again. Default: the nine engines that the report compares."),
    options.single(
        "--runs",
        metavar="N",
        read=options.number(1, 1000, 32, whole=True),
        default="32",
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
    from dataclasses import replace

    from quickreturn.plugins.methods.compiling import compiling
    from quickreturn.plugins.methods.race import race
    from quickreturn.plugins.methods.signed import read_lines
    from quickreturn.plugins.methods.studies import ENGINES, SCENES, contest

    signed = read_lines(Path(lines)) if lines else ()
    loaded = call.loaded(otherwise=SCENES)
    names = call.engines or ENGINES
    call.refuse_missing()
    _ = [case.mechanism for case in loaded]  # a scene without crank is refused before anything runs
    races, failed, chosen = list["Race"](), False, None
    with workshop(None, call.quiet, loaded, names) as opened:
        if not call.cases and not call.tag:
            compiling(opened, names)  # for the report
        for case in loaded:
            try:
                found = race(case, replace(contest(signed, chosen, names), runs=runs), opened)
            except qr.EngineFailure as failure:  # of the solution that defines errors; the other cases have their own
                tell(f"{case.name}: {failure}")
                failed = True
                continue
            assert found is not None  # this workshop computes
            races.append(found)
            if not (call.cases or call.tag) and case.name == SCENES[0]:
                chosen = found
            if not call.as_json:
                _print(found)
    if call.as_json:
        print_json({"benchmarks": [_as_document(found) for found in races]})
    for found in races:
        for name, reason in found.failures.items():
            tell(f"{found.case}: engine {name} was left out: {reason}")
    if failed or any(found.failures for found in races):
        return ExitCode.ENGINE_TROUBLE
    return ExitCode.BAD_INPUT if call.lost else ExitCode.GOOD


def _print(found: "Race") -> None:
    from quickreturn.plugins.methods.row import REACHED
    from quickreturn.reports.words import settings_words

    other = found.confirmation
    agreed = (
        f"not confirmed: {other.status}" if other.error is None else f"{other.engine} agrees to {other.error:.1e} in the tip deflection"
    )
    click.echo(f"{found.case}: errors against {settings_words(found.truth)}; {agreed}")
    table = []
    for by, level, method, at in _levels(found):
        row = at.row
        numbers = (at.seconds, 1e3), (row.seconds, 1e3), (row.calls, 1.0), (row.call_seconds, 1e6), (row.rows_seconds, 1e3)
        texts = ("-" if value is None else f"{scale * value:.4g}" for value, scale in numbers)
        table.append((by, f"{100.0 * level:g} %", method, *texts, settings_words(row.settings), row.signed))
    times = ("ms at the level", "ms", "right-hand sides", "µs each", "ms for rows")
    print_table(table, ("error of", "to", "method", *times, "first settings below it", "signed by"))
    for row in found.rows:
        if row.level is not None:
            answer = f"{row.answer_seconds or 0.0:.3g} s" if row.status == REACHED else f"{row.status} {row.remark}"
            click.echo(f"{row.engine} asked for {100.0 * row.level:g} %: {answer}")


def _levels(found: "Race") -> "Iterator[tuple[str, float, str, Standing]]":
    """Criterion, level, method, and the method's standing, the fastest first."""
    from quickreturn.plugins.methods.fronts import CRITERIA, standings
    from quickreturn.plugins.methods.row import LEVELS

    for by, level in product(CRITERIA, LEVELS):
        yield from ((by, level, method, at) for method, at in standings(found.given, level, by).items())


def _as_document(found: "Race") -> dict[str, Any]:
    """The race as a document; `points` are its rows, `levels` the time of each method at each level of the error."""
    levels = [
        {"by": by, "level": level, "method": method, "seconds": at.seconds, "calls": at.calls, "first_below": asdict(at.row)}
        for by, level, method, at in _levels(found)
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
    documents = [
        asdict(each)
        | {"reaches": [{key: getattr(row, key) for key in _ADVISED} | {"waited_seconds": row.answer_seconds} for row in each.reaches]}
        for each in found
    ]
    call.show_each(documents, "\n\n".join(map(str, found)))
