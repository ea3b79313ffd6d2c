"""`quickreturn simulate`: one trajectory of one engine, from the standard start, as a CSV file."""

from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

import click

from reports.commands.options import (
    accuracy_option,
    case_argument,
    engine_option,
    json_option,
    limits,
    load,
    memory_limit_option,
    path_given,
    read_assignments,
    set_option,
    single_option,
    time_limit_option,
)


@click.command(name="simulate")
@case_argument
@engine_option
@single_option("--duration", metavar="S", help='Time to simulate, "2 s" or a number of seconds; a multiple of the output step.')
@single_option("--output-step", metavar="S", help='Time between rows, "1 ms" or a number of seconds.')
@accuracy_option
@set_option
@single_option("--output", metavar="FILE.csv", required=True, callback=path_given, help="Where the trajectory goes, as CSV.")
@time_limit_option
@memory_limit_option
@json_option
def command(
    case: str,
    engine: str,
    duration: str | None,
    output_step: str | None,
    accuracy: float | None,
    assignments: Sequence[str],
    output: str,
    time_limit: str | None,
    memory_limit: str | None,
    as_json: bool,
) -> int:
    """Simulate CASE from the standard start and write the trajectory.

    Exit code 3: the engine failed, did not reach the accuracy, or cannot say that it reached the one asked for, because its error
    estimate is unknown or not verified; the rows that it delivered are in the file. One that crashed or was stopped at a limit delivers
    none. The accuracy of `thesis` is that of the integration of its own equations.
    """
    from reports import engine_jobs
    from reports.command_line import ENGINE_TROUBLE, GOOD
    from reports.output import check_writable, print_json

    overrides, settings = read_assignments(assignments)
    loaded = load(case, overrides, duration, output_step)
    allowed = limits(time_limit, memory_limit)
    check_writable(Path(output), keep="" if loaded.source == "library" else case, ending=".csv")
    document = engine_jobs.simulate(engine, loaded, settings, accuracy, output, allowed)
    if as_json:
        print_json(document)
    else:
        _print(document)
    if document["reached"]:
        return GOOD
    click.echo(f"quickreturn: {loaded.name}: engine {engine}: {document['remark']}{_kept(document)}", err=True)
    return ENGINE_TROUBLE


def _kept(document: dict[str, Any]) -> str:
    return f"; {document['rows']} rows are kept in {document['output']}" if document["rows"] else "; there is nothing to keep"


def _print(document: dict[str, Any]) -> None:
    from reports.output import print_table

    rows = [("case", document["case"]), ("engine", f"{document['engine']} ({document.get('version', 'version unknown')})")]
    if document["notes"]:
        rows.append(("notes", f"{len(document['notes'])} on this case: see `quickreturn show {document['case']}`"))
    if document["failure"] is None:
        times = " + ".join(f"{document[f'{part}_seconds']:.3g} s {part}" for part in ("compile", "setup", "solve", "estimate"))
        rows += [
            ("rows", f"{document['rows']} in {document['output']}"),
            *_estimates(document),
            ("times", times),
            ("settings", ", ".join(f"{name} = {value}" for name, value in document["settings"].items())),
        ]
        if document["remark"] and (document["reached"] or document["error_estimate"] is None):  # else standard error tells it
            rows.append(("remark", document["remark"]))
    print_table(rows)


def _estimates(document: dict[str, Any]) -> Iterator[tuple[str, str]]:
    """The error estimate of every column, a row for each; of a follower that does not bend, that of the tip's place."""
    from reports.words import ESTIMATE

    name, beside = ESTIMATE[document["estimate_of"]]
    each = dict(document["error_estimates"])
    deflection, estimate = each.pop("tip_deflection"), document["error_estimate"]
    asked = "" if document["accuracy"] is None else f" (asked: {document['accuracy']:g})"
    place = "deflection" if deflection is not None or estimate is None else "tip's place"
    lines = {place: f"{_digits(estimate)}{asked}{beside and '; '}{beside}"}
    lines |= {column.removeprefix("tip_").removeprefix("slider_").replace("_", " "): _digits(value) for column, value in each.items()}
    width = max(map(len, lines))
    for number, (column, text) in enumerate(lines.items()):
        yield "" if number else name, f"{column:{width}}  {text}"


def _digits(estimate: float | None) -> str:
    return "unknown" if estimate is None else f"{estimate:.1e}"
