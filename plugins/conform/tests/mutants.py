"""Engines that are `reference` with one mistake each, and the check that must find it."""

import dataclasses
import itertools
import math
import os
from collections.abc import Callable, Mapping
from typing import Any, ClassVar

import numpy as np
from numpy.typing import NDArray

from quickreturn.engines.base import AnyEngine, Comparison, EngineFailure, Simulation
from quickreturn.engines.own.reference import ReferenceEngine, ReferenceSettings
from quickreturn.engines.start import Start
from quickreturn.engines.trajectory import Trajectory
from quickreturn.reference_model.mechanism import FollowerAlone, Mechanism, PrescribedSpeed, Scene
from quickreturn.reference_model.natural_modes import frozen_crank_modes
from quickreturn.reference_model.scene_values import changed, value_at
from tests.engines import wrong_engines

Array = NDArray[np.float64]

Columns = dict[str, Array]


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


def column(name: str, change: Callable[[Array], Array]) -> type[Mutant]:
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


def late(values: Array) -> Array:
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


def of_frequencies(wrong: Callable[[Array], Any]) -> type[Mutant]:
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


def _accelerometer(columns: Columns, mechanism: Mechanism) -> None:
    columns["tip_acceleration"] = columns["tip_acceleration"] / 9.80665


def _from_tip(columns: Columns, mechanism: Mechanism) -> None:
    columns["slider_position"] = mechanism.follower.length - columns["slider_position"]


def _in_the_base_frame(columns: Columns, mechanism: Mechanism) -> None:
    columns["tip_acceleration"] = columns["tip_acceleration"] * np.cos(columns["follower_angle"])


def _dissipation_restarts(columns: Columns, mechanism: Mechanism) -> None:
    columns["dissipated_energy"] = columns["dissipated_energy"] - columns["dissipated_energy"][0]


class AboutTheEnd(Mutant):
    def scene(self, mechanism: Mechanism) -> Mechanism:
        tip = mechanism.tip
        return mechanism if tip is None else changed(mechanism, {"tip.inertia": max(0.0, tip.inertia - tip.mass * tip.center_of_mass**2)})


class _ForwardSpeed(Mutant):
    """A crank that can only be turned forwards."""

    def scene(self, mechanism: Mechanism) -> Mechanism:
        drive = mechanism.crank.drive
        return changed(mechanism, {"crank.prescribed_speed": abs(drive.speed)}) if isinstance(drive, PrescribedSpeed) else mechanism

    def start(self, start: Start) -> Start:
        return dataclasses.replace(start, crank_speed=abs(start.crank_speed))


class _DegreesForRadians(Mutant):
    def natural_frequencies(self, mechanism: Mechanism, crank_angle: float, count: int, settings: ReferenceSettings) -> Any:
        return super().natural_frequencies(mechanism, math.radians(crank_angle), count, settings)


class _UpsideDown(Mutant):
    def comparisons(self, settings: ReferenceSettings, mechanism: Mechanism, output_step: float) -> tuple[Comparison, ...]:
        return tuple(dataclasses.replace(pair, factor=1.0 / pair.factor) for pair in super().comparisons(settings, mechanism, output_step))


class _CoarserWhenAsked(Mutant):
    def settings_for(self, accuracy: float, mechanism: Any) -> ReferenceSettings:
        return ReferenceEngine.settings_for(self, 1e-3 if accuracy > 0.01 else 0.05, mechanism)


class _Smooth(Mutant):
    """A moving average, as to look better."""

    def spoil(self, columns: Columns, mechanism: Mechanism) -> None:
        columns["tip_acceleration"] = np.convolve(np.pad(columns["tip_acceleration"], 4, mode="edge"), np.ones(9) / 9.0, mode="valid")


OWN_STEP = 1e-3  # s


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


def _rollers_exchanged(m: Mechanism) -> dict[str, Any]:
    plus, minus = m.slider.joint_stiffness_plus, m.slider.joint_stiffness_minus
    return {"slider.joint_stiffness_plus": minus, "slider.joint_stiffness_minus": plus}


def _same_way_always(m: Mechanism) -> dict[str, Any]:
    """Friction that does not turn round with the slider: a start on the way out finds it driving."""
    outwards = m.slider.has_friction and 0.0 < m.crank.initial_angle < math.pi
    return {"slider.friction_speed": -m.slider.friction_speed} if outwards else {}


def _softer_of_both(m: Mechanism) -> dict[str, Any]:
    softer = min(m.slider.joint_stiffness_plus, m.slider.joint_stiffness_minus)
    return {"slider.joint_stiffness_plus": softer, "slider.joint_stiffness_minus": softer}


class WeightOfTheCrank(Mutant):
    """At a prescribed speed the crank's weight is in its torque with the wrong sign."""

    def spoil(self, columns: Columns, mechanism: Mechanism) -> None:
        if not mechanism.crank_is_free:
            angle, (g1, g2) = columns["crank_angle"], mechanism.gravity
            weight = mechanism.crank_moment * (g1 * np.sin(angle) - g2 * np.cos(angle))  # what holds the crank against it
            columns["crank_torque"] = columns["crank_torque"] - 2.0 * weight


class WeightOfTheSlider(Mutant):
    """At a prescribed speed the slider's weight is not in the crank's torque."""

    def spoil(self, columns: Columns, mechanism: Mechanism) -> None:
        if not mechanism.crank_is_free:
            angle, (g1, g2) = columns["crank_angle"], mechanism.gravity
            arm = mechanism.slider.mass * mechanism.crank.length
            columns["crank_torque"] = columns["crank_torque"] - arm * (g1 * np.sin(angle) - g2 * np.cos(angle))


def _turned_fully(name: str) -> Callable[[], AnyEngine]:
    kind: Any = getattr(wrong_engines, name)
    return lambda: kind(ReferenceEngine())


def _wrapped(values: Array) -> Array:
    return (values + np.pi) % (2.0 * np.pi) - np.pi


def _strains(change: Callable[[Array], Array]) -> type[Mutant]:
    return of_columns(lambda columns, _: columns.update({f"strain_{i}": change(columns[f"strain_{i}"]) for i in (1, 2, 3)}))


#: Mistake in one column -> the column, and how it is changed; the check of this column must fail.
_OF_COLUMN: dict[str, tuple[str, Callable[[Array], Array]]] = {
    "strain sign": ("strain_2", np.negative),
    "microstrain": ("strain_3", lambda y: 1e6 * y),
    "crank angle in degrees": ("crank_angle", np.degrees),
    "follower angle in degrees": ("follower_angle", np.degrees),
    "wrapped crank angle": ("crank_angle", _wrapped),
    "wrapped follower angle": ("follower_angle", _wrapped),
    "crank angle from the start": ("crank_angle", lambda y: y - math.pi),
    "speed in rpm": ("crank_speed", lambda y: 30.0 / math.pi * y),
    "speed in Hz": ("crank_speed", lambda y: y / (2.0 * math.pi)),
    "slider in inches": ("slider_position", lambda y: y / 0.0254),
    "deflection in mm": ("tip_deflection", lambda y: 1e3 * y),
    "deflection sign": ("tip_deflection", np.negative),
    "force sign": ("slider_force", np.negative),
    "force a row late": ("slider_force", late),
    "force 0.4 rows late": ("slider_force", _later(0.4)),
    "force in pounds": ("slider_force", lambda y: y / 4.4482216152605),
    "force without its sign": ("slider_force", np.abs),
    "force 2 %": ("slider_force", lambda y: 1.02 * y),
    "strain half a row late": ("strain_2", _later(0.5)),
    "strain 2 %": ("strain_2", lambda y: 0.98 * y),
    "acceleration two rows late": ("tip_acceleration", lambda y: late(late(y))),
    "acceleration 2 %": ("tip_acceleration", lambda y: 1.02 * y),
    "the base's rate in degrees": ("follower_rate", np.degrees),
    "kinetic energy doubled": ("kinetic_energy", lambda y: 2.0 * y),
    "strain energy halved": ("strain_energy", lambda y: 0.5 * y),
    "drive work sign": ("drive_work", np.negative),
    "torque in inch pounds": ("crank_torque", lambda y: y / 0.1129848290276167),
    "one shape doubled": ("shape_06", lambda y: 2.0 * y),
}
#: Mistake in one quantity of every scene -> its key, how it is changed, and the check that must fail.
_OF_QUANTITY: dict[str, tuple[str, Any, str]] = {
    "stiffness 2 %": ("follower.bending_stiffness", lambda x: 1.02 * x, "columns together"),
    "twice the stiffness": ("follower.bending_stiffness", lambda x: 2.0 * x, "columns together"),
    "beam mass 2 %": ("follower.mass_per_length", lambda x: 1.02 * x, "columns together"),
    "tip mass 2 %": ("tip.mass", lambda x: 1.02 * x, "columns together"),
    "half the tip mass": ("tip.mass", lambda x: 0.5 * x, "columns together"),
    "no tip body": ("tip", None, "columns together"),
    "crank inertia 5 %": ("crank.inertia", lambda x: 1.05 * x, "columns together"),
    "twice the crank inertia": ("crank.inertia", lambda x: 2.0 * x, "columns together"),
    "crank inertia shifted twice": ("crank.inertia", lambda x: x + 1.2 * 0.03**2 if x == 2e-3 else x, "columns together"),
    "crank inertia about O": ("crank.center_of_mass", 0.0, "columns together"),
    "half the torque": ("crank.torque", lambda x: 0.5 * x, "columns together"),
    "base inertia 3 times": ("base.inertia", lambda x: 3.0 * x, "columns together"),
    "half the base inertia": ("base.inertia", lambda x: 0.5 * x, "columns together"),
    "tip inertia about the wrong point": ("tip.inertia", lambda x: x + 0.05 * 0.02**2, "columns together"),
    "gravity ignored": ("mechanism.gravity", (0.0, 0.0), "quantity mechanism.gravity along n1"),
    "gravity turned round": ("mechanism.gravity", lambda g: (-g[0], -g[1]), "quantity mechanism.gravity along n2"),
    "gravity exchanged": ("mechanism.gravity", lambda g: (g[1], g[0]), "quantity mechanism.gravity along n1"),
    "gravity a quarter": ("mechanism.gravity", lambda g: (-g[1], g[0]), "quantity mechanism.gravity along n2"),
    "follower damping ignored": ("follower.damping", 0.0, "quantity follower.damping"),
    "follower damping doubled": ("follower.damping", lambda x: 2.0 * x, "quantity follower.damping"),
    "half the follower damping": ("follower.damping", lambda x: 0.5 * x, "quantity follower.damping"),
    "material twice as damped": ("follower.material_damping", lambda x: 2.0 * x, "quantity follower.material_damping"),
    "base damping ignored": ("base.damping", 0.0, "quantity base.damping"),
    "half the base damping": ("base.damping", lambda x: 0.5 * x, "quantity base.damping"),
    "pivot without friction": ("base.friction_torque", 0.0, "quantity base.friction_torque"),
    "tip offset ignored": ("tip.center_of_mass", 0.0, "quantity tip.center_of_mass"),
    "tip offset turned round": ("tip.center_of_mass", lambda x: -x, "quantity tip.center_of_mass"),
    "tip offset without its sign": ("tip.center_of_mass", abs, "quantity tip.center_of_mass"),
    "twice the tip offset": ("tip.center_of_mass", lambda x: 2.0 * x, "quantity tip.center_of_mass"),
    "slider mass ignored": ("slider.mass", 0.0, "quantity slider.mass"),
    "twice the slider mass": ("slider.mass", lambda x: 2.0 * x, "quantity slider.mass"),
    "slider inertia ignored": ("slider.inertia", 0.0, "quantity slider.inertia"),
    "half the joint stiffness": ("slider.joint_stiffness", lambda x: 0.5 * x, "quantity slider.joint_stiffness"),
    "joint damping ignored": ("slider.joint_damping", 0.0, "quantity slider.joint_damping"),
    "clearance doubled": ("slider.clearance", lambda x: 2.0 * x, "quantity slider.clearance"),
    "clearance ignored": ("slider.clearance", 0.0, "quantity slider.clearance"),
    "preload ignored": ("slider.preload", 0.0, "quantity slider.preload"),
    "contact damping halved": ("slider.contact_damping", lambda x: 0.5 * x, "quantity slider.contact_damping"),
    "friction ignored": ("slider.friction", 0.0, "quantity slider.friction, the slider moving outwards"),
    "drag twice": ("slider.friction_force", lambda x: 2.0 * x, "quantity slider.friction_force"),
    "tool force ignored": ("tip.force", (0.0, 0.0), "quantity tip.force along n1"),
    "gauges of the thesis": ("follower.strain_gauges", (0.14, 0.29, 0.46), "quantity follower.strain_gauges"),
}
#: Mistake in the frequencies -> how they are changed.
_OF_FREQUENCIES: dict[str, Callable[[Array], Any]] = {
    "frequencies in rad/s": lambda f: 2.0 * math.pi * f,
    "eigenvalues": lambda f: (2.0 * math.pi * f) ** 2,
    "NaN frequencies": lambda f: f * np.nan,
    "descending frequencies": lambda f: f[::-1],
    "frequencies 2 %": lambda f: 1.02 * f,
    "frequencies a quarter": lambda f: 0.25 * f,
    "a zero frequency": lambda f: np.concatenate([[0.0], f[:-1]]),
    "twice as many frequencies": lambda f: np.repeat(f, 2)[: len(f)],
}
_JOINT_IGNORED = of_scene(slider__joint_stiffness=math.inf, slider__joint_damping=0.0)
_ALWAYS_CUTS = of_scene(tip__force_from=0.0, tip__force_to=2.0 * math.pi)
_OUTWARDS = "quantity slider.friction, the slider moving outwards"
_TOGETHER = "quantity with everything on"
#: Mistake -> the engine, and the check that must fail.
PLANTED: dict[str, tuple[Callable[[], AnyEngine], str]] = {
    **{name: (column(of, change), f"column {of}") for name, (of, change) in _OF_COLUMN.items()},
    **{name: (of_scene(**{key.replace(".", "__"): value}), check) for name, (key, value, check) in _OF_QUANTITY.items()},
    **{name: (of_frequencies(change), "frequencies") for name, change in _OF_FREQUENCIES.items()},
    "percent": (_strains(lambda y: 100.0 * y), "column strain_1"),
    "strains a row late": (_strains(late), "column strain_1"),
    "curvature": (of_columns(lambda c, m: c.update(strain_1=2.0 / m.follower.thickness * c["strain_1"])), "column strain_1"),
    "gauges exchanged": (of_columns(_exchanged), "column strain_1"),
    "tip from P": (of_columns(_from_pivot), "column tip_x"),
    "relative acceleration": (of_columns(_relative), "column tip_acceleration"),
    "acceleration in g": (of_columns(_accelerometer), "column tip_acceleration"),
    "acceleration along the wrong axis": (of_columns(_in_the_base_frame), "column tip_acceleration"),
    "smoothed acceleration": (_Smooth, "column tip_acceleration"),
    "slider from the tip": (of_columns(_from_tip), "column slider_position"),
    "chord": (of_columns(_chord), "identity: bow and chord"),
    "the base's acceleration reversed": (
        column("follower_acceleration", np.negative),
        "identity: follower_acceleration from follower_rate",
    ),
    "the base's acceleration late": (column("follower_acceleration", late), "identity: follower_acceleration from follower_rate"),
    "shapes from tip to base": (of_columns(_shapes_reversed), "columns together"),
    "shapes in mm": (of_columns(_shapes_in_mm), "columns together"),
    "estimate too small, no finer rung": (IntegrationAlone, "columns together"),
    "time in ms": (column("time", lambda y: 1e3 * y), "a trajectory"),
    "time restarts": (RestartingTime, "pieces continue"),
    "dissipated energy restarts": (of_columns(_dissipation_restarts), "pieces continue"),
    "rows of the last own step": (RowsOfTheLastStep, "the same with 2.5 ms between rows"),
    "start not bending": (_NoRates, "a bent, moving start"),
    "start straight": (_Straight, "a bent, moving start"),
    "joint stiffness ignored": (_JOINT_IGNORED, "quantity slider.joint_stiffness"),
    "tool always cuts": (_ALWAYS_CUTS, "quantity tip.force_from"),
    "tip inertia about the flexible end": (AboutTheEnd, "quantity tip.center_of_mass"),
    "tip inertia shifted twice": (of_pair(_twice_shifted), "quantity tip.center_of_mass"),
    "turns forwards alone": (_ForwardSpeed, "quantity crank.prescribed_speed, reversed"),
    "slider without weight": (of_pair(_slider_without_weight), "quantity mechanism.gravity on the slider at a prescribed speed"),
    "weight of the slider not in the drive": (WeightOfTheSlider, "quantity mechanism.gravity on the slider at a prescribed speed"),
    "weight of the crank turned round": (WeightOfTheCrank, "quantity mechanism.gravity at a prescribed speed"),
    "gravity energy sign": (column("gravity_energy", np.negative), "quantity mechanism.gravity along n1"),
    "gravity turns with the start": (of_pair(_turned_with_the_crank), "quantity mechanism.gravity with the crank elsewhere"),
    "offset without gravity": (of_pair(_offset_without_gravity), _TOGETHER),
    "damping without offset": (of_pair(_damping_without_offset), _TOGETHER),
    "rollers exchanged, plus": (of_pair(_rollers_exchanged), "quantity slider.joint_stiffness_plus"),
    "rollers exchanged, minus": (of_pair(_rollers_exchanged), "quantity slider.joint_stiffness_minus"),
    "softer roller on either side": (of_pair(_softer_of_both), "quantity slider.joint_stiffness_minus"),
    "friction without sign": (of_pair(_same_way_always), _OUTWARDS),
    "raises in check": (RaisesInCheck, "quantity slider.inertia"),
    "keeps the whole scene": (KeepsAll, "quantity follower.length"),
    "wraps the angle": (_turned_fully("WrapsTheAngle"), "an arm that turns fully"),
    "begins a turn late": (_turned_fully("BeginsATurnLate"), "an arm that turns fully"),
    "folds the angle": (_turned_fully("FoldsTheAngle"), "an arm that turns fully"),
    "slides behind": (_turned_fully("SlidesBehind"), "an arm that turns fully"),
    "turns the deflection": (_turned_fully("TurnsTheDeflection"), "an arm that turns fully"),
    "finer goes backwards": (BackwardsLadder, "ladder: gets finer"),
    "finer stands still": (EndlessLadder, "ladder: ends"),
    "settings_for backwards": (_CoarserWhenAsked, "ladder: gets finer"),
    "overclaimed factor": (Overclaims, "estimates hold, coarse settings"),
    "factor upside down": (_UpsideDown, "estimates hold, coarse settings"),
    "crank held elsewhere": (_HeldAtTheStart, "frequencies"),
    "degrees for radians": (_DegreesForRadians, "frequencies"),
    "base held": (_Clamped, "frequencies"),
    "goes on in silence": (GoesOnInSilence, "failures: the slider leaves the follower"),
    "raises ValueError": (RaisesValueError, "failures: a start that cannot be"),
    "remembers": (_Random, "the same the second time"),
    "alone: stiffness": (of_alone(follower__bending_stiffness=21.0), "the follower alone"),
    "alone: strain sign": (_StrainOfAlone, "the follower alone"),
    "alone: no gravity": (of_alone(mechanism__gravity=(0.0, 0.0)), "the follower alone: mechanism.gravity along n1"),
    "alone: damping ignored": (of_alone(follower__damping=0.0), "the follower alone: follower.damping"),
}
