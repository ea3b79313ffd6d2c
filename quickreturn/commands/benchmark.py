"""`quickreturn benchmark`: error against solve time over each engine's settings."""

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import click

import quickreturn as qr
from quickreturn.commands import console, options
from quickreturn.reference_model.errors import ExitCode
from quickreturn.reports.output import print_json, print_table

if TYPE_CHECKING:
    from quickreturn.cases.benchmark import Benchmark
    from quickreturn.cases.benchmark.findings import Point


@click.command(name="benchmark")
@options.cases
@options.tag
@options.engines_for(help="Engine to measure; may be given again. Default: the nine engines that the report compares.")
@options.single(
    "--repetitions",
    metavar="N",
    read=options.number(1, 100, 5, whole=True),
    default="5",
    show_default=True,
    help="Repetitions at most, 1 to 100, interleaved.",
)
@options.case_assignments
@options.limited
@options.json
def command(
    cases: Sequence[str],
    tag: str | None,
    engines: Sequence[str],
    repetitions: int,
    assignments: Sequence[str],
    as_json: bool,
) -> int:
    """Measure error and solve time of every engine over its ladder of settings, from the standard start of each CASE.

    Without a CASE it measures the scenes on which the report compares methods. The report shows a measurement only if it contains all nine
    engines. All engines share one process: the time limit is for their sum.

    Exit code 3: the solution that defines the error could not be computed, an engine died or was stopped at a limit, or a default
    engine is not installed; the others are still measured. Settings with which an engine reports a failure are listed, but are not an
    error.
    """
    from quickreturn.cases.benchmark import SCENES, compiling, measure
    from quickreturn.cases.benchmark.scenes import ENGINES

    loaded = options.load_all(cases, tag, options.read_overrides(assignments), otherwise=SCENES)
    names = engines or ENGINES
    options.refuse_missing(engines)
    _ = [case.mechanism for case in loaded]  # a scene without crank is refused before anything runs
    workshop, tables = options.opened_workshop(loaded, names), []
    failed = False
    if not cases and not tag:
        compiling(workshop, names)  # for the report
    for case in loaded:
        try:
            tables.append(measure(case, workshop, names, repetitions))
        except qr.EngineFailure as failure:  # of the reference solution; the other cases have their own
            console.tell(f"{case.name}: {failure}")
            failed = True
            continue
        if not as_json:
            _print(tables[-1])
    if as_json:
        print_json({"benchmarks": [_as_document(table) for table in tables]})
    for table in tables:
        for name, reason in table.failures.items():
            console.tell(f"{table.case}: engine {name} was left out: {reason}")
    if failed or any(table.failures for table in tables):
        return ExitCode.ENGINE_TROUBLE
    return ExitCode.BAD_INPUT if workshop.store.lost else ExitCode.GOOD


def _print(table: "Benchmark") -> None:
    from quickreturn.cases.benchmark import pareto_front
    from quickreturn.reports.words import settings_words

    truth, confirmation = table.truth, table.confirmation
    agreed = f"not confirmed: {confirmation.failure}"
    if not confirmation.failure:
        difference = confirmation.differences["tip_deflection"]
        agreed = "nothing bends" if difference is None else f"{confirmation.engine} agrees to {difference:.1e} in the tip deflection"
    click.echo(f"{table.case}: errors against {truth.engine} ({settings_words(truth.settings)}); {agreed}")
    front = pareto_front(table.points)
    heads = ("", "method", "settings", "dof", "solve s", "largest s", "deflection", "acceleration", "strain", "force", "remark")
    print_table([_row(point, point in front, settings_words(point.changing)) for point in table.points], heads)
    click.echo("* on the Pareto front of solve time and error of the tip deflection")


def _as_document(table: "Benchmark") -> dict[str, Any]:
    """The table as a document: points with the measured values, if any, and the differences or the failure of the confirmation."""
    points = [{**vars(point), **(vars(point.measured) if point.measured else {})} for point in table.points]
    for point in points:
        del point["measured"]
    return vars(table) | {"points": points, "confirmation": {name: value for name, value in vars(table.confirmation).items() if value}}


def _row(point: "Point", best: bool, settings: str) -> tuple[str, ...]:
    head, measured = ("*" if best else "", point.method, settings), point.measured
    if measured is None:
        return (*head, *[""] * 7, point.status)
    shown = [point.error(column) for column in ("tip_deflection", "tip_acceleration", "strain", "slider_force")]
    times = (f"{measured.solve_seconds:.4f}", f"{measured.solve_seconds_largest:.4f}")
    return (*head, str(measured.degrees_of_freedom), *times, *("-" if value is None else f"{value:.1e}" for value in shown), "")
