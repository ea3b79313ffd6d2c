"""Fatigue at a place of the surface: cycles counted in the stress of a turn, and the fully reversed stress that is as bad as the worst.

A notch multiplies the amplitude by its fatigue notch factor K_f, not the mean stress, and not the largest stress: where a ductile material
yields in a notch, it is relieved there. A mean tension counts by the line of Goodman, one that presses does not count. With the amplitude
a, the mean m, the fatigue strength S_f under fully reversed stress and the tensile strength S_u, the safety factor n, by which all stress
may grow, follows from

    K_f a / S_f + max(m, 0) / S_u = 1 / n

so that a fully reversed stress of the amplitude K_f a + max(m, 0) S_f / S_u is as bad: `equivalent`. Without a tensile strength the mean
does not count. (Budynas and Nisbett, Shigley's Mechanical Engineering Design, 10th edition, sections 6-10 to 6-12.)
"""

from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from quickreturn.cases.motion.number import Number
from quickreturn.reference_model.follower import Follower

Array = NDArray[np.float64]

#: Part of the largest range below which a cycle of stress is not counted. A thousandth of its amplitude harms no metal.
COUNTED: Final = 0.01


@dataclass(frozen=True)
class Fatigue:
    """What counts for fatigue, at the place of the surface where it is worst."""

    equivalent: Number  # amplitude of the fully reversed stress that is as bad as the worst cycle there, Pa
    notch_factor: float  # there; 1 where no notch is given
    amplitude: float  # half of the range of the stress beside the notch in a turn, Pa
    mean: float  # mean of its extremes, Pa; tension is positive
    ranges: tuple[float, ...]  # of the cycles counted there in a turn, Pa, the largest first


def goodman_ratio(follower: Follower) -> float:
    """Fatigue strength over tensile strength; 0 where one is not known, so that the mean stress does not count."""
    if follower.fatigue_strength is None or follower.tensile_strength is None:
        return 0.0
    return follower.fatigue_strength / follower.tensile_strength


def equivalent_amplitude(amplitude: Array | float, mean: Array | float, ratio: float) -> Array:
    """Amplitude of the fully reversed stress that is as bad; `ratio`: see `goodman_ratio`."""
    return np.asarray(amplitude + ratio * np.maximum(mean, 0.0))


def counted_ranges(stress: Array) -> tuple[float, ...]:
    """Ranges of the cycles that count in a stress that repeats, the largest first; `stress`: of a turn, shape (rows,)."""
    ranges = sorted((high - low for low, high in cycles_of(stress)), reverse=True)
    return tuple(each for each in ranges if each >= COUNTED * ranges[0])


def cycles_of(stress: Array) -> list[tuple[float, float]]:
    """Lowest and highest stress of each cycle in a stress that repeats, by rainflow counting from its greatest value on.

    ASTM E1049-85, section 5.4.5: in a history that repeats every cycle is a whole one.
    """
    first = int(np.argmax(stress))
    cycles, open_ = list[tuple[float, float]](), list[float]()
    for value in _turning_points(np.concatenate([stress[first:], stress[: first + 1]])):
        open_.append(value)
        while len(open_) > 2 and abs(open_[-1] - open_[-2]) >= abs(open_[-2] - open_[-3]):
            cycles.append((min(open_[-3:-1]), max(open_[-3:-1])))
            del open_[-3:-1]
    return cycles


def _turning_points(values: Array) -> list[float]:
    """The first and the last value, and all between them at which the sequence turns."""
    moving = values[np.concatenate([[True], np.diff(values) != 0.0])]
    steps = np.sign(np.diff(moving))
    turns = np.concatenate([[True], steps[:-1] != steps[1:], [True]]) if steps.size else [True]
    return [float(value) for value in moving[turns]]
