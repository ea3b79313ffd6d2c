"""Requests to one engine on one scene: a trajectory from the standard start, or natural frequencies with the crank held.

Each is a job: it comes from the store if it is there, and is computed like all jobs otherwise (`cases.running.workshop`).
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, Any

from quickreturn.cases.running.job import Job, Outcome
from quickreturn.cases.running.store import can_be_stored
from quickreturn.engines import progress
from quickreturn.engines.accurate import Result, simulate
from quickreturn.engines.base import AnyEngine, EngineFailure
from quickreturn.engines.one_run import natural_frequencies
from quickreturn.engines.registry import usable_engine
from quickreturn.engines.start import standard_start
from quickreturn.reference_model.mechanism import Mechanism, Scene

if TYPE_CHECKING:
    from quickreturn.cases.files.case import Case

#: An engine's version, and its result or its failure.
Answer = tuple[str, Result | EngineFailure]


@dataclass(frozen=True, kw_only=True)
class TrajectoryRequest:
    """One engine on one scene, from the standard start; see `engines.accurate.simulate`."""

    scene: Scene
    duration: float  # s
    output_step: float  # s
    engine: str | AnyEngine  # the name; or an engine itself, whose answers are not stored
    settings: dict[str, str] = field(default_factory=dict)
    accuracy: float | None = None
    estimate: bool = True
    time_limit: float | None = field(default=None, compare=False)  # s; an answer that it cuts short is not stored

    def job(self, name: str) -> "Job[Answer]":
        """The request as a job; its failures are results."""
        return Job(name, answer_to, (self,), "trajectory", inputs=self, **kept(self.engine))


def inputs_of(case: "Case") -> tuple[Mechanism, float, float]:
    """Everything in a case that determines its trajectories: mechanism, duration (s) and output step (s)."""
    return case.mechanism, case.duration, case.output_step


def answer_to(request: TrajectoryRequest) -> Answer:
    """The engine's version, and its result or its failure.

    Raises:
        UnknownEngine, Refusal: there is no usable engine.
        ValueError, Refusal, SettingError: as `engines.accurate.simulate`.
    """
    chosen = usable_engine(request.engine) if isinstance(request.engine, str) else request.engine
    how = request.settings, request.accuracy, request.estimate, request.time_limit
    try:
        result = simulate(chosen, request.scene, standard_start(request.scene), request.duration, request.output_step, *how)
    except EngineFailure as failure:
        return chosen.version(), EngineFailure(
            failure.time, failure.cause, failure.advice, failure.partial
        )  # without the frames of the run
    return chosen.version(), replace(result, runs={})  # simulations stay in their process


def _lasts(outcome: Outcome[Any]) -> bool:
    """Whether there is an answer that can be stored and that no time limit cut short."""
    result = outcome.value[1] if isinstance(outcome.value, tuple) else None
    hurried = isinstance(result, Result) and result.hurried
    return outcome.completed and not hurried and can_be_stored(outcome.value)


def kept(engine: str | AnyEngine) -> dict[str, Any]:
    """Arguments of a job for its engine, and for the storage of its answer."""
    return {"engines": (engine,), "lasts": _lasts} if isinstance(engine, str) else {"lasts": None}


@dataclass(frozen=True)
class Frequencies:
    """Natural frequencies with the crank held, Hz, ascending, for each crank angle, with version and settings."""

    version: str  # of the engine
    settings: dict[str, Any]
    values: list[list[float]]


def frequencies_job(
    name: str, mechanism: Mechanism, engine: str | AnyEngine, crank_angles: Sequence[float], count: int, settings: Mapping[str, str]
) -> Job[Frequencies]:
    """The job for at most `count` frequencies at each crank angle (rad)."""
    arguments = mechanism, engine, tuple(crank_angles), count, dict(settings)
    return Job(name, frequencies_at, arguments, "natural frequencies", **kept(engine))


def frequencies_at(
    mechanism: Mechanism, engine: str | AnyEngine, crank_angles: Sequence[float], count: int, settings: Mapping[str, str]
) -> Frequencies:
    """See `frequencies_job`. Raises UnknownEngine, Refusal, SettingError, and EngineFailure as `engines.one_run`."""
    chosen = usable_engine(engine) if isinstance(engine, str) else engine
    chosen.check(mechanism)
    used = chosen.settings_for(chosen.default_accuracy, mechanism).with_texts(dict(settings))

    def at(angle: float) -> list[float]:
        frequencies = natural_frequencies(chosen, mechanism, angle, count, used).tolist()
        progress.tell(phase="natural frequencies")
        return frequencies

    progress.tell(engine=chosen.name, phase=progress.COMPILING if chosen.compiles else "natural frequencies")
    return Frequencies(chosen.version(), used.as_dict(), [at(angle) for angle in crank_angles])
