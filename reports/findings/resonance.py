"""The resonance curve around the speed of the user's own machine: the machine's place on it, or why there is no curve."""

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import CubicSpline

from quickreturn.cases.case import Case
from quickreturn.cases.jobs.job import Job
from quickreturn.cases.jobs.workshop import Workshop
from quickreturn.cases.loads import resonance
from quickreturn.cases.resonance_curve import PEAKS, ResonanceCurve, ResonancePeak, SpecialPoint, job_around
from quickreturn.engines.base import Refusal
from quickreturn.reference_model.columns import COLUMNS
from quickreturn.reference_model.rigid import crank_pace


@dataclass(frozen=True)
class Around:
    """A machine and its curve over speeds around its own.

    Attributes:
        case: the machine.
        curve: the curve over the crank's speed; None if there is none.
        reason: why there is no curve (a clause).
    """

    case: Case
    curve: ResonanceCurve | None
    reason: str = ""

    @cached_property
    def pace(self) -> float:
        """The machine's own speed, rad/s; its mean speed if a torque drives it."""
        return crank_pace(self.case.mechanism)

    @property
    def heights(self) -> NDArray[np.float64]:
        """The measure at the points of the curve, shape (k,)."""
        return next(iter(self.known.measures.values()))

    @property
    def known(self) -> ResonanceCurve:
        """The curve, if there is one."""
        assert self.curve is not None
        return self.curve

    @cached_property
    def own(self) -> list[tuple[float, str]]:
        """The motions at the machine's own speed: the measure, by splines over the arclength, and how the motion is unstable."""
        curve = self.known
        places = CubicSpline(curve.arclength, curve.values).solve(self.pace, extrapolate=False)
        heights = np.exp(CubicSpline(curve.arclength, np.log(self.heights))(places))
        before = np.searchsorted(curve.arclength, places, "right") - 1
        return [(float(height), curve.kind_after(int(at))) for height, at in zip(heights, before, strict=True)]

    @property
    def peak(self) -> ResonancePeak | None:
        """The peak nearest to the machine's speed."""
        return min(self.known.peaks, key=lambda each: abs(each.value - self.pace), default=None)

    @property
    def change(self) -> SpecialPoint | None:
        """The special point nearest to the machine's speed."""
        return min(self.known.special, key=lambda each: abs(each.value - self.pace), default=None)

    def faster(self, value: float) -> float:
        """Relative difference of another speed from the machine's own; negative if the other one is slower."""
        return value / self.pace - 1.0

    def order_at(self, speed: float) -> int | None:
        """The multiple of a crank speed (rad/s) that is nearest to the first mode."""
        first = resonance(self.case.mechanism)
        return None if first is None else replace(first, crank=abs(speed) / (2.0 * math.pi)).harmonic

    @property
    def lines(self) -> list[str]:
        """The machine's own motion, and the nearest peak and special point, as lines for a terminal."""
        curve, name = self.known, next(iter(self.known.measures))
        rpm, unit = curve.range.size, COLUMNS[PEAKS[name]].unit
        low, high = sorted((curve.range.low, curve.range.high))
        drive = ", its mean speed, prescribed here in place of its drive" if curve.prescribed else ""
        lines = [f"the machine runs at {self.pace / rpm:.5g} rpm{drive}"]
        lines += [f"there {name} is about {height:.3g} {unit}, {f'unstable: {kind}' if kind else 'stable'}" for height, kind in self.own]
        found = {
            "peak": [(f"order {each.order}, {each.height:.3g} {unit}", each.value) for each in [self.peak] if each],
            "change of stability": [(each.kind, each.value) for each in [self.change] if each],
        }
        for what, places in found.items():
            lines += [] if places else [f"no {what} between {low / rpm:.4g} and {high / rpm:.4g} rpm"]
            for words, value in places:
                way = "faster" if self.faster(value) > 0.0 else "slower"
                lines.append(f"nearest {what}: {words}, at {value / rpm:.5g} rpm, {100.0 * abs(self.faster(value)):.2g} % {way}")
        return lines


def jobs_around(cases: Sequence[Case]) -> dict[str, Job[ResonanceCurve] | str]:
    """Jobs of the cases' curves by case; for a machine that cannot have a curve, the reason (a clause)."""
    found: dict[str, Job[ResonanceCurve] | str] = {}
    for case in cases:
        try:
            found[case.name] = job_around(case)
        except Refusal as refusal:
            found[case.name] = str(refusal)
    return found


def curves_around(cases: Sequence[Case], workshop: Workshop) -> list[Around]:
    """The curve of each case, from the store if it is there, or the reason why there is none.

    Raises:
        KeyboardInterrupt: Ctrl-C; what was computed is stored.
    """
    asked = jobs_around(cases)
    jobs = {name: job for name, job in asked.items() if isinstance(job, Job)}
    ended = dict(zip(jobs, workshop.outcomes([*jobs.values()], "resonance curves"), strict=True))
    # a search for periodic motions has no instant at which it fails
    curves = {name: (outcome.value, outcome.explanation.removeprefix("failed at t = 0 s: ")) for name, outcome in ended.items()}
    return [Around(case, *curves.get(case.name, (None, str(asked[case.name])))) for case in cases]
