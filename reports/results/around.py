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
from quickreturn.cases.resonance_curve.curve import ResonanceCurve, ResonancePeak, SpecialPoint
from quickreturn.cases.resonance_curve.search import OF_CURVE, job_around
from quickreturn.engines.base import Refusal
from quickreturn.reference_model.rigid import mean_crank_speed


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
        """The machine's own speed, rad/s, negative if it turns clockwise: its mean speed if a torque drives it."""
        return mean_crank_speed(self.case.mechanism)

    @property
    def heights(self) -> NDArray[np.float64]:
        """The curve's first measure at its points, SI, shape (k,)."""
        return next(iter(self.solved_curve.measures.values()))

    @property
    def solved_curve(self) -> ResonanceCurve:
        """The curve of a machine that has one."""
        assert self.curve is not None
        return self.curve

    @cached_property
    def motions(self) -> list[tuple[float, str]]:
        """The motions at the machine's speed: first measure (SI, by splines over the arclength), and kind of instability or ""."""
        curve = self.solved_curve
        arclengths = CubicSpline(curve.arclength, curve.values).solve(self.pace, extrapolate=False)
        heights = np.exp(CubicSpline(curve.arclength, np.log(self.heights))(arclengths))
        before = np.searchsorted(curve.arclength, arclengths, "right") - 1
        return [(float(height), curve.kind_after(int(at))) for height, at in zip(heights, before, strict=True)]

    @property
    def peak(self) -> ResonancePeak | None:
        """The peak nearest to the machine's speed."""
        return min(self.solved_curve.peaks, key=lambda point: abs(point.value - self.pace), default=None)

    @property
    def change(self) -> SpecialPoint | None:
        """The special point nearest to the machine's speed."""
        return min(self.solved_curve.special, key=lambda point: abs(point.value - self.pace), default=None)

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
        curve, name = self.solved_curve, next(iter(self.solved_curve.measures))
        units = self.case.units
        speed, height_unit = units.of("rad/s"), units.of(OF_CURVE[name].unit)
        low, high = sorted((curve.range.low, curve.range.high))
        drive = ", its mean speed, prescribed here in place of its drive" if curve.prescribed else ""
        lines = [f"the machine runs at {speed.text(self.pace, '.5g')}{drive}"]
        lines += [
            f"there {name} is about {height_unit.text(height, '.3g')}, {f'unstable: {kind}' if kind else 'stable'}"
            for height, kind in self.motions
        ]
        nearest = {
            "peak": [(f"order {each.order}, {height_unit.text(each.height, '.3g')}", each.value) for each in [self.peak] if each],
            "change of stability": [(each.kind, each.value) for each in [self.change] if each],
        }
        for what, places in nearest.items():
            lines += [] if places else [f"no {what} between {low / speed.size:.4g} and {speed.text(high)}"]
            for words, value in places:
                direction = "faster" if self.faster(value) > 0.0 else "slower"
                share = f"{100.0 * abs(self.faster(value)):.2g} % {direction}"
                lines.append(f"nearest {what}: {words}, at {speed.text(value, '.5g')}, {share}")
        return lines


def jobs_around(cases: Sequence[Case]) -> dict[str, Job[ResonanceCurve] | str]:
    """Case -> the job of its curve, or the reason why it cannot have a curve (a clause)."""
    jobs: dict[str, Job[ResonanceCurve] | str] = {}
    for case in cases:
        try:
            jobs[case.name] = job_around(case)
        except Refusal as refusal:
            jobs[case.name] = str(refusal)
    return jobs


def curves_around(cases: Sequence[Case], workshop: Workshop) -> list[Around]:
    """The curve of each case, from the store if it is there, or the reason why there is none.

    Raises:
        KeyboardInterrupt: Ctrl-C; what was computed is stored.
    """
    jobs = jobs_around(cases)
    computable = {name: job for name, job in jobs.items() if isinstance(job, Job)}
    outcomes = dict(zip(computable, workshop.outcomes([*computable.values()], "resonance curves"), strict=True))
    # a search for periodic motions has no instant at which it fails
    curves = {name: (outcome.value, outcome.explanation.removeprefix("failed at t = 0 s: ")) for name, outcome in outcomes.items()}
    return [Around(case, *curves.get(case.name, (None, str(jobs[case.name])))) for case in cases]
