"""`quickreturn simulate`: one trajectory of one engine, from the standard start, as a CSV file; or of several."""

import dataclasses
import itertools
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

import click

from quickreturn.commands import options

if TYPE_CHECKING:
    from cases.case import Case
    from engines.base import EngineFailure
    from engines.trajectory import Trajectory
    from quickreturn.solution import Solution

_ADVICE: Final = "see the limits of time and memory, or report this to the author of the engine"


@click.command(name="simulate")
@options.cases
@options.tag
@options.engines
@options.duration
@options.single("--output-step", metavar="S", help='Time between rows, "1 ms" or a number of seconds.')
@options.accuracy
@options.assignments
@options.output("Where the trajectory goes, as CSV; of several engines or cases with {engine} or {case} in the name.", "FILE.csv")
@options.limited
@options.json
def command(
    cases: Sequence[str],
    tag: str | None,
    engines: Sequence[str],
    duration: str | None,
    output_step: str | None,
    accuracy: float | None,
    assignments: Sequence[str],
    output: str,
    as_json: bool,
) -> int:
    """Simulate CASE from the standard start and write the trajectory.

    Exit code 3: the engine failed, did not reach the accuracy, or cannot say that it reached the one asked for, because its error
    estimate is unknown or not verified; the rows that it delivered are in the file. One that crashed or was stopped at a limit delivers
    none. The accuracy of `thesis` is that of the integration of its own equations. With several engines or cases the JSON document is a
    list.
    """
    from cases.jobs.job import Job
    from cases.jobs.processes import get_ready
    from quickreturn import questions
    from quickreturn.command_line import ENGINE_TROUBLE, GOOD
    from reports.output import check_writable, print_json

    overrides, settings = options.read_assignments(assignments)
    get_ready(questions.COMPUTING)
    loaded = options.load_all(cases, tag, overrides, duration, output_step)
    allowed, names = options.limits(), list(dict.fromkeys(engines))
    texts = options.settings_of(settings, names)
    for case, name in itertools.product(loaded, names):
        questions.check(name, case.scene, texts[name])
    places = _places(output, loaded, names)
    asked = [(case, name) for case in loaded for name in names]
    for case, name in asked:
        check_writable(Path(places[case.name, name]), "" if case.source == "library" else case.source, ".csv")
    jobs = [Job(f"{case.name} {name}", attempt, (case, name, texts[name], accuracy)) for case, name in asked]
    outcomes = questions.asked(jobs, "simulating", allowed, options.quiet())
    documents: list[Simulated] = []
    refusal: Exception | None = None
    for (case, name), outcome in zip(asked, outcomes, strict=True):
        if documents and not as_json:
            click.echo()
        found = Simulated(case=case.name, engine=name, output=places[case.name, name], notes=case.notes, accuracy=accuracy)
        try:
            documents.append(_kept(found, *questions.value_of(outcome), as_json=as_json))
        except questions.EngineDied as death:
            documents.append(_failed(found, Failure(None, death.outcome.explanation, _ADVICE)))
            if not as_json:
                _print_failed(documents[-1])
        except Exception as error:  # the others' results are written before it is told
            refusal = refusal or error
    if as_json and documents:
        print_json(documents[0] if len(asked) == 1 else documents)
    for document in documents:
        if not document.reached:
            kept = f"; {document.rows} rows are kept in {document.output}" if document.rows else "; there is nothing to keep"
            options.tell(f"{document.case}: engine {document.engine}: {document.remark}{kept}")
    if refusal is not None:
        raise refusal
    return GOOD if all(document.reached for document in documents) else ENGINE_TROUBLE


def trajectories(
    cases: "Sequence[Case]", engines: Sequence[str], settings: Mapping[str, Mapping[str, str]], accuracy: float | None
) -> "dict[tuple[str, str], Trajectory]":
    """Trajectories by case and engine, computed in workers; what is missed of the accuracy is told.

    Raises:
        Refusal, SettingError, UnknownEngine, EngineFailure, EngineDied: one cannot, or failed.
    """
    from cases.jobs.job import Job
    from quickreturn import questions

    asked = [(case, name) for case in cases for name in engines]
    for case, name in asked:
        questions.check(name, case.scene, settings[name])
    jobs = [Job(f"{case.name} {name}", attempt, (case, name, settings[name], accuracy)) for case, name in asked]
    found = {}
    for (case, name), outcome in zip(asked, questions.asked(jobs, "simulating", quiet=options.quiet()), strict=True):
        _, solution = questions.value_of(outcome)
        if isinstance(solution, Exception):
            raise solution
        if not solution.reached:
            options.tell(f"{case.name}: engine {name}: {solution.remark}")
        found[case.name, name] = solution.trajectory
    return found


def _places(output: str, cases: "Sequence[Case]", engines: Sequence[str]) -> dict[tuple[str, str], str]:
    """The file of each case and engine. UsageError: two would have the same."""
    for what, several in (("{engine}", engines), ("{case}", cases)):
        if len(several) > 1 and what not in output:
            raise click.UsageError(f"--output {output}: several {what[1:-1]}s would write the same file; put {what} into its name")
    return {(case.name, engine): output.replace("{engine}", engine).replace("{case}", case.name) for case in cases for engine in engines}


def attempt(case: "Case", engine: str, settings: Mapping[str, str], accuracy: float | None) -> "tuple[str, Solution | EngineFailure]":
    """Simulate, in a worker: version of the engine, and what came of it. Raises as `quickreturn.simulate` but for failures."""
    from engines.base import EngineFailure
    from engines.registry import usable_engine
    from quickreturn.solution import simulate

    version = usable_engine(engine).version()
    try:
        return version, simulate(case, engine, accuracy=accuracy, settings=settings)
    except EngineFailure as failure:
        return version, failure


@dataclass(frozen=True)
class Failure:
    """Why a simulation has no end: the last good instant (s; None where the process died), the cause and what to try."""

    time: float | None
    cause: str
    advice: str


@dataclass(frozen=True, kw_only=True)
class Simulated:
    """What `--json` prints; None, empty or False where there is nothing after a failure."""

    case: str
    engine: str
    output: str
    notes: tuple[str, ...]
    accuracy: float | None
    version: str | None = None
    rows: int = 0
    reached: bool = False
    error_estimate: float | None = None
    error_estimates: dict[str, float | None] = field(default_factory=dict)
    estimate_of: str | None = None
    remark: str = ""
    settings: dict[str, Any] | None = None
    setup_seconds: float | None = None
    compile_seconds: float | None = None
    solve_seconds: float | None = None
    estimate_seconds: float | None = None
    statistics: dict[str, Any] = field(default_factory=dict)
    bodies: tuple[str, ...] = ()
    joints: tuple[str, ...] = ()
    degrees_of_freedom: int | None = None
    failure: Failure | None = None


def _kept(asked: Simulated, version: str, found: "Solution | EngineFailure", *, as_json: bool) -> Simulated:
    """Write the trajectory, as far as there is one, and print what there is to say unless JSON will."""
    from engines.base import EngineFailure
    from quickreturn.solution import as_csv
    from reports.output import print_table, write_file

    asked = dataclasses.replace(asked, version=version)
    if isinstance(found, EngineFailure):
        if found.partial is not None:
            statistics, seconds = dict(found.partial.statistics), found.partial.solve_seconds
            asked = dataclasses.replace(asked, rows=len(found.partial), solve_seconds=seconds, statistics=statistics)
            write_file(Path(asked.output), as_csv(found.partial))
        document = _failed(asked, Failure(found.time, found.cause, found.advice))
        if not as_json:
            _print_failed(document)
        return document
    result = found.result
    write_file(Path(asked.output), as_csv(found.trajectory))
    if not as_json:
        told = found.reached or result.error_estimate is None  # else standard error tells why not
        print_table([row for row in found.rows(asked.output) if told or row[0] != "remark"])
    same = {each.name: getattr(result, each.name) for each in dataclasses.fields(Simulated) if hasattr(result, each.name)}
    same |= {"settings": found.settings, "statistics": dict(found.trajectory.statistics), **vars(result.description)}
    return dataclasses.replace(asked, rows=len(found.trajectory), **same)


def _failed(asked: Simulated, failure: Failure) -> Simulated:
    when = "" if failure.time is None else f"failed at t = {failure.time:.6g} s: "
    return dataclasses.replace(asked, remark=f"{when}{failure.cause}; {failure.advice}", failure=failure)


def _print_failed(found: Simulated) -> None:
    from reports.output import print_table

    def rows() -> Iterator[tuple[str, str]]:
        yield "case", found.case
        yield "engine", f"{found.engine} ({found.version or 'version unknown'})"
        if found.notes:
            yield "notes", f"{len(found.notes)} on this case: see `quickreturn show {found.case}`"

    print_table(list(rows()))
