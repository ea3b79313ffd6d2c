"""`quickreturn run`: engines on cases in their steady state, measured, compared and held to what they claim."""

import math
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any, Final

import click

from quickreturn.commands.options import (
    accuracy_option,
    jobs_option,
    json_option,
    load,
    memory_limit_option,
    opened_workshop,
    read_assignments,
    refuse_equal_names,
    set_option,
    tell,
    time_limit_option,
)

if TYPE_CHECKING:
    from cases.jobs.workshop import Workshop
    from cases.runs.comparison import CaseResult, Check
    from cases.runs.request import Run

#: Departures shown of a pair of engines in the terminal.
SHOWN: Final = 5


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

    Two engines may differ by what both claim: their own error estimates and the uncertainty of what is measured. Exit code 1: some differ
    by more. Exit code 2: an engine asked for by name cannot model a scene. Exit code 3: an engine failed, was stopped at a limit, is not
    installed, did not settle or did not reach the accuracy asked. The others are not touched by that. Results are kept as they come: an
    interrupted run continues.
    """
    from cases.runs.comparison import cross_validate
    from engines.registry import MAIN
    from reports.output import print_json

    overrides, settings = read_assignments(assignments)
    loaded = [load(case, overrides) for case in dict.fromkeys(cases)]
    refuse_equal_names(loaded)
    check_engines(loaded, engines, settings)
    workshop = opened_workshop(jobs, time_limit, memory_limit)
    names = list(dict.fromkeys(engines)) or MAIN
    results = cross_validate(loaded, workshop, names, accuracy, dict.fromkeys(names, settings))
    if as_json:
        print_json(as_document(results, workshop.store.notices))
    else:
        _print(results)
    return exit_code(results, workshop, engines)


def exit_code(results: Sequence["CaseResult"], workshop: "Workshop", engines: Sequence[str]) -> int:
    """Tell on standard error what did not come to a result; `engines` are those that were asked for by name."""
    from cases.runs.request import REFUSED
    from quickreturn.command_line import BAD_INPUT, CLAIMS_BROKEN, ENGINE_TROUBLE, GOOD

    for result in results:
        for run in result.failures:
            tell(f"{result.case.name}: {_kind(run)} {run.engine} {run.status}: {run.remark}")
    refused = [(result.case.name, run) for result in results for run in result.runs.values() if engines and run.status == REFUSED]
    for case, run in refused:
        tell(f"{case}: engine {run.engine}: {run.remark}")
    if refused:
        return BAD_INPUT
    if any(result.failures for result in results):
        return ENGINE_TROUBLE
    if workshop.store.lost:
        return BAD_INPUT
    return CLAIMS_BROKEN if any(result.missed for result in results) else GOOD


def check_engines(cases: Sequence[Any], names: Sequence[str], settings: Mapping[str, str]) -> None:
    """Refuse before anything runs an engine that is asked for by name and not there, and settings that an engine does not have."""
    from engines.base import Refusal
    from engines.registry import MAIN, engine
    from engines.settings import SettingError

    for name in names or MAIN:
        chosen = engine(name)
        if names and (reason := chosen.unavailable()):
            raise Refusal(f"--engine {name}: {reason}")
        for case in cases if settings else ():
            try:
                chosen.settings_for(chosen.default_accuracy, case.mechanism).with_texts(dict(settings))
            except SettingError as error:  # several engines share the settings, and one of them may lack one
                raise SettingError(f"{error} (engine {name})") from error


def as_document(results: Sequence["CaseResult"], notices: Sequence[str]) -> dict[str, Any]:
    """The JSON document of `run` and `compare`: recorded tables stand among the engines, behind them."""
    return {
        "cases": [
            {
                "case": result.case.name,
                "turn": next((run.turn for run in result.runs.values()), None),
                "passed": result.passed,
                "reason": result.reason,
                "notes": list(result.case.notes),
                "engines": [_as_document(run) | {"accuracy_class": result.accuracy_class(name)} for name, run in result.all_runs.items()],
                "checks": [check.as_dict() for check in result.checks],
            }
            for result in results
        ],
        "failures": [
            {"case": result.case.name, "engine": run.engine, "status": run.status, "remark": run.remark}
            for result in results
            for run in result.failures
        ],
        "notices": list(notices),
    }


def _as_document(run: "Run") -> dict[str, Any]:
    """All that is known of a run but its cycle."""
    known = {name: value for name, value in vars(run).items() if name != "cycle"}
    return known | {"settling": run.settling and {**vars(run.settling), "sentence": run.settling.sentence()}}


def _print(results: Sequence["CaseResult"]) -> None:
    from cases.runs.request import REFUSED

    for result in results:
        if all(run.status == REFUSED for run in result.runs.values()):
            continue  # there is nothing to show
        click.echo(f"{result.case.name}: {result.case.title}")
        print_rows(result)
        for line in verdict(result):
            click.echo(f"  {line}")


def print_rows(result: "CaseResult") -> None:
    """One row for each engine and recorded table, and their remarks."""
    from reports.output import print_table

    numbers = ("class", "f1 pre Hz", "f1 post Hz", "peak accel. m/s2", "peak strain 2")
    header = ("engine", "status", "start", "cycles", "solve s", "estimate", *numbers)
    print_table([_row(run, result.accuracy_class(name)) for name, run in result.all_runs.items()], header)
    for run in result.all_runs.values():
        if run.remark:
            click.echo(f"  {run.engine}: {run.remark}")


def verdict(result: "CaseResult") -> list[str]:
    """What was judged and what came of it, and how far those engines lie from the reference that are not judged."""
    from cases.runs.comparison import REFERENCE, largest_differences, not_judged

    lines = []
    for (engine, other), checks in result.departures.items():
        total = sum((check.engine, check.other) == (engine, other) for check in result.checks)
        lines.append(f"{engine} and {other} disagree by more than they claim, in {len(checks)} of {total} comparisons:")
        worst = sorted(checks, key=lambda check: -abs(check.difference) / check.tolerance if check.tolerance else -math.inf)
        lines += [f"  {_departure(check)}" for check in worst[:SHOWN]]
        if len(checks) > SHOWN:
            lines.append(f"  and {len(checks) - SHOWN} more, which --json lists")
    if result.passed is None:
        lines.append(f"not judged: {result.reason}")
    elif not result.missed:
        names = ", ".join(dict.fromkeys(check.engine for check in result.checks))
        others = " and ".join(dict.fromkeys(check.other for check in result.checks))
        lines.append(f"{names}: within what is claimed of {others} in all {len(result.checks)} comparisons")
    reference = result.runs.get(REFERENCE)
    for name, run in result.runs.items():
        if reference is not None and reference.usable and run.usable and name != REFERENCE and (why := not_judged(run)):
            found = [f"{kind} {100.0 * size:.2g} %" for kind, size in largest_differences(run, reference).items() if size is not None]
            lines.append(f"{name}, not judged ({why}): largest differences from {REFERENCE}: {', '.join(found) or 'none'}")
    return lines


def _departure(check: "Check") -> str:
    return (
        f"{check.quantity}, {check.half}-return, {check.channel or 'all channels'}: {check.mine.value:.5g} and {check.its.value:.5g} differ"
        f" by {abs(check.difference):.2g}, claimed are {check.mine.width:.2g} by {check.engine} and {check.its.width:.2g} by {check.other}"
    )


def _kind(run: "Run") -> str:
    return "table" if run.recording else "engine"


def _row(run: "Run", accuracy_class: str | None) -> tuple[str, ...]:
    def number(value: float | None, form: str) -> str:
        return "-" if value is None else format(value, form)

    forms = {"tip_acceleration": ".2f", "strain_2": ".3e"}
    peaks = [number(run.peak(name) if run.usable and name in run.cycle else None, form) for name, form in forms.items()]
    return (
        run.engine,
        run.status,
        run.start or "-",
        str(run.cycles),
        number(run.solve_seconds, ".2f"),
        number(run.error_estimate, ".1e"),
        accuracy_class or "-",
        number(run.consensus_frequency("pre"), ".3f"),
        number(run.consensus_frequency("post"), ".3f"),
        *peaks,
    )
