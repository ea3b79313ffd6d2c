"""Exit code and JSON document of `run` and `compare`."""

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

from quickreturn.cases.loads import loads_of_run, resonance
from quickreturn.cases.measures.catalogue import MEASURES, numbers
from quickreturn.cases.runs.endings import Ending
from quickreturn.commands import console
from quickreturn.commands.console import ExitCode
from quickreturn.reports.results.loads import loads_document

if TYPE_CHECKING:
    from quickreturn.cases.jobs.workshop import Workshop
    from quickreturn.cases.runs.comparison import CaseResult
    from quickreturn.cases.runs.request import Run
    from quickreturn.reference_model.mechanism import Mechanism


def exit_code(results: "Sequence[CaseResult]", workshop: "Workshop", engines: Sequence[str]) -> int:
    """The exit code; runs without a result are named on standard error. `engines`: those asked for by name."""
    results = [result.with_tables for result in results]
    for result in results:
        for each in result.failures:
            console.tell(f"{result.case.name}: {'table' if each.recording else 'engine'} {each.engine} {each.status}: {each.remark}")
    refused = [(result.case.name, each) for result in results for each in result.runs.values() if engines and each.status == Ending.REFUSED]
    for name, each in refused:
        console.tell(f"{name}: engine {each.engine}: {each.remark}")
    if refused:
        return ExitCode.BAD_INPUT
    if any(result.failures for result in results):
        return ExitCode.ENGINE_TROUBLE
    if workshop.store.lost:
        return ExitCode.BAD_INPUT
    return ExitCode.CLAIMS_BROKEN if any(result.missed for result in results) else ExitCode.GOOD


def as_document(results: Sequence["CaseResult"], notices: Sequence[str]) -> dict[str, Any]:
    """The JSON document of `run` and `compare`: recorded tables follow the engines."""
    results = [result.with_tables for result in results]
    return {
        "cases": [
            {
                "case": result.case.name,
                "turn": result.turn,
                "passed": result.passed,
                "agreement": result.agreement,
                "reason": result.reason,
                "notes": list(result.case.notes),
                "engines": [
                    _as_document(run)
                    | {
                        "accuracy_class": result.accuracy_class(name),
                        "loads": loads_document(loads_of_run(result.case.mechanism, run)),
                        "numbers": {
                            measure: {"value": found.value, "error": found.error, "unit": MEASURES[measure].unit}
                            for measure, found in numbers(result.case.mechanism, run).items()
                        },
                    }
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
    found = resonance(mechanism)
    return None if found is None else {**vars(found), "ratio": found.ratio, "harmonic": found.harmonic}


def _as_document(run: "Run") -> dict[str, Any]:
    """Everything about a run except its cycle."""
    known = {name: value for name, value in vars(run).items() if name != "cycle"}
    return known | {"settling": run.settling and {**vars(run.settling), "sentence": run.settling.sentence()}}
