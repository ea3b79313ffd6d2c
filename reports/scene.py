"""A case's scene in SI, laid out as in a case file."""

from typing import Any

from cases.case import Case
from cases.keys import SECTIONS
from reference_model.mechanism import PrescribedSpeed


def scene_in_si(case: Case) -> dict[str, dict[str, Any]]:
    """Values by section and key of the case file, in the units of `units()`; parts and keys that the scene lacks are left out."""
    mechanism = case.mechanism
    drive = mechanism.crank.drive
    parts: dict[str, Any] = {name: getattr(mechanism, name) for name in ("crank", "base", "follower", "tip", "slider")}
    scene = {
        "mechanism": {"pivot_distance": mechanism.pivot_distance, "gravity": mechanism.gravity},
        **{name: _values(part, name) for name, part in parts.items() if part is not None},
        "simulation": {"duration": case.duration, "output_step": case.output_step},
    }
    scene["crank"] |= {"prescribed_speed": drive.speed} if isinstance(drive, PrescribedSpeed) else vars(drive)
    return scene


def units() -> dict[str, dict[str, str]]:
    """SI unit of each key, by section."""
    return {section: {name: key.dimension.si_unit for name, key in keys.items()} for section, keys in SECTIONS.items()}


def _values(part: Any, section: str) -> dict[str, Any]:
    return {name: getattr(part, name) for name in SECTIONS[section] if hasattr(part, name)}
