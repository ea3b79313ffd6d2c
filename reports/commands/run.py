"""`quickreturn run`: engines on cases in their steady state, measured, compared and held against tolerances."""

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

import click

from reports.commands.options import (
    accuracy_option,
    jobs_option,
    json_option,
    limits,
    load,
    memory_limit_option,
    opened_store,
    read_assignments,
    refuse_equal_names,
    set_option,
    tell,
    time_limit_option,
)

if TYPE_CHECKING:
    from cases.comparison import CaseResult
    from cases.engine_run import EngineRun


@click.command(name="run")
@click.argument("cases", metavar="CASE...", nargs=-1, required=True)
@click.option("--engine", "engines", metavar="E", multiple=True, help="Engine to run; may be given again. Default: the four main ones.")
@accuracy_option
@set_option
@jobs_option
@time_limit_option
@memory_limit_option
@json_option
def command(
    cases: Sequence[str],
    engines: Sequence[str],
    accuracy: float | None,
    assignments: Sequence[str],
    jobs: int | None,
    time_limit: str | None,
    memory_limit: str | None,
    as_json: bool,
) -> int:
    """Bring engines to their steady state on each CASE, measure, compare.

    Exit code 1: a tolerance was missed. Exit code 3: an engine failed, was stopped at a limit, is not installed, did not settle or did
    not reach the accuracy asked; the others are not touched by that. Results are kept as they come: an interrupted run continues.
    """
    from cases.cross_validation import cross_validate
    from engines.registry import MAIN
    from reports.command_line import BAD_INPUT, ENGINE_TROUBLE, GOOD, TOLERANCE_MISSED
    from reports.output import print_json

    overrides, settings = read_assignments(assignments)
    loaded = [load(case, overrides) for case in dict.fromkeys(cases)]
    refuse_equal_names(loaded)
    _check_engines(loaded, engines, settings)
    allowed = limits(time_limit, memory_limit)
    store = opened_store()
    results = cross_validate(loaded, store, list(dict.fromkeys(engines)) or MAIN, accuracy, settings, jobs, allowed)
    if as_json:
        print_json(as_document(results, store.notices))
    else:
        _print(results)
    for result in results:
        for run in result.failures:
            tell(f"{result.case.name}: engine {run.engine} {run.status}: {run.document['remark']}")
    if any(result.failures for result in results):
        return ENGINE_TROUBLE
    if store.lost:
        return BAD_INPUT
    return GOOD if all(result.passed for result in results) else TOLERANCE_MISSED


def _check_engines(cases: Sequence[Any], names: Sequence[str], settings: Mapping[str, str]) -> None:
    """Refuse before anything runs what an engine asked for by name cannot do, and settings that an engine does not have."""
    from engines.base import Refusal
    from engines.registry import MAIN, engine
    from engines.settings import SettingError

    for name in names or MAIN:
        chosen = engine(name)
        if names and (reason := chosen.unavailable()):
            raise Refusal(f"--engine {name}: {reason}")
        for case in cases:
            if names:
                chosen.check(case.mechanism)
            if settings:
                try:
                    chosen.settings_for(chosen.default_accuracy, case.mechanism).with_texts(dict(settings))
                except SettingError as error:  # several engines share the settings, and one of them may lack one
                    raise SettingError(f"{error} (engine {name})") from error


def as_document(results: Sequence["CaseResult"], notices: Sequence[str]) -> dict[str, Any]:
    """The JSON document of `run`."""
    return {
        "cases": [
            {
                "case": result.case.name,
                "passed": result.passed,
                "notes": list(result.case.notes),
                "engines": [run.document for run in result.runs.values()],
                "checks": [check.as_dict() for check in result.checks],
            }
            for result in results
        ],
        "failures": [
            {"case": result.case.name, "engine": run.engine, "status": run.status, "remark": run.document["remark"]}
            for result in results
            for run in result.failures
        ],
        "notices": list(notices),
    }


def _print(results: Sequence["CaseResult"]) -> None:
    from reports.output import print_table

    for result in results:
        click.echo(f"{result.case.name}: {result.case.title}")
        header = ("engine", "status", "cycles", "solve s", "estimate", "f1 pre Hz", "f1 post Hz", "peak accel. m/s2", "peak strain 2")
        print_table([_row(run) for run in result.runs.values()], header)
        for run in result.runs.values():
            if run.document["remark"]:
                click.echo(f"  {run.engine}: {run.document['remark']}")
        for check in result.missed:
            place = f"{check.half}-return {check.channel or 'consensus'}"
            click.echo(
                f"  {check.engine} misses a tolerance: {check.quantity} {place}: {check.tolerance.kind} {check.deviation:.4g}"
                f" is outside {check.tolerance.low:g} to {check.tolerance.high:g}"
            )
        if not result.checks:
            click.echo("  nothing compared: tolerances are relative to `reference`, run with one other engine or more")
        else:
            click.echo(f"  {len(result.missed) or 'none'} of {len(result.checks)} tolerances missed")


def _row(run: "EngineRun") -> tuple[str, ...]:
    document = run.document

    def number(value: float | None, form: str) -> str:
        return "-" if value is None else format(value, form)

    peaks = ("-", "-") if not run.usable else (f"{run.peak('tip_acceleration'):.2f}", f"{run.peak('strain_2'):.3e}")
    return (
        run.engine,
        run.status,
        str(document["cycles"]),
        number(document["solve_seconds"], ".2f"),
        number(document.get("error_estimate"), ".1e"),
        number(run.consensus_frequency("pre"), ".3f"),
        number(run.consensus_frequency("post"), ".3f"),
        *peaks,
    )
