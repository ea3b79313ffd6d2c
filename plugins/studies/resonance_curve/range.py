"""The quantity that varies along a resonance curve, and its range."""

from dataclasses import dataclass
from typing import Final

from quickreturn.cases.files.errors import CaseError, as_written, nearest_or_all
from quickreturn.cases.files.keys import PATHS, si_value, unit_given
from quickreturn.plugins.studies.sweep.grid import OF_START

SPEED: Final = "crank.prescribed_speed"


@dataclass(frozen=True)
class Range:
    """A quantity of a scene and the values between which it varies."""

    key: str  # dotted key of a case file
    low: float  # SI
    high: float
    unit: str  # unit in which they were given
    size: float  # of that unit, SI


def range_of(key: str, text: str, option: str) -> Range:
    """The range that "a .. b" describes. CaseError: it is invalid."""
    if key not in PATHS or key.startswith("simulation."):
        raise CaseError(option, key, None, "is no quantity of a scene", nearest_or_all(key, tuple(PATHS)))
    about = PATHS[key]
    if not about.is_number or not about.moves or key in OF_START:
        raise CaseError(option, key, None, "changes no periodic motion continuously", "give a single number of the scene")
    ends = [part.strip() for part in text.split("..")]
    example = f'such as "{"60 rpm .. 300 rpm" if key == SPEED else f"1 {about.unit} .. 2 {about.unit}"}"'
    if len(ends) != 2 or not all(ends):
        raise CaseError(option, key, as_written(text), "is no range", f"write two values with .. between them, {example}")
    low, high = (si_value(key, end, option, finite=True) for end in ends)
    if not low < high or low * high < 0.0 or (key == SPEED and low * high == 0.0):
        raise CaseError(option, key, as_written(text), "is no range to follow", f"give a smaller and a larger value of one sign, {example}")
    return Range(key, low, high, *unit_given(key, ends))
