"""Runs of the engine in question and of `reference`, and by how much they may differ."""

import functools
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Final

from cases.conformance.checks import Array
from cases.conformance.scenes import BASE, DURATION, OUTPUT_STEP, PRESCRIBED, SOFT, UNTIL_BENT
from engines.accurate import compared, run_once
from engines.base import AnyEngine, Engine, EngineFailure, Refusal
from engines.own.reference import ReferenceEngine, ReferenceSettings
from engines.registry import usable_engine
from engines.relative import rms
from engines.settings import Settings
from engines.start import Start, standard_start
from engines.trajectory import REQUIRED, Trajectory
from reference_model.mechanism import Mechanism, changed

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
class Truth:
    """A converged solution and, column by column, about how far it can be trusted (in the column's unit)."""

    columns: Mapping[str, Array]
    uncertainty: Mapping[str, float]


@functools.lru_cache(maxsize=256)
def _truth_columns(mechanism: Mechanism, duration: float, output_step: float, settings: ReferenceSettings) -> dict[str, Array]:
    return run_once(ReferenceEngine(), mechanism, standard_start(mechanism), duration, output_step, settings)[0].columns


def truth(mechanism: Mechanism, duration: float = DURATION, output_step: float = OUTPUT_STEP, start: Start | None = None) -> Truth:
    """The motion from a start, the standard one by default, by `reference` with five modes; four show its uncertainty."""
    if start is None:
        finest, fine = (_truth_columns(mechanism, duration, output_step, settings) for settings in (_FINEST, _FINE))
    else:
        finest, fine = (
            run_once(ReferenceEngine(), mechanism, start, duration, output_step, settings)[0].columns for settings in (_FINEST, _FINE)
        )
    return Truth(finest, {name: rms(finest[name] - fine[name]) for name in COMPARED})


@functools.lru_cache(maxsize=4)
def bent_start(mechanism: Mechanism) -> Start:
    """A bent follower in motion: where the scene is after a while."""
    from engines.own.simulation import OwnSimulation

    simulation = ReferenceEngine().prepare(mechanism, standard_start(mechanism), _FINEST)
    assert isinstance(simulation, OwnSimulation)
    simulation.advance(UNTIL_BENT, OUTPUT_STEP)
    return simulation.present_start()


class Bench:
    """The engine in question on the scenes of its trial.

    Attributes:
        engine: the engine.
        scene: the mild scene, with the drive that the engine can model.
    """

    def __init__(self, engine: AnyEngine) -> None:
        """Raises Refusal if the engine can model the scene with neither drive."""
        self.engine = engine
        try:
            engine.check(BASE)
            self.scene = BASE
        except Refusal:
            engine.check(PRESCRIBED)
            self.scene = PRESCRIBED
        self._runs: dict[tuple[object, ...], Trajectory] = {}

    @property
    def soft(self) -> Mechanism:
        """The scene with a softer follower."""
        return changed(self.scene, SOFT)

    def settings(self, mechanism: Mechanism) -> Settings:
        """Those that the engine picks unless asked otherwise."""
        found: Settings = self.engine.settings_for(self.engine.default_accuracy, mechanism)
        return found

    def run(
        self,
        mechanism: Mechanism,
        settings: Settings | None = None,
        *,
        duration: float = DURATION,
        output_step: float = OUTPUT_STEP,
        start: Start | None = None,
    ) -> Trajectory:
        """A complete and finite run, from the standard start by default. Raises as `run_once`."""
        settings = settings or self.settings(mechanism)
        key = (mechanism, settings, duration, output_step, id(start))
        if key not in self._runs:
            begin = start or standard_start(mechanism)
            self._runs[key] = run_once(self.engine, mechanism, begin, duration, output_step, settings)[0]
        return self._runs[key]

    def finer(self, mechanism: Mechanism, settings: Settings) -> Settings | None:
        """The next rung of an engine that is found to be twice as far off as it may be."""
        found: Settings | None = self.engine.finer(settings, (2.0,) * max(1, len(self.engine.comparisons(settings, mechanism, 1e-3))), 1e-3)
        return found

    def sharpened(self, mechanism: Mechanism, *, duration: float = DURATION, start: Start | None = None) -> Trajectory | None:
        """The run one rung above the default; None where there is none. What falls with it is an error of the resolution."""
        finer = self.finer(mechanism, self.settings(mechanism))
        try:
            return None if finer is None else self.run(mechanism, finer, duration=duration, start=start)
        except EngineFailure:
            return None

    @property
    def claims(self) -> bool:
        """Whether the engine says how far it is from the solution of the scene."""
        return self.engine.estimates == "total"

    def estimates(
        self, mechanism: Mechanism, settings: Settings | None = None, *, duration: float = DURATION, start: Start | None = None
    ) -> dict[str, float] | None:
        """The engine's error by its own comparisons, in the unit of each column; None where they show none."""
        settings = settings or self.settings(mechanism)
        parts: dict[str, float] = {}

        def run(other: Settings) -> Trajectory:
            return self.run(mechanism, other, duration=duration, start=start)

        try:
            for pair in self.engine.comparisons(settings, mechanism, OUTPUT_STEP):
                if pair.run == pair.other:
                    return None
                runs = compared(pair, run)
                for name in self.columns(runs.run.columns):
                    parts[name] = parts.get(name, 0.0) + runs.part(_difference_in(name))
        except EngineFailure:
            return None
        return parts

    def tolerances(
        self, known: Truth, mechanism: Mechanism, *, duration: float = DURATION, start: Start | None = None
    ) -> dict[str, float] | None:
        """By how much each column may be off, in its unit; None where the engine does not say."""
        estimates = self.estimates(mechanism, duration=duration, start=start) if self.claims else None
        if estimates is None:
            return None
        return {
            name: BENEFIT * (estimate + known.uncertainty[name]) + ROUNDING * rms(known.columns[name])
            for name, estimate in estimates.items()
        }

    @staticmethod
    def columns(delivered: Mapping[str, Array]) -> tuple[str, ...]:
        """Those that are held against `reference`."""
        return tuple(name for name in COMPARED if name in delivered)


def _difference_in(name: str) -> Callable[[Trajectory, Trajectory], float]:
    return lambda a, b: rms(a[name] - b[name])
