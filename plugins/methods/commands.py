"""`quickreturn benchmark`: error against solve time over each engine's settings; and `advise`: which method, by the map of classes."""

from dataclasses import asdict
from typing import TYPE_CHECKING, Any, Final

import click

import quickreturn as qr
from quickreturn.commands import options
from quickreturn.commands.console import Call, ExitCode, tell, tell_doubts
from quickreturn.computing import HIGHEST, LOWEST, workshop
from quickreturn.reports.output import print_json, print_table

if TYPE_CHECKING:
    from quickreturn.plugins.methods.benchmark import Benchmark
    from quickreturn.plugins.methods.trials.trial import Trial

#: Fields of a trial in the document: of each one, and of one that completed.
_KNOWN: Final = ("engine", "settings", "status")
_TIMES: Final = ("solve_seconds", "solve_seconds_median", "solve_seconds_largest", "repetitions", "setup_seconds", "estimate_seconds")
_MEASURED: Final = ("degrees_of_freedom", "errors", *_TIMES)

#: Fields of a trial in the document of `advise`.
_ADVISED: Final = ("scene", "engine", "level", "status", "solve_seconds", "waited_seconds", "error", "remark")


@options.command(
    options.cases,
    options.tag,
    options.engines_for(help="Engine to measure; may be given again. Default: the nine engines that the report compares."),
    options.single(
        "--repetitions",
        metavar="N",
        read=options.number(1, 100, 5, whole=True),
        default="5",
        show_default=True,
        help="Repetitions at most, 1 to 100, interleaved.",
    ),
    options.case_assignments,
    options.limited,
    options.json,
)
def benchmark(call: Call, repetitions: int) -> int:
    """Measure error and solve time of every engine over its ladder of settings, from the standard start of each CASE.

    Without a CASE it measures the scenes on which the report compares methods. The report shows a measurement only if it contains all nine
    engines. All engines share one process: the time limit is for their sum.

    Exit code 3: the solution that defines the error could not be computed, an engine died or was stopped at a limit, or a default
    engine is not installed; the others are still measured. Settings with which an engine reports a failure are listed, but are not an
    error.
    """
    from quickreturn.plugins.methods.benchmark import SCENES, compiling, measure
    from quickreturn.plugins.methods.benchmark.scenes import ENGINES

    loaded = call.loaded(otherwise=SCENES)
    names = call.engines or ENGINES
    call.refuse_missing()
    _ = [case.mechanism for case in loaded]  # a scene without crank is refused before anything runs
    measured, failed = [], False
    with workshop(None, call.quiet, loaded, names) as opened:
        if not call.cases and not call.tag:
            compiling(opened, names)  # for the report
        for case in loaded:
            try:
                measured.append(measure(case, opened, names, repetitions))
            except qr.EngineFailure as failure:  # of the reference solution; the other cases have their own
                tell(f"{case.name}: {failure}")
                failed = True
                continue
            if not call.as_json:
                _print(measured[-1])
    if call.as_json:
        print_json({"benchmarks": [_as_document(table) for table in measured]})
    for table in measured:
        for name, reason in table.failures.items():
            tell(f"{table.case}: engine {name} was left out: {reason}")
    if failed or any(table.failures for table in measured):
        return ExitCode.ENGINE_TROUBLE
    return ExitCode.BAD_INPUT if call.lost else ExitCode.GOOD


def _print(table: "Benchmark") -> None:
    from quickreturn.plugins.methods.trials.queries import changing, pareto_front
    from quickreturn.reports.words import settings_words

    truth, confirmation = table.truth, table.confirmation
    agreed = f"not confirmed: {confirmation.status}"
    if confirmation.completed:
        difference = confirmation.error
        agreed = "nothing bends" if difference is None else f"{confirmation.engine} agrees to {difference:.1e} in the tip deflection"
    click.echo(f"{table.case}: errors against {truth.engine} ({settings_words(truth.settings)}); {agreed}")
    front = pareto_front(table.trials)
    heads = ("", "method", "settings", "dof", "solve s", "largest s", "deflection", "acceleration", "strain", "force", "remark")
    print_table([_row(each, each in front, settings_words(changing(each, table.trials))) for each in table.trials], heads)
    click.echo("* on the Pareto front of solve time and error of the tip deflection")


def _as_document(table: "Benchmark") -> dict[str, Any]:
    """The table as a document: trials with the measured values, if any, and the differences or the failure of the confirmation."""
    from quickreturn.plugins.methods.trials.queries import changing

    points, other = [], table.confirmation
    for trial in table.trials:
        points.append({"method": trial.method, "changing": changing(trial, table.trials)} | {name: getattr(trial, name) for name in _KNOWN})
        if trial.completed:
            statistics = dict(trial.statistics)
            calls = {"calls_per_period": statistics.pop("calls_per_period", None)}
            points[-1] |= {name: getattr(trial, name) for name in _MEASURED} | calls | {"statistics": statistics}
    outcome = {"differences": other.errors} if other.completed else {"failure": other.status}
    document = {"points" if name == "trials" else name: value for name, value in vars(table).items()}
    return document | {"points": points, "confirmation": {"engine": other.engine, "settings": other.settings, **outcome}}


def _row(trial: "Trial", best: bool, settings: str) -> tuple[str, ...]:
    head = ("*" if best else "", trial.method, settings)
    if not trial.completed:
        return (*head, *[""] * 7, trial.status)
    errors = [trial.error_of(column) for column in ("tip_deflection", "tip_acceleration", "strain", "slider_force")]
    times = (f"{trial.seconds:.4f}", f"{trial.solve_seconds_largest:.4f}")
    free = "-" if trial.degrees_of_freedom is None else str(trial.degrees_of_freedom)
    return (*head, free, *times, *("-" if value is None else f"{value:.1e}" for value in errors), "")


@options.command(
    options.cases,
    options.tag,
    options.accuracy_of(default="0.01", show_default=True, help=f"Wanted relative error of the tip deflection, {HIGHEST:g} to {LOWEST:g}."),
    options.case_assignments,
    options.json,
)
def advise(call: Call) -> None:
    """Say where CASE lies on the map of classes, and which methods were the fastest there to an error.

    The map was recorded: one turn of the crank from the standard start, by every engine, in scenes that cover the dimensionless groups.
    Nothing is simulated. The output names each quantity that lies outside the map. With several cases the JSON document is a list.
    """
    loaded = call.loaded()
    found = [qr.advise(case, call.accuracy or 0.01) for case in loaded]
    tell_doubts(loaded)
    documents = [asdict(each) | {"reaches": [{key: getattr(trial, key) for key in _ADVISED} for trial in each.reaches]} for each in found]
    call.show_each(documents, "\n\n".join(map(str, found)))
