"""Engines that are wrong on purpose and do not say so: a sound engine with one thing done to it behind its back."""

from dataclasses import replace

import numpy as np

from quickreturn.engines.base import Comparison, Engine, ModelDescription, Simulation
from quickreturn.engines.settings import Settings
from quickreturn.engines.start import Start
from quickreturn.engines.trajectory import Trajectory
from quickreturn.reference_model.arrays import Array
from quickreturn.reference_model.mechanism import Mechanism


class Disguised(Engine):
    """Passes everything on to a sound engine."""

    name = "disguised"
    method = "another engine's"
    default_accuracy = 1e-2
    settings_type = Settings

    def __init__(self, sound: Engine) -> None:
        self.sound = sound

    def version(self) -> str:
        return self.sound.version()

    def check(self, mechanism: Mechanism) -> None:
        self.sound.check(mechanism)

    def describe(self, mechanism: Mechanism, settings: Settings) -> ModelDescription:
        return self.sound.describe(mechanism, settings)

    def settings_for(self, accuracy: float, mechanism: Mechanism) -> Settings:
        return self.sound.settings_for(accuracy, mechanism)

    def comparisons(self, settings: Settings, mechanism: Mechanism, output_step: float) -> tuple[Comparison, ...]:
        return self.sound.comparisons(settings, mechanism, output_step)

    def finer(self, settings: Settings, excess: tuple[float, ...], output_step: float) -> Settings | None:
        return self.sound.finer(settings, excess, output_step)

    def prepare(self, mechanism: Mechanism, start: Start, settings: Settings) -> Simulation:
        return self.sound.prepare(mechanism, start, settings)

    def natural_frequencies(self, mechanism: Mechanism, crank_angle: float, count: int, settings: Settings) -> Array:
        return self.sound.natural_frequencies(mechanism, crank_angle, count, settings)


class Stiffer(Disguised):
    """Bends a follower that is 3 % stiffer than the scene's."""

    def prepare(self, mechanism: Mechanism, start: Start, settings: Settings) -> Simulation:
        follower = replace(mechanism.follower, bending_stiffness=1.03 * mechanism.follower.bending_stiffness)
        return self.sound.prepare(replace(mechanism, follower=follower), start, settings)


class Restarting(Disguised):
    """Begins again from the start after half the time and does not say so, as a library does that resets itself."""

    def prepare(self, mechanism: Mechanism, start: Start, settings: Settings) -> Simulation:
        return _Restarted(self.sound.prepare(mechanism, start, settings))


class _Restarted(Simulation):
    def __init__(self, sound: Simulation) -> None:
        self._sound, self.setup_seconds, self.time = sound, sound.setup_seconds, sound.time

    def advance(self, duration: float, output_step: float) -> Trajectory:
        whole = self._sound.advance(duration, output_step)
        half, rest = len(whole) // 2, len(whole) - len(whole) // 2
        columns = {name: np.concatenate([values[:half], values[:rest]]) for name, values in whole.columns.items()}
        return Trajectory({**columns, "time": whole["time"]}, whole.solve_seconds, whole.statistics)
