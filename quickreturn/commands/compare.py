"""`quickreturn compare`: measures recorded tables like an engine's cycle and compares them with engines."""

from collections.abc import Sequence
from pathlib import Path
from typing import Final

import click

from quickreturn.cases.shown import in_lines
from quickreturn.commands import options
from quickreturn.reports.output import check_writable, print_json, write_file

PICTURES: Final = (".png", ".svg", ".pdf")


@click.command(name="compare")
@options.case
@click.argument("files", metavar="FILE...", nargs=-1, required=True)
@options.engines_for(help="Engine to compare with; may be given again. Default: the four main engines.")
@options.accuracy
@options.assignments
@options.single("--output", metavar="PICTURE", help="File for a picture of tables and engines: .png, .svg or .pdf.")
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
    """Measure recorded tables of CASE and compare them with engines.

    A FILE is a CSV table with `time` and any columns of a trajectory, units in the headings ("tip_deflection [mm]"; none: SI), from
    another tool, an earlier version or a test rig; `quickreturn show CASE --for-other-tools` says what to record. A table that begins in
    the standard start and has not settled is compared with the engines in the same turn of the crank, any other table in the steady state.

    The only claim for a table is the uncertainty of its measures. Exit code 1: it departs from an engine by more than this uncertainty and
    the engine's own estimate. Exit codes 2 and 3 are those of `run`.
    """
    from quickreturn.cases.recorded import read_table
    from quickreturn.cases.runs.campaign import hold_against_engines
    from quickreturn.commands.verdicts import as_document, exit_code
    from quickreturn.engine_choice import prepared
    from quickreturn.table_comparison import parts_of_tables, refuse_same_names, tables_in

    overrides, settings = options.read_assignments(assignments)
    loaded = options.load(case, overrides)
    names, texts, others = prepared([loaded], engines, settings)
    options.refuse_missing(names if engines else ())
    if output is not None:
        check_writable(Path(output), loaded.source, *PICTURES)
    tables = [*others.get(loaded.name, ()), *map(read_table, dict.fromkeys(files))]
    refuse_same_names(names, tables)
    workshop = options.opened_workshop([loaded], names)
    results = hold_against_engines(loaded, tables, workshop, names, accuracy, texts)
    if as_json:
        document = as_document(results, workshop.store.notices)
        for entry, result in zip(document["cases"], results, strict=True):
            held = {table.name: table for table in tables_in(result)}
            entry["differences"] = {name: table.differences for name, table in held.items()}
            entry["slips"] = {name: table.explanations for name, table in held.items()}
        print_json(document)
    else:
        for result in results:
            click.echo(in_lines(parts_of_tables(result, tables_in(result))))
    if output:
        from quickreturn.reports.drawing.recorded import drawn

        write_file(Path(output), drawn(results, Path(output).suffix.lower()))
    return exit_code(results, workshop, engines)
