"""`quickreturn run`: measures engines on cases in their steady state, and compares their differences with their claims."""

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import click

from quickreturn.commands import options

if TYPE_CHECKING:
    from quickreturn.cases.jobs.workshop import Workshop
    from quickreturn.cases.runs.comparison import CaseResult
    from quickreturn.cases.runs.request import Run
    from quickreturn.reference_model.mechanism import Mechanism


@click.command(name="run")
@options.cases
@options.tag
@options.main_engines
@options.accuracy
@options.assignments
@options.of_workshop
@options.json
def command(
    cases: Sequence[str],
    tag: str | None,
    engines: Sequence[str],
    accuracy: float | None,
    assignments: Sequence[str],
    as_json: bool,
) -> int:
    """Bring engines to their steady state on each CASE, measure and compare them.

    Two engines may differ by the sum of their claims: their own error estimates and the uncertainty of the measures. Exit code 1: some
    differ by more. Exit code 2: an engine asked for by name cannot model a scene. Exit code 3: an engine failed, was stopped at a limit, is
    not installed, did not settle or did not reach the accuracy asked. The other engines go on. Each result is stored at once: an
    interrupted run continues.
    """
    from quickreturn.catalogue import prepared
    from quickreturn.reports.output import print_json

    overrides, settings = options.read_assignments(assignments)
    loaded = options.load_all(cases, tag, overrides)
    names, texts, tables = prepared(loaded, engines, settings)
    options.refuse_missing(names if engines else ())
    workshop = options.opened_workshop(loaded, names)
    from quickreturn.cases.runs.comparison import cross_validate
    from quickreturn.cases.runs.request import REFUSED
    from quickreturn.cases.shown import in_lines
    from quickreturn.verdict_text import parts_of

    results = cross_validate(loaded, workshop, names, accuracy, texts, tables)
    if as_json:
        print_json(as_document(results, workshop.store.notices))
    else:
        for result in results:
            if not all(each.status == REFUSED for each in result.runs.values()):  # otherwise there is nothing to show
                click.echo(in_lines(parts_of(result)))
    return exit_code(results, workshop, engines)


def exit_code(results: "Sequence[CaseResult]", workshop: "Workshop", engines: Sequence[str]) -> int:
    """The exit code; runs without a result are named on standard error. `engines`: those asked for by name."""
    from quickreturn.cases.runs.request import REFUSED
    from quickreturn.command_line import BAD_INPUT, CLAIMS_BROKEN, ENGINE_TROUBLE, GOOD

    results = [result.whole for result in results]
    for result in results:
        for each in result.failures:
            options.tell(f"{result.case.name}: {'table' if each.recording else 'engine'} {each.engine} {each.status}: {each.remark}")
    refused = [(result.case.name, each) for result in results for each in result.runs.values() if engines and each.status == REFUSED]
    for name, each in refused:
        options.tell(f"{name}: engine {each.engine}: {each.remark}")
    if refused:
        return BAD_INPUT
    if any(result.failures for result in results):
        return ENGINE_TROUBLE
    if workshop.store.lost:
        return BAD_INPUT
    return CLAIMS_BROKEN if any(result.missed for result in results) else GOOD


def as_document(results: Sequence["CaseResult"], notices: Sequence[str]) -> dict[str, Any]:
    """The JSON document of `run` and `compare`: recorded tables follow the engines."""
    from quickreturn.cases.loads import loads_of_run
    from quickreturn.reports.tables.strength import document

    results = [result.whole for result in results]
    return {
        "cases": [
            {
                "case": result.case.name,
                "turn": result.turn,
                "passed": result.passed,
                "reason": result.reason,
                "notes": list(result.case.notes),
                "engines": [
                    _as_document(run)
                    | {"accuracy_class": result.accuracy_class(name), "loads": document(loads_of_run(result.case.mechanism, run))}
                    for name, run in result.runs.items()
                ],
                "resonance": _resonance(result.case.mechanism),
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


def _resonance(mechanism: "Mechanism") -> dict[str, Any] | None:
    """First mode (Hz, mean over the turn with the crank held), crank (Hz), their ratio and the nearest harmonic."""
    from quickreturn.cases.loads import resonance

    found = resonance(mechanism)
    return None if found is None else {**vars(found), "ratio": found.ratio, "harmonic": found.harmonic}


def _as_document(run: "Run") -> dict[str, Any]:
    """Everything about a run except its cycle."""
    known = {name: value for name, value in vars(run).items() if name != "cycle"}
    return known | {"settling": run.settling and {**vars(run.settling), "sentence": run.settling.sentence()}}
