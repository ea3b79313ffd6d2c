"""Mistakes of the kinds that authors make: in what is seldom looked at, in pairs, by parts of a row, by what an earlier scene leaves."""

import dataclasses
import math
import os
import time
from collections.abc import Mapping
from typing import Any, ClassVar

import numpy as np
from numpy.typing import NDArray

from quickreturn.engines.base import Comparison, Simulation
from quickreturn.engines.own.reference import ReferenceEngine, ReferenceSettings
from quickreturn.engines.settings import setting
from quickreturn.engines.start import Start
from quickreturn.engines.trajectory import Trajectory
from quickreturn.reference_model.mechanism import FollowerAlone, Mechanism, Scene
from quickreturn.reference_model.natural_modes import frozen_crank_modes
from quickreturn.reference_model.scene_values import changed
from tests.cases.conformance.mutants import Columns, Mutant, Spoiling, column, of_columns, of_frequencies, of_scene

Array = NDArray[np.float64]
OWN_STEP = 1e-3  # s
SECONDS_A_SECOND = 3.0


class _OwnStep(Simulation):
    """A solver with a step of its own: a row between two of them holds what the last one left."""

    def __init__(self, sound: Simulation) -> None:
        self.sound, self.setup_seconds, self.time = sound, sound.setup_seconds, 0.0

    def advance(self, duration: float, output_step: float) -> Trajectory:
        fine = 1e-4
        run = self.sound.advance(duration, fine)
        at = output_step * np.arange(round(duration / output_step) + 1)
        last = np.round(OWN_STEP * np.floor(at / OWN_STEP + 1e-6) / fine).astype(int)
        columns = {name: values[last] for name, values in run.columns.items()} | {"time": self.time + at}
        self.time += duration
        return dataclasses.replace(run, columns=columns)


class RowsOfTheLastStep(Mutant):
    def prepare(self, mechanism: Mechanism, start: Start, settings: ReferenceSettings) -> Any:
        return _OwnStep(ReferenceEngine.prepare(self, mechanism, start, settings))


def _later(part: float) -> Any:
    """Columns that come a part of a row late."""

    def late(values: Array) -> Array:
        rows = np.arange(len(values), dtype=np.float64)
        return np.interp(np.maximum(rows - part, 0.0), rows, values)

    return late


def _shapes_reversed(columns: Columns, mechanism: Mechanism) -> None:
    names = [f"shape_{place:02d}" for place in range(1, 12)]
    columns.update(dict(zip(names, [columns[name] for name in reversed(names)], strict=True)))


def _shapes_in_mm(columns: Columns, mechanism: Mechanism) -> None:
    columns.update({name: 1e3 * values for name, values in columns.items() if name.startswith("shape_")})


def of_pair(changes: Any) -> type[Mutant]:
    """Scenes in which two quantities meet are changed; others are left as they are."""

    def scene(self: Mutant, mechanism: Mechanism) -> Mechanism:
        values = changes(mechanism)
        return changed(mechanism, values) if values else mechanism

    return type("OfPair", (Mutant,), {"scene": scene})


def _slider_without_weight(m: Mechanism) -> dict[str, Any]:
    if not (m.slider.mass and m.has_gravity):
        return {}
    return {"slider.mass": 0.0, "crank.inertia": m.crank.inertia + m.slider.mass * m.crank.length**2}


def _offset_without_gravity(m: Mechanism) -> dict[str, Any]:
    return {"tip.center_of_mass": 0.0} if m.tip and m.tip.center_of_mass and m.has_gravity else {}


def _damping_without_offset(m: Mechanism) -> dict[str, Any]:
    return {"follower.damping": 0.0} if m.follower.damping and m.tip_body.center_of_mass else {}


def _turned_with_the_crank(m: Mechanism) -> dict[str, Any]:
    angle = m.crank.initial_angle - math.pi
    c, s = math.cos(angle), math.sin(angle)
    return {"mechanism.gravity": (c * m.gravity[0] - s * m.gravity[1], s * m.gravity[0] + c * m.gravity[1])}


class OfAlone(Mutant):
    """Wrong in its model of the follower alone only."""

    def alone(self, scene: FollowerAlone) -> FollowerAlone:
        return scene

    def prepare(self, mechanism: Any, start: Any, settings: Any) -> Any:
        sound = super().prepare(self.alone(mechanism) if start is None else mechanism, start, settings)
        return Spoiling(self, mechanism, sound) if start is None else sound


def of_alone(**values: Any) -> type[OfAlone]:
    """Quantities of the follower alone have these values; `__` stands for a dot."""

    def alone(self: OfAlone, scene: FollowerAlone) -> FollowerAlone:
        return changed(scene, {path.replace("__", "."): value for path, value in values.items()})

    return type("Alone", (OfAlone,), {"alone": alone})


class _StrainOfAlone(OfAlone):
    def spoil(self, columns: Columns, mechanism: Scene) -> None:
        if isinstance(mechanism, FollowerAlone):
            columns["strain_1"] = -columns["strain_1"]


class IntegrationAlone(ReferenceEngine):
    """Its one shape is what it errs by, its estimate is of the integration, and it has no finer rung to show that."""

    name = "integration-alone"
    default_accuracy = 3e-2

    def settings_for(self, accuracy: float, mechanism: Scene) -> ReferenceSettings:
        return ReferenceSettings(modes=1, tolerance=1e-7)

    def comparisons(self, settings: ReferenceSettings, mechanism: Scene, output_step: float) -> tuple[Comparison, ...]:
        return (Comparison(settings, settings.replaced(tolerance=10.0 * settings.tolerance), 10.0),)

    def finer(self, settings: ReferenceSettings, excess: Mapping[str, float], output_step: float) -> None:
        return None


class RaisesInCheck(Mutant):
    def check(self, mechanism: Mechanism) -> None:
        super().check(mechanism)
        if mechanism.slider.inertia:
            raise KeyError("inertia of the slider")


@dataclasses.dataclass(frozen=True, kw_only=True)
class _TwoSettings(ReferenceSettings):
    smoothing: float = setting(0.1, "of nothing", low=0.0, high=1.0)


class IdleSetting(Mutant):
    settings_type = _TwoSettings

    def settings_for(self, accuracy: float, mechanism: Scene) -> ReferenceSettings:
        found = super().settings_for(accuracy, mechanism)
        return _TwoSettings(modes=found.modes, tolerance=found.tolerance)


class Keeps(ReferenceEngine):
    """Keeps a part of the first scene that it sees; in a module of its own, so that another process can have it."""

    name = "keeps"
    part: ClassVar[str]
    kept: ClassVar[dict[str, Any]] = {}

    def prepare(self, mechanism: Mechanism, start: Start, settings: ReferenceSettings) -> Any:
        self.kept.setdefault(self.name, getattr(mechanism, self.part))
        return super().prepare(dataclasses.replace(mechanism, **{self.part: self.kept[self.name]}), start, settings)


class KeepsCrank(Keeps):
    name, part = "keeps-crank", "crank"


class KeepsTip(Keeps):
    name, part = "keeps-tip", "tip"


class KeepsFollower(Keeps):
    name, part = "keeps-follower", "follower"


class BuiltForAFollower(ReferenceEngine):
    """Builds its model anew where the follower is another one, and only there."""

    name = "built-for-a-follower"
    built: ClassVar[dict[Any, Mechanism]] = {}

    def prepare(self, mechanism: Mechanism, start: Start, settings: ReferenceSettings) -> Any:
        self.built.setdefault(mechanism.follower, mechanism)
        return super().prepare(self.built[mechanism.follower], start, settings)


class KeepsAll(Mutant):
    """Simulates the first scene again and again."""

    kept: ClassVar[dict[str, Mechanism]] = {}

    def scene(self, mechanism: Mechanism) -> Mechanism:
        return self.kept.setdefault("first", mechanism)


class Threaded(ReferenceEngine):
    """Its last digits depend on how many threads add its sums: here, on whether the process is one with a single thread."""

    name = "threaded"

    def prepare(self, mechanism: Mechanism, start: Start, settings: ReferenceSettings) -> Any:
        return _Threads(super().prepare(mechanism, start, settings))


class _Threads(Simulation):
    def __init__(self, sound: Simulation) -> None:
        self.sound, self.setup_seconds, self.time = sound, sound.setup_seconds, 0.0

    def advance(self, duration: float, output_step: float) -> Trajectory:
        run = self.sound.advance(duration, output_step)
        self.time = self.sound.time
        if os.environ.get("OPENBLAS_NUM_THREADS") == "1":
            return run
        noise = np.random.default_rng(1).normal(size=len(run))
        return dataclasses.replace(run, columns=run.columns | {"slider_force": run["slider_force"] * (1.0 + 1e-4 * noise)})


class Slow(ReferenceEngine):
    """Takes three seconds for a second of motion."""

    name = "slow"

    def prepare(self, mechanism: Mechanism, start: Start, settings: ReferenceSettings) -> Any:
        return _Sleeping(super().prepare(mechanism, start, settings))


class _Sleeping(Simulation):
    def __init__(self, sound: Simulation) -> None:
        self.sound, self.setup_seconds, self.time = sound, sound.setup_seconds, 0.0

    def advance(self, duration: float, output_step: float) -> Trajectory:
        time.sleep(SECONDS_A_SECOND * duration)
        run = self.sound.advance(duration, output_step)
        self.time = self.sound.time
        return run


class Coarse(ReferenceEngine):
    """Asks for no better than 20 % by default."""

    name = "coarse-by-default"
    default_accuracy = 0.2


def _base_held(mechanism: Mechanism, crank_angle: float, count: int) -> Array:
    return frozen_crank_modes(changed(mechanism, {"base.inertia": 1e6}), crank_angle, count + 1).frequencies[1:]


class _Clamped(Mutant):
    def natural_frequencies(self, mechanism: Mechanism, crank_angle: float, count: int, settings: ReferenceSettings) -> Any:
        return _base_held(mechanism, crank_angle, count)


def _twice_shifted(m: Mechanism) -> dict[str, Any]:
    tip = m.tip
    return {"tip.inertia": tip.inertia + tip.mass * tip.center_of_mass**2} if tip else {}


#: Name -> the engine, a regular expression that the cause of a failed check must match, and the group of that check.
THIRD: dict[str, tuple[type[ReferenceEngine], str, str]] = {
    "the base's rate in degrees": (column("follower_rate", np.degrees), "degrees per second", "motion"),
    "the base's acceleration reversed": (column("follower_acceleration", np.negative), "wrong sign", "motion"),
    "the base's acceleration late": (column("follower_acceleration", lambda values: np.r_[values[0], values[:-1]]), "row", "motion"),
    "rows of the last own step": (RowsOfTheLastStep, r"with 2.5 ms between rows", "motion"),
    "force 0.4 rows late": (column("slider_force", _later(0.4)), "slider_force comes 0.4 rows late", "motion"),
    "strain half a row late": (column("strain_2", _later(0.5)), "strain_2 comes 0.5 rows late", "motion"),
    "kinetic energy doubled": (column("kinetic_energy", lambda y: 2.0 * y), "kinetic_energy is twice", "motion"),
    "strain energy halved": (column("strain_energy", lambda y: 0.5 * y), "strain_energy is half", "motion"),
    "gravity energy sign": (column("gravity_energy", np.negative), "gravity_energy has the wrong sign", "quantities"),
    "drive work sign": (column("drive_work", np.negative), "drive_work has the wrong sign", "motion"),
    "torque in inch pounds": (column("crank_torque", lambda y: y / 0.1129848290276167), "crank_torque .*inch pounds", "motion"),
    "one shape doubled": (column("shape_06", lambda y: 2.0 * y), "shape_06 is twice", "motion"),
    "shapes from tip to base": (of_columns(_shapes_reversed), "shape_01 holds shape_11", "motion"),
    "shapes in mm": (of_columns(_shapes_in_mm), "shape_01 is in millimetres", "motion"),
    "slider without weight": (of_pair(_slider_without_weight), "mechanism.gravity on the slider .* is not followed", "quantities"),
    "offset without gravity": (of_pair(_offset_without_gravity), r"gravity.*nor without tip.center_of_mass", "quantities"),
    "damping without offset": (of_pair(_damping_without_offset), r"follower.damping.*nor without tip.center_of_mass", "quantities"),
    "gravity turns with the start": (of_pair(_turned_with_the_crank), "gravity turns with the crank's angle at the start", "quantities"),
    "gravity a quarter": (
        of_pair(lambda m: {"mechanism.gravity": (-m.gravity[1], m.gravity[0])}),
        "turned by a quarter, counter-clock",
        "quantities",
    ),
    "alone: stiffness": (of_alone(follower__bending_stiffness=21.0), "follower.bending_stiffness 1.05 times", "follower alone"),
    "alone: no gravity": (of_alone(mechanism__gravity=(0.0, 0.0)), "gravity along n1 is ignored", "follower alone"),
    "alone: damping ignored": (of_alone(follower__damping=0.0), "follower.damping is ignored", "follower alone"),
    "alone: strain sign": (_StrainOfAlone, "strain_1 has the wrong sign", "follower alone"),
    "estimate too small, no finer rung": (IntegrationAlone, "columns are off by more than .* own estimate", "motion"),
    "raises in check": (RaisesInCheck, "KeyError", "quantities"),
    "idle setting": (IdleSetting, "smoothing does nothing", "resolution"),
    "keeps the whole scene": (KeepsAll, "most quantities are ignored.*earlier", "quantities"),
    "crank inertia shifted twice": (
        of_scene(crank__inertia=lambda x: x + 1.2 * 0.03**2 if x == 2e-3 else x),
        "crank.inertia shifted to O twice",
        "motion",
    ),
    "tip inertia shifted twice": (of_pair(_twice_shifted), "tip.inertia is shifted to the flexible end twice", "quantities"),
    "base held": (_Clamped, "base is held", "frequencies"),
    "half the torque": (of_scene(crank__torque=lambda x: 0.5 * x), "crank.torque half as large", "motion"),
    "twice the stiffness": (of_scene(follower__bending_stiffness=lambda x: 2.0 * x), "bending_stiffness twice as large", "motion"),
    "half the tip mass": (of_scene(tip__mass=lambda x: 0.5 * x), "tip.mass half as large", "motion"),
    "twice the crank inertia": (of_scene(crank__inertia=lambda x: 2.0 * x), "crank.inertia twice as large", "motion"),
    "half the base inertia": (of_scene(base__inertia=lambda x: 0.5 * x), "base.inertia half as large", "motion"),
    "half the follower damping": (of_scene(follower__damping=lambda x: 0.5 * x), "follower.damping acts.* half as large", "quantities"),
    "twice the slider mass": (of_scene(slider__mass=lambda x: 2.0 * x), "slider.mass acts.* twice as large", "quantities"),
    "half the joint stiffness": (of_scene(slider__joint_stiffness=lambda x: 0.5 * x), "joint_stiffness acts.* half as large", "quantities"),
    "tip offset without its sign": (of_scene(tip__center_of_mass=abs), "tip.center_of_mass .*without its sign", "quantities"),
    "twice the tip offset": (of_scene(tip__center_of_mass=lambda x: 2.0 * x), "tip.center_of_mass acts.* twice as large", "quantities"),
    "frequencies a quarter": (of_frequencies(lambda f: 0.25 * f), "0.25 times", "frequencies"),
}
