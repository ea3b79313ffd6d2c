"""Engines that are `reference` with one mistake each, and the check that must find it."""

import dataclasses
import itertools
import math
from collections.abc import Callable, Mapping
from typing import Any, ClassVar

import numpy as np

from quickreturn.engines.base import AnyEngine, Comparison, EngineFailure, Simulation
from quickreturn.engines.own.reference import ReferenceEngine, ReferenceSettings
from quickreturn.engines.start import Start
from quickreturn.engines.trajectory import Trajectory
from quickreturn.reference_model.arrays import Array
from quickreturn.reference_model.mechanism import Mechanism
from quickreturn.reference_model.natural_modes import frozen_crank_modes
from quickreturn.reference_model.scene_values import changed, value_at

Columns = dict[str, Array]

SOUND = ReferenceEngine()
STRAINS = ("strain_1", "strain_2", "strain_3")
SHAPES = [f"shape_{place:02d}" for place in range(1, 12)]


class Around(Simulation):
    """A sound simulation whose columns are changed before they are delivered."""

    def __init__(self, sound: Simulation, change: Callable[[Columns], Any] = dict) -> None:
        self.sound, self.change, self.setup_seconds, self.time = sound, change, sound.setup_seconds, 0.0

    def advance(self, duration: float, output_step: float) -> Trajectory:
        run = self.sound.advance(duration, output_step)
        self.time += duration
        return dataclasses.replace(run, columns={**run.columns, **self.change(dict(run.columns))})


class Mutant(ReferenceEngine):
    """Changes a scene or a start before the model is built, or columns, of mechanisms or of followers alone."""

    name = "mutant"
    alone: ClassVar[bool] = False
    scene: ClassVar[Callable[[Any], Any]] = staticmethod(lambda scene: scene)
    start: ClassVar[Callable[[Any], Any]] = staticmethod(lambda start: start)
    columns: ClassVar[Callable[[Columns, Any], Any]] = staticmethod(lambda columns, scene: columns)

    def prepare(self, scene: Any, start: Start | None, settings: ReferenceSettings) -> Any:
        if (start is None) != self.alone:
            return SOUND.prepare(scene, start, settings)
        return Around(SOUND.prepare(self.scene(scene), self.start(start), settings), lambda c: self.columns(c, scene))


def having(**members: Any) -> type[Mutant]:
    """A mutant with these hooks, which get no self, or methods."""
    hooks = {"scene", "start", "columns"}
    return type("Having", (Mutant,), {name: staticmethod(each) if name in hooks else each for name, each in members.items()})


def column(name: str, change: Callable[[Array], Array]) -> type[Mutant]:
    return having(columns=lambda c, _: {name: change(c[name])})


def of_scene(values: Mapping[str, Any], **members: Any) -> type[Mutant]:
    """The quantities have these values whatever the scene says; a function makes one from the scene's."""

    def other(scene: Any) -> Any:
        for key, value in values.items():
            present = value_at(scene, key) if "." in key else getattr(scene, key)
            if present is not None:
                scene = changed(scene, {key: value(present) if callable(value) else value})
        return scene

    return having(scene=other, **members)


def of_pair(changes: Callable[[Mechanism], dict[str, Any]]) -> type[Mutant]:
    """Scenes in which two quantities meet are changed; others are left as they are."""
    return having(scene=lambda mechanism: changed(mechanism, changes(mechanism)))


def of_frequencies(frequencies: Callable[[Any, float, int, Any], Any]) -> type[Mutant]:
    return having(natural_frequencies=lambda self, *given: frequencies(*given))


def of_factor(change: Callable[[float], float]) -> type[Mutant]:
    """The factor of each comparison is another one."""
    return having(
        comparisons=lambda _, *given: tuple(dataclasses.replace(each, factor=change(each.factor)) for each in SOUND.comparisons(*given))
    )


def late(values: Array, rows: float = 1.0) -> Array:
    """A column that comes some rows late."""
    numbers = np.arange(len(values), dtype=np.float64)
    return np.interp(np.maximum(numbers - rows, 0.0), numbers, values)


def wrapped(angle: Array) -> Array:
    """The angle of numpy.arctan2."""
    return np.angle(np.exp(1j * angle))


def weight(moment: Callable[[Mechanism], float]) -> type[Mutant]:
    """At a prescribed speed the crank's torque lacks what holds a moment (kg m) against its weight."""

    def torque(c: Columns, m: Mechanism) -> Columns:
        angle, (g1, g2) = c["crank_angle"], m.gravity
        held = moment(m) * (g1 * np.sin(angle) - g2 * np.cos(angle))
        return {} if m.crank_is_free else {"crank_torque": c["crank_torque"] - held}

    return having(columns=torque)


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


def _raising(self: Any, *given: Any) -> Any:
    try:
        return SOUND.prepare(*given)
    except EngineFailure as failure:
        raise ValueError("math domain error") from failure


def _raising_check(self: Any, scene: Any) -> None:
    if scene.crank and scene.slider.inertia:
        raise KeyError("inertia of the slider")


def _turned_with_the_crank(m: Mechanism) -> dict[str, Any]:
    gravity = complex(*m.gravity) * np.exp(1j * (m.crank.initial_angle - math.pi))
    return {"mechanism.gravity": (gravity.real, gravity.imag)}


def _rollers(m: Mechanism, law: Callable[[float, float], tuple[float, float]]) -> dict[str, Any]:
    pair = law(m.slider.joint_stiffness_plus, m.slider.joint_stiffness_minus)
    return dict(zip(("slider.joint_stiffness_plus", "slider.joint_stiffness_minus"), pair, strict=True))


def _about_the_end(m: Mechanism, sign: float) -> dict[str, Any]:
    return {"tip.inertia": max(0.0, m.tip.inertia + sign * m.tip.mass * m.tip.center_of_mass**2)} if m.tip else {}


def _weightless_slider(m: Mechanism) -> dict[str, Any]:
    heavy = {"slider.mass": 0.0, "crank.inertia": m.crank.inertia + m.slider.mass * m.crank.length**2}
    return heavy if m.slider.mass and m.has_gravity else {}


def _driving_friction(m: Mechanism) -> dict[str, Any]:
    """It does not turn round with the slider: a start on the way out finds it driving."""
    outwards = m.slider.has_friction and 0.0 < m.crank.initial_angle < math.pi
    return {"slider.friction_speed": -m.slider.friction_speed} if outwards else {}


_ALONG, _HEAT, _EVERYTHING = "tip_acceleration", "dissipated_energy", "quantity with everything on"
_BOW = "identity: bow and chord"
_TOGETHER, _RATE, _TURNING = "columns together", "identity: follower_acceleration from follower_rate", "an arm that turns fully"
_ON_THE_SLIDER = "quantity mechanism.gravity on the slider at a prescribed speed"
_count = itertools.count()
_kept: dict[str, Mechanism] = {}
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
#: Mistake in one quantity of every scene -> its key, how it is changed, and the check that must fail: if none is named, of that quantity.
_OF_QUANTITY: dict[str, tuple[str, Any, str]] = {
    "stiffness 2 %": ("follower.bending_stiffness", lambda x: 1.02 * x, _TOGETHER),
    "beam mass 2 %": ("follower.mass_per_length", lambda x: 1.02 * x, _TOGETHER),
    "tip mass 2 %": ("tip.mass", lambda x: 1.02 * x, _TOGETHER),
    "no tip body": ("tip", None, _TOGETHER),
    "crank inertia shifted twice": ("crank.inertia", lambda x: x + 1.2 * 0.03**2 if x == 2e-3 else x, _TOGETHER),
    "crank inertia about O": ("crank.center_of_mass", 0.0, _TOGETHER),
    "half the torque": ("crank.torque", lambda x: 0.5 * x, _TOGETHER),
    "base inertia 3 times": ("base.inertia", lambda x: 3.0 * x, _TOGETHER),
    "tip inertia about the wrong point": ("tip.inertia", lambda x: x + 0.05 * 0.02**2, _TOGETHER),
    "gravity ignored": ("mechanism.gravity", (0.0, 0.0), "quantity mechanism.gravity along n1"),
    "gravity exchanged": ("mechanism.gravity", lambda g: (g[1], g[0]), "quantity mechanism.gravity along n1"),
    "follower damping ignored": ("follower.damping", 0.0, ""),
    "follower damping doubled": ("follower.damping", lambda x: 2.0 * x, ""),
    "material twice as damped": ("follower.material_damping", lambda x: 2.0 * x, ""),
    "base damping ignored": ("base.damping", 0.0, ""),
    "pivot without friction": ("base.friction_torque", 0.0, ""),
    "tip offset ignored": ("tip.center_of_mass", 0.0, ""),
    "tip offset without its sign": ("tip.center_of_mass", abs, ""),
    "slider mass ignored": ("slider.mass", 0.0, ""),
    "slider inertia ignored": ("slider.inertia", 0.0, ""),
    "half the joint stiffness": ("slider.joint_stiffness", lambda x: 0.5 * x, ""),
    "joint damping ignored": ("slider.joint_damping", 0.0, ""),
    "clearance ignored": ("slider.clearance", 0.0, ""),
    "preload ignored": ("slider.preload", 0.0, ""),
    "contact damping halved": ("slider.contact_damping", lambda x: 0.5 * x, ""),
    "friction ignored": ("slider.friction", 0.0, "quantity slider.friction, the slider moving outwards"),
    "drag twice": ("slider.friction_force", lambda x: 2.0 * x, ""),
    "tool force ignored": ("tip.force", (0.0, 0.0), "quantity tip.force along n1"),
    "gauges of the thesis": ("follower.strain_gauges", (0.14, 0.29, 0.46), ""),
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
#: Mistake in several columns -> what they become, and the check that must fail.
_OF_COLUMNS: dict[str, tuple[Callable[[Columns, Any], Any], str]] = {
    "percent": (lambda c, m: {name: 100.0 * c[name] for name in STRAINS}, "column strain_1"),
    "strains a row late": (lambda c, m: {name: late(c[name]) for name in STRAINS}, "column strain_1"),
    "curvature": (lambda c, m: {"strain_1": 2.0 / m.follower.thickness * c["strain_1"]}, "column strain_1"),
    "gauges exchanged": (lambda c, m: {"strain_1": c["strain_3"], "strain_3": c["strain_1"]}, "column strain_1"),
    "tip from P": (lambda c, m: {"tip_x": c["tip_x"] - m.pivot_distance}, "column tip_x"),
    "relative acceleration": (lambda c, m: {_ALONG: np.gradient(np.gradient(c["tip_deflection"], 1e-3), 1e-3)}, f"column {_ALONG}"),
    "acceleration along the wrong axis": (lambda c, m: {_ALONG: c[_ALONG] * np.cos(c["follower_angle"])}, f"column {_ALONG}"),
    "slider from the tip": (lambda c, m: {"slider_position": m.follower.length - c["slider_position"]}, "column slider_position"),
    "chord": (lambda c, m: {"slider_position": abs(m.crank.length * np.exp(1j * c["crank_angle"]) - m.pivot_distance)}, _BOW),
    "shapes from tip to base": (lambda c, m: dict(zip(SHAPES, [c[name] for name in SHAPES[::-1]], strict=True)), "column shape_01"),
    "shapes in mm": (lambda c, m: {name: 1e3 * c[name] for name in SHAPES}, "column shape_01"),
    "time restarts": (lambda c, m: {"time": c["time"] - c["time"][0]}, "pieces continue"),
    "dissipated energy restarts": (lambda c, m: {_HEAT: c[_HEAT] - c[_HEAT][0]}, "pieces continue"),
}
#: Mistake that needs several quantities -> what it changes in a scene, and the check that must fail.
_OF_PAIRS: dict[str, tuple[Callable[[Mechanism], dict[str, Any]], str]] = {
    "tip inertia about the flexible end": (lambda m: _about_the_end(m, -1.0), "quantity tip.center_of_mass"),
    "tip inertia shifted twice": (lambda m: _about_the_end(m, 1.0), "quantity tip.center_of_mass"),
    "slider without weight": (_weightless_slider, _ON_THE_SLIDER),
    "gravity turns with the start": (_turned_with_the_crank, "quantity mechanism.gravity with the crank elsewhere"),
    "offset without gravity": (lambda m: {"tip.center_of_mass": 0.0} if m.tip_body.center_of_mass and m.has_gravity else {}, _EVERYTHING),
    "damping without offset": (
        lambda m: {"follower.damping": 0.0} if m.tip_body.center_of_mass and m.follower.damping else {},
        _EVERYTHING,
    ),
    "rollers exchanged, plus": (lambda m: _rollers(m, lambda plus, minus: (minus, plus)), "quantity slider.joint_stiffness_plus"),
    "rollers exchanged, minus": (lambda m: _rollers(m, lambda plus, minus: (minus, plus)), "quantity slider.joint_stiffness_minus"),
    "softer roller on either side": (lambda m: _rollers(m, lambda *two: (min(two), min(two))), "quantity slider.joint_stiffness_minus"),
    "friction without sign": (_driving_friction, "quantity slider.friction, the slider moving outwards"),
    "remembers": (lambda m: {"tip.mass": m.tip.mass * (1.0 + 1e-5 * next(_count))} if m.tip else {}, "the same the second time"),
}
#: Mistake of an arm that turns fully -> the columns that are wrong then. "folds the angle": an inverse tangent of one argument, made
#: continuous, is right beyond P and half a turn off.
_OF_TURNING: dict[str, Callable[[Columns], Columns]] = {
    "wraps the angle": lambda c: {"follower_angle": wrapped(c["follower_angle"])},
    "begins a turn late": lambda c: {"follower_angle": c["follower_angle"] - 2.0 * np.pi},
    "folds the angle": lambda c: {"follower_angle": c["follower_angle"] - np.pi, "slider_position": -c["slider_position"]},
    "slides behind": lambda c: {"slider_position": -c["slider_position"]},
    "turns the deflection": lambda c: {"tip_deflection": c["tip_deflection"] * np.sign(np.cos(c["follower_angle"]))},
}
_RIGID, _FINER = of_scene({"slider.joint_stiffness": math.inf, "slider.joint_damping": 0.0}), "ladder: gets finer"
#: A crank that can only be turned forwards.
_FORWARDS = having(
    scene=lambda m: m if m.crank_is_free else changed(m, {"crank.prescribed_speed": abs(m.crank.drive.speed)}),
    start=lambda start: dataclasses.replace(start, crank_speed=abs(start.crank_speed)),
)
#: Its one shape is what it errs by, its estimate is of the integration, and it has no finer rung to show that.
_INTEGRATION_ALONE = having(
    default_accuracy=3e-2,
    settings_for=lambda *_: ReferenceSettings(modes=1, tolerance=1e-7),
    comparisons=lambda _, settings, *given: (Comparison(settings, settings.replaced(tolerance=10.0 * settings.tolerance), 10.0),),
    finer=lambda *_: None,
)
#: Mistake -> the engine, and the check that must fail.
PLANTED: dict[str, tuple[Callable[[], AnyEngine], str]] = {
    **{name: (column(of, change), f"column {of}") for name, (of, change) in _OF_COLUMN.items()},
    **{name: (having(columns=change), check) for name, (change, check) in _OF_COLUMNS.items()},
    **{name: (of_scene({key: value}), check or f"quantity {key}") for name, (key, value, check) in _OF_QUANTITY.items()},
    **{name: (of_pair(changes), check) for name, (changes, check) in _OF_PAIRS.items()},
    **{name: (of_frequencies(wrong), "frequencies") for name, wrong in _OF_FREQUENCIES.items()},
    **{name: (having(columns=lambda c, m, wrong=wrong: wrong(c) if m.turns_fully else c), _TURNING) for name, wrong in _OF_TURNING.items()},
    "the base's acceleration reversed": (column("follower_acceleration", np.negative), _RATE),
    "the base's acceleration late": (column("follower_acceleration", late), _RATE),
    "estimate too small, no finer rung": (_INTEGRATION_ALONE, _TOGETHER),
    "time in ms": (column("time", lambda y: 1e3 * y), "a trajectory"),
    "rows of the last own step": (having(prepare=lambda _, *given: OwnStep(SOUND.prepare(*given))), "the same with 1.3 ms between rows"),
    "start not bending": (having(start=lambda start: dataclasses.replace(start, deflection_rate=None)), "a bent, moving start"),
    "start straight": (having(start=lambda start: Start(start.crank_angle, start.crank_speed)), "a bent, moving start"),
    "joint stiffness ignored": (_RIGID, "quantity slider.joint_stiffness"),
    "tool always cuts": (of_scene({"tip.force_from": 0.0, "tip.force_to": 2.0 * math.pi}), "quantity tip.force_from"),
    "turns forwards alone": (_FORWARDS, "quantity crank.prescribed_speed, reversed"),
    "weight of the slider not in the drive": (weight(lambda m: m.slider.mass * m.crank.length), _ON_THE_SLIDER),
    "weight of the crank turned round": (weight(lambda m: 2.0 * m.crank_moment), "quantity mechanism.gravity at a prescribed speed"),
    "gravity energy sign": (column("gravity_energy", np.negative), "quantity mechanism.gravity along n1"),
    "raises in check": (having(check=_raising_check), "quantity slider.inertia"),
    "keeps the whole scene": (having(scene=lambda m: _kept.setdefault("first", m)), "quantity follower.length"),
    "finer goes backwards": (having(finer=lambda _, s, *given: s.replaced(modes=s.modes - 1) if s.modes > 1 else None), _FINER),
    "finer stands still": (having(finer=lambda _, settings, *given: settings), "ladder: ends"),
    "settings_for backwards": (having(settings_for=lambda _, error, m: SOUND.settings_for(1e-3 if error > 0.01 else 0.05, m)), _FINER),
    "overclaimed factor": (of_factor(lambda factor: 10.0), "estimates hold, coarse settings"),
    "factor upside down": (of_factor(lambda factor: 1.0 / factor), "estimates hold, coarse settings"),
    "goes on in silence": (having(prepare=lambda _, *given: Swallowing(SOUND.prepare(*given))), "failures: the slider leaves the follower"),
    "raises ValueError": (having(prepare=_raising), "failures: a start that cannot be"),
    "alone: stiffness": (of_scene({"follower.bending_stiffness": 21.0}, alone=True), "the follower alone"),
    "alone: strain sign": (having(columns=lambda c, _: {"strain_1": -c["strain_1"]}, alone=True), "the follower alone"),
    "alone: no gravity": (of_scene({"mechanism.gravity": (0.0, 0.0)}, alone=True), "the follower alone: mechanism.gravity along n1"),
    "alone: damping ignored": (of_scene({"follower.damping": 0.0}, alone=True), "the follower alone: follower.damping"),
}
