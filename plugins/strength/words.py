"""Loads on the parts by one engine: their numbers with names, and sentences on them."""

import math
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any, Final

from quickreturn.cases.files.case import Case
from quickreturn.cases.files.shown import Unit, Units
from quickreturn.cases.files.units import in_si
from quickreturn.cases.motion.number import Number
from quickreturn.plugins.strength.loads import UNITS, Loads
from quickreturn.plugins.strength.stress import Factor
from quickreturn.reports.words import TIED, degrees, number, off_by, quantity, size

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
    "pivot_force": "force in the bearing P of the arm",
    "crank_force": "force in the bearing O of the crank",
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


def verdict(loads: Loads) -> str:
    """Whether the arm holds (a sentence), not judged by a stress with an error of tens of percent; "" where no strength is given."""
    both = {"yielding": loads.yield_factor, "fatigue": loads.fatigue_factor}
    if not (factors := {against: factor for against, factor in both.items() if factor is not None}):
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


def _factor(name: str, factor: Factor) -> Load:
    if factor.lowest is None or factor.highest is None:
        return Load(name, factor.value, "1")
    if math.isinf(factor.highest):
        return Load(name, factor.value, "1", lowest=factor.lowest)
    return Load(name, factor.value, "1", factor.highest - factor.value, lowest=factor.lowest, highest=factor.highest)


def _peak(name: str, peak: Number, unit: str) -> Load:
    return Load(name, peak.value, unit, None if math.isnan(peak.error) else peak.error, peak.place, peak.crank_angle)
