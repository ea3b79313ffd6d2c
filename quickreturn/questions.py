"""What the command line asks of engines, each question that may load a library in a process of its own.

A library that crashes, prints or holds on to the interpreter then costs no more than its own answer: Ctrl-C works at once, and
nothing but the command's own words gets to standard output. What an engine computed comes back through a pipe and is written here,
so that a worker which is killed leaves no half file behind.
"""

import dataclasses
from collections.abc import Callable, Container, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Final

from quickreturn.cases.errors import shortened
from quickreturn.cases.jobs.display import answers
from quickreturn.cases.jobs.here import done
from quickreturn.cases.jobs.job import Job, Limits, Outcome, T
from quickreturn.cases.jobs.processes import LocalProcesses
from quickreturn.reference_model.errors import ExitCode, ToldError

if TYPE_CHECKING:
    from quickreturn.cases.case import Case
    from quickreturn.engines.base import ModelDescription
    from quickreturn.reference_model.mechanism import Scene


class EngineDied(ToldError):
    """The process of an engine ended without an answer, or with an error that no engine should make; one sentence."""

    exit_code = ExitCode.ENGINE_TROUBLE


#: What processes import that tell of engines, those that compute.
DESCRIBING: Final = ("quickreturn.cases.jobs.worker", "quickreturn.engines.registry")
COMPUTING: Final = (*DESCRIBING, "quickreturn.cases.solving", "quickreturn.engines.own.simulation")
#: In place of an engine's name, among settings: whichever runs.
ANY_ENGINE: Final = "engine"


def asked(jobs: Sequence[Job[T]], title: str, limits: Limits | None = None, quiet: bool = True) -> list[Outcome[T]]:
    """How each of the jobs ended; `limits` None: `cases.jobs.job.default_limits`. What they import is decided by `get_ready`."""
    return answers(LocalProcesses(limits=limits, preload=DESCRIBING, quiet=quiet), jobs, title)


def asked_of_all(question: Callable[..., T], arguments: tuple[Any, ...], title: str, here: Container[str]) -> list[Outcome[T]]:
    """How each engine answers `question(name, *arguments)`; those in `here` load no library and are asked in this process."""
    from quickreturn.engines.registry import engine_names

    jobs = [Job(name, question, (name, *arguments)) for name in engine_names()]
    elsewhere = iter(asked([job for job in jobs if job.name not in here], title))
    return [done(job) if job.name in here else next(elsewhere) for job in jobs]


def value_of(outcome: Outcome[T]) -> T:
    """What a job came to. Raises Refusal, SettingError, UnknownEngine or EngineFailure as the job did, EngineDied if it ended otherwise."""
    if outcome.value is not None:
        return outcome.value
    from quickreturn.engines.base import EngineFailure, Refusal
    from quickreturn.engines.registry import UnknownEngine
    from quickreturn.engines.settings import SettingError

    if isinstance(outcome.error, (Refusal, SettingError, UnknownEngine, EngineFailure)):
        raise outcome.error
    raise EngineDied(f"engine {outcome.job.name}: {outcome.explanation}")


def settings_of(settings: Mapping[str, Mapping[str, str]], names: Sequence[str]) -> dict[str, dict[str, str]]:
    """Settings by engine: those for `ANY_ENGINE`, and before these its own. SettingError: of an engine that is not among those that run."""
    from quickreturn.engines.settings import SettingError

    for name, texts in settings.items():
        if name != ANY_ENGINE and name not in names:
            key = next(iter(texts), "")
            raise SettingError(f"{name}.{shortened(key)}: engine {name} does not run here; those that do are {', '.join(names)}")
    return {name: {**settings.get(ANY_ENGINE, {}), **settings.get(name, {})} for name in names}


def check(name: str, scene: "Scene", settings: Mapping[str, str]) -> None:
    """Raises what can be known before anything runs: UnknownEngine; Refusal or SettingError of one of this project's engines."""
    from quickreturn.engines.registry import OWN, engine, engine_names
    from quickreturn.engines.scene import check_scene

    if name in engine_names() and name not in OWN:  # it would load its library here
        return
    found = engine(name)
    found.settings_type().with_texts(dict(settings))
    check_scene(found, scene)


def check_settings(cases: "Sequence[Case]", settings: Mapping[str, Mapping[str, str]]) -> None:
    """Find out before anything runs whether settings can be. SettingError: one that an engine does not have or take."""
    from quickreturn.engines.registry import engine
    from quickreturn.engines.settings import SettingError

    for name, texts in settings.items():
        for case in cases if texts else ():
            chosen = engine(name)
            try:
                chosen.settings_for(chosen.default_accuracy, case.mechanism).with_texts(dict(texts))
            except SettingError as error:  # several engines may share the settings, and one of them may lack one
                raise SettingError(f"{error} (engine {name})" if len(settings) > 1 else str(error)) from error


@dataclass(frozen=True, kw_only=True)
class About:
    """An engine: what its error estimate is of, and whether it can be used here or why not."""

    name: str
    method: str
    version: str | None = None
    estimate_of: str | None = None
    available: bool
    reason: str | None

    @property
    def estimate(self) -> str:
        """What its error estimate is of, in words."""
        from quickreturn.reports.words import ESTIMATE

        if self.estimate_of is None:
            return "-"
        name, beside = ESTIMATE[self.estimate_of]
        return f"{name.removesuffix(' estimate')}{beside and '; '}{beside}"


def about(name: str) -> About:
    """What an engine says of itself."""
    from quickreturn.engines.registry import engine

    found = engine(name)
    if reason := found.unavailable():
        return About(name=name, method=found.method, available=False, reason=reason)
    return About(name=name, method=found.method, version=found.version(), estimate_of=found.estimates, available=True, reason=None)


def about_all() -> list[About]:
    """What all engines say of themselves."""
    from quickreturn.engines.registry import OWN

    return [
        each.value or About(name=each.job.name, method="unknown", available=False, reason=f"asked about itself, it {each.failure}")
        for each in asked_of_all(about, (), "engines", OWN)
    ]


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
    from quickreturn.engines.registry import engine

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
    from quickreturn.engines.registry import usable_engine
    from quickreturn.engines.scene import describe_scene

    return describe_scene(usable_engine(name), scene)
