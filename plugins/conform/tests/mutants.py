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
from quickreturn.reference_model.mechanism import Mechanism, Scene
from quickreturn.reference_model.natural_modes import frozen_crank_modes
from quickreturn.reference_model.scene_values import changed, value_at

Array = NDArray[np.float64]
Columns = dict[str, Array]

SOUND = ReferenceEngine()
STRAINS = ("strain_1", "strain_2", "strain_3")
SHAPES = [f"shape_{place:02d}" for place in range(1, 12)]


class Mutant(ReferenceEngine):
    """Changes a scene or a start before the model is built, or columns before they are delivered; of a follower alone likewise."""

    name = "mutant"
    scene: ClassVar[Callable[[Any], Any]] = staticmethod(lambda mechanism: mechanism)
    alone: ClassVar[Callable[[Any], Any]] = staticmethod(lambda scene: scene)
    start: ClassVar[Callable[[Start], Start]] = staticmethod(lambda start: start)
    spoil: ClassVar[Callable[[Columns, Any], None]] = staticmethod(lambda columns, mechanism: None)
    spoil_alone: ClassVar[Callable[[Columns, Any], None]] = staticmethod(lambda columns, scene: None)

    def prepare(self, mechanism: Any, start: Start | None, settings: ReferenceSettings) -> Any:
        if start is None:
            return Spoiling(self.spoil_alone, mechanism, SOUND.prepare(self.alone(mechanism), None, settings))
        return Spoiling(self.spoil, mechanism, SOUND.prepare(self.scene(mechanism), self.start(start), settings))


class Spoiling(Simulation):
    def __init__(self, spoil: Callable[[Columns, Any], None], mechanism: Scene, sound: Simulation) -> None:
        self.spoil, self.mechanism, self.sound = spoil, mechanism, sound
        self.setup_seconds, self.time = sound.setup_seconds, 0.0

    def advance(self, duration: float, output_step: float) -> Trajectory:
        run = self.sound.advance(duration, output_step)
        self.time += duration
        columns = dict(run.columns)
        self.spoil(columns, self.mechanism)
        return dataclasses.replace(run, columns=columns)


def having(**members: Any) -> type[Mutant]:
    """A mutant with these hooks, which get no self, or methods."""
    return type(
        "Having",
        (Mutant,),
        {name: staticmethod(member) if name in vars(Mutant) and name != "prepare" else member for name, member in members.items()},
    )


def column(name: str, change: Callable[[Array], Array]) -> type[Mutant]:
    return having(spoil=lambda columns, _: columns.update({name: change(columns[name])}))


def of_scene(values: Mapping[str, Any], where: str = "scene") -> type[Mutant]:
    """The quantities have these values whatever the scene says; a function makes one from the scene's."""

    def other(scene: Any) -> Any:
        for key, value in values.items():
            present = value_at(scene, key) if "." in key else getattr(scene, key)
            if present is not None:
                scene = changed(scene, {key: value(present) if callable(value) else value})
        return scene

    return having(**{where: other})


def of_pair(changes: Callable[[Mechanism], dict[str, Any]]) -> type[Mutant]:
    """Scenes in which two quantities meet are changed; others are left as they are."""
    return having(scene=lambda mechanism: changed(mechanism, changes(mechanism)))


def of_frequencies(frequencies: Callable[[Any, float, int, Any], Any]) -> type[Mutant]:
    return having(natural_frequencies=lambda self, *given: frequencies(*given))


def of_factor(change: Callable[[float], float]) -> type[Mutant]:
    """The factor of each comparison is another one."""

    def comparisons(_: Any, *given: Any) -> tuple[Comparison, ...]:
        return tuple(dataclasses.replace(pair, factor=change(pair.factor)) for pair in SOUND.comparisons(*given))

    return having(comparisons=comparisons)


def late(values: Array, rows: float = 1.0) -> Array:
    """A column that comes some rows late."""
    numbers = np.arange(len(values), dtype=np.float64)
    return np.interp(np.maximum(numbers - rows, 0.0), numbers, values)


def wrapped(angle: Array) -> Array:
    """The angle of numpy.arctan2."""
    return np.angle(np.exp(1j * angle))


def in_turn(wrong: Callable[[Columns], Columns]) -> type[Mutant]:
    """Right in an arm that swings, and wrong in columns of one that turns fully."""
    return having(spoil=lambda columns, mechanism: columns.update(wrong(columns) if mechanism.turns_fully else {}))


def weight(moment: Callable[[Mechanism], float]) -> type[Mutant]:
    """At a prescribed speed the crank's torque lacks what holds a moment (kg m) against its weight."""

    def spoil(columns: Columns, mechanism: Mechanism) -> None:
        if not mechanism.crank_is_free:
            angle, (g1, g2) = columns["crank_angle"], mechanism.gravity
            columns["crank_torque"] = columns["crank_torque"] - moment(mechanism) * (g1 * np.sin(angle) - g2 * np.cos(angle))

    return having(spoil=spoil)


class Around(Simulation):
    """Around a sound simulation."""

    def __init__(self, sound: Simulation) -> None:
        self.sound, self.setup_seconds, self.time = sound, sound.setup_seconds, 0.0


class Swallowing(Around):
    """Holds its last row where the slider leaves the follower."""

    def advance(self, duration: float, output_step: float) -> Trajectory:
        self.time += duration
        try:
            return self.sound.advance(duration, output_step)
        except EngineFailure as failure:
            if failure.partial is None:
                raise
            rows = round(duration / output_step) + 1
            held = {name: np.pad(values, (0, rows - len(values)), mode="edge") for name, values in failure.partial.columns.items()}
            return Trajectory(held | {"time": output_step * np.arange(rows, dtype=np.float64)}, 0.0)


class OwnStep(Around):
    """A solver with a step of 1 ms of its own: a row between two of them holds what the last one left."""

    def advance(self, duration: float, output_step: float) -> Trajectory:
        run = self.sound.advance(duration, 1e-4)
        at = output_step * np.arange(round(duration / output_step) + 1)
        last = np.round(10.0 * np.floor(1e3 * at + 1e-6)).astype(int)
        columns = {name: values[last] for name, values in run.columns.items()} | {"time": self.time + at}
        self.time += duration
        return dataclasses.replace(run, columns=columns)


class RaisesValueError(Mutant):
    def prepare(self, mechanism: Mechanism, start: Start, settings: ReferenceSettings) -> Any:
        try:
            return super().prepare(mechanism, start, settings)
        except EngineFailure as failure:
            raise ValueError("math domain error") from failure


class RaisesInCheck(Mutant):
    def check(self, mechanism: Mechanism) -> None:
        super().check(mechanism)
        if mechanism.slider.inertia:
            raise KeyError("inertia of the slider")


class ForwardSpeed(Mutant):
    """A crank that can only be turned forwards."""

    def prepare(self, mechanism: Any, start: Start, settings: ReferenceSettings) -> Any:
        if not mechanism.crank_is_free:
            mechanism = changed(mechanism, {"crank.prescribed_speed": abs(mechanism.crank.drive.speed)})
        return super().prepare(mechanism, dataclasses.replace(start, crank_speed=abs(start.crank_speed)), settings)


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


class Threaded(ReferenceEngine):
    """Its last digits depend on how many threads add its sums: here, on whether the process is one with a single thread."""

    name = "threaded"

    def prepare(self, mechanism: Mechanism, start: Start, settings: ReferenceSettings) -> Any:
        return _Threads(super().prepare(mechanism, start, settings))


class _Threads(Around):
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


def _turned_with_the_crank(m: Mechanism) -> dict[str, Any]:
    angle, (g1, g2) = m.crank.initial_angle - math.pi, m.gravity
    c, s = math.cos(angle), math.sin(angle)
    return {"mechanism.gravity": (c * g1 - s * g2, s * g1 + c * g2)}


def _rollers_exchanged(m: Mechanism) -> dict[str, Any]:
    plus, minus = m.slider.joint_stiffness_plus, m.slider.joint_stiffness_minus
    return {"slider.joint_stiffness_plus": minus, "slider.joint_stiffness_minus": plus}


def _softer_of_both(m: Mechanism) -> dict[str, Any]:
    softer = min(m.slider.joint_stiffness_plus, m.slider.joint_stiffness_minus)
    return {"slider.joint_stiffness_plus": softer, "slider.joint_stiffness_minus": softer}


def _chord(columns: Columns, m: Mechanism) -> None:
    x, y = m.crank.length * np.cos(columns["crank_angle"]) - m.pivot_distance, m.crank.length * np.sin(columns["crank_angle"])
    columns["slider_position"] = np.hypot(x, y)


#: Mistake in one column -> the column, and how it is changed; the check of this column must fail.
_OF_COLUMN: dict[str, tuple[str, Callable[[Array], Array]]] = {
    "strain sign": ("strain_2", np.negative),
    "crank angle in degrees": ("crank_angle", np.degrees),
    "wrapped crank angle": ("crank_angle", wrapped),
    "crank angle from the start": ("crank_angle", lambda y: y - math.pi),
    "force 0.4 rows late": ("slider_force", lambda y: late(y, 0.4)),
    "force without its sign": ("slider_force", np.abs),
    "strain 2 %": ("strain_2", lambda y: 0.98 * y),
    "acceleration two rows late": ("tip_acceleration", lambda y: late(y, 2.0)),
    "the base's rate in degrees": ("follower_rate", np.degrees),
    "kinetic energy doubled": ("kinetic_energy", lambda y: 2.0 * y),
    "drive work sign": ("drive_work", np.negative),
    "one shape doubled": ("shape_06", lambda y: 2.0 * y),
    "acceleration in g": ("tip_acceleration", lambda y: y / 9.80665),
    "smoothed acceleration": ("tip_acceleration", lambda y: np.convolve(np.pad(y, 4, mode="edge"), np.ones(9) / 9.0, mode="valid")),
}
#: Mistake in one quantity of every scene -> its key, how it is changed, and the check that must fail.
_OF_QUANTITY: dict[str, tuple[str, Any, str]] = {
    "stiffness 2 %": ("follower.bending_stiffness", lambda x: 1.02 * x, "columns together"),
    "beam mass 2 %": ("follower.mass_per_length", lambda x: 1.02 * x, "columns together"),
    "tip mass 2 %": ("tip.mass", lambda x: 1.02 * x, "columns together"),
    "no tip body": ("tip", None, "columns together"),
    "crank inertia shifted twice": ("crank.inertia", lambda x: x + 1.2 * 0.03**2 if x == 2e-3 else x, "columns together"),
    "crank inertia about O": ("crank.center_of_mass", 0.0, "columns together"),
    "half the torque": ("crank.torque", lambda x: 0.5 * x, "columns together"),
    "base inertia 3 times": ("base.inertia", lambda x: 3.0 * x, "columns together"),
    "tip inertia about the wrong point": ("tip.inertia", lambda x: x + 0.05 * 0.02**2, "columns together"),
    "gravity ignored": ("mechanism.gravity", (0.0, 0.0), "quantity mechanism.gravity along n1"),
    "gravity exchanged": ("mechanism.gravity", lambda g: (g[1], g[0]), "quantity mechanism.gravity along n1"),
    "follower damping ignored": ("follower.damping", 0.0, "quantity follower.damping"),
    "follower damping doubled": ("follower.damping", lambda x: 2.0 * x, "quantity follower.damping"),
    "material twice as damped": ("follower.material_damping", lambda x: 2.0 * x, "quantity follower.material_damping"),
    "base damping ignored": ("base.damping", 0.0, "quantity base.damping"),
    "pivot without friction": ("base.friction_torque", 0.0, "quantity base.friction_torque"),
    "tip offset ignored": ("tip.center_of_mass", 0.0, "quantity tip.center_of_mass"),
    "tip offset without its sign": ("tip.center_of_mass", abs, "quantity tip.center_of_mass"),
    "slider mass ignored": ("slider.mass", 0.0, "quantity slider.mass"),
    "slider inertia ignored": ("slider.inertia", 0.0, "quantity slider.inertia"),
    "half the joint stiffness": ("slider.joint_stiffness", lambda x: 0.5 * x, "quantity slider.joint_stiffness"),
    "joint damping ignored": ("slider.joint_damping", 0.0, "quantity slider.joint_damping"),
    "clearance ignored": ("slider.clearance", 0.0, "quantity slider.clearance"),
    "preload ignored": ("slider.preload", 0.0, "quantity slider.preload"),
    "contact damping halved": ("slider.contact_damping", lambda x: 0.5 * x, "quantity slider.contact_damping"),
    "friction ignored": ("slider.friction", 0.0, "quantity slider.friction, the slider moving outwards"),
    "drag twice": ("slider.friction_force", lambda x: 2.0 * x, "quantity slider.friction_force"),
    "tool force ignored": ("tip.force", (0.0, 0.0), "quantity tip.force along n1"),
    "gauges of the thesis": ("follower.strain_gauges", (0.14, 0.29, 0.46), "quantity follower.strain_gauges"),
}
#: Mistake in the frequencies -> how they come from a scene, an angle of the crank, their largest number, and settings.
_OF_FREQUENCIES: dict[str, Callable[[Any, float, int, Any], Any]] = {
    "frequencies in rad/s": lambda *of: 2.0 * math.pi * SOUND.natural_frequencies(*of),
    "NaN frequencies": lambda *of: np.nan * SOUND.natural_frequencies(*of),
    "descending frequencies": lambda *of: SOUND.natural_frequencies(*of)[::-1],
    "frequencies 2 %": lambda *of: 1.02 * SOUND.natural_frequencies(*of),
    "a zero frequency": lambda *of: np.append(0.0, SOUND.natural_frequencies(*of)[:-1]),
    "twice as many frequencies": lambda *of: np.repeat(SOUND.natural_frequencies(*of), 2)[: of[2]],
    "crank held elsewhere": lambda scene, angle, *of: SOUND.natural_frequencies(scene, math.pi, *of),
    "degrees for radians": lambda scene, angle, *of: SOUND.natural_frequencies(scene, math.radians(angle), *of),
    "base held": lambda scene, angle, n, _: frozen_crank_modes(changed(scene, {"base.inertia": 1e6}), angle, n + 1).frequencies[1:],
}
#: Mistake in several columns -> how it changes them, and the check that must fail.
_OF_COLUMNS: dict[str, tuple[Callable[[Columns, Any], None], str]] = {
    "percent": (lambda c, m: c.update({name: 100.0 * c[name] for name in STRAINS}), "column strain_1"),
    "strains a row late": (lambda c, m: c.update({name: late(c[name]) for name in STRAINS}), "column strain_1"),
    "curvature": (lambda c, m: c.update(strain_1=2.0 / m.follower.thickness * c["strain_1"]), "column strain_1"),
    "gauges exchanged": (lambda c, m: c.update(strain_1=c["strain_3"], strain_3=c["strain_1"]), "column strain_1"),
    "tip from P": (lambda c, m: c.update(tip_x=c["tip_x"] - m.pivot_distance), "column tip_x"),
    "relative acceleration": (
        lambda c, m: c.update(tip_acceleration=np.gradient(np.gradient(c["tip_deflection"], c["time"]), c["time"])),
        "column tip_acceleration",
    ),
    "acceleration along the wrong axis": (
        lambda c, m: c.update(tip_acceleration=c["tip_acceleration"] * np.cos(c["follower_angle"])),
        "column tip_acceleration",
    ),
    "slider from the tip": (lambda c, m: c.update(slider_position=m.follower.length - c["slider_position"]), "column slider_position"),
    "chord": (_chord, "identity: bow and chord"),
    "shapes from tip to base": (lambda c, m: c.update(zip(SHAPES, [c[name] for name in SHAPES[::-1]], strict=True)), "column shape_01"),
    "shapes in mm": (lambda c, m: c.update({name: 1e3 * c[name] for name in SHAPES}), "column shape_01"),
    "time restarts": (lambda c, m: c.update(time=c["time"] - c["time"][0]), "pieces continue"),
    "dissipated energy restarts": (
        lambda c, m: c.update(dissipated_energy=c["dissipated_energy"] - c["dissipated_energy"][0]),
        "pieces continue",
    ),
}
_BASE_RATE = "identity: follower_acceleration from follower_rate"
_TURNING = "an arm that turns fully"
_OUTWARDS = "quantity slider.friction, the slider moving outwards"
_ON_THE_SLIDER = "quantity mechanism.gravity on the slider at a prescribed speed"
_TOGETHER = "quantity with everything on"
_count = itertools.count()
_kept: dict[str, Mechanism] = {}
#: Mistake that needs several quantities -> what it changes in a scene, and the check that must fail.
_OF_PAIRS: dict[str, tuple[Callable[[Mechanism], dict[str, Any]], str]] = {
    "tip inertia about the flexible end": (
        lambda m: {"tip.inertia": max(0.0, m.tip.inertia - m.tip.mass * m.tip.center_of_mass**2)} if m.tip else {},
        "quantity tip.center_of_mass",
    ),
    "tip inertia shifted twice": (
        lambda m: {"tip.inertia": m.tip.inertia + m.tip.mass * m.tip.center_of_mass**2} if m.tip else {},
        "quantity tip.center_of_mass",
    ),
    "slider without weight": (
        lambda m: (
            {"slider.mass": 0.0, "crank.inertia": m.crank.inertia + m.slider.mass * m.crank.length**2}
            if m.slider.mass and m.has_gravity
            else {}
        ),
        _ON_THE_SLIDER,
    ),
    "gravity turns with the start": (_turned_with_the_crank, "quantity mechanism.gravity with the crank elsewhere"),
    "offset without gravity": (
        lambda m: {"tip.center_of_mass": 0.0} if m.tip and m.tip.center_of_mass and m.has_gravity else {},
        _TOGETHER,
    ),
    "damping without offset": (lambda m: {"follower.damping": 0.0} if m.follower.damping and m.tip_body.center_of_mass else {}, _TOGETHER),
    "rollers exchanged, plus": (_rollers_exchanged, "quantity slider.joint_stiffness_plus"),
    "rollers exchanged, minus": (_rollers_exchanged, "quantity slider.joint_stiffness_minus"),
    "softer roller on either side": (_softer_of_both, "quantity slider.joint_stiffness_minus"),
    # friction that does not turn round with the slider: a start on the way out finds it driving
    "friction without sign": (
        lambda m: (
            {"slider.friction_speed": -m.slider.friction_speed} if m.slider.has_friction and 0.0 < m.crank.initial_angle < math.pi else {}
        ),
        _OUTWARDS,
    ),
    "remembers": (
        lambda m: {"tip.mass": m.tip.mass * (1.0 + 1e-5 * next(_count))} if m.tip else {},
        "the same the second time",
    ),
}
#: Mistake -> the engine, and the check that must fail.
PLANTED: dict[str, tuple[Callable[[], AnyEngine], str]] = {
    **{name: (column(of, change), f"column {of}") for name, (of, change) in _OF_COLUMN.items()},
    **{name: (having(spoil=spoil), check) for name, (spoil, check) in _OF_COLUMNS.items()},
    **{name: (of_scene({key: value}), check) for name, (key, value, check) in _OF_QUANTITY.items()},
    **{name: (of_pair(changes), check) for name, (changes, check) in _OF_PAIRS.items()},
    **{name: (of_frequencies(wrong), "frequencies") for name, wrong in _OF_FREQUENCIES.items()},
    "the base's acceleration reversed": (column("follower_acceleration", np.negative), _BASE_RATE),
    "the base's acceleration late": (column("follower_acceleration", late), _BASE_RATE),
    "estimate too small, no finer rung": (IntegrationAlone, "columns together"),
    "time in ms": (column("time", lambda y: 1e3 * y), "a trajectory"),
    "rows of the last own step": (having(prepare=lambda _, *given: OwnStep(SOUND.prepare(*given))), "the same with 1.3 ms between rows"),
    "start not bending": (having(start=lambda start: dataclasses.replace(start, deflection_rate=None)), "a bent, moving start"),
    "start straight": (having(start=lambda start: Start(start.crank_angle, start.crank_speed)), "a bent, moving start"),
    "joint stiffness ignored": (
        of_scene({"slider.joint_stiffness": math.inf, "slider.joint_damping": 0.0}),
        "quantity slider.joint_stiffness",
    ),
    "tool always cuts": (of_scene({"tip.force_from": 0.0, "tip.force_to": 2.0 * math.pi}), "quantity tip.force_from"),
    "turns forwards alone": (ForwardSpeed, "quantity crank.prescribed_speed, reversed"),
    "weight of the slider not in the drive": (weight(lambda m: m.slider.mass * m.crank.length), _ON_THE_SLIDER),
    "weight of the crank turned round": (weight(lambda m: 2.0 * m.crank_moment), "quantity mechanism.gravity at a prescribed speed"),
    "gravity energy sign": (column("gravity_energy", np.negative), "quantity mechanism.gravity along n1"),
    "raises in check": (RaisesInCheck, "quantity slider.inertia"),
    "keeps the whole scene": (having(scene=lambda m: _kept.setdefault("first", m)), "quantity follower.length"),
    "wraps the angle": (in_turn(lambda c: {"follower_angle": wrapped(c["follower_angle"])}), _TURNING),
    "begins a turn late": (in_turn(lambda c: {"follower_angle": c["follower_angle"] - 2.0 * np.pi}), _TURNING),
    # an inverse tangent of one argument, made continuous: it is right beyond P and half a turn off
    "folds the angle": (
        in_turn(lambda c: {"follower_angle": c["follower_angle"] - np.pi, "slider_position": -c["slider_position"]}),
        _TURNING,
    ),
    "slides behind": (in_turn(lambda c: {"slider_position": -c["slider_position"]}), _TURNING),
    "turns the deflection": (in_turn(lambda c: {"tip_deflection": c["tip_deflection"] * np.sign(np.cos(c["follower_angle"]))}), _TURNING),
    "finer goes backwards": (
        having(finer=lambda _, settings, *given: settings.replaced(modes=settings.modes - 1) if settings.modes > 1 else None),
        "ladder: gets finer",
    ),
    "finer stands still": (having(finer=lambda _, settings, *given: settings), "ladder: ends"),
    "settings_for backwards": (
        having(settings_for=lambda _, accuracy, scene: SOUND.settings_for(1e-3 if accuracy > 0.01 else 0.05, scene)),
        "ladder: gets finer",
    ),
    "overclaimed factor": (of_factor(lambda factor: 10.0), "estimates hold, coarse settings"),
    "factor upside down": (of_factor(lambda factor: 1.0 / factor), "estimates hold, coarse settings"),
    "goes on in silence": (having(prepare=lambda _, *given: Swallowing(SOUND.prepare(*given))), "failures: the slider leaves the follower"),
    "raises ValueError": (RaisesValueError, "failures: a start that cannot be"),
    "alone: stiffness": (of_scene({"follower.bending_stiffness": 21.0}, "alone"), "the follower alone"),
    "alone: strain sign": (having(spoil_alone=lambda c, _: c.update(strain_1=-c["strain_1"])), "the follower alone"),
    "alone: no gravity": (of_scene({"mechanism.gravity": (0.0, 0.0)}, "alone"), "the follower alone: mechanism.gravity along n1"),
    "alone: damping ignored": (of_scene({"follower.damping": 0.0}, "alone"), "the follower alone: follower.damping"),
}
