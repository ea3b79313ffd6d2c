"""Measures of a motion on a resonance curve, their error claims, and the tops of its peaks."""

import math
from collections.abc import Sequence
from dataclasses import replace
from typing import Final

import numpy as np
from numpy.typing import NDArray

from quickreturn.cases.motion.catalogue import MEASURES, SettledMotion
from quickreturn.cases.motion.number import Number
from quickreturn.cases.motion.request import Run
from quickreturn.plugins.studies.resonance_curve.curve import ResonancePeak
from quickreturn.reference_model.cycles.continuation import between
from quickreturn.reference_model.cycles.cycle_family import CycleFamily
from quickreturn.reference_model.cycles.fixed_points import BranchPoint, NotConverged
from quickreturn.reference_model.cycles.poincare import CycleBroken

Array = NDArray[np.float64]

#: Rows of a cycle; a spline finds the peak between them.
ROWS: Final = 256
#: Error of the place of a peak's top, over the distance of the points beside it. It counts at kinks, where another instant of the turn
#: becomes the highest: elsewhere the height is off by its square.
TOP: Final = 2e-3


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
