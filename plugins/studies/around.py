"""A machine's own place on its resonance curve, or why there is no curve."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import CubicSpline

from quickreturn.cases.comparison.campaign import Work
from quickreturn.cases.files.case import Case
from quickreturn.cases.files.keys import PATHS
from quickreturn.cases.files.shown import Unit, Units
from quickreturn.cases.motion.catalogue import MEASURES
from quickreturn.cases.motion.measure import Measure
from quickreturn.cases.motion.resonance import Resonance, ordinal, resonance
from quickreturn.cases.motion.stability import UNSTABLE
from quickreturn.cases.running.job import Job
from quickreturn.cases.running.workshop import Workshop
from quickreturn.engines.base import Refusal
from quickreturn.plugins.studies.resonance_curve.curve import SPEED, ResonanceCurve, ResonancePeak, SpecialPoint
from quickreturn.plugins.studies.resonance_curve.search import PROMINENT, job_around
from quickreturn.plugins.studies.uncertainty.parameters import Parameter
from quickreturn.reference_model.rigid import mean_crank_speed
from quickreturn.reports.page.content import Content
from quickreturn.reports.words import MINUS, TIED, in_words, listed, number, percent, size


@dataclass(frozen=True)
class Around:
    """A machine and its curve."""

    case: Case  # the machine
    curve: ResonanceCurve | None  # the curve, over its speed or another quantity; None if there is none
    reason: str = ""  # why there is no curve (a clause)
    unit: Unit | None = None  # unit of what varies; None: that of the case
    mean_speed: float | None = None  # of the crank in the settled motion, rad/s; None: that of the rigid mechanism counts

    @cached_property
    def own(self) -> float:
        """The machine's own value of what varies, SI; its speed is negative if it turns clockwise, and the mean if a torque drives it."""
        key = SPEED if self.curve is None else self.curve.range.key
        scene = self.case.mechanism
        return self.mean_speed or mean_crank_speed(scene) if key == SPEED else Parameter.of_key(key, self.case.name).of(scene)

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
        """The motions at the machine's own value: first measure (SI, by splines over the arclength), and kind of instability or ""."""
        curve = self.solved_curve
        arclengths = CubicSpline(curve.arclength, curve.values).solve(self.own, extrapolate=False)
        heights = np.exp(CubicSpline(curve.arclength, np.log(self.heights))(arclengths))
        before = np.searchsorted(curve.arclength, arclengths, "right") - 1
        return [(float(height), curve.kind_after(int(at))) for height, at in zip(heights, before, strict=True)]

    @property
    def peak(self) -> ResonancePeak | None:
        """The peak nearest to the machine's own value."""
        return min(self.solved_curve.peaks, key=lambda point: abs(point.value - self.own), default=None)

    @property
    def change(self) -> SpecialPoint | None:
        """The special point nearest to the machine's own value; where the curve was lost is none."""
        curve = self.solved_curve
        return min((each for each in curve.special if each not in curve.lost), key=lambda point: abs(point.value - self.own), default=None)

    def faster(self, value: float) -> float:
        """Relative difference of another value from the machine's own; negative if the other one is slower."""
        return value / self.own - 1.0 if self.own else math.inf

    def shown(self, value: float) -> str:
        """A value of what varies: "236 rpm"."""
        return f"{number(value / self._unit.size, '.5g')} {self._unit.sign}"

    @property
    def _unit(self) -> Unit:
        return self.unit or self.case.units.of(PATHS[self.solved_curve.range.key].unit)

    def way(self, value: float) -> str:
        """How far another value is from the machine's own, in its unit and as a part: "2.5 rpm or 1.1 % faster"."""
        words = ("faster", "slower") if self.solved_curve.range.key == SPEED else ("more", "less")
        part = f" or {size(self.faster(value))}" if self.own else ""
        far = number(abs(value - self.own) / self._unit.size, ".3g")
        return f"{far} {self._unit.sign}{part} {words[self.faster(value) < 0.0]}"

    @property
    def nearest(self) -> str:
        """The peak and the special point nearest to the machine's own value, as a clause each."""
        change = self.change
        of_change = f"{change.kind} at {self.shown(change.value)}, {self.way(change.value)}" if change else ""
        return f"{self.nearest_peak}; {of_change or f'no fold and no loss of stability {self._within}'}"

    @property
    def nearest_peak(self) -> str:
        """The peak nearest to the machine's own value, or that there is none (a clause)."""
        peak = self.peak
        return f"nearest peak at {self.shown(peak.value)} ({peak.name}), {self.way(peak.value)}" if peak else f"no peak {self._within}"

    @property
    def _within(self) -> str:
        low, high = sorted(self.solved_curve.reach, key=abs)
        return f"between {self.shown(low)} and {self.shown(high)}"

    @property
    def without_effect(self) -> str:
        """A clause on the harmonic nearest to the first mode if the two meet within the curve and make no peak of it; "" otherwise."""
        curve, first = self.solved_curve, self._first_mode
        if first is None or curve.range.key != SPEED:
            return ""
        if not curve.range.low <= math.copysign(first.resonant_speed, self.own) <= curve.range.high:
            return ""
        if any((peak.order, peak.mode) == (first.harmonic, 1) for peak in curve.peaks):
            return ""
        least = percent(PROMINENT - 1.0, ".0f")
        return f"the {ordinal(first.harmonic)} harmonic, the nearest to the first mode, raises no peak of {least} or more"

    @property
    def _first_mode(self) -> Resonance | None:
        return resonance(self.case.mechanism, self.mean_speed)

    @property
    def sentences(self) -> list[str]:
        """The machine's own value, the motions there, and what is nearest."""
        curve = self.solved_curve
        own = f"Your machine {'runs at' if curve.range.key == SPEED else 'has'} {self.shown(self.own)}"
        if curve.prescribed and curve.range.key == SPEED:
            mean = "its mean speed" if self.mean_speed else "the mean speed of its rigid mechanism"
            own += f", {mean}, which is prescribed here in place of its drive"
        motions = motion_sentences(self.motions, MEASURES[next(iter(curve.measures))], self.case.units)
        clauses = filter(None, (own, motions, self.nearest, self.without_effect))
        return [f"{each[0].upper()}{each[1:]}{'' if each.endswith('.') else '.'}" for each in clauses]

    @property
    def lines(self) -> list[str]:
        """The sentences as lines for a terminal, in plain characters."""
        return [sentence.replace(TIED, " ").replace(MINUS, "-").replace("²", "^2") for sentence in self.sentences]

    @property
    def document(self) -> dict[str, Any]:
        """The machine on its curve for JSON, SI."""
        motions = [{"height": height, "stability": UNSTABLE.format(kind) if kind else "stable"} for height, kind in self.motions]
        places = {"nearest_peak": self.peak, "nearest_change": self.change}
        far = {name: {"distance": each.value - self.own, "relative": self.faster(each.value)} for name, each in places.items() if each}
        return {"value": self.own, "motions": motions, **far, "sentences": self.lines}


def around_of(content: Content) -> list[Around]:
    """The resonance curves of the user's own machines, around their speeds."""
    if content.workshop is None or not content.is_own:
        return []
    speeds = {result.case.name: result.settled_speed for result in content.results}
    return curves_around([result.case for result in content.results], content.workshop, speeds)


def nearness(content: Content) -> dict[str, str]:
    """Case -> a sentence on how near a resonance is, by its curve, for cases that have one."""
    return {each.case.name: near_words(each) for each in content.of(around_of) if each.curve}


def near_words(around: Around) -> str:
    """How near a resonance is, by the curve of a machine that has one."""
    begin = "has its" if around.peak else "has"
    return f"The resonance curve {'; '.join(filter(None, (f'{begin} {around.nearest_peak}', around.without_effect)))}."


def work(cases: Sequence[Case], engines: Sequence[str], own: bool) -> Work:
    """The curves of the user's own machines."""
    return Work(jobs=[job for job in jobs_around(cases).values() if isinstance(job, Job)] if own else [])


def motion_sentences(motions: Sequence[tuple[float, str]], measure: Measure, units: Units) -> str:
    """How many motions a machine has, and which are stable; each of `motions` is its measure, SI, and its kind of instability or ""."""
    about, unit = measure.meaning.replace("_", " "), units.of(measure.unit)
    # splines between points miss by some percent
    heights = [f"{number(height / unit.size, '.2g')} {unit.sign}" for height, _ in motions]
    if not motions:
        return "The curve does not reach there, and says nothing of it."
    if len(motions) > 1:
        texts = [f"{height} ({UNSTABLE.format(kind) if kind else 'stable'})" for height, (_, kind) in zip(heights, motions, strict=True)]
        stable = sum(not kind for _, kind in motions)
        history = " Its history decides which of the stable ones it follows." if stable > 1 else ""
        told = f"There it has {in_words(len(motions))} periodic motions, {in_words(stable)} of them stable"
        return f"{told}, with a {about} of about {listed(texts)}.{history}"
    kind = motions[0][1]
    stability = f"which is unstable ({kind}): the machine would leave it" if kind else "which is stable"
    return f"There it has one periodic motion on this curve, with a {about} of about {heights[0]}, {stability}."


def jobs_around(cases: Sequence[Case]) -> dict[str, Job[ResonanceCurve] | str]:
    """Case -> the job of its curve, or the reason why it cannot have a curve (a clause)."""
    jobs: dict[str, Job[ResonanceCurve] | str] = {}
    for case in cases:
        try:
            jobs[case.name] = job_around(case)
        except Refusal as refusal:
            jobs[case.name] = str(refusal)
    return jobs


def curves_around(cases: Sequence[Case], workshop: Workshop, speeds: Mapping[str, float | None]) -> list[Around]:
    """The curve of each case, from the store if it is there, or the reason why there is none; `speeds`: case -> see `Around.mean_speed`.

    Raises:
        KeyboardInterrupt: Ctrl-C; what was computed is stored.
    """
    jobs = jobs_around(cases)
    computable = {name: job for name, job in jobs.items() if isinstance(job, Job)}
    outcomes = dict(zip(computable, workshop.outcomes([*computable.values()], "resonance curves"), strict=True))
    # a search for periodic motions has no instant at which it fails
    curves = {name: (outcome.value, outcome.explanation.removeprefix("failed at t = 0 s: ")) for name, outcome in outcomes.items()}
    return [Around(case, *curves.get(case.name, (None, str(jobs[case.name]))), mean_speed=speeds.get(case.name)) for case in cases]
