"""Runs of the tested engine and of `reference`, the tolerances of their differences, and the outcomes of checks."""

import functools
from collections import Counter
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any, Final, Literal

from quickreturn.cases.files.shown import Cell, Printable, Rows
from quickreturn.engines import progress
from quickreturn.engines.accurate import check_scene
from quickreturn.engines.base import AnyEngine, Engine, EngineFailure, Refusal, first_line
from quickreturn.engines.error_parts import compared
from quickreturn.engines.one_run import raised_at, run_once
from quickreturn.engines.own.reference import ReferenceEngine, ReferenceSettings
from quickreturn.engines.registry import usable_engine
from quickreturn.engines.settings import Settings
from quickreturn.engines.start import Start, standard_start
from quickreturn.engines.trajectory import REQUIRED, Trajectory, rms
from quickreturn.plugins.conform.scenes import ALONE, BASE, CLAMPED, DURATION, OUTPUT_STEP, PRESCRIBED, SPUN_UP, UNTIL_BENT
from quickreturn.reference_model.arrays import Array
from quickreturn.reference_model.columns import COLUMNS
from quickreturn.reference_model.mechanism import Mechanism, Scene

Status = Literal["passed", "failed", "not judged"]

#: Largest number of names in a sentence.
_NAMED: Final = 4


@dataclass(frozen=True)
class Check:
    """One check of an adapter."""

    check: str  # name of the check
    status: Status  # how it ended
    cause: str = ""  # what is wrong, why it was not judged, or that a passed one was refused
    advice: str = ""  # what to do, by the engine that breaks down


@dataclass(frozen=True, repr=False)
class Conformance(Printable):
    """The outcome of all checks of an engine."""

    engine: str
    conforms: bool | None  # False if a check failed; None if nothing could be judged
    checks: tuple[Check, ...]

    def _parts(self) -> Iterator[Cell]:
        yield f"{self.engine}: {self.verdict}"
        lines = [(each.check, each.status, "; ".join(filter(None, (each.cause, each.advice)))) for each in self.checks]
        yield Rows(lines, ("check", "status", "cause"))

    @property
    def failed(self) -> tuple[Check, ...]:
        """The checks that failed."""
        return tuple(check for check in self.checks if check.status == "failed")

    @property
    def verdict(self) -> str:
        """The outcome in words."""
        failed = f"does not conform: {len(self.failed)} check{'s' * (len(self.failed) > 1)} failed"
        return {True: "conforms", False: failed, None: "not judged"}[self.conforms]


class Fault(Exception):
    """What is wrong: the check fails."""

    status: Status = "failed"


class Unjudged(Fault):
    """Why a check cannot be made."""

    status: Status = "not judged"


def check_by(name: str, look: Callable[..., None], *arguments: Any) -> Check:
    """The check by a function, which raises `Fault`. The engine that it runs may refuse, or raise anything."""
    try:
        look(*arguments)
        return Check(name, "passed")
    except Refusal as refusal:
        return Check(name, "passed", f"refused: {refusal}")
    except Exception as error:  # an author's engine may raise anything
        return ended(name, error)


def ended(name: str, error: Exception) -> Check:
    """The check that an exception ended."""
    if isinstance(error, Fault):
        return Check(name, error.status, str(error))
    if isinstance(error, Refusal):
        return Check(name, "not judged", f"the engine models no scene of a trial: {error}")
    if isinstance(error, EngineFailure):
        return Check(name, "failed", f"a run breaks down: {error.cause}", error.advice)
    return Check(name, "failed", f"the engine raises {type(error).__name__}{raised_at(error)}: {first_line(error)}")


def some(names: Sequence[str]) -> str:
    """Names for a sentence: the first ones, and the number of the others."""
    more = len(names) - _NAMED
    return ", ".join(names) if more <= 1 else f"{', '.join(names[:_NAMED])} and {more} more"


#: Columns that are not compared with `reference`: the grid, residuals of a model's own numerics, and the acceleration of a base that rings
#: with vibrations faster than any model here resolves, which is held against the engine's own `follower_rate`.
_NOT_COMPARED: Final = ("time", "constraint_gap", "axial_stretch", "follower_acceleration")
#: Columns that are compared with `reference`, if the engine delivers them.
COMPARED: Final = tuple(name for name in COLUMNS if name not in _NOT_COMPARED)
#: Columns from which a mistake of the model is recognised: the others follow from them.
DECISIVE: Final = (*(name for name in REQUIRED if name != "time"), "crank_torque", "kinetic_energy", "strain_energy", "dissipated_energy")

#: Settings of the converged solution: five modes leave an error of 1e-5 of the tip deflection in the mild scene, and tables of more modes
#: take seconds to build. Its uncertainty comes from a run with the settings `_FINE`.
_FINEST: Final = ReferenceSettings(modes=5, tolerance=1e-8)
_FINE: Final = ReferenceSettings(modes=4, tolerance=1e-8)
#: Tolerance of a column over its error estimate: in 59 measured scenes the worst claim of this project's engines was exceeded 2.5-fold.
TOLERANCE_FACTOR: Final = 3.0
#: Part of a column's size that counts as rounding of sums.
ROUNDING: Final = 1e-6


def engine_from(engine: AnyEngine | str) -> AnyEngine:
    """The engine itself, or the usable one of this name. Raises UnknownEngine, Refusal as `usable_engine`."""
    return engine if isinstance(engine, Engine) else usable_engine(engine)


@dataclass(frozen=True)
class Motion:
    """A motion to simulate: a scene from a start, the standard one by default; duration and output step in s."""

    scene: Scene
    duration: float = DURATION
    output_step: float = OUTPUT_STEP
    start: Start | None = None

    def by(self, engine: AnyEngine, settings: Settings) -> Trajectory:
        """A complete and finite run of an engine. Raises as `run_once`; Refusal if it does not model a follower alone."""
        check_scene(engine, self.scene)
        return run_once(engine, self.scene, self.start or standard_start(self.scene), self.duration, self.output_step, settings).trajectory


@functools.lru_cache(maxsize=512)
def solution(motion: Motion, settings: ReferenceSettings = _FINEST) -> Mapping[str, Array]:
    """Columns of the motion by `reference`, with five modes."""
    return motion.by(ReferenceEngine(), settings).columns


def uncertainty(motion: Motion) -> dict[str, float]:
    """Approximate error of the columns of `solution`, in the column's unit: from a run with four modes."""
    fine = solution(motion, _FINE)
    return {name: rms(values - fine[name]) for name, values in solution(motion).items()}


@functools.lru_cache(maxsize=4)
def bent_start(mechanism: Mechanism) -> Start:
    """A start with a bent follower in motion: the state of the scene after a while."""
    simulation = ReferenceEngine().prepare(mechanism, standard_start(mechanism), _FINEST)
    simulation.advance(UNTIL_BENT, OUTPUT_STEP)
    start = simulation.present_start()
    assert start is not None
    return start


#: Motions with a mechanism and of a follower alone: of each kind an engine is tried in the first that it models.
MECHANISMS: Final = (Motion(BASE), Motion(PRESCRIBED))
FOLLOWERS: Final = tuple(Motion(scene, SPUN_UP) for scene in (ALONE, replace(ALONE, tip=None), CLAMPED))


def first_modelled(engine: AnyEngine, motions: Iterable[Motion]) -> Motion:
    """The first motion whose scene the engine models. Raises Refusal if there is none."""
    refusals = list[Refusal]()
    for motion in motions:
        try:
            check_scene(engine, motion.scene)
        except Refusal as refusal:
            refusals.append(refusal)
        else:
            return motion
    raise refusals[0]


class Bench:
    """The tested engine on the scenes of its trial.

    Attributes:
        engine: the engine.
        scene: the mild scene, with the drive that the engine can model.
        mild: the motion in it; that of a follower alone for an engine without mechanism.
    """

    def __init__(self, engine: AnyEngine) -> None:
        """Raises Refusal if the engine models no scene."""
        self.engine, self._runs = engine, dict[tuple[Motion, Settings], Trajectory]()
        self.mild = first_modelled(engine, MECHANISMS + FOLLOWERS)
        self.scene: Any = self.mild.scene

    def settings(self, scene: Scene) -> Settings:
        """The engine's default settings for a scene."""
        settings: Settings = self.engine.settings_for(self.engine.default_accuracy, scene)
        return settings

    def run(self, motion: Motion, settings: Settings | None = None) -> Trajectory:
        """A complete and finite run. Raises as `run_once`."""
        key = motion, settings or self.settings(motion.scene)
        if key not in self._runs:
            progress.tell(engine=self.engine.name, phase=f"run {len(self._runs) + 1}")
            self._runs[key] = motion.by(self.engine, key[1])
        return self._runs[key]

    def finer(self, scene: Scene, settings: Settings) -> Settings | None:
        """The next rung for an error that is twice as large as allowed."""
        parts = Counter(pair.of for pair in self.engine.comparisons(settings, scene, OUTPUT_STEP))
        next_rung: Settings | None = self.engine.finer(settings, {of: 2.0 * count for of, count in parts.items()}, OUTPUT_STEP)
        return next_rung

    @property
    def claims(self) -> bool:
        """Whether the engine estimates its distance from the solution of the scene."""
        return self.engine.estimates == "total"

    def estimates(self, motion: Motion, settings: Settings | None = None) -> dict[str, float] | None:
        """The engine's error by its own comparisons, in the unit of each column; None if they show none."""
        parts, settings = dict[str, float](), settings or self.settings(motion.scene)
        try:
            for pair in self.engine.comparisons(settings, motion.scene, motion.output_step):
                if pair.run == pair.other:
                    return None
                runs = compared(pair, settings, functools.partial(self.run, motion))
                for name in compared_columns(runs.run):
                    parts[name] = parts.get(name, 0.0) + runs.part(lambda a, b, name=name: rms(a[name] - b[name])).error  # type: ignore[misc]
        except EngineFailure:
            return None
        return parts

    def tolerances(self, motion: Motion) -> dict[str, float] | None:
        """Tolerance of each column, in its unit; None if the engine does not say."""
        estimates = self.estimates(motion) if self.claims else None
        if estimates is None:
            return None
        right, unsure = solution(motion), uncertainty(motion)
        return {
            name: TOLERANCE_FACTOR * (estimate + unsure[name]) + ROUNDING * rms(right[name])
            for name, estimate in estimates.items()
            if name in right
        }


def compared_columns(run: Trajectory, among: Iterable[str] = COMPARED, right: Mapping[str, Array] | None = None) -> tuple[str, ...]:
    """Names of the columns of `run` that are in `among` and, if columns by `reference` are given (`right`), not zero in these."""
    names = [name for name in among if name in run.columns]
    return tuple(name for name in names if right is None or (name in right and rms(right[name]) > 0.0))
