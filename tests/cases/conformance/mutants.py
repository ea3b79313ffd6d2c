"""Engines that are `reference` with one mistake each, and a word that the cause must name."""

import dataclasses
import itertools
import math
from collections.abc import Callable, Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from quickreturn.engines.base import Comparison, EngineFailure, Simulation
from quickreturn.engines.own.reference import ReferenceEngine, ReferenceSettings
from quickreturn.engines.start import Start
from quickreturn.engines.trajectory import Trajectory
from quickreturn.reference_model.mechanism import Mechanism
from quickreturn.reference_model.scene_values import changed, value_at

Columns = dict[str, NDArray[np.float64]]


class Mutant(ReferenceEngine):
    """Spoils a scene before it is built, or columns before they are delivered."""

    name = "mutant"

    def scene(self, mechanism: Mechanism) -> Mechanism:
        return mechanism

    def start(self, start: Start) -> Start:
        return start

    def spoil(self, columns: Columns, mechanism: Mechanism) -> None:
        """What goes wrong in a table."""

    def prepare(self, mechanism: Any, start: Start | None, settings: ReferenceSettings) -> Any:
        if start is None:  # the follower alone is modelled as it should be
            return super().prepare(mechanism, None, settings)
        return Spoiling(self, mechanism, super().prepare(self.scene(mechanism), self.start(start), settings))


class Spoiling(Simulation):
    def __init__(self, engine: Mutant, mechanism: Mechanism, sound: Simulation) -> None:
        self.engine, self.mechanism, self.sound = engine, mechanism, sound
        self.setup_seconds, self.time = sound.setup_seconds, 0.0

    def advance(self, duration: float, output_step: float) -> Trajectory:
        run = self.sound.advance(duration, output_step)
        self.time += duration
        columns = dict(run.columns)
        self.engine.spoil(columns, self.mechanism)
        return dataclasses.replace(run, columns=columns)


def of_columns(spoil: Callable[[Columns, Mechanism], None]) -> type[Mutant]:
    return type("OfColumns", (Mutant,), {"spoil": lambda self, columns, mechanism: spoil(columns, mechanism)})


def column(name: str, change: Callable[[NDArray[np.float64]], NDArray[np.float64]]) -> type[Mutant]:
    return of_columns(lambda columns, mechanism: columns.update({name: change(columns[name])}))


def of_scene(**values: Any) -> type[Mutant]:
    """The quantities have these values whatever the scene says; a function makes one from the scene's; `__` stands for a dot."""

    def scene(self: Mutant, mechanism: Mechanism) -> Mechanism:
        for path, value in values.items():
            key = path.replace("__", ".")
            present = value_at(mechanism, key) if "." in key else getattr(mechanism, key)
            if present is not None:
                mechanism = changed(mechanism, {key: value(present) if callable(value) else value})
        return mechanism

    return type("OfScene", (Mutant,), {"scene": scene})


def late(values: NDArray[np.float64]) -> NDArray[np.float64]:
    return np.concatenate([values[:1], values[:-1]])


def _exchanged(columns: Columns, mechanism: Mechanism) -> None:
    columns["strain_1"], columns["strain_3"] = columns["strain_3"], columns["strain_1"]


def _all_late(columns: Columns, mechanism: Mechanism) -> None:
    columns.update({name: late(columns[name]) for name in ("strain_1", "strain_2", "strain_3")})


def _relative(columns: Columns, mechanism: Mechanism) -> None:
    step = columns["time"][1] - columns["time"][0]
    columns["tip_acceleration"] = np.gradient(np.gradient(columns["tip_deflection"], step), step)


def _chord(columns: Columns, mechanism: Mechanism) -> None:
    crank = mechanism.crank.length
    x, y = crank * np.cos(columns["crank_angle"]) - mechanism.pivot_distance, crank * np.sin(columns["crank_angle"])
    columns["slider_position"] = np.hypot(x, y)


def _from_pivot(columns: Columns, mechanism: Mechanism) -> None:
    columns["tip_x"] = columns["tip_x"] - mechanism.pivot_distance


class BackwardsLadder(Mutant):
    def finer(self, settings: ReferenceSettings, excess: Mapping[str, float], output_step: float) -> ReferenceSettings | None:
        return settings.replaced(modes=settings.modes - 1) if settings.modes > 1 else None


class EndlessLadder(Mutant):
    def finer(self, settings: ReferenceSettings, excess: Mapping[str, float], output_step: float) -> ReferenceSettings | None:
        return settings


class Overclaims(Mutant):
    def comparisons(self, settings: ReferenceSettings, mechanism: Mechanism, output_step: float) -> tuple[Comparison, ...]:
        return tuple(dataclasses.replace(pair, factor=10.0) for pair in super().comparisons(settings, mechanism, output_step))


class RestartingTime(Mutant):
    def spoil(self, columns: Columns, mechanism: Mechanism) -> None:
        columns["time"] = columns["time"] - columns["time"][0]


def of_frequencies(wrong: Callable[[NDArray[np.float64]], Any]) -> type[Mutant]:
    class OfFrequencies(Mutant):
        def natural_frequencies(self, mechanism: Mechanism, crank_angle: float, count: int, settings: ReferenceSettings) -> Any:
            return wrong(super().natural_frequencies(mechanism, crank_angle, count, settings))

    return OfFrequencies


class _HeldAtTheStart(Mutant):
    def natural_frequencies(self, mechanism: Mechanism, crank_angle: float, count: int, settings: ReferenceSettings) -> Any:
        return super().natural_frequencies(mechanism, math.pi, count, settings)


class _NoRates(Mutant):
    def start(self, start: Start) -> Start:
        return dataclasses.replace(start, deflection_rate=None)


class _Straight(Mutant):
    def start(self, start: Start) -> Start:
        return Start(start.crank_angle, start.crank_speed)


class _Random(Mutant):
    count = itertools.count()

    def scene(self, mechanism: Mechanism) -> Mechanism:
        return changed(mechanism, {"tip.mass": mechanism.tip_body.mass * (1.0 + 1e-5 * next(self.count))}) if mechanism.tip else mechanism


class _Swallowing(Spoiling):
    def advance(self, duration: float, output_step: float) -> Trajectory:
        try:
            return super().advance(duration, output_step)
        except EngineFailure as failure:
            if failure.partial is None:
                raise
            rows = round(duration / output_step) + 1
            held = {name: np.pad(values, (0, rows - len(values)), mode="edge") for name, values in failure.partial.columns.items()}
            held["time"] = output_step * np.arange(rows, dtype=np.float64)
            return Trajectory(held, 0.0)


class GoesOnInSilence(Mutant):
    def prepare(self, mechanism: Mechanism, start: Start, settings: ReferenceSettings) -> Any:
        return _Swallowing(self, mechanism, ReferenceEngine.prepare(self, mechanism, start, settings))


class RaisesValueError(Mutant):
    def prepare(self, mechanism: Mechanism, start: Start, settings: ReferenceSettings) -> Any:
        try:
            return super().prepare(mechanism, start, settings)
        except EngineFailure as failure:
            raise ValueError("math domain error") from failure


#: Name -> the engine, a regular expression that the cause of a failed check must match, and the group of that check.
MUTANTS: dict[str, tuple[type[Mutant], str, str]] = {
    "strain sign": (column("strain_2", np.negative), r"strain_2 .*sign", "motion"),
    "percent": (
        of_columns(lambda c, m: c.update({f"strain_{i}": 100.0 * c[f"strain_{i}"] for i in (1, 2, 3)})),
        "strain_1 .*percent",
        "motion",
    ),
    "microstrain": (column("strain_3", lambda y: 1e6 * y), "strain_3 .*microstrain", "motion"),
    "curvature": (of_columns(lambda c, m: c.update(strain_1=2.0 / m.follower.thickness * c["strain_1"])), "strain_1 .*curvature", "motion"),
    "gauges exchanged": (of_columns(_exchanged), "strain_1 holds strain_3", "motion"),
    "crank angle in degrees": (column("crank_angle", np.degrees), "crank_angle .*degrees", "motion"),
    "follower angle in degrees": (column("follower_angle", np.degrees), "follower_angle .*degrees", "motion"),
    "wrapped crank angle": (column("crank_angle", lambda y: (y + np.pi) % (2.0 * np.pi) - np.pi), "crank_angle .*wrapped", "motion"),
    "wrapped follower angle": (
        column("follower_angle", lambda y: (y + np.pi) % (2.0 * np.pi) - np.pi),
        "follower_angle .*wrapped",
        "motion",
    ),
    "crank angle from the start": (column("crank_angle", lambda y: y - math.pi), "crank_angle .*(start|n1)", "motion"),
    "speed in rpm": (column("crank_speed", lambda y: 30.0 / math.pi * y), "crank_speed .*rpm", "motion"),
    "slider in inches": (column("slider_position", lambda y: y / 0.0254), "slider_position .*inches", "motion"),
    "tip from P": (of_columns(_from_pivot), "tip_x .*from P", "motion"),
    "deflection in mm": (column("tip_deflection", lambda y: 1e3 * y), "tip_deflection .*millimetres", "motion"),
    "deflection sign": (column("tip_deflection", np.negative), "tip_deflection .*sign", "motion"),
    "force sign": (column("slider_force", np.negative), "slider_force .*sign", "motion"),
    "force a row late": (column("slider_force", late), "slider_force .*late", "motion"),
    "strains a row late": (of_columns(_all_late), "strain_1 .*late", "motion"),
    "acceleration two rows late": (column("tip_acceleration", lambda y: late(late(y))), "tip_acceleration .*late", "motion"),
    "relative acceleration": (of_columns(_relative), "tip_acceleration .*relative", "motion"),
    "chord": (of_columns(_chord), "slider_position .*straight distance", "motion"),
    "time in ms": (column("time", lambda y: 1e3 * y), "milliseconds", "motion"),
    "time restarts": (RestartingTime, "time begins at zero", "motion"),
    "force 2 %": (column("slider_force", lambda y: 1.02 * y), "slider_force is off by a plain factor of 1.02", "motion"),
    "strain 2 %": (column("strain_2", lambda y: 0.98 * y), "strain_2 is off by a plain factor of 0.98", "motion"),
    "acceleration 2 %": (column("tip_acceleration", lambda y: 1.02 * y), "tip_acceleration is off by a plain factor of 1.02", "motion"),
    "stiffness 2 %": (of_scene(follower__bending_stiffness=lambda x: 1.02 * x), "bending_stiffness", "motion"),
    "beam mass 2 %": (of_scene(follower__mass_per_length=lambda x: 1.02 * x), "mass_per_length", "motion"),
    "tip mass 2 %": (of_scene(tip__mass=lambda x: 1.02 * x), "tip.mass", "motion"),
    "crank inertia 5 %": (of_scene(crank__inertia=lambda x: 1.05 * x), "crank", "motion"),
    "no tip body": (of_scene(tip=None), "no tip|tip.mass", "motion"),
    "crank inertia about O": (of_scene(crank__center_of_mass=0.0), "crank.inertia taken about O", "motion"),
    "gravity ignored": (of_scene(mechanism__gravity=(0.0, 0.0)), "gravity.* ignored", "quantities"),
    "gravity turned round": (of_scene(mechanism__gravity=lambda g: (-g[0], -g[1])), "gravity.* sign", "quantities"),
    "gravity exchanged": (of_scene(mechanism__gravity=lambda g: (g[1], g[0])), "gravity acts along n2 in place of n1", "quantities"),
    "follower damping ignored": (of_scene(follower__damping=0.0), "follower.damping is ignored", "quantities"),
    "follower damping doubled": (of_scene(follower__damping=lambda x: 2.0 * x), "follower.damping acts", "quantities"),
    "base damping ignored": (of_scene(base__damping=0.0), "base.damping is ignored", "quantities"),
    "tip offset ignored": (of_scene(tip__center_of_mass=0.0), "tip.center_of_mass is ignored", "quantities"),
    "tip offset turned round": (of_scene(tip__center_of_mass=lambda x: -x), "tip.center_of_mass .*towards the pivot", "quantities"),
    "slider mass ignored": (of_scene(slider__mass=0.0), "slider.mass is ignored", "quantities"),
    "slider inertia ignored": (of_scene(slider__inertia=0.0), "slider.inertia is ignored", "quantities"),
    "joint stiffness ignored": (
        of_scene(slider__joint_stiffness=math.inf, slider__joint_damping=0.0),
        "joint_stiffness is ignored",
        "quantities",
    ),
    "joint damping ignored": (of_scene(slider__joint_damping=0.0), "joint_damping is ignored", "quantities"),
    "tool force ignored": (of_scene(tip__force=(0.0, 0.0)), "tip.force along n1 is ignored", "quantities"),
    "tool always cuts": (of_scene(tip__force_from=0.0, tip__force_to=2.0 * math.pi), "whole turn|force_from is ignored", "quantities"),
    "gauges of the thesis": (of_scene(follower__strain_gauges=(0.14, 0.29, 0.46)), "strain_gauges is ignored", "quantities"),
    "finer goes backwards": (BackwardsLadder, "coarser", "resolution"),
    "finer stands still": (EndlessLadder, "gives back the settings", "resolution"),
    "overclaimed factor": (Overclaims, "factor", "resolution"),
    "frequencies in rad/s": (of_frequencies(lambda f: 2.0 * math.pi * f), "rad/s", "frequencies"),
    "eigenvalues": (of_frequencies(lambda f: (2.0 * math.pi * f) ** 2), "eigenvalues", "frequencies"),
    "NaN frequencies": (of_frequencies(lambda f: f * np.nan), "not finite", "frequencies"),
    "descending frequencies": (of_frequencies(lambda f: f[::-1]), "ascend", "frequencies"),
    "frequencies 2 %": (of_frequencies(lambda f: 1.02 * f), "1.02 times", "frequencies"),
    "a zero frequency": (of_frequencies(lambda f: np.concatenate([[0.0], f[:-1]])), "zero", "frequencies"),
    "crank held elsewhere": (_HeldAtTheStart, "initial angle", "frequencies"),
    "start not bending": (_NoRates, "rate is ignored", "motion"),
    "start straight": (_Straight, "deflection .*ignored", "motion"),
    "remembers": (_Random, "second time|another way", "repetition"),
    "goes on in silence": (GoesOnInSilence, "as if nothing|goes on|simulated all the same", "failures"),
    "raises ValueError": (RaisesValueError, "ValueError", "failures"),
}
