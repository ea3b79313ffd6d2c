"""A machine's own place on its resonance curve."""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from scipy.interpolate import CubicSpline

from quickreturn.cases.files.case import Case
from quickreturn.cases.files.shown import Unit, Units
from quickreturn.cases.motion.catalogue import MEASURES
from quickreturn.cases.motion.measure import Measure
from quickreturn.cases.motion.resonance import ordinal, resonance
from quickreturn.cases.motion.stability import UNSTABLE
from quickreturn.plugins.studies.resonance_curve.curve import SPEED, ResonanceCurve, ResonancePeak, SpecialPoint
from quickreturn.plugins.studies.resonance_curve.search import PROMINENT
from quickreturn.plugins.studies.uncertainty.parameters import Parameter
from quickreturn.reference_model.rigid import mean_crank_speed
from quickreturn.reports.words import MINUS, TIED, in_words, listed, number, percent, size


@dataclass(frozen=True)
class Around:
    """A machine and its curve."""

    case: Case  # the machine
    curve: ResonanceCurve  # the curve, over its speed or another quantity
    unit: Unit  # unit of what varies

    @cached_property
    def own(self) -> float:
        """The machine's own value of what varies, SI; its speed is negative if it turns clockwise, and the mean if a torque drives it."""
        key, scene = self.curve.range.key, self.case.mechanism
        return mean_crank_speed(scene) if key == SPEED else Parameter.of_key(key, self.case.name).of(scene)

    @cached_property
    def motions(self) -> list[tuple[float, str]]:
        """The motions at the machine's own value: first measure (SI, by splines over the arclength), and kind of instability or ""."""
        curve, sizes = self.curve, next(iter(self.curve.measures.values()))
        # a motion on the joint of two pieces is found in both
        arclengths = np.unique(np.round(CubicSpline(curve.arclength, curve.values).solve(self.own, extrapolate=False), 9))
        heights = np.exp(CubicSpline(curve.arclength, np.log(sizes))(arclengths))
        before = np.searchsorted(curve.arclength, arclengths, "right") - 1
        return [(float(height), curve.kind_after(int(at))) for height, at in zip(heights, before, strict=True)]

    @property
    def peak(self) -> ResonancePeak | None:
        """The peak nearest to the machine's own value."""
        return min(self.curve.peaks, key=lambda point: abs(point.value - self.own), default=None)

    @property
    def change(self) -> SpecialPoint | None:
        """The special point nearest to the machine's own value; where the curve was lost is none."""
        curve = self.curve
        return min((each for each in curve.special if each not in curve.lost), key=lambda point: abs(point.value - self.own), default=None)

    def faster(self, value: float) -> float:
        """Relative difference of another value from the machine's own; negative if the other one is slower."""
        return value / self.own - 1.0 if self.own else math.inf

    def shown(self, value: float) -> str:
        """A value of what varies: "236 rpm"."""
        return f"{number(value / self.unit.size, '.5g')} {self.unit.sign}"

    def way(self, value: float) -> str:
        """How far another value is from the machine's own, in its unit and as a part: "2.5 rpm or 1.1 % faster"."""
        words = ("faster", "slower") if self.curve.range.key == SPEED else ("more", "less")
        part = f" or {size(self.faster(value))}" if self.own else ""
        far = number(abs(value - self.own) / self.unit.size, ".3g")
        return f"{far} {self.unit.sign}{part} {words[self.faster(value) < 0.0]}"

    @property
    def nearest(self) -> str:
        """The peak and the special point nearest to the machine's own value, as a clause each."""
        peak, change = self.peak, self.change
        of_peak = f"nearest peak at {self.shown(peak.value)} ({peak.name}), {self.way(peak.value)}" if peak else f"no peak {self._within}"
        of_change = f"{change.kind} at {self.shown(change.value)}, {self.way(change.value)}" if change else ""
        return f"{of_peak}; {of_change or f'no fold and no loss of stability {self._within}'}"

    @property
    def _within(self) -> str:
        low, high = sorted(self.curve.reach, key=abs)
        return f"between {self.shown(low)} and {self.shown(high)}"

    @property
    def without_effect(self) -> str:
        """A clause on the harmonic nearest to the first mode if the two meet within the curve and make no peak of it; "" otherwise."""
        curve, first = self.curve, resonance(self.case.mechanism)
        if first is None or curve.range.key != SPEED:
            return ""
        if not curve.range.low <= math.copysign(first.resonant_speed, self.own) <= curve.range.high:
            return ""
        if any((peak.order, peak.mode) == (first.harmonic, 1) for peak in curve.peaks):
            return ""
        least = percent(PROMINENT - 1.0, ".0f")
        return f"the {ordinal(first.harmonic)} harmonic, the nearest to the first mode, raises no peak of {least} or more"

    @property
    def sentences(self) -> list[str]:
        """The machine's own value, the motions there, and what is nearest."""
        curve = self.curve
        own = f"Your machine {'runs at' if curve.range.key == SPEED else 'has'} {self.shown(self.own)}"
        if curve.prescribed and curve.range.key == SPEED:
            own += ", the mean speed of its rigid mechanism, which is prescribed here in place of its drive"
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
