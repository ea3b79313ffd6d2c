"""`quickreturn run`: engines on cases in their steady state, measured, compared and held to what they claim."""

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import click

from quickreturn.commands.options import (
    accuracy_option,
    cases_argument,
    jobs_option,
    json_option,
    load_all,
    main_engines_option,
    memory_limit_option,
    opened_workshop,
    read_assignments,
    set_option,
    settings_of,
    tag_option,
    tell,
    time_limit_option,
)

if TYPE_CHECKING:
    from cases.runs.comparison import CaseResult
    from cases.runs.request import Run


@click.command(name="run")
@cases_argument
@tag_option
@main_engines_option
@accuracy_option
@set_option
@jobs_option
@time_limit_option
@memory_limit_option
@json_option
def command(
    cases: Sequence[str],
    tag: str | None,
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
    from cases.runs.request import REFUSED
    from engines.registry import MAIN
    from quickreturn.command_line import BAD_INPUT, CLAIMS_BROKEN, ENGINE_TROUBLE, GOOD
    from quickreturn.cross_validation import check_engines, run
    from quickreturn.verdict_text import text_of
    from reports.output import print_json

    overrides, settings = read_assignments(assignments)
    loaded, names = load_all(cases, tag, overrides), list(dict.fromkeys(engines)) or list(MAIN)
    check_engines(engines)
    texts = settings_of(settings, names)
    workshop = opened_workshop(jobs, time_limit, memory_limit)
    found = run(loaded, names, accuracy=accuracy, settings=texts, workshop=workshop)
    results = found.results
    if as_json:
        print_json(as_document(results, found.notices))
    else:
        for result in results:
            if not all(each.status == REFUSED for each in result.runs.values()):  # else there is nothing to show
                click.echo(text_of(result))
    for result in results:
        for each in result.failures:
            tell(f"{result.case.name}: engine {each.engine} {each.status}: {each.remark}")
    refused = [(result.case.name, each) for result in results for each in result.runs.values() if engines and each.status == REFUSED]
    for name, each in refused:
        tell(f"{name}: engine {each.engine}: {each.remark}")
    if refused:
        return BAD_INPUT
    if any(result.failures for result in results):
        return ENGINE_TROUBLE
    if workshop.store.lost:
        return BAD_INPUT
    return CLAIMS_BROKEN if any(result.missed for result in results) else GOOD


def as_document(results: Sequence["CaseResult"], notices: Sequence[str]) -> dict[str, Any]:
    """The JSON document of `run`."""
    return {
        "cases": [
            {
                "case": result.case.name,
                "passed": result.passed,
                "reason": result.reason,
                "notes": list(result.case.notes),
                "engines": [_as_document(run) | {"accuracy_class": result.accuracy_class(name)} for name, run in result.runs.items()],
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
