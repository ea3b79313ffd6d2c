"""A scene as numbers by section and key, as a case file has them, and back: everything follows from what `mechanism` declares."""

from collections.abc import Mapping
from types import MappingProxyType
from typing import Any, Final

from reference_model.mechanism import (
    Base,
    Crank,
    Follower,
    FollowerAlone,
    ImpossibleMechanism,
    Material,
    Mechanism,
    PrescribedSpeed,
    Scene,
    Slider,
    SpinUp,
    Tip,
    TorqueDrive,
)
from reference_model.quantities import Quantity, key_of, quantities_of

Value = float | tuple[float, ...]
#: Section -> key -> SI value.
Values = Mapping[str, Mapping[str, Value]]

#: Parts that a section is made of; of some only one is there.
_PARTS: Final[Mapping[str, tuple[type, ...]]] = MappingProxyType(
    {
        "mechanism": (Mechanism,),
        "crank": (Crank, TorqueDrive, PrescribedSpeed),
        "base": (Base, SpinUp),
        "follower": (Follower, Material),
        "tip": (Tip,),
        "slider": (Slider,),
    }
)


def _keys_of(parts: tuple[type, ...]) -> dict[str, Quantity]:
    return {key_of(declared, found): found for part in parts for declared, found in quantities_of(part)}


#: Section -> key -> what it measures.
SECTIONS: Final = MappingProxyType({name: MappingProxyType(_keys_of(parts)) for name, parts in _PARTS.items()})
#: Keys that replace each other: the first of a pair excludes the others, and one of them must be there.
ALTERNATIVES: Final = (
    ("crank.prescribed_speed", ("crank.torque", "crank.damping", "crank.initial_speed")),
    ("follower.elastic_modulus", ("follower.bending_stiffness",)),
    ("follower.density", ("follower.mass_per_length",)),
)
#: Keys that turn the base of a follower alone; a scene with a crank must not have them.
SPIN_UP: Final = ("base.spin_up_speed", "base.spin_up_time")
DRIVE_CHOICE: Final = "give either prescribed_speed alone, or torque and damping (and, if the start is not torque / damping, initial_speed)"


class MissingQuantity(ImpossibleMechanism):
    """A quantity, or a section `[name]`, that cannot be left out."""


def scene_of(values: Values) -> Scene:
    """The scene that these numbers describe.

    Args:
        values: sections that are there, each with the keys that are given.

    Raises:
        ImpossibleMechanism: what cannot be, does not fit together, or (`MissingQuantity`) is missing.
    """
    alone = _is_alone(values)
    _check_alternatives(values)
    _check_complete(values, alone)
    given = {name: dict(values.get(name, {})) for name in SECTIONS}
    base, tip = given["base"], Tip(**given["tip"]) if "tip" in values else None  # type: ignore[arg-type]
    of_base: dict[str, Any] = {name: base[name] for name in ("inertia", "damping")}
    parts: dict[str, Any] = {"base": Base(**of_base), "follower": _follower(given["follower"]), "tip": tip, **given["mechanism"]}
    if alone:
        return FollowerAlone(spin_up=SpinUp(speed=base["spin_up_speed"], time=base["spin_up_time"]), **parts)  # type: ignore[arg-type]
    slider: dict[str, Any] = given["slider"]
    scene = Mechanism(crank=_crank(given["crank"]), slider=Slider(**slider), **parts)
    _check_joint(scene.slider)
    if scene.crank_is_free and scene.crank_inertia == 0.0:
        raise ImpossibleMechanism(
            "crank.inertia",
            "leaves a torque-driven crank without inertia about its axis",
            "give crank.inertia, or crank.mass and center_of_mass",
            ("crank.mass", "crank.center_of_mass"),
        )
    return scene


def values_of(scene: Scene) -> dict[str, dict[str, Value]]:
    """The numbers of a scene by section and key; sections that it lacks are left out."""
    parts: dict[str, list[Any]] = {
        "mechanism": [scene],
        **{name: [part] for name in ("crank", "base", "follower", "tip", "slider") if (part := getattr(scene, name, None)) is not None},
    }
    if isinstance(scene, Mechanism):
        parts["crank"].append(scene.crank.drive)
    else:
        parts["base"].append(scene.spin_up)
    return {
        name: {key_of(declared, found): getattr(part, declared.name) for part in members for declared, found in quantities_of(part)}
        for name, members in parts.items()
    }


def _is_alone(values: Values) -> bool:
    """Whether the scene is a follower alone: no crank, and a base that is spun up."""
    given = [path for path in SPIN_UP if path.removeprefix("base.") in values.get("base", {})]
    choice = f"give either [crank], or {' and '.join(SPIN_UP)} for the follower alone"
    if "crank" in values:
        if given:
            raise ImpossibleMechanism(given[0], "conflicts with [crank], which turns the follower", choice)
        return False
    if not given:
        raise MissingQuantity("[crank]", "this section is missing", choice)
    if "slider" in values:
        raise ImpossibleMechanism("[slider]", "conflicts with the missing [crank], on whose tip it would sit", choice)
    if "pivot_distance" in values.get("mechanism", {}):
        problem = "conflicts with the missing [crank], from whose axis it is measured"
        raise ImpossibleMechanism("mechanism.pivot_distance", problem, "leave it out, or give [crank]")
    return True


def _check_alternatives(values: Values) -> None:
    for first, others in ALTERNATIVES:
        if _has(values, first) and (given := [other for other in others if _has(values, other)]):
            accepted = DRIVE_CHOICE if first.startswith("crank.") else "give one of them"
            raise ImpossibleMechanism(first, f"conflicts with {given[0]}", accepted)
    speed, of_torque = ALTERNATIVES[0]
    if "crank" in values and not any(_has(values, path) for path in (speed, *of_torque)):
        raise ImpossibleMechanism("crank", "nothing drives the crank", DRIVE_CHOICE)


def _check_complete(values: Values, alone: bool) -> None:
    for section, keys in SECTIONS.items():
        if section not in values:
            if section in ("tip", "slider") or (alone and section in ("mechanism", "crank")):
                continue
            raise MissingQuantity(f"[{section}]", "this section is missing", f"its keys are {', '.join(keys)}")
        for name, found in keys.items():
            path = f"{section}.{name}"
            if found.optional or name in values[section] or _is_replaced(values, path) or (path in SPIN_UP and not alone):
                continue
            if not (alone and path == "mechanism.pivot_distance"):
                raise MissingQuantity(path, "this key is missing")


def _is_replaced(values: Values, path: str) -> bool:
    """Whether another key stands in for this one; the first of a pair of alternatives is never asked for by itself."""
    return any(path == first or (path in others and _has(values, first)) for first, others in ALTERNATIVES)


def _has(values: Values, path: str) -> bool:
    section, _, key = path.partition(".")
    return key in values.get(section, {})


def _follower(given: dict[str, Any]) -> Follower:
    section = given["thickness"], given["width"]
    if "elastic_modulus" in given:
        given["bending_stiffness"] = Material.bending_stiffness(given.pop("elastic_modulus"), *section)
    if "density" in given:
        given["mass_per_length"] = Material.mass_per_length(given.pop("density"), *section)
    return Follower(**given)


def _crank(given: dict[str, Any]) -> Crank:
    if "prescribed_speed" in given:
        return Crank(drive=PrescribedSpeed(speed=given.pop("prescribed_speed")), **given)
    torque, damping, speed = given.pop("torque"), given.pop("damping"), given.pop("initial_speed", None)
    if speed is None and damping == 0.0:
        problem = "this key is missing, and without damping there is no speed torque / damping"
        raise MissingQuantity("crank.initial_speed", problem)
    speed = torque / damping if speed is None else speed
    return Crank(drive=TorqueDrive(torque=torque, damping=damping, initial_speed=speed), **given)


def _check_joint(slider: Slider) -> None:
    if slider.joint_damping > 0.0 and slider.joint_stiffness == float("inf"):
        raise ImpossibleMechanism(
            "slider.joint_damping",
            "makes a rigid joint with damping, which has nothing to act on",
            'give a finite slider.joint_stiffness such as "2e4 N/m", or no slider.joint_damping',
            ("slider.joint_stiffness",),
        )
