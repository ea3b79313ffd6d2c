"""Queries of the command line to engines. A query that may load a library runs in a process of its own.

If a library crashes, prints or blocks the interpreter, only its own answer is lost: Ctrl-C works at once, and standard output has only the
command's own text. Results come back through a pipe and this process writes them, so that a killed worker leaves no incomplete file.
"""

import dataclasses
from collections.abc import Callable, Container, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
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
    """The process of an engine ended without an answer, or with an unexpected error; the text is one sentence."""

    exit_code = ExitCode.ENGINE_TROUBLE


#: Modules that are preloaded: in processes that describe engines, and in those that run them.
DESCRIBING: Final = ("quickreturn.cases.jobs.worker", "quickreturn.engines.registry")
COMPUTING: Final = (*DESCRIBING, "quickreturn.cases.solving", "quickreturn.engines.own.simulation")
#: Stands for every engine that runs, in place of an engine's name among settings.
ANY_ENGINE: Final = "engine"


def asked(jobs: Sequence[Job[T]], title: str, limits: Limits | None = None, quiet: bool = True) -> list[Outcome[T]]:
    """The outcome of each job; `limits` None: the default ones. Jobs preload `DESCRIBING` unless `get_ready` has chosen other modules."""
    return answers(LocalProcesses(limits=limits, preload=DESCRIBING, quiet=quiet), jobs, title)


def asked_of_all(question: Callable[..., T], arguments: tuple[Any, ...], title: str, here: Container[str]) -> list[Outcome[T]]:
    """The answer of each engine to `question(name, *arguments)`; engines in `here` load no library and answer in this process."""
    from quickreturn.engines.registry import engine_names

    jobs = [Job(name, question, (name, *arguments)) for name in engine_names()]
    with ThreadPoolExecutor(1) as beside:  # while the other processes answer
        own = {job.name: beside.submit(done, job) for job in jobs if job.name in here}
        elsewhere = iter(asked([job for job in jobs if job.name not in here], title))
        return [own[job.name].result() if job.name in here else next(elsewhere) for job in jobs]


def value_of(outcome: Outcome[T]) -> T:
    """The value of a job. Raises Refusal, SettingError, UnknownEngine or EngineFailure as the job did, EngineDied if it ended otherwise."""
    if outcome.value is not None:
        return outcome.value
    from quickreturn.engines.base import EngineFailure, Refusal
    from quickreturn.engines.registry import UnknownEngine
    from quickreturn.engines.settings import SettingError

    if isinstance(outcome.error, (Refusal, SettingError, UnknownEngine, EngineFailure)):
        raise outcome.error
    raise EngineDied(f"engine {outcome.job.name}: {outcome.explanation}")


def settings_of(settings: Mapping[str, Mapping[str, str]], names: Sequence[str]) -> dict[str, dict[str, str]]:
    """Settings by engine: those for `ANY_ENGINE`, overridden by its own. SettingError: there are some for an engine that does not run."""
    from quickreturn.engines.settings import SettingError

    for name, texts in settings.items():
        if name != ANY_ENGINE and name not in names:
            key = next(iter(texts), "")
            raise SettingError(f"{name}.{shortened(key)}: engine {name} does not run here; those that do are {', '.join(names)}")
    return {name: {**settings.get(ANY_ENGINE, {}), **settings.get(name, {})} for name in names}


def check(name: str, scene: "Scene", settings: Mapping[str, str]) -> None:
    """Check an engine before anything runs. Raises UnknownEngine, or Refusal or SettingError of one of this project's engines."""
    from quickreturn.engines.registry import OWN, engine, engine_names
    from quickreturn.engines.scene import check_scene

    if name in engine_names() and name not in OWN:  # an engine of another package would load its library here
        return
    chosen = engine(name)
    chosen.settings_type().with_texts(dict(settings))
    check_scene(chosen, scene)


def check_settings(cases: "Sequence[Case]", settings: Mapping[str, Mapping[str, str]]) -> None:
    """Check settings before anything runs. SettingError: an engine does not have a setting, or does not accept its value."""
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
        from quickreturn.reports.words import ESTIMATE

        if self.estimate_of is None:
            return "-"
        name, beside = ESTIMATE[self.estimate_of]
        return f"{name.removesuffix(' estimate')}{beside and '; '}{beside}"


def about(name: str) -> About:
    """The description of an engine by itself."""
    from quickreturn.engines.registry import engine

    chosen = engine(name)
    if reason := chosen.unavailable():
        return About(name=name, method=chosen.method, available=False, reason=reason)
    return About(name=name, method=chosen.method, version=chosen.version(), estimate_of=chosen.estimates, available=True, reason=None)


def about_all() -> list[About]:
    """The descriptions of all engines by themselves."""
    from quickreturn.engines.registry import LIGHT

    return [
        each.value or About(name=each.job.name, method="unknown", available=False, reason=f"could not be queried: it {each.failure}")
        for each in asked_of_all(about, (), "engines", LIGHT)
    ]


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
    from quickreturn.engines.registry import engine

    def accepted(field: "dataclasses.Field[Any]") -> str:
        about = field.metadata
        if about["choices"]:
            return ", ".join(about["choices"])
        return "true or false" if isinstance(field.default, bool) else f"{about['low']:g} to {about['high']:g} {about['unit']}".strip()

    chosen = engine(name)
    rows = [Setting(f"engine.{each.name}", accepted(each), each.metadata["meaning"]) for each in dataclasses.fields(chosen.settings_type)]
    return AboutSettings(**vars(about(name)), default_accuracy=chosen.default_accuracy, settings=tuple(rows))


def model(name: str, scene: "Scene") -> "ModelDescription":
    """The model that the engine builds for a scene with its default settings. Refusal: it cannot model the scene."""
    from quickreturn.engines.registry import usable_engine
    from quickreturn.engines.scene import describe_scene

    return describe_scene(usable_engine(name), scene)
