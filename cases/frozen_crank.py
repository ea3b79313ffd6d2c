"""What the natural frequencies of the crank held still say about the thesis' readings and its suspicion of the slider joint."""

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import brentq

from engines.registry import engine
from reference_model.mechanism import Mechanism, changed
from reference_model.natural_modes import FrozenModes, frozen_crank_modes

Array = NDArray[np.float64]

#: Crank angles at which modes are looked at, rad: farthest to nearest; the way back mirrors them.
ANGLES: Final = np.linspace(math.pi, 0.0, 61)
MODES: Final = 3

LBF_PER_IN: Final = 4.4482216152605 / 0.0254  # N/m
#: Joint stiffnesses that are tried, N/m: rigid, and 1000 lbf/in.
STIFFNESSES: Final = (math.inf, 1000.0 * LBF_PER_IN)
#: A lowering of the first mode as large as the discrepancies that the thesis speaks of.
LOWERING: Final = 0.05
#: Signs of strains 1, 2, 3.
ALTERNATING: Final = (1, -1, 1)
ALIKE: Final = (1, 1, 1)
#: "Doubling or tripling": numbers of cubic elements.
ELEMENTS: Final = (1, 2, 3)


@dataclass(frozen=True)
class Range:
    """Smallest and largest value over the crank angle."""

    low: float
    high: float

    def holds(self, value: float) -> bool:
        """Whether a value lies within."""
        return self.low <= value <= self.high


@dataclass(frozen=True)
class JointEffect:
    """A slider joint of some stiffness (N/m): change of the mean first frequency in each half, and where the third mode lies (Hz)."""

    stiffness: float
    change_pre: float
    change_post: float
    third_mode: Range


@dataclass(frozen=True)
class FrozenCrank:
    """What is known of a run.

    Attributes:
        converged: ranges of the first three converged modes over the crank angle, Hz.
        cubic: ranges of the modes of the thesis' single cubic, Hz.
        alternating: per converged mode the share of crank angles at which strains 1 and 3 have one sign and strain 2 the other.
        alike: the same for all three of one sign.
        elements: largest excess of the first frequency with one, two and three cubic elements over the converged one, relative.
        joints: what a soft slider joint does; empty where there is no reference cycle.
    """

    converged: tuple[Range, ...]
    cubic: tuple[Range, ...]
    alternating: tuple[float, ...]
    alike: tuple[float, ...]
    elements: tuple[float, ...]
    joints: tuple[JointEffect, ...]


def frozen_crank(mechanism: Mechanism, cycle: Mapping[str, Array]) -> FrozenCrank:
    """All of it; `cycle`: crank angle (rad) and time (s) over the reference's steady cycle, or empty."""
    converged = converged_ranges(mechanism)
    return FrozenCrank(
        converged=tuple(converged),
        cubic=tuple(cubic_ranges(mechanism, 2)),
        alternating=tuple(share_with_signs(mechanism, mode, ALTERNATING) for mode in range(len(converged))),
        alike=tuple(share_with_signs(mechanism, mode, ALIKE) for mode in range(len(converged))),
        elements=tuple(excess_of_elements(mechanism, elements) for elements in ELEMENTS),
        joints=tuple(joint_effects(mechanism, cycle["crank_angle"], cycle["time"])) if cycle else (),
    )


def converged_modes(mechanism: Mechanism) -> list[FrozenModes]:
    """Modes at each of `ANGLES`."""
    return [frozen_crank_modes(mechanism, float(angle), MODES) for angle in ANGLES]


def ranges(frequencies: Array) -> list[Range]:
    """Range of each mode over the crank angle from frequencies of shape (angles, modes), Hz."""
    return [Range(float(column.min()), float(column.max())) for column in frequencies.T]


def converged_ranges(mechanism: Mechanism) -> list[Range]:
    """Ranges of the first three converged modes, Hz."""
    return ranges(np.array([mode.frequencies for mode in converged_modes(mechanism)]))


def cubic_ranges(mechanism: Mechanism, count: int) -> list[Range]:
    """Ranges of the first modes of the thesis' single cubic, Hz."""
    return ranges(cubic_frequencies(mechanism, 1, count))


def cubic_frequencies(mechanism: Mechanism, elements: int, count: int) -> Array:
    """Frequencies of the thesis' model with a number of cubic elements at every sixth of `ANGLES`, Hz, shape (angles, modes)."""
    chosen = engine("thesis")
    settings = chosen.settings_for(chosen.default_accuracy, mechanism).with_texts({"elements": str(elements)})
    return np.array([chosen.natural_frequencies(mechanism, float(angle), count, settings) for angle in ANGLES[::6]])


def excess_of_elements(mechanism: Mechanism, elements: int) -> float:
    """Largest excess of the first frequency of a number of cubic elements over the converged one, relative."""
    converged = _first(mechanism, math.inf)[::6]
    return float(np.max(np.abs(cubic_frequencies(mechanism, elements, 1)[:, 0] / converged - 1.0)))


def share_with_signs(mechanism: Mechanism, mode: int, signs: tuple[int, int, int]) -> float:
    """At which share of the crank angles a mode (from 0) bends the three gauges with these signs, or all reversed."""
    gauges = np.array(mechanism.follower.strain_gauges)
    wanted = np.array(signs)
    found = [np.sign(modes.curvature(gauges)[mode]) for modes in converged_modes(mechanism)]
    return float(np.mean([abs(float(wanted @ pattern)) == wanted.size for pattern in found]))


def joint_effects(mechanism: Mechanism, crank_angle: Array, time: Array) -> list[JointEffect]:
    """How a linearly soft joint moves the first mode before and after the return.

    Tried are `STIFFNESSES` and the stiffness that lowers the first mode by `LOWERING` before the return.

    Args:
        mechanism: with a rigid joint.
        crank_angle: of a steady cycle, rad, shape (n,).
        time: s, shape (n,).
    """
    halves = _half_weights(crank_angle, time)
    rigid = _first(mechanism, math.inf)

    def change(stiffness: float, half: int) -> float:
        soft = _first(mechanism, stiffness)
        return float(halves[half] @ soft / (halves[half] @ rigid) - 1.0)

    soft = float(np.exp(brentq(lambda exponent: change(float(np.exp(exponent)), 0) + LOWERING, math.log(1e2), math.log(1e7), rtol=1e-4)))
    return [
        JointEffect(stiffness, change(stiffness, 0), change(stiffness, 1), converged_ranges(_with_joint(mechanism, stiffness))[2])
        for stiffness in (*STIFFNESSES, soft)
    ]


def _with_joint(mechanism: Mechanism, stiffness: float) -> Mechanism:
    return changed(mechanism, {"slider.joint_stiffness": stiffness})


def _first(mechanism: Mechanism, stiffness: float) -> Array:
    """First natural frequency at each of `ANGLES`, Hz."""
    softened = _with_joint(mechanism, stiffness)
    return np.array([frozen_crank_modes(softened, float(angle), 1).frequencies[0] for angle in ANGLES])


def _half_weights(crank_angle: Array, time: Array) -> tuple[Array, Array]:
    """Per half the time that a steady cycle spends near each of `ANGLES`, as weights of sum 1."""
    turned = np.abs(crank_angle - crank_angle[0])
    steps = np.linspace(0.0, math.pi, ANGLES.size)
    weights = []
    for offset in (0.0, math.pi):
        instants = np.interp(offset + steps, turned, time)
        spans = np.gradient(instants)
        weights.append(spans / spans.sum())
    return weights[0], weights[1][::-1]
