"""An engine whose motion and error are known in closed form: the tip swings as sin(t), plus `error_of(step)` times cos(t).

It depends on nothing but the engine interface, so a copy of this file serves as a third-party package. Its setting `behaviour`
makes it misbehave in the ways that the runner must survive.
"""

import os
import time
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from quickreturn.engines.base import Comparison, Engine, EngineFailure, ModelDescription, Refusal, Simulation, SteadyState
from quickreturn.engines.settings import Settings as AnySettings
from quickreturn.engines.settings import setting
from quickreturn.engines.start import Start
from quickreturn.engines.trajectory import REQUIRED, Trajectory
from quickreturn.reference_model.arrays import Array
from quickreturn.reference_model.mechanism import Mechanism

BEHAVIOURS = ("good", "coarse fails", "unstable", "fails", "raises", "nan", "short", "prints", "hangs", "rigid")


@dataclass(frozen=True, kw_only=True)
class FakeSettings(AnySettings):
    step: float = setting(0.1, "step", unit="s", low=1e-4, high=1.0)
    behaviour: str = setting("good", "what goes wrong", choices=BEHAVIOURS)


def error_of(step: float) -> float:
    """Relative error of the tip deflection: second order in the step."""
    return 0.5 * step**2


class FakeSimulation(Simulation):
    def __init__(self, start: Start, settings: FakeSettings) -> None:
        self.setup_seconds, self.time = 0.25, 0.0
        self._start, self._settings = start, settings

    def advance(self, duration: float, output_step: float) -> Trajectory:
        rows = round(duration / output_step) + 1
        times: Array = np.float64(self.time) + output_step * np.arange(rows, dtype=np.float64)
        self.time += duration
        behaviour, step = self._settings.behaviour, self._settings.step
        trajectory = self._motion(times)
        match behaviour:
            case "fails":
                raise EngineFailure(float(times[2]), "the beam snapped", "try another beam", self._motion(times[:3]))
            case "coarse fails" if step >= 0.1:
                raise EngineFailure(0.0, "the step is too large", "try a smaller step")
            case "unstable" if step >= 0.1:
                trajectory.columns["tip_deflection"][5:] = np.nan
            case "nan":
                trajectory.columns["strain_2"][5:] = np.nan
            case "raises":
                raise ZeroDivisionError("a bug\non two lines")
            case "short":
                return self._motion(times[: rows // 2])
            case "prints":
                print("chatter of the library")
                os.write(1, b"chatter of the C library\n")
            case "hangs":
                time.sleep(3600.0)
        return trajectory

    def _motion(self, times: Array) -> Trajectory:
        columns = {name: np.zeros_like(times) for name in REQUIRED}
        wave = np.sin(times) + error_of(self._settings.step) * np.cos(times)
        columns["time"] = times
        columns["crank_angle"] = self._start.crank_angle + self._start.crank_speed * times
        columns["slider_position"] = np.full_like(times, 0.4)
        columns["tip_x"] = 0.5 + error_of(self._settings.step) * np.cos(times)
        if self._settings.behaviour != "rigid":
            columns["tip_deflection"] = wave
            columns["strain_1"] = 0.001 * wave
        columns["kinetic_energy"] = np.ones_like(times)
        return Trajectory(columns, 0.125, {"steps": times[-1] / self._settings.step})


class FakeEngine(Engine):
    name = "fake"
    method = "closed form"
    default_accuracy = 1e-2
    settings_type = FakeSettings

    def version(self) -> str:
        return "fake 1.0"

    def check(self, mechanism: Mechanism) -> None:
        if mechanism.slider.mass > 0.0:
            raise Refusal("slider.mass: engine fake models a massless slider only")

    def describe(self, mechanism: Mechanism, settings: AnySettings) -> ModelDescription:
        return ModelDescription(("crank", "follower"), ("slider on the follower",), 3)

    def settings_for(self, accuracy: float, mechanism: Mechanism) -> FakeSettings:
        return FakeSettings(step=0.2 if accuracy > 1e-3 else 0.1)

    def comparisons(self, settings: AnySettings, mechanism: Mechanism, output_step: float) -> tuple[Comparison, ...]:
        return (Comparison(settings, settings.replaced(step=2.0 * settings.step), 4.0),)

    def finer(self, settings: AnySettings, excess: Mapping[str, float], output_step: float) -> FakeSettings | None:
        return settings.replaced(step=settings.step / 2.0) if settings.step > 0.03 else None

    def prepare(self, mechanism: Mechanism, start: Start, settings: AnySettings) -> FakeSimulation:
        assert isinstance(settings, FakeSettings)
        self.check(mechanism)
        return FakeSimulation(start, settings)

    def steady_state(self, mechanism: Mechanism, start: Start, settings: AnySettings, near: SteadyState | None = None) -> None:
        """None, and that is the engine's own answer: its motion has nothing to do with the periodic state of the mechanism."""

    def natural_frequencies(self, mechanism: Mechanism, crank_angle: float, count: int, settings: AnySettings) -> Array:
        return np.array([10.0, 20.0, 30.0])[:count] + crank_angle
