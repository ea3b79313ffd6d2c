"""Rival methods for the constraint and the moving load, on the same beam; used only where they are asked for."""

from typing import Final

RIVALS: Final = ("fixed-shapes", "multiplier", "stiff-spring", "nodal-load", "moving-boundaries")
