"""The installation of MuJoCo: which distribution, and whether it can be used."""

from importlib.util import find_spec
from typing import Final

from quickreturn.engines.base import installed

_DISTRIBUTIONS: Final = ("mujoco-core", "mujoco")  # either provides the package `mujoco`
_OLDEST: Final = (4, 0, 1)


def version() -> str:
    """Name and version."""
    return f"mujoco {installed(*_DISTRIBUTIONS) or 'not installed'}"


def unavailable() -> str | None:
    """Why it cannot be used (a sentence), or None."""
    present = installed(*_DISTRIBUTIONS)
    if present is None or find_spec("mujoco") is None:
        return "the package mujoco is not installed (distribution mujoco-core)"
    if tuple(int(part) for part in present.split(".")[:3] if part.isdigit()) < _OLDEST:
        return f"mujoco {present} is installed, {'.'.join(map(str, _OLDEST))} or later is needed"
    return None
