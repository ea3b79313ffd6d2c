"""Hard scenes, each the case `ORIGINAL` with a few changed values: engines fail in them, or are wrong without a warning.

Violent motion (soft follower, fast crank), stiff equations (hard follower, light follower), the ends of the follower, light and
heavy tips, long undamped motion, and optional features of a scene. A scene in `IMPOSSIBLE` must be refused with the sentence given there.
"""

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from types import MappingProxyType
from typing import Any, Final

from quickreturn.cases.files.case import case_of
from quickreturn.cases.files.document import Document
from quickreturn.reference_model.mechanism import Scene
from quickreturn.reference_model.scene_values import AnyScene, changed, changed_values, value_at


@dataclass(frozen=True)
class Variation:
    """Quantities of a scene, by their keys in a case file, that get new values, all at once."""

    name: str  # the change in words
    given: Mapping[str, Any] = field(default_factory=dict)  # dotted key -> new value, as in `scene_values.Changes`
    scaled: Mapping[str, float] = field(default_factory=dict, kw_only=True)  # dotted key -> factor on the value that it has

    def changes(self, scene: Scene) -> dict[str, Any]:
        """All new values, for a scene."""
        return {path: factor * value_at(scene, path) for path, factor in self.scaled.items()} | dict(self.given)

    def of(self, scene: AnyScene) -> AnyScene:
        """A scene with the new values. ImpossibleMechanism: as `scene_values.changed`."""
        return changed(scene, self.changes(scene))


TAG: Final = "hard"
ORIGINAL: Final = "thesis-24"

#: Dotted key -> text as in a case file.
Values = Mapping[str, str | list[str] | None]


#: The tip body without its mass plates.
_NO_PLATES: Final[Values] = {"tip.mass": "4.1e-05 lbf*s^2/in", "tip.inertia": "2.8e-06 lbf*s^2*in"}
#: The crank starts at torque / damping.
_AT_EQUILIBRIUM: Final[Values] = {"crank.initial_speed": None}


def _speed(factor: int, title: str) -> Variation:
    """A crank speed times a factor: the same torque against a weaker damping."""
    return Variation(title, _AT_EQUILIBRIUM, scaled={"crank.damping": 1.0 / factor})


def _crank(length: str, title: str) -> Variation:
    return Variation(f"crank {length}, no plates: {title}", {"crank.length": length, **_NO_PLATES})


def _joint(stiffness: str) -> Variation:
    return Variation(f"slider joint of {stiffness} N/m", {"slider.joint_stiffness": f"{stiffness} N/m"})


#: Name -> what differs from run 24, by the keys and texts of a case file; None leaves a key or, by its name, a section out.
SCENES: Final = MappingProxyType(
    {
        "hard-ei-x0.1": Variation("bending stiffness x 0.1", scaled={"follower.bending_stiffness": 0.1}),
        "hard-ei-x10": Variation("bending stiffness x 10", scaled={"follower.bending_stiffness": 10.0}),
        "hard-ei-x1000": Variation("bending stiffness x 1000", scaled={"follower.bending_stiffness": 1000.0}),
        "hard-speed-x2": _speed(2, "crank speed x 2"),
        "hard-speed-x3": _speed(3, "crank speed x 3: the slider leaves the follower"),
        "hard-crank-6in": _crank("6 in", "slider up to 96 % of the length"),
        "hard-crank-6.9in": _crank("6.9 in", "slider up to 99.6 % of the length"),
        "hard-crank-6.95in": _crank("6.95 in", "the deflection pushes the slider off"),
        "hard-no-tip": Variation("no tip body", {"tip": None}),
        "hard-tip-x10": Variation("tip body x 10", scaled={"tip.mass": 10.0, "tip.inertia": 10.0}),
        "hard-mass-x0.1": Variation("follower's mass x 0.1", scaled={"follower.mass_per_length": 0.1}),
        "hard-undamped": Variation(
            "neither torque nor damping, 100 cycles",
            {"simulation.duration": "38 s"},  # 2 pi / 16.617773 rad/s = 0.3781 s a cycle
            scaled=dict.fromkeys(("crank.torque", "crank.damping", "base.damping", "follower.damping"), 0.0),
        ),
        "hard-gravity": Variation(
            "gravity along -n2, crank balanced about O with the same inertia",
            # 0.1 lbf s²/in x (3 in)² + 4.0e-4 lbf s² in: run 24's inertia about O
            {"mechanism.gravity": ["0 m/s^2", "-9.81 m/s^2"], "crank.center_of_mass": "0 in", "crank.inertia": "0.9004 lbf*s^2*in"},
        ),
        "hard-prescribed-speed": Variation("crank speed prescribed", {"crank.prescribed_speed": "16.617773 rad/s"}),
        "hard-start-at-0deg": Variation("start in the quick return", {"crank.initial_angle": "0 deg"}),
        "hard-reversed": Variation("reversed rotation", _AT_EQUILIBRIUM, scaled={"crank.torque": -1.0}),
        "hard-slider-mass": Variation("slider of 0.5 kg", {"slider.mass": "0.5 kg"}),
        "hard-slider-inertia": Variation("slider with inertia", {"slider.mass": "0.1 kg", "slider.inertia": "2e-5 kg*m^2"}),
        "hard-joint-1e3": _joint("1e3"),
        "hard-joint-1e5": _joint("1e5"),
        "hard-joint-1e7": _joint("1e7"),
        "hard-joint-1e9": _joint("1e9"),
        "hard-crank-7.5in": _crank("7.5 in", "longer than the follower reaches"),
    }
)

#: Scenes that must be refused before anything runs, with the whole sentence.
IMPOSSIBLE: Final = MappingProxyType(
    {
        "hard-crank-7.5in": 'hard-crank-7.5in: crank.length: "7.5 in" cannot be: the slider leaves the follower: pivot_distance +'
        " crank.length = 0.6477 m must not exceed follower.length = 0.635 m"
    }
)


def scene_title(name: str) -> str:
    """The difference of a hard scene from run 24, in one line."""
    return f"Run 24, {SCENES[name].name}"


def scene_document(name: str, original: Document) -> Document:
    """A hard scene as in a case file, with scaled values in SI. Raises KeyError for a name that is not in `SCENES`."""
    values = changed_values(original.values, SCENES[name].changes(case_of(original).scene))
    header = {"name": name, "title": scene_title(name), "tags": [TAG]}
    return replace(original, source=name, header=header, values=values)
