"""`quickreturn run`, `compare`, `report` and `check`: settled engines and recorded tables, compared by what they claim."""

import functools
import os
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

import click

from quickreturn.cases.files.errors import as_written
from quickreturn.cases.files.recorded import is_table
from quickreturn.cases.motion.endings import Ending
from quickreturn.commands import options
from quickreturn.commands.console import Call, ExitCode, check_file, tell, tell_slow, write
from quickreturn.pack.check import LARGEST, BadInput, judged
from quickreturn.reports.output import print_json

if TYPE_CHECKING:
    from quickreturn.cases.comparison.engines import CaseResult

PICTURES: Final = (".png", ".svg", ".pdf")
#: Endings of files. With such a name a user expects a page, not a folder.
_OF_FILES: Final = (".html", ".htm", ".csv", ".pdf", ".md", ".json", ".zip", ".parquet")


@options.command(options.cases, options.tag, options.main_engines, options.accuracy, options.assignments, options.of_workshop, options.json)
def run(call: Call) -> int:
    """Bring engines to their steady state on each CASE, measure and compare them.

    Two engines may differ by the sum of their claims: their own error estimates and the uncertainty of the measures. Exit code 1: some
    differ by more. Exit code 2: an engine asked for by name is not installed or cannot model a scene. Exit code 3: an engine failed, was
    stopped at a limit, did not settle or did not reach the accuracy asked, or a default engine is not installed. The other engines go on.
    Each result is stored at once: an interrupted run continues.
    """
    loaded = call.loaded()
    call.refuse_missing()
    import quickreturn as qr
    from quickreturn.cases.files.shown import in_lines
    from quickreturn.verdict_text import as_document, parts_of

    tell_slow(loaded)
    found = qr.run(loaded, call.engines, accuracy=call.accuracy, settings=call.settings)
    if call.as_json:
        print_json(as_document(found.results, found.notices))
        return _exit_code(call, found.results)
    for result in found.results:
        if not all(each.status == Ending.REFUSED for each in result.runs.values()):  # otherwise there is nothing to show
            click.echo(in_lines(parts_of(result)))
    return _exit_code(call, found.results)


@options.command(
    functools.partial(options.case, metavar="[CASE]"),
    click.argument("files", metavar="FILE...", nargs=-1),
    options.engines_for(help="Engine to compare with; may be given again. Default: the four main engines."),
    options.accuracy,
    options.assignments,
    options.table_options,
    click.option(
        "--write-mapping",
        "writes_mapping",
        is_flag=True,
        help="Write what each heading is to a file beside FILE, for you to edit; it is read with FILE from then on.",
    ),
    options.output("File for a picture of tables and engines: .png, .svg or .pdf.", "PICTURE", required=False),
    options.of_workshop,
    options.json,
)
def compare(call: Call, files: Sequence[str], writes_mapping: bool, **reading: Any) -> int:
    """Measure recorded tables of CASE and compare them with engines.

    A FILE is a table with `time` and any columns of a trajectory, units in the headings ("tip_deflection [mm]"; none: SI), from another
    tool, an earlier version or a test rig. Separator, decimal sign, comments and a row of units are recognised; --separator, --decimal and
    --skip say what is not, --column names the columns of other programs. `quickreturn show CASE --for-other-tools` says what to record. A
    table that begins in the standard start and has not settled is compared with the engines in the same turn of the crank, any other table
    in the steady state. Two files without a CASE are compared column by column in the rows at the same instants: the second one counts as
    right, and nothing is judged.

    The only claim for a table is the uncertainty of its measures. Exit code 1: it departs from an engine by more than this uncertainty and
    the engine's own estimate. Exit codes 2 and 3 are those of `run`.
    """
    if not files:
        raise click.UsageError("give a CASE and a FILE, or two FILEs", click.get_current_context())
    if writes_mapping:
        return options.write_mapping(files, reading)
    if is_table(call.cases[0]):
        return _two_tables(call, [*call.cases, *files], reading)
    loaded = call.case()
    call.refuse_missing()
    check_file(call.output, loaded.source, PICTURES)
    from quickreturn.cases.files.shown import in_lines
    from quickreturn.table_comparison import compared, parts_of_tables, tables_in
    from quickreturn.verdict_text import as_document

    results = compared(loaded, options.read_tables(files, reading), call.engines, accuracy=call.accuracy, settings=call.settings)
    tables_of = [tables_in(result) for result in results]
    if call.as_json:
        document = as_document(results, [] if call.store is None else call.store.notices)
        for entry, each in zip(document["cases"], tables_of, strict=True):
            for key, name in (("differences", "differences"), ("places", "places"), ("slips", "explanations")):
                entry[key] = {table.name: getattr(table, name) for table in each}
        print_json(document)
    else:
        click.echo("\n".join(in_lines(parts_of_tables(result, each)) for result, each in zip(results, tables_of, strict=True)))
    if call.output:
        from quickreturn.reports.drawing.cycle import draw
        from quickreturn.reports.drawing.style import picture

        write(call.output, lambda ending: picture(draw(results), ending))
    return _exit_code(call, results)


def _two_tables(call: Call, files: Sequence[str], reading: Mapping[str, Any]) -> int:
    """The differences of two tables. UsageError: there are more, or options that only a comparison with engines has."""
    given = {"--engine": call.engines, "--accuracy": call.accuracy, "--set": call.overrides or call.settings, "--output": call.output}
    if len(files) != 2 or any(given.values()):
        told = ", ".join([f"{len(files)} files"] * (len(files) != 2) + [option for option, value in given.items() if value])
        raise click.UsageError(f"{told}: without a CASE two files are compared, without engines or a picture; give the CASE first")
    from quickreturn.table_comparison import difference

    found = difference(*options.read_tables(files, reading))
    document = {"relative": dict(found), "absolute": found.absolute, "rows": found.rows, "step": found.step}
    call.show(document, str(found))
    return ExitCode.GOOD


def _exit_code(call: Call, results: "Sequence[CaseResult]") -> int:
    """The exit code; runs without a result are named on standard error."""
    results = [result.with_tables for result in results]
    failed = _failed(results)
    by_name = [(result.case.name, each) for result in results for each in result.runs.values() if call.engines]
    refused = [(name, each) for name, each in by_name if each.status == Ending.REFUSED]
    for name, each in refused:
        tell(f"{name}: engine {each.engine}: {each.remark}")
    if refused:
        return ExitCode.BAD_INPUT
    if failed:
        return ExitCode.ENGINE_TROUBLE
    if call.lost:
        return ExitCode.BAD_INPUT
    return ExitCode.CLAIMS_BROKEN if any(result.missed for result in results) else ExitCode.GOOD


def _failed(results: "Sequence[CaseResult]") -> bool:
    """Whether an engine or a table did not deliver; each is named on standard error."""
    failures = [(result.case.name, run) for result in results for run in result.failures]
    for case, run in failures:
        tell(f"{case}: {'table' if run.recording else 'engine'} {run.engine} {run.status}: {run.remark}")
    return bool(failures)


def _folder(option: str, text: str) -> str:
    """The path as given. UsageError: it is empty, or it looks like that of a file and no such folder exists."""
    if not text.strip() or (text.lower().endswith(_OF_FILES) and not os.path.isdir(text)):
        raise click.UsageError(f"{option} {as_written(text)}: give a folder, the page in it is index.html")
    return text


@options.command(
    options.cases,
    options.tag,
    options.main_engines,
    options.accuracy,
    options.engine_assignments,
    options.output("Folder of the page and its tables.", "DIR", required=False, default="reports/output", show_default=True, read=_folder),
    options.of_workshop,
)
def report(call: Call) -> int:
    """Write the report on each CASE; without one, on the 24 runs of the thesis.

    A slow engine is quicker with coarser settings (--set my-engine.links=8) or to a lower accuracy (--accuracy 0.05).

    Exit code 0: the page is written, and every engine completed and reached its accuracy; the page shows where engines disagree. Exit code
    3: an engine failed, was stopped at a limit, did not settle or missed its accuracy, or a default engine is not installed; the page is
    still written and shows it. Each result is stored at once: an interrupted report continues where it stopped.
    """
    loaded = call.loaded(otherwise=("thesis-*",))
    call.refuse_missing()
    from quickreturn.cross_validation import written_report

    tell_slow(loaded)
    written = written_report(loaded, str(call.output), call.engines, accuracy=call.accuracy, settings=call.settings)
    click.echo(written.summary)
    if _failed([result.with_tables for result in written.content.results]):
        return ExitCode.ENGINE_TROUBLE
    return ExitCode.BAD_INPUT if call.lost else ExitCode.GOOD


@options.command(
    click.argument("problem", metavar="PROBLEM"),
    click.argument("file", metavar="FILE"),
    options.single(
        "--share",
        metavar="REL",
        read=options.number(0.0, LARGEST, 1e-3),
        default="0",
        show_default=True,
        help="Part of each signal's largest value that is added to its bound.",
    ),
    options.json,
)
def check(call: Call, problem: str, file: str, share: float) -> int:
    """Judge a table by the reference results of PROBLEM.

    A PROBLEM is a folder of the pack, such as sag or thesis-24; its problem.md says what to compute. FILE is a CSV table with `time` and
    names of signals in its first line, in SI units. Each signal is within its bound, outside, beyond the horizon or missing.

    Exit code 1: a signal is outside.
    """
    try:
        verdicts = judged(problem, Path(file), share)
    except BadInput as wrong:
        raise click.ClickException(str(wrong)) from None
    document = {"problem": problem, "signals": [each._asdict() for each in verdicts]}
    call.show(document, "\n".join(f"{each.signal:18} {each.status:18} {each.told}".rstrip() for each in verdicts))
    return ExitCode.CLAIMS_BROKEN if any(each.status == "outside" for each in verdicts) else ExitCode.GOOD
