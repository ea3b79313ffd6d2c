"""`quickreturn benchmark`: error against solve time over each engine's settings."""

from collections.abc import Sequence
from typing import Any

import click

from reports.commands.options import json_option, load, read_assignments, refuse_engine_settings, set_option


@click.command(name="benchmark")
@click.argument("cases", metavar="CASE...", nargs=-1, required=True)
@click.option("--engine", "engines", metavar="E", multiple=True, help="Engine to measure; may be given again. Default: the four main ones.")
@click.option("--repetitions", metavar="N", type=click.IntRange(1, 100), default=5, show_default=True, help="Interleaved repetitions.")
@set_option
@json_option
def command(cases: Sequence[str], engines: Sequence[str], repetitions: int, assignments: Sequence[str], as_json: bool) -> int:
    """Measure error and solve time of every engine over its ladder of settings, from the standard start of each CASE.

    Exit code 3: the solution to measure against could not be computed. Points that fail are listed and no error.
    """
    import dataclasses

    from cases.benchmark import benchmark
    from cases.workers import Job
    from engines.registry import MAIN, engine
    from reports import engine_jobs
    from reports.command_line import GOOD
    from reports.output import print_json

    overrides, settings = read_assignments(assignments)
    refuse_engine_settings(settings)
    loaded = [load(case, overrides) for case in dict.fromkeys(cases)]
    names = list(dict.fromkeys(engines)) or list(MAIN)
    for name in names:
        engine(name)  # an unknown name is answered before anything runs
    tables = []
    for case in loaded:
        table = engine_jobs.answer_of(Job(case.name, benchmark, (case, names, repetitions)))
        tables.append(dataclasses.asdict(table))
        if not as_json:
            _print(tables[-1])
    if as_json:
        print_json({"benchmarks": tables})
    return GOOD


def _print(table: dict[str, Any]) -> None:
    from cases.benchmark import pareto_front
    from reports.output import print_table

    confirmation = table["confirmation"]
    if "differences" in confirmation:
        difference = confirmation["differences"]["tip_deflection"]
        agreed = "nothing bends" if difference is None else f"{confirmation['engine']} agrees to {difference:.1e} in the tip deflection"
    else:
        agreed = f"not confirmed: {confirmation['failure']}"
    click.echo(f"{table['case']}: errors against {table['truth']['engine']} ({_settings(table['truth']['settings'])}); {agreed}")
    front = pareto_front(table["points"])
    heads = ("", "engine", "settings", "dof", "solve s", "largest s", "deflection", "acceleration", "strain", "force")
    print_table([_row(point, point in front) for point in table["points"]], heads)
    click.echo("* on the Pareto front of solve time and error of the tip deflection")


def _row(point: dict[str, Any], best: bool) -> tuple[str, ...]:
    head = ("*" if best else "", point["engine"], _settings(point["settings"]))
    if "errors" not in point:
        return (*head, point["status"], "", "", "", "", "", "")
    errors = point["errors"]
    strains = [errors[name] for name in ("strain_1", "strain_2", "strain_3") if errors[name] is not None]
    shown = (errors["tip_deflection"], errors["tip_acceleration"], max(strains, default=None), errors["slider_force"])
    times = (f"{point['solve_seconds']:.4f}", f"{point['solve_seconds_largest']:.4f}")
    return (*head, str(point["degrees_of_freedom"]), *times, *("-" if value is None else f"{value:.1e}" for value in shown))


def _settings(settings: dict[str, Any]) -> str:
    return ", ".join(f"{name} {value:g}" if isinstance(value, float) else f"{name} {value}" for name, value in settings.items())
