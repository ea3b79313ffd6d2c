"""Measures of a motion on a resonance curve, their error claims, the tops of its peaks, and what drives these."""

import math
from collections.abc import Sequence
from dataclasses import replace
from typing import Final

import numpy as np
from numpy.typing import NDArray

from quickreturn.cases.motion.catalogue import MEASURES
from quickreturn.cases.motion.measure import SettledMotion
from quickreturn.cases.motion.number import Number
from quickreturn.cases.motion.request import Run
from quickreturn.cases.motion.resonance import ANGLES
from quickreturn.plugins.studies.resonance_curve.curve import ResonancePeak
from quickreturn.reference_model.cycles.continuation import between
from quickreturn.reference_model.cycles.cycle_family import CycleFamily
from quickreturn.reference_model.cycles.fixed_points import BranchPoint, NotConverged
from quickreturn.reference_model.cycles.poincare import CycleBroken
from quickreturn.reference_model.mechanism import Mechanism
from quickreturn.reference_model.natural_modes import frozen_crank_modes, turn_angles
from quickreturn.reference_model.rigid import mean_crank_speed

Array = NDArray[np.float64]

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
