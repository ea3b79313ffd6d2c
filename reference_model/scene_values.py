"""Converts between a scene and its values by section and key, as in a case file, from the declarations in `mechanism`."""

import math
from collections.abc import Container, Iterator, Mapping, Sequence
from dataclasses import replace
from types import MappingProxyType
from typing import Any, Final, TypeVar, cast, get_args

from quickreturn.reference_model.errors import ImpossibleMechanism
from quickreturn.reference_model.follower import DIMENSIONS, Follower, Material, section_of
from quickreturn.reference_model.mechanism import (
    Base,
    Crank,
    Drive,
    FollowerAlone,
    Mechanism,
    MotorCurve,
    PrescribedMotion,
    PrescribedSpeed,
    Scene,
    SpinUp,
    TorqueDrive,
)
from quickreturn.reference_model.quantities import Quantity, quantities_of
from quickreturn.reference_model.slider import Slider
from quickreturn.reference_model.spring import Spring
from quickreturn.reference_model.table import Table
from quickreturn.reference_model.tip import Tip

Value = float | tuple[float, ...] | Table
#: Section -> key -> SI value.
Values = Mapping[str, Mapping[str, Value]]
#: Dotted key, `section.key` -> SI value; None leaves out the key, or the section that is named alone.
Changes = Mapping[str, Value | None]
#: Section -> keys that are given.
Keys = Mapping[str, Container[str]]

T = TypeVar("T")
AnyScene = TypeVar("AnyScene", bound=Scene)

#: Section -> dataclasses whose quantities it holds. A scene has only one of [crank]'s drives.
_PARTS: Final[Mapping[str, tuple[type, ...]]] = MappingProxyType(
    {
        "mechanism": (Mechanism,),
        "crank": (Crank, *get_args(Drive)),
        "base": (Base, SpinUp),
        "follower": (Follower, Material),
        "tip": (Tip,),
        "slider": (Slider,),
        "spring": (Spring,),
    }
)


#: Section -> the part of the machine that it describes, in a line; [mechanism] has none.
DESCRIPTIONS: Final[Mapping[str, str]] = MappingProxyType(
    {name: (parts[0].__doc__ or "").partition("\n")[0] for name, parts in _PARTS.items() if name != "mechanism"}
)
#: Section -> key -> what it measures.
SECTIONS: Final[Mapping[str, Mapping[str, Quantity]]] = MappingProxyType(
    {name: MappingProxyType({key: of_key for part in parts for _, key, of_key in quantities_of(part)}) for name, parts in _PARTS.items()}
)
#: `section.key` -> what it measures, for quantities that a model may lack. An engine names those that it has and refuses the rest.
NAMED: Final[Mapping[str, Quantity]] = MappingProxyType(
    {f"{name}.{key}": quantity for name, keys in SECTIONS.items() for key, quantity in keys.items() if quantity.named}
)
#: Sections that a scene with a crank may lack.
OPTIONAL_SECTIONS: Final = ("tip", "slider", "spring")
#: Keys of a crank that a torque drives.
OF_TORQUE: Final = ("crank.torque", "crank.damping", "crank.initial_speed")
#: Keys that exclude each other: the first of each pair, and the others. A case file needs one of the two sides.
ALTERNATIVES: Final = (
    ("crank.prescribed_speed", OF_TORQUE),
    ("crank.torque_table", ("crank.torque", "crank.damping", "crank.prescribed_speed")),
    ("crank.speed_table", ("crank.prescribed_speed", "crank.torque_table", *OF_TORQUE)),
    ("follower.elastic_modulus", ("follower.bending_stiffness",)),
    ("follower.density", ("follower.mass_per_length",)),
    ("follower.diameter", ("follower.thickness", "follower.width", "follower.flange", "follower.web")),
    ("follower.wall", ("follower.flange", "follower.web")),
)
#: Keys any of which drives the crank.
DRIVES: Final = ("crank.prescribed_speed", "crank.speed_table", "crank.torque_table", *OF_TORQUE)
#: Ways to give the force of a tool: each takes the place of the others, and a table also that of the window in which a constant one acts.
FORCES: Final = ("tip.force", "tip.force_following", "tip.force_table")
WINDOW: Final = ("tip.force_from", "tip.force_to", "tip.force_ramp")
#: Keys that turn the base of a follower alone; a scene with a crank must not have them.
SPIN_UP: Final = ("base.spin_up_speed", "base.spin_up_time")
CRANK_OR_NOT: Final = f"give either [crank], or {' and '.join(SPIN_UP)} for the follower alone"
DRIVE_CHOICE: Final = (
    "give either prescribed_speed or speed_table alone, or torque and damping, or torque_table"
    " (and, if the start is not at the speed at which these leave no torque, initial_speed)"
)


class MissingQuantity(ImpossibleMechanism):
    """Quantities, or sections `[name]`, that a case file lacks; `keys` holds all of them, in the order of a case file."""

    def __init__(self, keys: Sequence[str]) -> None:
        super().__init__(keys[0], "is missing", CRANK_OR_NOT if "[crank]" in keys else "")
        self.keys = keys


def scene_of(values: Values) -> Scene:
    """The scene that these values describe.

    Args:
        values: the sections that are given, each with its keys.

    Raises:
        ImpossibleMechanism: values are impossible or conflict, or (`MissingQuantity`) some are missing.
    """
    if misfit := next(misfits_of_keys(values), None):
        raise misfit
    alone = _is_alone(values)
    given: dict[str, dict[str, Any]] = {name: dict(values.get(name, {})) for name in SECTIONS}
    base = given["base"]
    spin_up = SpinUp(speed=base.pop("spin_up_speed"), time=base.pop("spin_up_time")) if alone else None
    parts: dict[str, Any] = {
        "base": Base(**base),
        "follower": _follower(given["follower"]),
        "tip": Tip(**given["tip"]) if "tip" in values else None,
        "spring": Spring(**given["spring"]) if "spring" in values else None,
        **given["mechanism"],
    }
    if spin_up:
        return FollowerAlone(spin_up=spin_up, **parts)
    scene = Mechanism(crank=_crank(given["crank"]), slider=Slider(**given["slider"]), **parts)
    if scene.crank_is_free and scene.crank_inertia == 0.0:
        raise ImpossibleMechanism(
            "crank.inertia",
            "leaves a torque-driven crank without inertia about its axis",
            "give crank.inertia, or crank.mass and center_of_mass",
            ("crank.mass", "crank.center_of_mass"),
        )
    return scene


def values_of(scene: Scene) -> dict[str, dict[str, Value]]:
    """The values of a scene by section and key; sections and keys that it lacks are left out."""
    parts: dict[str, list[Any]] = {
        "mechanism": [scene],
        **{name: [part] for name in ("crank", "base", "follower", "tip", "slider", "spring") if (part := getattr(scene, name)) is not None},
    }
    if scene.crank is None:
        del parts["slider"]
        parts["base"].append(scene.spin_up)
    else:
        parts["crank"].append(scene.crank.drive)
    return {
        name: {key: value for part in members for field, key, _ in quantities_of(part) if (value := getattr(part, field)) is not None}
        for name, members in parts.items()
    }


def what_moves_nothing(scene: Scene) -> dict[str, Value]:
    """The values on which the motion does not depend, such as strengths, by dotted key: keys of stored motions do not contain them."""
    values = values_of(scene)
    return {f"{name}.{key}": value for name, keys in values.items() for key, value in keys.items() if not SECTIONS[name][key].moves}


def replaced_by(paths: Container[str]) -> list[str]:
    """Keys (`section.key`) that must be dropped from a scene when the keys in `paths` are set, because they exclude each other."""
    dropped = list[str]()
    for first, others in ALTERNATIVES:
        dropped += others if first in paths else [first] if any(path in paths for path in others) else []
    for force in FORCES:
        if force in paths:
            dropped += [other for other in (*FORCES, *(WINDOW if force == FORCES[-1] else ())) if other != force]
    return dropped


def value_at(scene: Scene, path: str) -> Any:
    """The value of a scene at a dotted key; None if the scene lacks it."""
    section, _, key = path.partition(".")
    return values_of(scene).get(section, {}).get(key)


def changed(scene: AnyScene, changes: Changes) -> AnyScene:
    """A scene with changes, see `changed_values`.

    A scene holds the stiffness and the mass of its follower, whatever gave them: another thickness leaves them. A case knows its material.

    Raises:
        ImpossibleMechanism: as `scene_of`.
    """
    return cast(AnyScene, scene_of(changed_values(values_of(scene), changes)))


def changed_values(values: Mapping[str, Mapping[str, T]], changes: Mapping[str, T | None]) -> dict[str, dict[str, T]]:
    """Values by section and key with changes by dotted key, one after the other; None leaves out a key, or the section that is named alone.

    A key that is set removes those that it replaces, such as the other way of driving the crank; if those are set as well, the conflict
    remains.
    """
    new = {section: dict(keys) for section, keys in values.items()}
    gone = replaced_by([path for path, value in changes.items() if value is not None])
    for path, value in {**dict.fromkeys(gone), **changes}.items():
        section, _, key = path.partition(".")
        if value is not None:
            new.setdefault(section, {})[key] = value
        elif key:
            new.get(section, {}).pop(key, None)
        else:
            new.pop(section, None)
    return new


def misfits_of_keys(given: Keys) -> Iterator[ImpossibleMechanism]:
    """Errors of the given keys, whatever their values: an error for each conflict, then one `MissingQuantity` for all that are missing."""
    if (spun_up := [path for path in SPIN_UP if _has(given, path)]) and "crank" in given:
        yield ImpossibleMechanism(spun_up[0], "conflicts with [crank], which turns the follower", CRANK_OR_NOT)
        return  # the missing keys depend on which of the two the user keeps
    if spun_up:
        for key, there in (("[slider]", "slider" in given), ("mechanism.pivot_distance", _has(given, "mechanism.pivot_distance"))):
            if there:
                yield ImpossibleMechanism(key, "conflicts with the missing [crank]", "leave it out, or give [crank]")
    for first, others in ALTERNATIVES:
        if _has(given, first) and (conflicting := [other for other in others if _has(given, other)]):
            accepted = DRIVE_CHOICE if first.startswith("crank.") else "give one of them"
            yield ImpossibleMechanism(first, f"conflicts with {conflicting[0]}", accepted)
    if "crank" in given and not any(_has(given, path) for path in DRIVES):
        yield ImpossibleMechanism("crank", "nothing drives the crank", DRIVE_CHOICE)
    elif missing := tuple(_missing(given, _is_alone(given))):
        yield MissingQuantity(missing)


def _is_alone(given: Keys) -> bool:
    """Whether the scene is a follower alone: no crank, and a base that is spun up."""
    return "crank" not in given and any(_has(given, path) for path in SPIN_UP)


def _missing(given: Keys, alone: bool) -> Iterator[str]:
    """Keys, and sections as `[name]`, that are missing."""
    needless = {"mechanism.pivot_distance"} if alone else {*SPIN_UP}
    for first, others in ALTERNATIVES:
        needless |= {first, *others} if _has(given, first) else {first}
    for section, keys in SECTIONS.items():
        if section in given:
            absent = {f"{section}.{name}": quantity for name, quantity in keys.items() if name not in given[section]}
            yield from (path for path, quantity in absent.items() if not quantity.optional and path not in needless)
        elif section not in OPTIONAL_SECTIONS and not (alone and section in ("mechanism", "crank")):
            yield f"[{section}]"


def _has(given: Keys, path: str) -> bool:
    section, _, key = path.partition(".")
    return key in given.get(section, ())


def _follower(given: dict[str, Any]) -> Follower:
    """The follower, with stiffness and mass per length from its material where that is given."""
    section = section_of(**{name: given.get(name) for name in DIMENSIONS})
    if "elastic_modulus" in given:
        given["bending_stiffness"] = section.second_moment(given.pop("elastic_modulus"))
    if "density" in given:
        given["mass_per_length"] = section.area(given.pop("density"))
    return Follower(**given)


def _crank(given: dict[str, Any]) -> Crank:
    """The crank with its drive. Raises ImpossibleMechanism: nothing gives an initial speed."""
    if "prescribed_speed" in given:
        return Crank(drive=PrescribedSpeed(speed=given.pop("prescribed_speed")), **given)
    if "speed_table" in given:
        begins_at = given.get("initial_angle", math.pi)
        return Crank(drive=PrescribedMotion(speed_table=given.pop("speed_table"), begins_at=begins_at), **given)
    speed: float | None = given.pop("initial_speed", None)
    of_drive = {key: given.pop(key) for key in ("torque", "damping", "torque_table") if key in given}
    drive: Any = (MotorCurve if "torque_table" in of_drive else TorqueDrive)(**of_drive, initial_speed=speed or 0.0)
    if speed is None and math.isinf(drive.balanced_speed):
        problem = "is missing, and no speed torque / damping, or in torque_table, leaves no torque"
        raise ImpossibleMechanism("crank.initial_speed", problem, 'give one, such as "16 rad/s"')
    return Crank(drive=drive if speed is not None else replace(drive, initial_speed=drive.balanced_speed), **given)
