"""Runs of the tested engine and of `reference`, and the tolerances of their differences."""

import contextlib
import functools
import time
from collections import Counter
from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass, replace
from typing import Final, TypeVar

from quickreturn.cases.conformance.checks import NOT_QUICK, Array, LeftOut
from quickreturn.cases.conformance.scenes import BASE, DURATION, OUTPUT_STEP, PRESCRIBED, UNTIL_BENT
from quickreturn.cases.jobs.tally import span
from quickreturn.cases.variation import Variation
from quickreturn.engines import progress
from quickreturn.engines.base import AnyEngine, Engine, EngineFailure, Refusal
from quickreturn.engines.error_parts import compared
from quickreturn.engines.one_run import run_once
from quickreturn.engines.own.reference import ReferenceEngine, ReferenceSettings
from quickreturn.engines.registry import usable_engine
from quickreturn.engines.relative import rms, scale
from quickreturn.engines.scene import check_scene
from quickreturn.engines.settings import Settings
from quickreturn.engines.start import Start, standard_start
from quickreturn.engines.trajectory import REQUIRED, Trajectory
from quickreturn.reference_model.columns import COLUMNS
from quickreturn.reference_model.errors import ImpossibleMechanism
from quickreturn.reference_model.mechanism import Mechanism, Scene
from quickreturn.reference_model.scene_values import AnyScene

T = TypeVar("T")

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
#: Number of rungs above the default that are tried until an error falls: on a ladder of small steps one rung changes little.
_SHARPENED: Final = 3
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


@dataclass(frozen=True)
class Truth:
    """A converged solution and, column by column, its approximate error (in the column's unit)."""

    columns: Mapping[str, Array]
    uncertainty: Mapping[str, float]


@functools.lru_cache(maxsize=512)
def solution(motion: Motion) -> Mapping[str, Array]:
    """Columns of the motion by `reference` with five modes."""
    return motion.by(ReferenceEngine(), _FINEST).columns


@functools.lru_cache(maxsize=128)
def truth(motion: Motion) -> Truth:
    """`solution` with its uncertainty from a run with four modes."""
    finest, fine = solution(motion), motion.by(ReferenceEngine(), _FINE).columns
    return Truth(finest, {name: rms(finest[name] - fine[name]) for name in COMPARED if name in finest})


@functools.lru_cache(maxsize=4)
def bent_start(mechanism: Mechanism) -> Start:
    """A start with a bent follower in motion: the state of the scene after a while."""
    simulation = ReferenceEngine().prepare(mechanism, standard_start(mechanism), _FINEST)
    simulation.advance(UNTIL_BENT, OUTPUT_STEP)
    start = simulation.present_start()
    assert start is not None
    return start


class Bench:
    """The tested engine on the scenes of its trial.

    Attributes:
        engine: the engine.
        scene: the mild scene, with the drive that the engine can model.
        mild: the motion in it; that of the follower alone for an engine without mechanism.
        seconds: limit of wall time for the engine's runs; None: no limit.
        expected: approximate number of runs of the engine; 0: unknown.
    """

    def __init__(self, engine: AnyEngine, seconds: float | None = None, alone: Motion | None = None) -> None:
        """Raises Refusal if the engine can model the scene with neither drive, and no motion of a follower alone is given."""
        self.engine, self.seconds, self.expected = engine, seconds, 0
        self.scene, self.mild = BASE, alone or Motion(BASE)
        if alone is None:
            try:
                engine.check(BASE)
            except Refusal:
                engine.check(PRESCRIBED)
                self.scene, self.mild = PRESCRIBED, Motion(PRESCRIBED)
        self._runs: dict[tuple[Motion, Settings], Trajectory] = {}
        self._spent, self._simulated = 0.0, 0.0
        self.begin()

    def begin(self) -> None:
        """Begin to count the limited time."""
        self._began = time.monotonic()

    def settings(self, scene: Scene) -> Settings:
        """The engine's default settings for a scene."""
        settings: Settings = self.engine.settings_for(self.engine.default_accuracy, scene)
        return settings

    def run(self, motion: Motion, settings: Settings | None = None) -> Trajectory:
        """A complete and finite run. Raises as `run_once`, and LeftOut."""
        key = motion, settings or self.settings(motion.scene)
        if key not in self._runs:
            self._compile(motion, key[1])
            self._tell(motion)
            began = time.monotonic()
            try:
                self._runs[key] = motion.by(self.engine, key[1])
            finally:
                self._spent += time.monotonic() - began
                self._simulated += motion.duration
        return self._runs[key]

    def _compile(self, motion: Motion, settings: Settings) -> None:
        """Make a run of a single row before the first run, so that no time contains compilation or loading."""
        if self._runs or not self.engine.compiles:
            return
        progress.tell(engine=self.engine.name, phase="compiling")
        with contextlib.suppress(EngineFailure):
            replace(motion, duration=motion.output_step).by(self.engine, settings)
        self.begin()

    def _tell(self, motion: Motion) -> None:
        """Report the progress of the trial. Raises LeftOut if the next run does not fit into the remaining time."""
        done = len(self._runs)
        ahead = self._spent / self._simulated * motion.duration if self._simulated else 0.0
        if self.seconds is not None and done and time.monotonic() - self._began + ahead > self.seconds:
            raise LeftOut(f"left out: there was no time for it, a run takes about {span(ahead)}", NOT_QUICK)
        rest = self._spent / done * (self.expected - done) if done else 0.0
        if self.seconds is not None:
            rest = min(rest, self.seconds - (time.monotonic() - self._began))
        left = f", about {span(rest)} left" if rest > 0.0 else ""
        of = f" of about {max(self.expected, done + 1)}" if self.expected else ""
        progress.tell(engine=self.engine.name, phase=f"run {done + 1}{of}{left}")

    def finer(self, scene: Scene, settings: Settings) -> Settings | None:
        """The next rung for an error that is twice as large as allowed."""
        parts = Counter(pair.of for pair in self.engine.comparisons(settings, scene, OUTPUT_STEP))
        next_rung: Settings | None = self.engine.finer(settings, {of: 2.0 * count for of, count in parts.items()}, OUTPUT_STEP)
        return next_rung

    def sharpened(self, motion: Motion) -> Iterator[Trajectory]:
        """Runs of a few rungs above the default: an error that falls with them is one of the resolution."""
        settings: Settings | None = self.settings(motion.scene)
        for _ in range(_SHARPENED):
            settings = self.finer(motion.scene, settings) if settings is not None else None
            if settings is None:
                return
            try:
                yield self.run(motion, settings)
            except EngineFailure:
                return

    def coarsened(self, motion: Motion) -> Trajectory | None:
        """A run that is coarser than the default according to `comparisons`; None if they name none."""
        settings = self.settings(motion.scene)
        pairs = self.engine.comparisons(settings, motion.scene, motion.output_step)
        coarser = [pair for pair in pairs if pair.factor > 1.0 and pair.run == settings]
        try:
            return self.run(motion, coarser[0].other) if coarser else None
        except EngineFailure:
            return None

    def errors(self, motion: Motion) -> dict[str, float]:
        """Name -> RMS error of a column that is compared with `reference`, over its `scale`."""
        run, right = self.run(motion), truth(motion).columns
        return {name: rms(run[name] - right[name]) / scale(name, right) for name in compared_columns(run, right=right)}

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
        right = truth(motion)
        return {
            name: TOLERANCE_FACTOR * (estimate + right.uncertainty[name]) + ROUNDING * rms(right.columns[name])
            for name, estimate in estimates.items()
            if name in right.columns
        }


def compared_columns(run: Trajectory, among: Iterable[str] = COMPARED, right: Mapping[str, Array] | None = None) -> tuple[str, ...]:
    """Names of the columns of `run` that are in `among` and, if columns by `reference` are given (`right`), not zero in these."""
    names = [name for name in among if name in run.columns]
    return tuple(name for name in names if right is None or (name in right and rms(right[name]) > 0.0))


def possible_results(scene: AnyScene, variations: Iterable[Variation], result_of: Callable[[AnyScene], T]) -> Iterator[tuple[str, T]]:
    """The name and the result of each variation of a scene; variations that are impossible or cannot be simulated are left out."""
    for variation in variations:
        with contextlib.suppress(EngineFailure, ImpossibleMechanism):
            yield variation.name, result_of(variation.of(scene))
