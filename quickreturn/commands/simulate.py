"""`quickreturn simulate`: one trajectory of one engine, from the standard start, as a CSV file."""

from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import click

from quickreturn.commands.options import (
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

if TYPE_CHECKING:
    from quickreturn.questions import Simulated


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
    from cases.jobs.processes import get_ready
    from quickreturn import questions
    from quickreturn.command_line import ENGINE_TROUBLE, GOOD
    from reports.output import check_writable, print_json

    overrides, settings = read_assignments(assignments)
    get_ready(questions.COMPUTING)
    loaded = load(case, overrides, duration, output_step)
    allowed = limits(time_limit, memory_limit)
    check_writable(Path(output), "" if loaded.source == "library" else case, ".csv")
    found = questions.simulate(engine, loaded, settings, accuracy, output, allowed)
    if as_json:
        print_json(found)
    else:
        _print(found)
    if found.reached:
        return GOOD
    click.echo(f"quickreturn: {loaded.name}: engine {engine}: {found.remark}{_kept(found)}", err=True)
    return ENGINE_TROUBLE


def _kept(found: "Simulated") -> str:
    return f"; {found.rows} rows are kept in {found.output}" if found.rows else "; there is nothing to keep"


def _print(found: "Simulated") -> None:
    from reports.output import print_table

    rows = [("case", found.case), ("engine", f"{found.engine} ({found.version or 'version unknown'})")]
    if found.notes:
        rows.append(("notes", f"{len(found.notes)} on this case: see `quickreturn show {found.case}`"))
    if found.failure is None:
        times = {
            "compile": found.compile_seconds,
            "setup": found.setup_seconds,
            "solve": found.solve_seconds,
            "estimate": found.estimate_seconds,
        }
        rows += [
            ("rows", f"{found.rows} in {found.output}"),
            *_estimates(found),
            ("times", " + ".join(f"{seconds:.3g} s {part}" for part, seconds in times.items())),
            ("settings", ", ".join(f"{name} = {value}" for name, value in (found.settings or {}).items())),
        ]
        if found.remark and (found.reached or found.error_estimate is None):  # else standard error tells it
            rows.append(("remark", found.remark))
    print_table(rows)


def _estimates(found: "Simulated") -> Iterator[tuple[str, str]]:
    """The error estimate of every column, a row for each; of a follower that does not bend, that of the tip's place."""
    from reports.words import ESTIMATE

    name, beside = ESTIMATE[found.estimate_of or "total"]
    each, estimate = dict(found.error_estimates), found.error_estimate
    deflection = each.pop("tip_deflection")
    asked = "" if found.accuracy is None else f" (asked: {found.accuracy:g})"
    place = "deflection" if deflection is not None or estimate is None else "tip's place"
    lines = {place: f"{_digits(estimate)}{asked}{beside and '; '}{beside}"}
    lines |= {column.removeprefix("tip_").removeprefix("slider_").replace("_", " "): _digits(value) for column, value in each.items()}
    width = max(map(len, lines))
    for number, (column, text) in enumerate(lines.items()):
        yield "" if number else name, f"{column:{width}}  {text}"


def _digits(estimate: float | None) -> str:
    return "unknown" if estimate is None else f"{estimate:.1e}"
