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
from reference_model.natural_modes import frozen_crank_modes

Array = NDArray[np.float64]

#: Crank angles at which modes are looked at, rad: farthest to nearest; the way back mirrors them.
ANGLES: Final = np.linspace(math.pi, 0.0, 61)
MODES: Final = 3
#: Of the angles one in so many, for the models with cubic elements.
EVERY: Final = 6

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
    """What is known of a run."""

    converged: tuple[Range, ...]  # ranges of the first three converged modes over the crank angle, Hz
    cubic: tuple[Range, ...]  # ranges of the modes of the thesis' single cubic, Hz
    # per converged mode the share of crank angles at which strains 1 and 3 have one sign and strain 2 the other
    alternating: tuple[float, ...]
    alike: tuple[float, ...]  # the same for all three of one sign
    # largest excess of the first frequency with one, two and three cubic elements over the converged one, relative
    elements: tuple[float, ...]
    joints: tuple[JointEffect, ...]  # what a soft slider joint does; empty where there is no reference cycle


def frozen_crank(mechanism: Mechanism, cycle: Mapping[str, Array]) -> FrozenCrank:
    """All of it; `cycle`: crank angle (rad) and time (s) over the reference's steady cycle, or empty."""
    modes = [frozen_crank_modes(mechanism, float(angle), MODES) for angle in ANGLES]
    signs = np.sign([each.curvature(np.array(mechanism.follower.strain_gauges)) for each in modes])  # (angles, modes, gauges)
    first = _frequencies(mechanism, math.inf, 1)[::EVERY, 0]
    return FrozenCrank(
        converged=_ranges(np.array([each.frequencies for each in modes])),
        cubic=_ranges(_cubic_frequencies(mechanism, 1, 2)),
        alternating=_share_with(signs, ALTERNATING),
        alike=_share_with(signs, ALIKE),
        elements=tuple(float(np.max(np.abs(_cubic_frequencies(mechanism, number, 1)[:, 0] / first - 1.0))) for number in ELEMENTS),
        joints=joint_effects(mechanism, cycle["crank_angle"], cycle["time"]) if cycle else (),
    )


def _ranges(frequencies: Array) -> tuple[Range, ...]:
    """Range of each mode over the crank angle from frequencies of shape (angles, modes), Hz."""
    return tuple(Range(float(column.min()), float(column.max())) for column in frequencies.T)


def _cubic_frequencies(mechanism: Mechanism, elements: int, count: int) -> Array:
    """Frequencies of the thesis' model with a number of cubic elements at some of `ANGLES`, Hz, shape (angles, modes)."""
    chosen = engine("thesis")
    settings = chosen.settings_for(chosen.default_accuracy, mechanism).with_texts({"elements": str(elements)})
    return np.array([chosen.natural_frequencies(mechanism, float(angle), count, settings) for angle in ANGLES[::EVERY]])


def _share_with(signs: Array, wanted: tuple[int, int, int]) -> tuple[float, ...]:
    """Per mode at which share of the crank angles it bends the three gauges with these signs, or all reversed."""
    return tuple(np.mean(np.abs(signs @ np.array(wanted)) == len(wanted), axis=0).tolist())


def joint_effects(mechanism: Mechanism, crank_angle: Array, time: Array) -> tuple[JointEffect, ...]:
    """How a linearly soft joint moves the first mode before and after the return.

    Tried are `STIFFNESSES` and the stiffness that lowers the first mode by `LOWERING` before the return.

    Args:
        mechanism: with a rigid joint.
        crank_angle: of a steady cycle, rad, shape (n,).
        time: s, shape (n,).
    """
    halves = _half_weights(crank_angle, time)
    rigid = _frequencies(mechanism, math.inf, 1)[:, 0]

    def changes(stiffness: float) -> tuple[float, float]:
        soft = _frequencies(mechanism, stiffness, 1)[:, 0]
        before, after = (float(half @ soft / (half @ rigid) - 1.0) for half in halves)
        return before, after

    soft = float(np.exp(brentq(lambda exponent: changes(float(np.exp(exponent)))[0] + LOWERING, math.log(1e2), math.log(1e7), rtol=1e-4)))
    return tuple(
        JointEffect(stiffness, *changes(stiffness), _ranges(_frequencies(mechanism, stiffness, MODES))[2])
        for stiffness in (*STIFFNESSES, soft)
    )


def _frequencies(mechanism: Mechanism, stiffness: float, count: int) -> Array:
    """Natural frequencies at each of `ANGLES` with a joint of this stiffness, Hz, shape (angles, count)."""
    softened = changed(mechanism, {"slider.joint_stiffness": stiffness})
    return np.array([frozen_crank_modes(softened, float(angle), count).frequencies for angle in ANGLES])


def _half_weights(crank_angle: Array, time: Array) -> tuple[Array, Array]:
    """Per half the time that a steady cycle spends near each of `ANGLES`, as weights of sum 1."""
    turned = np.abs(crank_angle - crank_angle[0])
    steps = np.linspace(0.0, math.pi, ANGLES.size)
    spans = [np.gradient(np.interp(offset + steps, turned, time)) for offset in (0.0, math.pi)]
    before, after = (each / each.sum() for each in spans)
    return before, after[::-1]
