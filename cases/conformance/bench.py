"""Runs of the engine in question and of `reference`, and by how much they may differ."""

import functools
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Final

from cases.conformance.checks import Array
from cases.conformance.scenes import BASE, DURATION, OUTPUT_STEP, PRESCRIBED, UNTIL_BENT
from engines.accurate import compared, run_once
from engines.base import AnyEngine, Engine, EngineFailure, Refusal
from engines.own.reference import ReferenceEngine, ReferenceSettings
from engines.own.simulation import OwnSimulation
from engines.registry import usable_engine
from engines.relative import rms
from engines.settings import Settings
from engines.start import Start, standard_start
from engines.trajectory import REQUIRED, Trajectory
from reference_model.mechanism import Mechanism

#: Columns that are held against `reference`; those that are not required, where the engine has them.
COMPARED: Final = (*(name for name in REQUIRED if name != "time"), "crank_torque", "kinetic_energy", "strain_energy", "dissipated_energy")

#: Tables of more than five modes take seconds to build, and five leave 1e-5 of the tip deflection in the mild scene.
_FINEST: Final = ReferenceSettings(modes=5, tolerance=1e-8)
_FINE: Final = ReferenceSettings(modes=4, tolerance=1e-8)
#: By how many times its own estimate a column may be off: of the claims measured in 59 scenes the worst was missed 2.5-fold, and in a
#: column that no claim is made for the estimate is this module's.
BENEFIT: Final = 3.0
#: Part of a column's size that nobody notices: sums of many numbers are rounded.
ROUNDING: Final = 1e-6


def found_engine(engine: AnyEngine | str) -> AnyEngine:
    """The engine itself, or the usable one of this name. Raises UnknownEngine, Refusal as `usable_engine`."""
    return engine if isinstance(engine, Engine) else usable_engine(engine)


@dataclass(frozen=True)
class Motion:
    """What is simulated: a scene from a start, the standard one by default; duration and output step in s."""

    scene: Mechanism
    duration: float = DURATION
    output_step: float = OUTPUT_STEP
    start: Start | None = None

    def by(self, engine: AnyEngine, settings: Settings) -> Trajectory:
        """A complete and finite run of an engine. Raises as `run_once`."""
        start = self.start or standard_start(self.scene)
        return run_once(engine, self.scene, start, self.duration, self.output_step, settings).trajectory


@dataclass(frozen=True)
class Truth:
    """A converged solution and, column by column, about how far it can be trusted (in the column's unit)."""

    columns: Mapping[str, Array]
    uncertainty: Mapping[str, float]


@functools.lru_cache(maxsize=128)
def truth(motion: Motion) -> Truth:
    """The motion by `reference` with five modes; four show its uncertainty."""
    finest, fine = (motion.by(ReferenceEngine(), settings).columns for settings in (_FINEST, _FINE))
    return Truth(finest, {name: rms(finest[name] - fine[name]) for name in COMPARED})


@functools.lru_cache(maxsize=4)
def bent_start(mechanism: Mechanism) -> Start:
    """A bent follower in motion: where the scene is after a while."""
    simulation = ReferenceEngine().prepare(mechanism, standard_start(mechanism), _FINEST)
    assert isinstance(simulation, OwnSimulation)
    simulation.advance(UNTIL_BENT, OUTPUT_STEP)
    return simulation.present_start()


class Bench:
    """The engine in question on the scenes of its trial.

    Attributes:
        engine: the engine.
        elsewhere: what came of it in another process (`cases.conformance.repetition`), where that was tried.
        scene: the mild scene, with the drive that the engine can model.
        mild: the motion in it.
    """

    def __init__(self, engine: AnyEngine, elsewhere: dict[str, Array] | str = "not tried") -> None:
        """Raises Refusal if the engine can model the scene with neither drive."""
        self.engine, self.elsewhere = engine, elsewhere
        try:
            engine.check(BASE)
            self.scene = BASE
        except Refusal:
            engine.check(PRESCRIBED)
            self.scene = PRESCRIBED
        self.mild = Motion(self.scene)
        self._runs: dict[tuple[Motion, Settings], Trajectory] = {}

    def settings(self, mechanism: Mechanism) -> Settings:
        """Those that the engine picks unless asked otherwise."""
        found: Settings = self.engine.settings_for(self.engine.default_accuracy, mechanism)
        return found

    def run(self, motion: Motion, settings: Settings | None = None) -> Trajectory:
        """A complete and finite run. Raises as `run_once`."""
        key = motion, settings or self.settings(motion.scene)
        if key not in self._runs:
            self._runs[key] = motion.by(self.engine, key[1])
        return self._runs[key]

    def finer(self, mechanism: Mechanism, settings: Settings) -> Settings | None:
        """The next rung of an engine that is found to be twice as far off as it may be."""
        found: Settings | None = self.engine.finer(settings, (2.0,) * max(1, len(self.engine.comparisons(settings, mechanism, 1e-3))), 1e-3)
        return found

    def sharpened(self, motion: Motion) -> Trajectory | None:
        """The run one rung above the default; None where there is none. What falls with it is an error of the resolution."""
        finer = self.finer(motion.scene, self.settings(motion.scene))
        try:
            return None if finer is None else self.run(motion, finer)
        except EngineFailure:
            return None

    @property
    def claims(self) -> bool:
        """Whether the engine says how far it is from the solution of the scene."""
        return self.engine.estimates == "total"

    def estimates(self, motion: Motion, settings: Settings | None = None) -> dict[str, float] | None:
        """The engine's error by its own comparisons, in the unit of each column; None where they show none."""
        parts: dict[str, float] = {}
        try:
            for pair in self.engine.comparisons(settings or self.settings(motion.scene), motion.scene, OUTPUT_STEP):
                if pair.run == pair.other:
                    return None
                runs = compared(pair, functools.partial(self.run, motion))
                for name in columns_of(runs.run):
                    parts[name] = parts.get(name, 0.0) + runs.part(lambda a, b, name=name: rms(a[name] - b[name]))  # type: ignore[misc]
        except EngineFailure:
            return None
        return parts

    def tolerances(self, motion: Motion) -> dict[str, float] | None:
        """By how much each column may be off, in its unit; None where the engine does not say."""
        estimates = self.estimates(motion) if self.claims else None
        if estimates is None:
            return None
        known = truth(motion)
        return {
            name: BENEFIT * (estimate + known.uncertainty[name]) + ROUNDING * rms(known.columns[name])
            for name, estimate in estimates.items()
        }


def columns_of(run: Trajectory) -> tuple[str, ...]:
    """Its columns that are held against `reference`."""
    return tuple(name for name in COMPARED if name in run.columns)
