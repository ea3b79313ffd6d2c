"""`quickreturn simulate`: one trajectory of one engine, from the standard start, as a CSV file; or of several."""

import itertools
import shlex
from collections.abc import Mapping, Sequence
from pathlib import Path, PurePath
from typing import TYPE_CHECKING, Any

import click

from quickreturn.cases.jobs.fork_server import COMPUTING, get_ready
from quickreturn.commands import console, options
from quickreturn.commands.console import ExitCode
from quickreturn.computing import Computing
from quickreturn.reports.output import check_writable, print_json, print_table

if TYPE_CHECKING:
    from quickreturn.cases.case import Case
    from quickreturn.commands.answers import Found


@click.command(name="simulate")
@options.cases
@options.tag
@options.engines
@options.duration
@options.single("--output-step", metavar="S", read=options.seconds, help='Time between rows, "1 ms" or a number of seconds.')
@options.accuracy
@click.option("--no-estimate", is_flag=True, help="Make one run without an error estimate.")
@options.assignments
@options.output(
    "File for the trajectory. For several engines or cases put {engine} or {case} into its name. Default: nothing is written.",
    "FILE.csv",
    required=False,
)
@options.limited
@options.stored
@options.json
@options.computing
def simulate(
    cases: Sequence[str],
    tag: str | None,
    engines: Sequence[str],
    duration: float | None,
    output_step: float | None,
    accuracy: float | None,
    no_estimate: bool,
    assignments: Sequence[str],
    output: str | None,
    as_json: bool,
    computing: Computing,
) -> int:
    """Simulate CASE from the standard start; with --output, write the trajectory.

    Exit code 3: the engine failed, did not reach the accuracy, or cannot say whether it did, because its error estimate is unknown or not
    verified; the file has the rows that it delivered. An engine that crashed or was stopped at a limit delivers none. Runs for the error
    estimate that could exceed --time-limit are not begun. The accuracy of `thesis` is that of the integration of its own equations. With
    several engines or cases the JSON document is a list.
    """
    if no_estimate and accuracy is not None:
        raise click.UsageError(
            f"--accuracy {accuracy:g} and --no-estimate are both given; the estimate alone shows what is reached, give one of them"
        )
    overrides, settings = options.read_assignments(assignments)
    get_ready(COMPUTING)  # what it imports takes longer than what this process does
    from quickreturn.commands.answers import NOTHING, solved, written

    loaded = options.load_all(cases, tag, overrides, duration, output_step)
    places = _places(output, loaded, engines)
    for case, name in itertools.product(loaded, engines):
        if (file := places[case.name, name]) is not None:
            check_writable(Path(file), case.source, ".csv")
    documents: list[dict[str, Any]] = []
    refusal: Exception | None = None
    for case, name, outcome, found in solved(loaded, engines, settings, accuracy, computing, not no_estimate):
        try:
            known = written(outcome, found, places[case.name, name])
        except Exception as error:  # the results of the others are written before the error is raised
            refusal = refusal or error
            continue
        if documents and not as_json:
            click.echo()
        document = {"case": case.name, "engine": name, "output": places[case.name, name], "notes": case.notes, "accuracy": accuracy}
        documents.append(document | NOTHING | known)
        if not as_json:
            _print(documents[-1], found, shlex.join(["quickreturn", "show", *options.given_as(case, overrides)]))
    if as_json and documents:
        print_json(documents[0] if len(places) == 1 else documents)
    elif documents and output is None:
        click.echo(f"no trajectory is written; --output {_example(loaded, engines)} writes {'it' if len(places) == 1 else 'them'}")
    missed = [document for document in documents if not document["reached"]]
    for document in missed:
        kept = "there is nothing to keep"
        if document["rows"]:
            kept = f"{document['rows']} rows are kept {f'in {place}' if (place := document['output']) else 'only with --output'}"
        console.tell(f"{document['case']}: engine {document['engine']}: {document['remark']}; {kept}")
    if refusal is not None:
        raise refusal
    return ExitCode.ENGINE_TROUBLE if missed else ExitCode.GOOD


def _places(output: str | None, cases: "Sequence[Case]", engines: Sequence[str]) -> dict[tuple[str, str], str | None]:
    """The file of each case and engine, if one is to be written. UsageError: two would have the same file."""
    if output is None:
        return dict.fromkeys((case.name, engine) for case in cases for engine in engines)
    for what, several in (("{engine}", engines), ("{case}", cases)):
        if len(several) > 1 and what not in output:
            raise click.UsageError(f"--output {output}: several {what[1:-1]}s would write the same file; put {what} into its name")
    names = {engine: PurePath(engine).name for engine in engines}  # of an engine's file the name without its folder
    if twice := next((engine for engine in engines if list(names.values()).count(names[engine]) > 1), None):
        raise click.UsageError(f"--output {output}: two engines are called {names[twice]}; simulate one after the other")
    return {
        (case.name, each): output.replace("{engine}", name).replace("{case}", case.name) for case in cases for each, name in names.items()
    }


def _example(cases: "Sequence[Case]", engines: Sequence[str]) -> str:
    """A value of --output for some cases and engines."""
    return f"{cases[0].name if len(cases) == 1 else '{case}'}{'-{engine}' if len(engines) > 1 else ''}.csv"


def _print(document: Mapping[str, Any], found: "Found", notes: str) -> None:
    """A simulation as a table; `notes`: the command that shows those on the case."""
    if isinstance(found, Exception):
        rows = [("case", document["case"]), ("engine", f"{document['engine']} ({document['version'] or 'version unknown'})")]
        if document["notes"]:
            rows.append(("notes", f"{len(document['notes'])} on this case: see `{notes}`"))
    else:
        told = found.reached or found.result.error_estimate is None  # otherwise standard error says why not
        rows = [row for row in found.rows(document["output"] or "", f"`{notes}`") if told or row[0] != "remark"]
    print_table(rows)
