"""`quickreturn compare`: recorded tables measured like an engine's cycle and held against engines."""

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Final

import click

from quickreturn.commands import options

if TYPE_CHECKING:
    from cases.runs.comparison import CaseResult
    from cases.runs.request import Run

PICTURES: Final = (".png", ".svg", ".pdf")


@click.command(name="compare")
@options.case
@click.argument("files", metavar="FILE...", nargs=-1, required=True)
@options.engines_for(help="Engine to hold against; may be given again. Default: the four main ones.")
@options.accuracy
@options.assignments
@options.single("--output", metavar="PICTURE", help="Draw it: .png, .svg or .pdf.")
@options.of_workshop
@options.json
def command(
    case: str,
    files: Sequence[str],
    engines: Sequence[str],
    accuracy: float | None,
    assignments: Sequence[str],
    output: str | None,
    as_json: bool,
) -> int:
    """Measure recorded tables of CASE and hold them against engines.

    A FILE is a CSV table with `time` and any columns of a trajectory, units in the headings ("tip_deflection [mm]"; none: SI), from
    another tool, an earlier version or a test rig; `quickreturn show CASE --for-other-tools` says what to record. One that begins in the
    standard start and has not settled is held against the engines in the same turn of the crank, any other in the steady state.

    Nothing is claimed of a table but the uncertainty of its measures. Exit code 1: it departs from an engine by more than that and the
    engine's own estimate. Exit codes 2 and 3 are those of `run`.
    """
    from cases.recorded import read_table
    from cases.runs.comparison import hold_against_engines
    from quickreturn.catalogue import prepared
    from quickreturn.commands.run import as_document, exit_code
    from reports.output import check_writable, print_json

    overrides, settings = options.read_assignments(assignments)
    loaded = options.load(case, overrides)
    names, texts, others = prepared([loaded], engines, settings)
    options.refuse_missing(names if engines else ())
    if output is not None:
        check_writable(Path(output), "" if loaded.source == "library" else case, *PICTURES)
    tables = [*others.get(loaded.name, ()), *map(read_table, dict.fromkeys(files))]
    called = [*names, *(table.name for table in tables)]
    for name in called:
        if called.count(name) > 1:
            raise click.UsageError(f'two tables or engines are called "{name}"; give each file a name of its own')
    workshop = options.opened_workshop([loaded], names)
    results = hold_against_engines(loaded, tables, workshop, names, accuracy, texts)
    if as_json:
        document = as_document(results, workshop.store.notices)
        for entry, result in zip(document["cases"], results, strict=True):
            entry["differences"], entry["slips"] = {name: {} for name in result.recorded}, _mistakes(result)
            for (table, engine), found in _differences(result).items():
                entry["differences"][table][engine] = found
        print_json(document)
    else:
        _print(results)
    if output:
        from reports.output import write_file
        from reports.plots.recorded import drawn

        write_file(Path(output), drawn(results, Path(output).suffix.lower()))
    return exit_code(results, workshop, engines)


def _pairs(result: "CaseResult") -> "list[tuple[Run, Run]]":
    """Each table with each engine that it can be held against."""
    return [(run, other) for run in result.recorded.values() for other in result.runs.values() if run.usable and other.usable]


def _differences(result: "CaseResult") -> dict[tuple[str, str], dict[str, float]]:
    """Table and engine -> column -> relative RMS difference in the turn that is compared."""
    from cases.runs.differences import column_differences

    return {(run.engine, other.engine): column_differences(run, other) for run, other in _pairs(result)}


def _mistakes(result: "CaseResult") -> dict[str, dict[str, str]]:
    """Table -> column -> the mistake that would explain its difference from the engine that it is held against first."""
    from cases.runs.differences import explanations

    return {run.engine: explanations(run, other, result.case) for run, other in reversed(_pairs(result))}


def _print(results: "Sequence[CaseResult]") -> None:
    from quickreturn.verdict_text import text_of
    from reports.output import print_table

    for result in results:
        click.echo(text_of(result))
        differences = _differences(result)
        columns = dict.fromkeys(name for found in differences.values() for name in found)
        if columns:
            alone = len(result.recorded) == 1
            heads = [engine if alone else f"{table} - {engine}" for table, engine in differences]
            rows = [[f"  {name}", *(f"{found[name]:.1e}" if name in found else "-" for found in differences.values())] for name in columns]
            click.echo("  RMS difference in this turn, over the engine's RMS:")
            print_table(rows, ("", *heads))
        for table, found in _mistakes(result).items():
            for told in found.values():
                click.echo(f"  {table}: {told}")
