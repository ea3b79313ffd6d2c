"""`quickreturn run` and `compare`: engines, and recorded tables, measured and compared by what they claim."""

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

import click

from quickreturn.cases.displayed import in_lines
from quickreturn.cases.runs.endings import Ending
from quickreturn.commands import console, options, tables
from quickreturn.commands.console import ExitCode
from quickreturn.computing import Computing
from quickreturn.reports.output import check_writable, print_json, write_file

if TYPE_CHECKING:
    from quickreturn.cases.runs.comparison import CaseResult

PICTURES: Final = (".png", ".svg", ".pdf")


@click.command(name="run")
@options.cases
@options.tag
@options.main_engines
@options.accuracy
@options.assignments
@options.of_workshop
@options.json
@options.computing
def run(
    cases: Sequence[str],
    tag: str | None,
    engines: Sequence[str],
    accuracy: float | None,
    assignments: Sequence[str],
    as_json: bool,
    computing: Computing,
) -> int:
    """Bring engines to their steady state on each CASE, measure and compare them.

    Two engines may differ by the sum of their claims: their own error estimates and the uncertainty of the measures. Exit code 1: some
    differ by more. Exit code 2: an engine asked for by name is not installed or cannot model a scene. Exit code 3: an engine failed, was
    stopped at a limit, did not settle or did not reach the accuracy asked, or a default engine is not installed. The other engines go on.
    Each result is stored at once: an interrupted run continues.
    """
    overrides, settings = options.read_assignments(assignments)
    loaded = options.load_all(cases, tag, overrides)
    options.refuse_missing(engines)
    from quickreturn.cross_validation import validated
    from quickreturn.verdict_text import as_document, parts_of

    options.tell_slow(loaded)
    found = validated(loaded, engines, settings, accuracy, computing)
    if as_json:
        print_json(as_document(found.results, found.notices))
    else:
        for result in found.results:
            if not all(each.status == Ending.REFUSED for each in result.runs.values()):  # otherwise there is nothing to show
                click.echo(in_lines(parts_of(result)))
    return _exit_code(found.results, engines)


@click.command(name="compare")
@options.case
@click.argument("files", metavar="FILE...", nargs=-1, required=True)
@options.engines_for(help="Engine to compare with; may be given again. Default: the four main engines.")
@options.accuracy
@options.assignments
@tables.options
@click.option(
    "--write-mapping",
    "writes_mapping",
    is_flag=True,
    help="Write what each heading is to a file beside FILE, for you to edit; it is read with FILE from then on.",
)
@options.single("--output", metavar="PICTURE", help="File for a picture of tables and engines: .png, .svg or .pdf.")
@options.of_workshop
@options.json
@options.computing
def compare(
    case: str,
    files: Sequence[str],
    engines: Sequence[str],
    accuracy: float | None,
    assignments: Sequence[str],
    reading: Mapping[str, Any],
    writes_mapping: bool,
    output: str | None,
    as_json: bool,
    computing: Computing,
) -> int:
    """Measure recorded tables of CASE and compare them with engines.

    A FILE is a table with `time` and any columns of a trajectory, units in the headings ("tip_deflection [mm]"; none: SI), from another
    tool, an earlier version or a test rig. Separator, decimal sign, comments and a row of units are recognised; --separator, --decimal and
    --skip say what is not, --column names the columns of other programs. `quickreturn show CASE --for-other-tools` says what to record. A
    table that begins in the standard start and has not settled is compared with the engines in the same turn of the crank, any other table
    in the steady state.

    The only claim for a table is the uncertainty of its measures. Exit code 1: it departs from an engine by more than this uncertainty and
    the engine's own estimate. Exit codes 2 and 3 are those of `run`.
    """
    overrides, settings = options.read_assignments(assignments)
    loaded = options.load(case, overrides)
    options.refuse_missing(engines)
    if writes_mapping:
        return tables.write_mapping(files, reading)
    if output is not None:
        check_writable(Path(output), loaded.source, *PICTURES)
    from quickreturn.table_comparison import compared, parts_of_tables, tables_in
    from quickreturn.verdict_text import as_document

    results = compared(loaded, tables.read(files, reading), engines, settings, accuracy, computing)
    if as_json:
        document = as_document(results, console.call().notices)
        for entry, result in zip(document["cases"], results, strict=True):
            held = {table.name: table for table in tables_in(result)}
            entry["differences"] = {name: table.differences for name, table in held.items()}
            entry["places"] = {name: table.places for name, table in held.items()}
            entry["slips"] = {name: table.explanations for name, table in held.items()}
        print_json(document)
    else:
        for result in results:
            click.echo(in_lines(parts_of_tables(result, tables_in(result))))
    if output:
        from quickreturn.reports.drawing.cycle import drawn

        write_file(Path(output), drawn(results, Path(output).suffix.lower()))
    return _exit_code(results, engines)


def _exit_code(results: "Sequence[CaseResult]", engines: Sequence[str]) -> int:
    """The exit code; runs without a result are named on standard error. `engines`: those asked for by name."""
    results = [result.with_tables for result in results]
    for result in results:
        for each in result.failures:
            console.tell(f"{result.case.name}: {'table' if each.recording else 'engine'} {each.engine} {each.status}: {each.remark}")
    refused = [(result.case.name, each) for result in results for each in result.runs.values() if engines and each.status == Ending.REFUSED]
    for name, each in refused:
        console.tell(f"{name}: engine {each.engine}: {each.remark}")
    if refused:
        return ExitCode.BAD_INPUT
    if any(result.failures for result in results):
        return ExitCode.ENGINE_TROUBLE
    if console.call().lost:
        return ExitCode.BAD_INPUT
    return ExitCode.CLAIMS_BROKEN if any(result.missed for result in results) else ExitCode.GOOD
