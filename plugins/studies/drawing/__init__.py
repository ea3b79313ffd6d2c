"""Pictures of studies; their axes have keys and measures in words."""

from typing import Final

from quickreturn.cases.motion.measure import Measure
from quickreturn.plugins.studies.resonance_curve.curve import SPEED

#: Largest number of letters of an axis' label: two lines.
LABEL: Final = 72


def key_words(key: str) -> str:
    """A key of a case file as the label of an axis: "tip mass"."""
    return "crank speed" if key == SPEED else key.removeprefix("mechanism.").replace(".", " ").replace("_", " ")


def measure_words(measure: Measure) -> str:
    """A measure as the label of an axis: "largest magnitude of tip acceleration"; its name where that takes more than `LABEL` letters."""
    words = measure.meaning.replace("_", " ").removesuffix(" in a turn").rstrip(",")
    return words if len(words) <= LABEL else measure.name.replace("_", " ").replace(".", " ")
