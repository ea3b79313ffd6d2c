"""Descriptions that engines give of themselves: methods, settings, models.

One that may load a library is made in a process of its own. If the library crashes, prints or blocks the interpreter, only its own
description is lost: Ctrl-C works at once, and standard output has only the command's own text.
"""

import dataclasses
from collections.abc import Callable, Container, Iterator, Sequence
from dataclasses import dataclass
from typing import Any

from quickreturn.arguments import Listing
from quickreturn.cases.running.display import answers
from quickreturn.cases.running.fork_server import DESCRIBING
from quickreturn.cases.running.isolation import LocalProcesses
from quickreturn.cases.running.job import Job, Limits, Outcome, T, done
from quickreturn.engines.accurate import describe_scene
from quickreturn.engines.base import EngineFailure, ModelDescription, Refusal
from quickreturn.engines.registry import UnknownEngine, engine, engine_names, own_engines, usable_engine
from quickreturn.engines.settings import SettingError
from quickreturn.reference_model.errors import EngineTrouble
from quickreturn.reference_model.mechanism import Scene


class EngineDied(EngineTrouble):
    """The process of an engine ended without an answer, or with an unexpected error; the text is one sentence."""


def outcomes(jobs: Sequence[Job[T]], title: str, limits: Limits | None = None, quiet: bool = True) -> list[Outcome[T]]:
    """The outcome of each job; `limits` None: the default ones. Jobs preload `DESCRIBING` unless `get_ready` has chosen other modules."""
    return answers(LocalProcesses(limits=limits, preload=DESCRIBING, quiet=quiet), jobs, title)


def by_each(describe: Callable[..., T], arguments: tuple[Any, ...], title: str, here: Container[str]) -> Iterator[Outcome[T]]:
    """`describe(name, *arguments)` for each engine, as it comes; those of engines in `here`, which load no library, in this process."""
    jobs, elsewhere = [Job(name, describe, (name, *arguments)) for name in engine_names()], None
    for job in jobs:
        if job.name not in here and elsewhere is None:
            elsewhere = iter(outcomes([each for each in jobs if each.name not in here], title))
        yield done(job) if elsewhere is None or job.name in here else next(elsewhere)


def value_of(outcome: Outcome[T]) -> T:
    """The value of a job. Raises Refusal, SettingError, UnknownEngine or EngineFailure as the job did, EngineDied if it ended otherwise."""
    if outcome.value is not None:
        return outcome.value
    if isinstance(outcome.error, (Refusal, SettingError, UnknownEngine, EngineFailure)):
        raise outcome.error
    raise EngineDied(f"engine {outcome.job.name}: {outcome.explanation}")


@dataclass(frozen=True, kw_only=True)
class About:
    """An engine, as it describes itself."""

    name: str
    method: str
    version: str | None = None  # of the library behind it; None if it is not available
    estimate_of: str | None = None  # what its error estimate covers, see `engines.base.EstimateOf`
    available: bool  # whether it can be used on this machine
    reason: str | None  # why not

    @property
    def estimate(self) -> str:
        """What its error estimate covers, in words."""
        from quickreturn.reports.words import ESTIMATE  # with the library of cases, which a process that describes an engine does not need

        if self.estimate_of is None:
            return "-"
        name, beside = ESTIMATE[self.estimate_of]
        return f"{name.removesuffix(' estimate')}{beside and '; '}{beside}"


def about(name: str) -> About:
    """The description of an engine by itself."""
    chosen = engine(name)
    if reason := chosen.unavailable():
        return About(name=name, method=chosen.method, available=False, reason=reason)
    return About(name=name, method=chosen.method, version=chosen.version(), estimate_of=chosen.estimates, available=True, reason=None)


def list_engines() -> "Listing[About]":
    """All engines: name, version, what their error estimates cover, method, and whether they can be used on this machine or why not."""
    described = [
        each.value or About(name=each.job.name, method="unknown", available=False, reason=f"could not be queried: it {each.failure}")
        for each in by_each(about, (), "engines", own_engines())
    ]
    return Listing.of(
        described,
        NAME=lambda each: each.name,
        VERSION=lambda each: each.version or "-",
        ESTIMATES=lambda each: each.estimate,
        METHOD=lambda each: each.method,
        STATE=lambda each: "available" if each.available else f"not available: {each.reason}",
    )


@dataclass(frozen=True)
class Setting:
    """A setting of an engine."""

    name: str  # key for `--set`
    accepted: str  # accepted values, in words
    meaning: str


@dataclass(frozen=True, kw_only=True)
class AboutSettings(About):
    """An engine with its default accuracy and its settings."""

    default_accuracy: float
    settings: tuple[Setting, ...]


def settings(name: str) -> AboutSettings:
    """The description of an engine and of its settings by itself."""

    def accepted(field: "dataclasses.Field[Any]") -> str:
        about = field.metadata
        if about["choices"]:
            return ", ".join(about["choices"])
        return "true or false" if isinstance(field.default, bool) else f"{about['low']:g} to {about['high']:g} {about['unit']}".strip()

    chosen = engine(name)
    rows = [Setting(f"engine.{each.name}", accepted(each), each.metadata["meaning"]) for each in dataclasses.fields(chosen.settings_type)]
    return AboutSettings(**vars(about(name)), default_accuracy=chosen.default_accuracy, settings=tuple(rows))


def model(name: str, scene: Scene) -> ModelDescription:
    """The model that the engine builds for a scene with its default settings. Refusal: it cannot model the scene."""
    return describe_scene(usable_engine(name), scene)
