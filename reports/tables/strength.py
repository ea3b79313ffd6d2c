"""Loads on the parts of a machine: a row for each number of each engine on each case."""

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Any, Final

from quickreturn.cases.loads import UNITS, Factor, Loads, Peak
from quickreturn.reports.findings.loads import CaseLoads
from quickreturn.reports.tables.table import CASE, Cell, Column, ColumnList, Table
from quickreturn.reports.words import TIED, off_by, quantity, span

#: Number -> its name and unit in the page.
NAMES: Final = {
    "stress": ("largest stress", "MPa"),
    "strain": ("the same as strain", "µε"),
    "stress_amplitude": ("stress amplitude", "MPa"),
    "stress_mean": ("mean stress there", "MPa"),
    "yield_factor": ("safety against yielding", ""),
    "fatigue_factor": ("safety against fatigue", ""),
    "crank_torque": ("torque of the drive", "N m"),
    "pivot_force": ("force in the bearing P", "N"),
    "crank_force": ("force in the bearing O", "N"),
    "slider_force": ("force at the slider", "N"),
    "tip_deflection": ("deflection of the tip", "mm"),
    "mean_first_frequency": ("first mode, mean over the turn", "Hz"),
    "frequency_ratio": ("the same over the crank's frequency", ""),
}


@dataclass(frozen=True)
class Number:
    """A load; fields that are unknown, or that it does not have, are None."""

    quantity: str  # key of `NAMES`
    value: float  # the number
    unit: str  # SI
    error: float | None = None  # estimated error, SI; of a safety factor the farther end of its interval, None where that has none
    place: float | None = None  # arc length from P, m
    crank_angle: float | None = None  # rad, from 0 to a turn
    lowest: float | None = None  # least and greatest value of a safety factor by the stress's error
    highest: float | None = None  # None where it has no bound


def numbers(loads: Loads) -> Iterator[Number]:
    """All numbers of an engine's loads."""
    if loads.stress is not None:
        yield _peak("stress", loads.stress.largest, "Pa")
        if loads.strain is not None:
            yield _peak("strain", loads.strain, "1")
        yield _peak("stress_amplitude", loads.stress.amplitude, "Pa")
        yield Number("stress_mean", loads.stress.mean, "Pa", place=loads.stress.amplitude.place)
    factors: dict[str, Factor | None] = {"yield_factor": loads.yield_factor, "fatigue_factor": loads.fatigue_factor}
    yield from (_factor(name, factor) for name, factor in factors.items() if factor is not None)
    yield from (_peak(name, peak, UNITS[name]) for name in NAMES if (peak := loads.peaks.get(name)) is not None)


def document(loads: Loads | None) -> dict[str, dict[str, Any]]:
    """Quantity -> the other fields of its `Number`, for a JSON document; empty without loads."""
    documents = [vars(number) for number in numbers(loads)] if loads is not None else []
    return {one["quantity"]: {key: value for key, value in one.items() if key != "quantity"} for one in documents}


def of_case(case: CaseLoads) -> Iterator[tuple[str, Number]]:
    """All numbers of a case, each with its engine, or with "" where it needs none."""
    for engine, loads in case.loads.items():
        yield from ((engine, number) for number in numbers(loads))
    if case.resonance is not None:
        yield "", Number("mean_first_frequency", case.resonance.first_mode, "Hz", case.shift_of_motion)
        yield "", Number("frequency_ratio", case.resonance.ratio, "1", case.shift_of_motion / case.resonance.crank)


def strength(cases: Sequence[CaseLoads]) -> Table:
    """All numbers of all cases."""
    columns: ColumnList = (
        *(CASE, "engine", Column("quantity", words=lambda name: NAMES[name][0])),
        Column("value", unit="[SI]", form=".4g"),
        Column("error", "off by", unit="[SI]", form=".2g", meaning="by the spacing of rows and places, and the engine's own estimate"),
        Column("unit", in_page=False),
        Column("place", "from P", "mm", ".0f", meaning="arc length"),
        Column("crank_angle", "crank at", "°", ".0f"),
        Column("lowest", in_page=False),
        Column("highest", in_page=False),
    )
    table = Table("strength", columns)
    for case in cases:
        for engine, number in of_case(case):
            text = quantity(number.value, NAMES[number.quantity][1]).strip(TIED)
            error = Cell(number.error, _off(number))
            table.add(number, case=case.case.name, engine=engine, value=Cell(number.value, text), error=error)
    return table


def _off(number: Number) -> str:
    """The error in words; of a safety factor its interval, which is not even about the value."""
    if number.lowest is not None:
        return f"{number.lowest:.3g} or more" if number.highest is None else span(number.lowest, number.highest, ".3g")
    return "" if number.error is None else off_by(number.error, number.value)


def _factor(name: str, factor: Factor) -> Number:
    if factor.lowest is None or factor.highest is None:
        return Number(name, factor.value, "1")
    if math.isinf(factor.highest):
        return Number(name, factor.value, "1", lowest=factor.lowest)
    return Number(name, factor.value, "1", factor.highest - factor.value, lowest=factor.lowest, highest=factor.highest)


def _peak(name: str, peak: Peak, unit: str) -> Number:
    return Number(name, peak.value, unit, peak.error, peak.place, peak.crank_angle)
