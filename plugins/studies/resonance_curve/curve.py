"""A resonance curve: its points with stability and error claims, special points and peaks; and the range over which it goes."""

import itertools
import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from typing import Final

import numpy as np

from quickreturn.cases.files.errors import CaseError, as_written, nearest_or_all
from quickreturn.cases.files.keys import PATHS, si_value, unit_given
from quickreturn.cases.motion import endings
from quickreturn.cases.motion.catalogue import MEASURES
from quickreturn.cases.motion.measure import SettledMotion
from quickreturn.cases.motion.number import Number
from quickreturn.cases.motion.request import Run
from quickreturn.cases.motion.resonance import ANGLES
from quickreturn.cases.motion.stability import UNSTABLE
from quickreturn.plugins.studies.sweep.grid import OF_START
from quickreturn.reference_model.arrays import Array
from quickreturn.reference_model.cycles.continuation import between
from quickreturn.reference_model.cycles.cycle_family import CycleFamily
from quickreturn.reference_model.cycles.fixed_points import BranchPoint, NotConverged
from quickreturn.reference_model.cycles.poincare import CycleBroken
from quickreturn.reference_model.mechanism import Mechanism
from quickreturn.reference_model.natural_modes import frozen_crank_modes, turn_angles
from quickreturn.reference_model.rigid import mean_crank_speed

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


#: Error of a multiplier: differences of cycles leave about 1e-4 of the largest derivatives.
MULTIPLIER_TOLERANCE: Final = 1e-3

#: Modes that a harmonic of the crank's speed may drive, in words.
MODES: Final = ("first", "second")


@dataclass(frozen=True)
class SpecialPoint:
    """A point where the kind of motion changes."""

    kind: str  # "fold", "period doubling", "torus", "slider left" or "lost"
    value: float  # of the varied quantity, SI
    tolerance: float  # error of its location on the model's own curve
    error: float | None  # claim: its displacement with more modes; None: unknown
    at: int  # number of the point on the curve
    reason: str = ""  # why the curve ends there (a clause); "" if it goes on


@dataclass(frozen=True)
class ResonancePeak:
    """A local maximum of the first measure along the curve."""

    value: float  # of the varied quantity, SI
    height: float  # of the measure
    at: int  # number of the point on the curve
    order: int  # multiple of the crank's speed that drives a mode there: it is nearest to the mean frequency with the crank held
    mode: int = 1  # number of this mode

    @property
    def name(self) -> str:
        """The harmonic and the mode: "7 x crank = first mode"."""
        return f"{self.order} x crank = {MODES[self.mode - 1]} mode"


@dataclass(frozen=True)
class ResonanceCurve:
    """Points in order of arclength, which pass through folds; arrays of shape (k,).

    A point's claim is a rectangle: the curve of a converged model passes through `values` +- `value_errors` and each measure +- its error.
    The converged point is sought in the plane across the curve, so the claim also holds at folds.
    """

    range: Range  # what varies, and between which values
    prescribed: bool  # whether the crank's speed was prescribed in place of the case's own drive
    values: Array  # of the varied quantity, SI
    arclength: Array  # along the curve, in parts of the range and of the motion's size
    measures: dict[str, Array]  # by name
    errors: dict[str, Array]  # of these, by name; nan where unknown
    value_errors: Array  # nan where unknown
    multipliers: Array  # largest Floquet multiplier, real and imaginary part, shape (k, 2)
    kinds: tuple[str, ...]  # "" of a stable point, else "fold", "period doubling" or "torus"
    special: tuple[SpecialPoint, ...]  # in order of arclength
    peaks: tuple[ResonancePeak, ...]  # likewise
    settings: dict[str, float]  # modes and tolerance of the model, and of the finer one

    def stability(self, at: int) -> str:
        """Whether a point is stable, "neutral" where its largest multiplier is 1 within its error, or how it is unstable."""
        if abs(math.hypot(*self.multipliers[at]) - 1.0) <= MULTIPLIER_TOLERANCE:
            return endings.Ending.NEUTRAL
        return UNSTABLE.format(self.kinds[at]) if self.kinds[at] else "stable"

    def kind_after(self, at: int) -> str:
        """How the motion is unstable between a point and the next one, "" if it is stable."""
        return self.kinds[at + 1 if any(each.at == at for each in self.special) else at]

    @property
    def lost(self) -> tuple[SpecialPoint, ...]:
        """Where the curve could not be followed any farther."""
        return tuple(each for each in self.special if each.kind == "lost")

    @property
    def reach(self) -> tuple[float, float]:
        """The range, or what of it was followed before the curve was lost, SI."""
        if not self.lost:
            return self.range.low, self.range.high
        return float(self.values.min()), float(self.values.max())

    def stretches(self) -> Iterator[tuple[slice, bool]]:
        """Stretches of the curve, and whether they are unstable; special points belong to both adjacent stretches."""
        unstable, begin = [bool(self.kind_after(at)) for at in range(len(self.kinds) - 1)], 0
        for state, group in itertools.groupby(unstable):
            end = begin + len(list(group))
            yield slice(begin, end + 1), state
            begin = end


#: Rows of a cycle; a spline finds the peak between them.
ROWS: Final = 256
#: Error of the place of a peak's top, over the distance of the points beside it. It counts at kinks, where another instant of the turn
#: becomes the highest: elsewhere the height is off by its square.
TOP: Final = 2e-3
#: Distance of a ratio of frequencies from a whole number above which it lies between two, and below which it is close to one. At the peaks
#: of run 24's machine the first mode is 0.01 to 0.14 from a multiple of the crank's speed.
BETWEEN: Final = 0.25
CLOSE: Final = 0.1


def numbers_of(family: CycleFamily, point: Array, value: float, measures: Sequence[str]) -> list[Number]:
    """Each measure of a motion, and its uncertainty from the spacing of rows."""
    run = Run(engine="reference", estimate_of="total", cycle=family.columns(point, value, ROWS))
    motion = SettledMotion(family.scene_at(value), run)
    return [MEASURES[name].of(motion) for name in measures]


def claims_on(
    point: BranchPoint, found: Sequence[Number], finer: CycleFamily, measures: Sequence[str], part: float, displacement: Array | None
) -> tuple[list[float], float, Array | None]:
    """Claims on measures and place: `part` of the difference to the finer family's point (equation 10.13); nan where there is none.

    Also the displacement of the finer family's point. Its search begins with the `displacement` at the point before, None if unknown.
    """
    try:
        there = finer.nearest(point, displacement)
        others = numbers_of(finer, there.point, there.parameter, measures)
    except (CycleBroken, NotConverged):
        return [math.nan] * len(found), math.nan, None
    errors = [part * abs(other.value - one.value) + one.uncertainty for one, other in zip(found, others, strict=True)]
    return errors, part * abs(there.parameter - point.parameter), there.displacement


def topped(family: CycleFamily, points: Sequence[BranchPoint], peak: ResonancePeak, measure: str) -> ResonancePeak:
    """The peak with its top on the curve itself, between the three points about it; unchanged where the curve has no point there."""
    from scipy.optimize import minimize_scalar

    before, here, after = points

    def motion(place: float) -> tuple[Array, float]:
        begin, end = (before, here) if place < here.arclength else (here, after)
        return between(family, begin, end, place - begin.arclength)

    ends = before.arclength, after.arclength
    try:
        top = minimize_scalar(
            lambda place: -numbers_of(family, *motion(place), (measure,))[0].value,
            bounds=ends,
            method="bounded",
            options={"xatol": TOP * (ends[1] - ends[0])},
        )
        return replace(peak, value=motion(float(top.x))[1], height=-float(top.fun))
    except (CycleBroken, NotConverged):
        return peak


def driven(mechanism: Mechanism) -> tuple[int, int]:
    """The harmonic of the crank's speed that drives a mode most, and the mode's number, for a scene at a peak of its resonance curve.

    That is the multiple of the speed nearest to the mean frequency of the first mode, unless the speed lies between two such multiples and
    close to one of the second mode.
    """
    modes = [frozen_crank_modes(mechanism, angle, 2).frequencies for angle in turn_angles(mechanism, ANGLES)]
    ratios = np.asarray(np.trapezoid(modes, axis=0)) / (len(modes) - 1) / (abs(mean_crank_speed(mechanism)) / (2.0 * math.pi))
    first, second = np.abs(ratios - np.round(ratios))
    mode = 1 if second > CLOSE or first < BETWEEN else 2
    return max(1, round(float(ratios[mode - 1]))), mode
