"""Case files: from the text that a person wrote to a `Case` in SI units, or to one sentence about what is wrong with it."""

import math
import os
from collections.abc import Mapping
from dataclasses import replace
from typing import Any, Final

from cases.case import Case
from cases.document import Document, check_complete, header_of, missing, overridden, read_document
from cases.errors import CaseError, as_written, nearest, path_shown
from cases.keys import PRESCRIBED, SECTIONS, SPIN_UP, TORQUE_DRIVEN, Key, key_of
from cases.library import case_names, case_notes, case_text, impossible_names
from cases.text_file import read_text
from cases.units import ANGULAR_SPEED, QuantityError, parse_quantity
from reference_model.mechanism import (
    Base,
    Crank,
    Follower,
    FollowerAlone,
    ImpossibleMechanism,
    Mechanism,
    PrescribedSpeed,
    Scene,
    Slider,
    SpinUp,
    Tip,
    TorqueDrive,
)

_MOST_STEPS: Final = 2_000_000  # a table of a gigabyte
_LARGEST_ANGLE: Final = math.radians(1e6)  # there a double is still exact to 4e-12 rad; far beyond, a crank would turn in jumps
_ROUNDING: Final = 1e-9  # relative; a quotient of two doubles that were read from decimal texts


def load_case(name_or_path: str, overrides: Mapping[str, str] | None = None) -> Case:
    """The case of a library name or of a file.

    A name of the library wins over a file of the same name; write `./name` to mean the file.

    Args:
        name_or_path: e.g. "thesis-24" or "my/scene.toml".
        overrides: dotted key -> text as in the file, e.g. {"crank.length": "5 in"}; see `cases.document.overridden`.

    Raises:
        CaseError: no such case, an unreadable file, or a mistake in the file or the overrides.
    """
    if name_or_path in case_names() or name_or_path in impossible_names():
        case = parse_case(case_text(name_or_path), name_or_path, overrides)
        return replace(case, notes=case_notes(name_or_path), source="library")
    if not (os.sep in name_or_path or name_or_path.endswith(".toml") or os.path.lexists(name_or_path)):
        shown = as_written(name_or_path)
        near = nearest(name_or_path, case_names())
        accepted = f"the nearest one is {near} (`quickreturn cases` lists all); or give a path"
        raise CaseError(shown, None, None, "no case of the library has this name", accepted)
    return parse_case(read_text(name_or_path), path_shown(name_or_path), overrides)


def parse_case(text: str, source: str, overrides: Mapping[str, str] | None = None) -> Case:
    """The case that a TOML text describes.

    Args:
        text: of the file.
        source: what messages call it.
        overrides: see `load_case`.

    Raises:
        CaseError: any mistake in text or overrides.
    """
    document = overridden(read_document(text, source), overrides or {})
    name, title, tags = header_of(document)
    check_complete(document)
    scene = _scene(document)
    duration, output_step = _quantity(document, "simulation.duration"), _quantity(document, "simulation.output_step")
    if problem := _misfit(duration, output_step):
        path = document.blame("simulation.duration", "simulation.output_step")
        raise document.error(path, *problem)
    return Case(name=name, title=title, tags=tags, scene=scene, duration=duration, output_step=output_step, source=source)


def with_times(case: Case, duration: float | None = None, output_step: float | None = None) -> Case:
    """The case with other simulation times in s, as `--duration` and `--output-step` give them.

    Raises:
        CaseError: not positive, or the duration no whole multiple of the output step.
    """
    for option, value in (("--duration", duration), ("--output-step", output_step)):
        if value is not None and not 0.0 < value < float("inf"):
            raise CaseError("command line", option, f"{value:.6g}", "is no positive time in seconds", "such as 2 or 0.001")
    new = replace(case, duration=duration or case.duration, output_step=output_step or case.output_step)
    if problem := _misfit(new.duration, new.output_step):
        option, value = ("--duration", duration) if duration else ("--output-step", new.output_step)
        raise CaseError("command line", option, f"{value:.9g}", *problem)
    return new


def _scene(document: Document) -> Scene:
    sections = {name: _section(document, name) for name in SECTIONS if name in document.sections and name != "simulation"}
    if "crank" not in sections:
        return _follower_alone(document, sections)
    crank = sections["crank"]
    for path in (PRESCRIBED, *TORQUE_DRIVEN):
        crank.pop(path.removeprefix("crank."), None)
    if abs(crank["initial_angle"]) > _LARGEST_ANGLE:
        raise document.error("crank.initial_angle", "is beyond a million degrees", "angles from -1e6 deg to 1e6 deg are accepted")
    _check_gauges(document, sections["follower"])
    _check_joint(document, sections.get("slider", {}))
    drive = _drive(document)
    parts: dict[str, Any] = {
        "crank": Crank(drive=drive, **crank),
        "base": Base(**sections["base"]),
        "follower": Follower(**sections["follower"]),
        "tip": Tip(**sections["tip"]) if "tip" in sections else None,
        "slider": Slider(**sections.get("slider", {})),
    }
    _check_inertia(document, drive, parts["crank"], parts["slider"])
    try:
        return Mechanism(**sections["mechanism"], **parts)
    except ImpossibleMechanism as impossible:
        path = document.blame(impossible.key, "mechanism.pivot_distance", "crank.length", "follower.length")
        raise document.error(path, f"cannot be: {impossible.message}") from None


def _follower_alone(document: Document, sections: dict[str, dict[str, Any]]) -> FollowerAlone:
    base = sections["base"]
    _check_gauges(document, sections["follower"])
    try:
        return FollowerAlone(
            spin_up=SpinUp(speed=base.pop("spin_up_speed"), time=base.pop("spin_up_time")),
            base=Base(**base),
            follower=Follower(**sections["follower"]),
            tip=Tip(**sections["tip"]) if "tip" in sections else None,
            **sections.get("mechanism", {}),
        )
    except ImpossibleMechanism as impossible:
        raise document.error(document.blame(impossible.key, *SPIN_UP), f"cannot be: {impossible.message}") from None


def _section(document: Document, section: str) -> dict[str, Any]:
    """SI values of a section's keys that are written there."""
    paths = {name: f"{section}.{name}" for name in SECTIONS[section]}
    return {name: _quantity(document, path) for name, path in paths.items() if path in document.values}


def _quantity(document: Document, path: str) -> Any:
    """SI value, or tuple of SI values, of a key that is there."""
    key, written = key_of(path), document.values[path]
    if key.count is None:
        return _one_quantity(document, path, key, written)
    return tuple(_one_quantity(document, path, key, text) for text in written)


def _one_quantity(document: Document, path: str, key: Key, text: str) -> float:
    try:
        value = parse_quantity(text, key.dimension, infinity_accepted=key.infinity_accepted)
    except QuantityError as wrong:
        raise document.error(path, wrong.problem, wrong.accepted, value=text) from None
    if key.sign == "positive" and value <= 0.0:
        raise document.error(path, "is not positive", f"{key.dimension.name} greater than zero is accepted", value=text)
    if key.sign == "not negative" and value < 0.0:
        raise document.error(path, "is negative", f"{key.dimension.name} of zero or more is accepted", value=text)
    return value


def _drive(document: Document) -> TorqueDrive | PrescribedSpeed:
    """The crank's drive: a prescribed speed, or torque against damping from an initial speed."""
    choice = "give either prescribed_speed alone, or torque and damping (and, if the start is not torque / damping, initial_speed)"
    given = [path for path in TORQUE_DRIVEN if path in document.values]
    if PRESCRIBED in document.values:
        if given:
            other = f"{given[0]} = {as_written(document.values[given[0]])}"
            raise document.error(PRESCRIBED, f"conflicts with {other}", choice)
        return PrescribedSpeed(speed=_quantity(document, PRESCRIBED))
    if not given:
        raise CaseError(document.source, "crank", None, "nothing drives the crank", choice)
    for path in TORQUE_DRIVEN[:2]:
        if path not in document.values:
            raise missing(document, path)
    torque, damping = _quantity(document, "crank.torque"), _quantity(document, "crank.damping")
    if "crank.initial_speed" in document.values:
        initial_speed = _quantity(document, "crank.initial_speed")
    elif damping > 0.0:
        initial_speed = torque / damping
    else:
        problem = "this key is missing, and without damping there is no speed torque / damping"
        raise document.error("crank.initial_speed", problem, f"write {ANGULAR_SPEED.name}, such as {ANGULAR_SPEED.example}")
    return TorqueDrive(torque=torque, damping=damping, initial_speed=initial_speed)


def _check_gauges(document: Document, follower: dict[str, Any]) -> None:
    for place, text in zip(follower["strain_gauges"], document.values["follower.strain_gauges"], strict=True):
        if place > follower["length"]:
            path = document.blame("follower.strain_gauges", "follower.length")
            length = as_written(document.values["follower.length"])
            raise document.error(path, f"leaves the strain gauge at {text} outside the follower", f"its length is {length}")


def _check_joint(document: Document, slider: dict[str, Any]) -> None:
    if slider.get("joint_damping", 0.0) > 0.0 and slider.get("joint_stiffness", float("inf")) == float("inf"):
        path = document.blame("slider.joint_damping", "slider.joint_stiffness")
        raise document.error(
            path,
            "makes a rigid joint with damping, which has nothing to act on",
            'give a finite slider.joint_stiffness such as "2e4 N/m", or no slider.joint_damping',
        )


def _check_inertia(document: Document, drive: TorqueDrive | PrescribedSpeed, crank: Any, slider: Any) -> None:
    """A crank that a torque drives needs inertia of its own: the follower lends it none where both are at right angles."""
    if isinstance(drive, TorqueDrive) and crank.inertia_about_pivot + slider.mass * crank.length**2 == 0.0:
        path = document.blame("crank.inertia", "crank.mass", "crank.center_of_mass")
        raise document.error(
            path, "leaves a torque-driven crank without inertia about its axis", "give crank.inertia, or crank.mass and center_of_mass"
        )


def _misfit(duration: float, output_step: float) -> tuple[str, str] | None:
    """What is wrong with this pair of times and what is accepted, or None."""
    steps = duration / output_step
    times = f"duration {duration:.9g} s, output step {output_step:.9g} s"
    if steps > _MOST_STEPS:
        return f"gives {steps:.3g} output steps ({times})", f"at most {_MOST_STEPS // 1_000_000} million are accepted"
    if round(steps) < 1 or abs(steps - round(steps)) > _ROUNDING * steps:
        return f"gives {steps:.6g} output steps ({times})", "the duration must be a whole multiple of the output step"
    return None
