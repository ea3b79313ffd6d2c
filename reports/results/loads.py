"""Loads on the parts of a machine, by each engine on each case, and by the leading engine; their numbers, and sentences on them."""

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from functools import cached_property
from typing import TYPE_CHECKING, Any, Final

from quickreturn.cases.files.case import Case
from quickreturn.cases.files.shown import Unit, Units
from quickreturn.cases.files.units import in_si
from quickreturn.cases.loads import UNITS, Factor, Loads, Resonance, loads_of_run, resonance, share_of, shift_of_motion
from quickreturn.cases.motion.endings import Ending
from quickreturn.cases.motion.number import Number
from quickreturn.reports.words import TIED, degrees, number, off_by, percent, quantity, size

if TYPE_CHECKING:
    from quickreturn.cases.comparison.engines import CaseResult
    from quickreturn.cases.motion.request import Run

#: Number -> its name in the page.
NAMES: Final = {
    "stress": "largest stress",
    "stress_axial_part": "part of the normal force in it",
    "strain": "the same as strain",
    "axial_stress": "largest stress by the normal force alone",
    "stress_amplitude": "stress amplitude",
    "stress_mean": "mean stress there",
    "equivalent_amplitude": "equivalent amplitude for fatigue",
    "notch_factor": "notch factor there",
    "stress_cycles": "cycles of stress in a turn there",
    "yield_factor": "safety against yielding",
    "fatigue_factor": "safety against fatigue",
    "crank_torque": "torque of the drive",
    "pivot_force": "force in the bearing P",
    "crank_force": "force in the bearing O",
    "slider_force": "force at the slider",
    "tip_deflection": "deflection of the tip",
    "mean_first_frequency": "first mode, mean over the turn",
    "frequency_ratio": "the same over the crank's frequency",
}
#: What follows "notch_1_" in the name of a number at the first notch -> its name in the page.
_AT_NOTCH: Final = {"equivalent_amplitude": "equivalent amplitude", "fatigue_factor": "safety against fatigue"}
#: Unit in which the page shows the strain of the arm.
STRAIN: Final = Unit("µε", in_si("microstrain"))


def name_of(quantity: str) -> str:
    """The name of a number in the page."""
    if quantity in NAMES:
        return NAMES[quantity]
    _, number, what = quantity.split("_", 2)
    return f"{_AT_NOTCH[what]} at notch {number}"


@dataclass(frozen=True)
class Load:
    """A load; fields that are unknown, or that it does not have, are None."""

    quantity: str  # see `name_of`
    value: float  # the number
    unit: str  # SI
    error: float | None = None  # estimated error, SI; of a safety factor the farther end of its interval, None where that has none
    place: float | None = None  # arc length from P, m
    crank_angle: float | None = None  # rad, from 0 to a turn
    lowest: float | None = None  # least and greatest value of a safety factor by the stress's error
    highest: float | None = None  # None where it has no bound

    def text(self, units: Units) -> str:
        """The number as the page shows it."""
        if self.quantity == "stress_cycles":
            return f"{self.value:.0f}"
        return quantity(self.value, STRAIN if self.quantity == "strain" else units.of(self.unit))


@dataclass(frozen=True)
class CaseLoads:
    """The loads of a case by each engine."""

    case: Case
    loads: dict[str, Loads]  # by engine, for those with a usable cycle
    models: frozenset[str] = frozenset()  # engines whose discretization is their model: a difference is not an error of theirs
    missed: tuple[str, ...] = ()  # a clause for each engine that misses its accuracy
    shares: Mapping[str, float | None] = field(default_factory=dict)  # by engine, of the harmonic nearest to the first mode: `share_of`
    mean_speed: float | None = None  # of the crank in the settled motion, rad/s

    @property
    def lead(self) -> str:
        """The engine whose numbers are shown: `reference`, or else the first that gives a stress; "" if none does, or if it is zero."""
        from quickreturn.cases.comparison.engines import REFERENCE  # the loads of a single trajectory need no comparison

        stressed = [name for name, loads in self.loads.items() if loads.stress is not None and loads.stress.largest.value > 0.0]
        return REFERENCE if REFERENCE in stressed else next(iter(stressed), "")

    @cached_property
    def resonance(self) -> Resonance | None:
        """The first mode beside the crank's frequency; None where there is no such mode."""
        return resonance(self.case.mechanism, self.mean_speed)

    @property
    def resonance_sentence(self) -> str:
        """How near a resonance is, by the harmonic nearest to the first mode; "" if nothing vibrates."""
        return f"Of the crank’s speed {self.resonance.sentence(self.case.units, self.share)}." if self.resonance else ""

    @property
    def share(self) -> float | None:
        """What the harmonics about the nearest one to the first mode have of the tip's acceleration, by the leading engine."""
        return self.shares.get(self.lead)

    @property
    def verdict(self) -> str:
        """Whether the arm holds, by the leading engine (a sentence); "" where no strength is given."""
        return verdict(self.loads[self.lead])

    @cached_property
    def shift_of_motion(self) -> float:
        """Amount, Hz, by which the crank's rotation changes the mean first frequency; frequencies with the crank held lack it."""
        return abs(shift_of_motion(self.case.mechanism))

    def departures(self) -> dict[str, float]:
        """Engine -> its largest stress over the leading engine's, minus one; without engines whose discretization is their model."""
        same = {name: loads for name, loads in self.loads.items() if name not in self.models}
        stress = {name: loads.stress.largest.value for name, loads in same.items() if loads.stress is not None}
        lead = stress.pop(self.lead, 0.0)
        return {name: value / lead - 1.0 for name, value in stress.items()} if lead else {}


def settled_speed(result: "CaseResult") -> float | None:
    """Mean crank speed (rad/s) of the settled motion by `reference`, or else by the first engine that has one; None without one."""
    usable = {name: run for name, run in result.runs.items() if run.usable}
    return mean_crank_speed(usable.get("reference", next(iter(usable.values())))) if usable else None


def mean_crank_speed(run: "Run") -> float:
    """Mean crank speed over a run's cycle, rad/s."""
    angle, time = run.cycle["crank_angle"], run.cycle["time"]
    return float(angle[-1] - angle[0]) / float(time[-1] - time[0])


def loads_of_case(result: "CaseResult") -> CaseLoads:
    """The loads of a case by each engine; recorded tables are left out, because they may lack the moments."""
    mechanism = result.case.mechanism
    by_engine = {name: loads for name, run in result.runs.items() if (loads := loads_of_run(mechanism, run)) is not None}
    models = frozenset(name for name, run in result.runs.items() if run.estimate_of == "integration")
    return CaseLoads(result.case, by_engine, models, accuracies_missed(result), _shares(result), settled_speed(result))


def _shares(result: "CaseResult") -> dict[str, float | None]:
    first = resonance(result.case.mechanism, settled_speed(result))
    return {name: share_of(first.harmonic, run.cycle) for name, run in result.runs.items() if run.usable} if first else {}


def accuracies_missed(result: "CaseResult") -> tuple[str, ...]:
    """A clause for each engine whose estimate misses the accuracy asked, with both."""
    return tuple(_missed(run) for run in result.runs.values() if run.status == Ending.INACCURATE)


def _missed(run: "Run") -> str:
    error, accuracy = run.computation.error_estimate, run.computation.accuracy
    estimate = "an unknown error" if error is None else f"an error of {size(error)} of the tip’s deflection"
    asked = "" if accuracy is None else f" where {percent(accuracy, 'g')} was asked"
    return f"{run.engine} estimates {estimate}{asked}"


def leading_loads(result: "CaseResult") -> CaseLoads:
    """The loads of a case by the leading engine alone."""
    from quickreturn.cases.comparison.engines import REFERENCE

    mechanism, names = result.case.mechanism, sorted(result.runs, key=lambda name: name != REFERENCE)
    for name in names:
        loads = loads_of_run(mechanism, result.runs[name])
        if loads is not None and loads.stress is not None:
            return CaseLoads(result.case, {name: loads}, shares=_shares(result), mean_speed=settled_speed(result))
    return CaseLoads(result.case, {})


def verdict(loads: Loads) -> str:
    """Whether the arm holds (a sentence), not judged by a stress with an error of tens of percent; "" where no strength is given."""
    both = {"yielding": loads.yield_factor, "fatigue": loads.fatigue_factor}
    factors = {against: factor for against, factor in both.items() if factor is not None}
    if not factors:
        return ""
    values = " and ".join(f"{_safety(factor)} against {against}" for against, factor in factors.items())
    if unjudged := [factor for factor in factors.values() if not factor.judged]:
        errors = [factor.error for factor in unjudged if factor.error is not None]
        why = f"is{TIED}{size(max(errors))} of it" if errors else "is not known"
        return f"Whether the arm holds cannot be judged, as the error of its stress {why}: the safety factor is {values}."
    broken = any(factor.highest is not None and factor.highest < 1.0 for factor in factors.values())
    close = any(factor.lowest is not None and factor.lowest <= 1.0 for factor in factors.values())
    begin = "The arm does not hold" if broken else "Whether the arm holds is too close to tell" if close else "The arm holds"
    below = ", below one" if broken and len(factors) == 1 else ""
    return f"{begin}: the safety factor is {values}{below}."


def from_p(peak: Number, units: Units) -> str:
    """The place of a peak along the arm: "375 mm from P"."""
    assert peak.place is not None
    return f"{number(peak.place / units.of('m').size, units.form('m', '.0f'))} {units.of('m').sign} from P"


def axial_words(axial: Number | None, units: Units) -> str:
    """Whether a largest stress is tension, and how much of it comes from the normal force (a clause); "" where that is not known."""
    if axial is None:
        return ""
    return f"{tension_or_compression(axial)}, {quantity(abs(axial.value), units.of('Pa'))} of it from the normal force"


def tension_or_compression(axial: Number) -> str:
    """The kind of a largest stress, by the part of the normal force in it: the bending beside it has the same sign."""
    return "tension" if axial.value > 0.0 else "compression" if axial.value < 0.0 else "tension and compression alike"


def notch_lines(loads: Loads, case: Case) -> list[str]:
    """For each notch its safety against fatigue, or the stress that counts there, and whether it decides (a clause each)."""
    told = list[str]()
    if loads.stress is None or not loads.notch_factors:
        return told
    worst = loads.stress.fatigue
    for notch, safe in zip(loads.stress.notches, loads.notch_factors, strict=True):
        decides = (notch.notch_factor, notch.equivalent.place) == (worst.notch_factor, worst.equivalent.place)
        counts = f"equivalent amplitude {quantity(notch.equivalent.value, case.units.of('Pa'))}"
        factor = f"safety factor {_safety(safe)} against fatigue" if safe else counts
        told.append(f"notch {from_p(notch.equivalent, case.units)}: {factor}, {'decides' if decides else 'does not decide'}")
    return told


def _safety(factor: Factor) -> str:
    """A safety factor with its error; its interval is told where that is too large."""
    return f"{factor.text} ({off_by(factor.error, 1.0)})" if factor.judged and factor.error is not None else factor.text


def stress_text(loads: Loads, case: Case) -> str:
    """The largest stress in a case and where it is, and whether the arm holds, in a line. There must be a stress."""
    assert loads.stress is not None
    length, units = case.scene.follower.length, case.units
    largest_stress, where = loads.stress.largest, []
    if largest_stress.place is not None:
        where.append(f"{from_p(largest_stress, units)} ({100.0 * largest_stress.place / length:.0f} % of the arm)")
    if largest_stress.crank_angle is not None:
        where.append(f"crank at {degrees(largest_stress.crank_angle)}")
    error = "" if math.isnan(largest_stress.error) else f" ({off_by(largest_stress.error, largest_stress.value)})"
    axial = axial_words(loads.stress.axial, units)
    where = [axial, *where] if axial else where
    text = f"largest stress {quantity(largest_stress.value, units.of('Pa'))}{error}, {', '.join(where)}"
    return f"{text}. {verdict_text.removesuffix('.')}" if (verdict_text := verdict(loads)) else text


def numbers(loads: Loads) -> Iterator[Load]:
    """All numbers of an engine's loads."""
    if loads.stress is not None:
        largest, fatigue = loads.stress.largest, loads.stress.fatigue
        yield _peak("stress", largest, "Pa")
        if loads.stress.axial is not None:
            yield _peak("stress_axial_part", loads.stress.axial, "Pa")
        if loads.strain is not None:
            yield _peak("strain", loads.strain, "1")
        yield _peak("stress_amplitude", loads.stress.amplitude, "Pa")
        error = loads.stress.amplitude.error  # like that of the mean, half the sum of those of both extremes
        yield Load("stress_mean", loads.stress.mean, "Pa", None if math.isnan(error) else error, loads.stress.amplitude.place)
        yield _peak("equivalent_amplitude", fatigue.equivalent, "Pa")
        yield Load("notch_factor", fatigue.notch_factor, "1", place=fatigue.equivalent.place)
        yield Load("stress_cycles", float(len(fatigue.ranges)), "1", place=fatigue.equivalent.place)
        for number, notch in enumerate(loads.stress.notches, 1):
            yield _peak(f"notch_{number}_equivalent_amplitude", notch.equivalent, "Pa")
    if loads.axial_stress is not None:
        yield _peak("axial_stress", loads.axial_stress, "Pa")
    factors: dict[str, Factor | None] = {"yield_factor": loads.yield_factor, "fatigue_factor": loads.fatigue_factor}
    factors |= {f"notch_{number}_fatigue_factor": factor for number, factor in enumerate(loads.notch_factors, 1)}
    yield from (_factor(name, factor) for name, factor in factors.items() if factor is not None)
    yield from (_peak(name, peak, UNITS[name]) for name in NAMES if (peak := loads.peaks.get(name)) is not None)


def loads_document(loads: Loads | None) -> dict[str, dict[str, Any]]:
    """Quantity -> the other fields of its `Load`, for a JSON document; empty without loads."""
    documents = [vars(each) for each in numbers(loads)] if loads is not None else []
    return {one["quantity"]: {key: value for key, value in one.items() if key != "quantity"} for one in documents}


def numbers_of_case(case: CaseLoads) -> Iterator[tuple[str, Load]]:
    """All numbers of a case, each with its engine, or with "" where it needs none."""
    for engine, loads in case.loads.items():
        yield from ((engine, each) for each in numbers(loads))
    if case.resonance is not None:
        yield "", Load("mean_first_frequency", case.resonance.first_mode, "Hz", case.shift_of_motion)
        yield "", Load("frequency_ratio", case.resonance.ratio, "1", case.shift_of_motion / case.resonance.crank)


def _factor(name: str, factor: Factor) -> Load:
    if factor.lowest is None or factor.highest is None:
        return Load(name, factor.value, "1")
    if math.isinf(factor.highest):
        return Load(name, factor.value, "1", lowest=factor.lowest)
    return Load(name, factor.value, "1", factor.highest - factor.value, lowest=factor.lowest, highest=factor.highest)


def _peak(name: str, peak: Number, unit: str) -> Load:
    return Load(name, peak.value, unit, None if math.isnan(peak.error) else peak.error, peak.place, peak.crank_angle)
