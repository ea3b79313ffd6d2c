"""A case's scene in SI, laid out as in a case file."""

from typing import Any

from cases.case import Case
from cases.keys import SECTIONS
from reference_model.mechanism import FollowerAlone, PrescribedSpeed


def scene_in_si(case: Case) -> dict[str, dict[str, Any]]:
    """Values by section and key of the case file, in the units of `units()`; parts and keys that the scene lacks are left out."""
    scene = case.scene
    parts: dict[str, Any] = {name: getattr(scene, name, None) for name in ("crank", "base", "follower", "tip", "slider")}
    values: dict[str, dict[str, Any]] = {
        "mechanism": {"gravity": scene.gravity},
        **{name: _values(part, name) for name, part in parts.items() if part is not None},
        "simulation": {"duration": case.duration, "output_step": case.output_step},
    }
    if isinstance(scene, FollowerAlone):
        values["base"] |= {"spin_up_speed": scene.spin_up.speed, "spin_up_time": scene.spin_up.time}
    else:
        drive = scene.crank.drive
        values["mechanism"] = {"pivot_distance": scene.pivot_distance, **values["mechanism"]}
        values["crank"] |= {"prescribed_speed": drive.speed} if isinstance(drive, PrescribedSpeed) else vars(drive)
    return values


def units() -> dict[str, dict[str, str]]:
    """SI unit of each key, by section."""
    return {section: {name: key.dimension.si_unit for name, key in keys.items()} for section, keys in SECTIONS.items()}


def _values(part: Any, section: str) -> dict[str, Any]:
    return {name: getattr(part, name) for name in SECTIONS[section] if hasattr(part, name)}
