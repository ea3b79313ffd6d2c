"""Natural frequencies with the crank held, for the thesis' readings."""

import math
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from quickreturn.engines.registry import engine
from quickreturn.reference_model.mechanism import Mechanism
from quickreturn.reference_model.natural_modes import frozen_crank_modes

Array = NDArray[np.float64]

#: Crank angles at which modes are computed, rad: farthest to nearest; the way back mirrors them.
ANGLES: Final = np.linspace(math.pi, 0.0, 61)
MODES: Final = 3
#: The models with cubic elements are computed at each sixth of the angles.
EVERY: Final = 6

#: Signs of strains 1, 2, 3.
ALTERNATING_SIGNS: Final = (1, -1, 1)
SAME_SIGNS: Final = (1, 1, 1)
#: "Doubling or tripling": numbers of cubic elements.
ELEMENTS: Final = (1, 2, 3)


@dataclass(frozen=True)
class Span:
    """Smallest and largest value over the crank angle."""

    low: float
    high: float

    def holds(self, value: float) -> bool:
        """Whether a value lies within."""
        return self.low <= value <= self.high


@dataclass(frozen=True)
class ThesisModes:
    """Frequencies and signs of a run."""

    converged: tuple[Span, ...]  # ranges of the first three converged modes over the crank angle, Hz
    cubic: tuple[Span, ...]  # ranges of the modes of the thesis' single cubic, Hz
    # per converged mode the share of crank angles at which strains 1 and 3 have one sign and strain 2 the other
    alternating: tuple[float, ...]
    alike: tuple[float, ...]  # the same for all three of one sign
    # largest excess of the first frequency with one, two and three cubic elements over the converged one, relative
    elements: tuple[float, ...]


def thesis_modes(mechanism: Mechanism) -> ThesisModes:
    """The frequencies and signs of a mechanism."""
    modes = [frozen_crank_modes(mechanism, float(angle), MODES) for angle in ANGLES]
    signs = np.sign([each.curvature(np.array(mechanism.follower.strain_gauges)) for each in modes])  # (angles, modes, gauges)
    first = np.array([each.frequencies[0] for each in modes[::EVERY]])
    return ThesisModes(
        converged=_ranges(np.array([each.frequencies for each in modes])),
        cubic=_ranges(_cubic_frequencies(mechanism, 1, 2)),
        alternating=_share_with(signs, ALTERNATING_SIGNS),
        alike=_share_with(signs, SAME_SIGNS),
        elements=tuple(float(np.max(np.abs(_cubic_frequencies(mechanism, number, 1)[:, 0] / first - 1.0))) for number in ELEMENTS),
    )


def _ranges(frequencies: Array) -> tuple[Span, ...]:
    """Span of each mode over the crank angle from frequencies of shape (angles, modes), Hz."""
    return tuple(Span(float(column.min()), float(column.max())) for column in frequencies.T)


def _cubic_frequencies(mechanism: Mechanism, elements: int, count: int) -> Array:
    """Frequencies of the thesis' model with a number of cubic elements at some of `ANGLES`, Hz, shape (angles, modes)."""
    chosen = engine("thesis")
    settings = chosen.settings_for(chosen.default_accuracy, mechanism).with_texts({"elements": str(elements)})
    return np.array([chosen.natural_frequencies(mechanism, float(angle), count, settings) for angle in ANGLES[::EVERY]])


def _share_with(signs: Array, wanted: tuple[int, int, int]) -> tuple[float, ...]:
    """For each mode the share of crank angles at which the three gauges have these signs, or all three the opposite ones."""
    return tuple(np.mean(np.abs(signs @ np.array(wanted)) == len(wanted), axis=0).tolist())
