"""What the command line asks of engines, each question that may load a library in a process of its own.

A library that crashes, prints or holds on to the interpreter then costs no more than its own answer: Ctrl-C works at once, and
nothing but the command's own words gets to standard output. What an engine computed comes back through a pipe and is written here,
so that a worker which is killed leaves no half file behind.
"""

import dataclasses
from collections.abc import Callable, Container, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

from cases.jobs.job import Job, Limits, Outcome, T, answers
from cases.jobs.processes import LocalProcesses
from reports.output import write_file

if TYPE_CHECKING:
    from cases.case import Case
    from engines.accurate import Result
    from engines.base import EngineFailure, ModelDescription
    from reference_model.mechanism import Mechanism, Scene

_ADVICE: Final = "see the limits of time and memory, or report this to the author of the engine"


class EngineDied(Exception):
    """The process of an engine ended without an answer, or with an error that no engine should make; one sentence."""

    def __init__(self, sentence: str, outcome: Outcome[Any]) -> None:
        super().__init__(sentence)
        self.outcome = outcome


#: What processes import that tell of engines, and those that compute.
TELLING: Final = ("cases.jobs.worker", "engines.registry")
COMPUTING: Final = (*TELLING, "engines.accurate", "engines.own.simulation")


def asked(jobs: Sequence[Job[T]], title: str, limits: Limits | None = None) -> list[Outcome[T]]:
    """How each of the jobs ended; `limits` None: `cases.jobs.job.default_limits`. What they import is decided by `get_ready`."""
    return answers(LocalProcesses(limits=limits, preload=TELLING), jobs, title)


def asked_of_all(question: Callable[..., T], arguments: tuple[Any, ...], title: str, here: Container[str]) -> list[Outcome[T]]:
    """How each engine answers `question(name, *arguments)`, in their order.

    Args:
        question: see above.
        arguments: those behind the name.
        title: of them all, for the person who waits.
        here: engines that answer without loading a library: they are asked in this process.
    """
    from engines.registry import engine_names

    jobs = [Job(name, question, (name, *arguments)) for name in engine_names()]
    elsewhere = iter(asked([job for job in jobs if job.name not in here], title))
    return [_asked_here(job) if job.name in here else next(elsewhere) for job in jobs]


def _asked_here(job: Job[T]) -> Outcome[T]:
    try:
        return Outcome(job, job.function(*job.arguments))
    except Exception as error:
        return Outcome(job, failure=f"raised {type(error).__name__}: {error}", error=error)


def answer_of(job: Job[T], limits: Limits | None = None) -> T:
    """The job's value; `limits`: see `asked`.

    Raises:
        Refusal, SettingError, UnknownEngine, EngineFailure: as raised in the job.
        EngineDied: it ended in any other way.
    """
    (outcome,) = asked([job], f"engine {job.name}", limits)
    if outcome.value is not None:
        return outcome.value
    from engines.base import EngineFailure, Refusal
    from engines.registry import UnknownEngine
    from engines.settings import SettingError

    if isinstance(outcome.error, (Refusal, SettingError, UnknownEngine, EngineFailure)):
        raise outcome.error
    raise EngineDied(f"engine {outcome.job.name}: {outcome.explanation}", outcome)


@dataclass(frozen=True, kw_only=True)
class About:
    """An engine: what its error estimate is of, and whether it can be used here or why not."""

    name: str
    method: str
    version: str | None = None
    estimate_of: str | None = None
    available: bool
    reason: str | None


def about(name: str) -> About:
    """What an engine says of itself."""
    from engines.registry import engine

    found = engine(name)
    if reason := found.unavailable():
        return About(name=name, method=found.method, available=False, reason=reason)
    return About(name=name, method=found.method, version=found.version(), estimate_of=found.estimates, available=True, reason=None)


@dataclass(frozen=True)
class Setting:
    """A setting of an engine: name for `--set`, what is accepted, meaning."""

    name: str
    accepted: str
    meaning: str


@dataclass(frozen=True, kw_only=True)
class AboutSettings(About):
    """Besides, the accuracy that the engine works to unless asked, and its settings."""

    default_accuracy: float
    settings: tuple[Setting, ...]


def settings(name: str) -> AboutSettings:
    """What an engine says of itself and its settings."""
    from engines.registry import engine

    def accepted(field: "dataclasses.Field[Any]") -> str:
        about = field.metadata
        if about["choices"]:
            return ", ".join(about["choices"])
        return "true or false" if isinstance(field.default, bool) else f"{about['low']:g} to {about['high']:g} {about['unit']}".strip()

    found = engine(name)
    rows = [Setting(f"engine.{each.name}", accepted(each), each.metadata["meaning"]) for each in dataclasses.fields(found.settings_type)]
    return AboutSettings(**vars(about(name)), default_accuracy=found.default_accuracy, settings=tuple(rows))


def model(name: str, scene: "Scene") -> "ModelDescription":
    """What the engine builds for a scene with its default settings. Raises Refusal if it cannot."""
    from engines.registry import usable_engine
    from engines.scene import describe_scene

    return describe_scene(usable_engine(name), scene)


@dataclass(frozen=True)
class Modes:
    """Natural frequencies, Hz, ascending, and what they were computed with."""

    engine: str
    version: str
    settings: dict[str, Any]
    frequencies: list[float]


def modes(name: str, mechanism: "Mechanism", crank_angle: float, count: int, texts: Mapping[str, str]) -> Modes:
    """Natural frequencies with the crank held at `crank_angle` (rad). Raises as `engines.frozen_crank` does."""
    from engines.frozen_crank import natural_frequencies
    from engines.registry import usable_engine

    found = usable_engine(name)
    found.check(mechanism)
    settings = found.settings_for(found.default_accuracy, mechanism).with_texts(dict(texts))
    frequencies = natural_frequencies(found, mechanism, crank_angle, count, settings)
    return Modes(name, found.version(), settings.as_dict(), [float(frequency) for frequency in frequencies])


@dataclass(frozen=True)
class Failure:
    """Why a simulation has no end: the last good instant (s; None where the process died), the cause and what to try."""

    time: float | None
    cause: str
    advice: str


@dataclass(frozen=True, kw_only=True)
class Simulated:
    """What `quickreturn simulate --json` prints; None, empty or False where there is nothing after a failure."""

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


def simulate(
    name: str, case: "Case", texts: Mapping[str, str], accuracy: float | None, output: str, limits: Limits | None = None
) -> Simulated:
    """Simulate a case from its standard start and write the trajectory, as far as it got, to the file `output`.

    Raises:
        Refusal, SettingError, UnknownEngine, OutputError.
    """
    asked = Simulated(case=case.name, engine=name, output=output, notes=case.notes, accuracy=accuracy)
    try:
        found, table = answer_of(Job(name, _simulated, (asked, case, texts)), limits)
    except EngineDied as death:
        return _failed(asked, Failure(None, death.outcome.explanation, _ADVICE))
    if table is not None:
        write_file(Path(output), table)
    return found


def _simulated(asked: Simulated, case: "Case", texts: Mapping[str, str]) -> tuple[Simulated, bytes | None]:
    """The part of `simulate` that happens in the worker; with the trajectory as CSV as far as there is one."""
    from engines.base import EngineFailure
    from engines.registry import usable_engine
    from engines.scene import simulate_scene

    found = usable_engine(asked.engine)
    asked = dataclasses.replace(asked, version=found.version())
    try:
        result = simulate_scene(found, case.scene, case.duration, case.output_step, texts, asked.accuracy)
    except EngineFailure as failure:
        document, trajectory = _broken(asked, failure), failure.partial
    else:
        document, trajectory = _completed(asked, result), result.trajectory
    # pandas writes floats in full: the shortest text that reads back as the same number
    table = None if trajectory is None else trajectory.table().to_csv(index=False, lineterminator="\n").encode("ascii")
    return document, table


def _completed(asked: Simulated, result: "Result") -> Simulated:
    same = {each.name: getattr(result, each.name) for each in dataclasses.fields(Simulated) if hasattr(result, each.name)}
    same |= {"settings": result.settings.as_dict(), "statistics": dict(result.trajectory.statistics), **vars(result.description)}
    return dataclasses.replace(asked, rows=len(result.trajectory), **same)


def _broken(asked: Simulated, failure: "EngineFailure") -> Simulated:
    partial = failure.partial
    if partial is not None:
        statistics = dict(partial.statistics)
        asked = dataclasses.replace(asked, rows=len(partial), solve_seconds=partial.solve_seconds, statistics=statistics)
    return _failed(asked, Failure(failure.time, failure.cause, failure.advice))


def _failed(asked: Simulated, failure: Failure) -> Simulated:
    when = "" if failure.time is None else f"failed at t = {failure.time:.6g} s: "
    return dataclasses.replace(asked, remark=f"{when}{failure.cause}; {failure.advice}", failure=failure)
