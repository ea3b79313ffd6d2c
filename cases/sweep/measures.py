"""Measures of a settled motion: names, units, meanings, and the error of each number."""

import difflib
import math
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from functools import cached_property, partial
from types import MappingProxyType
from typing import Final

import numpy as np

from quickreturn.cases.errors import CaseError, as_written
from quickreturn.cases.loads import Claimed
from quickreturn.cases.loads.peak import Peak, of_column, of_vector
from quickreturn.cases.loads.stress import arm_stress
from quickreturn.cases.measures.cycle import HALVES
from quickreturn.cases.measures.extremes import extremes
from quickreturn.cases.measures.time_scale import CHANNELS
from quickreturn.cases.runs.request import PeriodicOrbit, Run
from quickreturn.reference_model.columns import COLUMNS
from quickreturn.reference_model.mechanism import Mechanism

#: Value and its error, in the measure's unit; nan where unavailable.
Measured = tuple[float, float]
NOTHING: Final[Measured] = (math.nan, math.nan)


@dataclass(frozen=True)
class SettledMotion:
    """A settled motion."""

    mechanism: Mechanism
    run: Run  # the same as `run` reports it
    finer: tuple[PeriodicOrbit, float] | None = None  # the orbit of finer settings, and its error over that of the run

    @cached_property
    def claim(self) -> Claimed:
        """By how much a column may be off at a crank angle, by the engine's own estimate."""
        return Claimed(self.run)


@dataclass(frozen=True)
class Measure:
    """A number that a study may ask for."""

    name: str  # as asked for
    unit: str  # SI
    meaning: str  # in words
    of: Callable[[SettledMotion], Measured]  # takes it
    columns: tuple[str, ...] = ()  # of the cycle that it needs
    vibration: bool = False  # whether the first mode must be fitted for it, which takes longest


def measure(name: str) -> Measure:
    """The measure of a name. Raises CaseError for an unknown one, with the nearest."""
    if name in MEASURES:
        return MEASURES[name]
    near = difflib.get_close_matches(name, MEASURES, 3, 0.4)
    accepted = f"the nearest are {', '.join(near)}" if near else "`quickreturn sweep --help` lists them"
    raise CaseError("measure", None, as_written(name), "is unknown", accepted)


def of_columns(name: str, unit: str) -> Iterator[Measure]:
    """The measures of a column of the trajectory."""
    kinds: tuple[tuple[str, str, Callable[[str, SettledMotion], Measured]], ...] = (
        ("peak", f"largest magnitude of {name} in a turn", _peak),
        ("min", f"least value of {name} in a turn", partial(_extreme, 0)),
        ("max", f"greatest value of {name} in a turn", partial(_extreme, 1)),
        ("rms", f"root mean square of {name} over a turn", _rms),
    )
    for kind, meaning, of in kinds:
        yield Measure(f"{kind}.{name}", unit, meaning, partial(_where_given, name, of), (name,))


def _where_given(column: str, of: Callable[[str, SettledMotion], Measured], motion: SettledMotion) -> Measured:
    """A measure of a column; `NOTHING` where the engine does not deliver it."""
    return of(column, motion) if column in motion.run.cycle else NOTHING


def _of_peak(peak: Peak | None) -> Measured:
    return NOTHING if peak is None else (peak.value, _known(peak.error))


def _peak(name: str, motion: SettledMotion) -> Measured:
    return _of_peak(of_column(name, motion.run.cycle, motion.claim))


def _bearing(name: str, motion: SettledMotion) -> Measured:
    return _of_peak(of_vector(name, motion.run.cycle, motion.claim))


def _stress(what: str, motion: SettledMotion) -> Measured:
    stress = arm_stress(motion.mechanism, motion.run.cycle, motion.claim)
    return _of_peak(None if stress is None else getattr(stress, what))


def _extreme(which: int, column: str, motion: SettledMotion) -> Measured:
    """The least (0) or greatest (1) value."""
    cycle = motion.run.cycle
    found = extremes(cycle["time"], cycle[column], cycle["time"][0], cycle["time"][-1])[which]
    return found.value, _known(motion.claim(column, float(np.interp(found.time, cycle["time"], cycle["crank_angle"])))) + found.uncertainty


def _rms(column: str, motion: SettledMotion) -> Measured:
    time, values = motion.run.cycle["time"], motion.run.cycle[column]
    return math.sqrt(float(np.trapezoid(values**2, time)) / float(time[-1] - time[0])), _largest_claim(motion, column)


def _per_turn(column: str, motion: SettledMotion) -> Measured:
    values = motion.run.cycle[column]
    return float(values[-1] - values[0]), 2.0 * _largest_claim(motion, column)


def _largest_claim(motion: SettledMotion, column: str) -> float:
    begin, end = motion.run.cycle["crank_angle"][[0, -1]]
    known = [motion.claim(column, float(begin + part * (end - begin))) for part in (0.25, 0.75)]
    return max(map(_known, known)) if None not in known else math.nan


def _consensus(half: str, motion: SettledMotion) -> Measured:
    found = next((each for each in motion.run.consensus if each.half == half), None)
    if found is None or found.first_mode_frequency is None:
        return NOTHING
    return found.first_mode_frequency, _known(found.first_mode_frequency_estimate) + _known(found.uncertainty)


def _vibration(half: str, channel: str, quantity: str, motion: SettledMotion) -> Measured:
    found = next((each for each in motion.run.measures if each.half == half and each.channel == channel), None)
    if found is None or (value := found.number(quantity)) is None:
        return NOTHING
    return value, _known(found.estimate(quantity)) + _known(found.number(f"{quantity}_uncertainty"))


def _of_orbit(number: Callable[[PeriodicOrbit], float], motion: SettledMotion) -> Measured:
    if motion.run.periodic_orbit is None:
        return NOTHING
    return _beside_finer(number(motion.run.periodic_orbit), number, motion)


def _period(motion: SettledMotion) -> Measured:
    time = motion.run.cycle["time"]
    return _beside_finer(float(time[-1] - time[0]), lambda orbit: orbit.period, motion)


def _beside_finer(value: float, number: Callable[[PeriodicOrbit], float], motion: SettledMotion) -> Measured:
    """A value with its error, estimated from the orbit with finer settings."""
    if motion.finer is None:
        return value, math.nan
    orbit, factor = motion.finer
    return value, abs(number(orbit) - value) / abs(1.0 - factor)


def _known(number: float | None) -> float:
    return math.nan if number is None else number


def _declared() -> Iterator[Measure]:
    for name, column in COLUMNS.items():
        if name != "time":
            yield from of_columns(name, column.unit)
    for name, where in (("pivot_force", "P"), ("crank_force", "O")):
        yield Measure(f"peak.{name}", "N", f"largest force of the bearing {where}", partial(_bearing, name), (f"{name}_x", f"{name}_y"))
    for name, what, meaning in (
        ("peak", "largest", "largest bending stress along the arm"),
        ("amplitude", "amplitude", "half the range of the stress in a turn, where that is largest"),
    ):
        yield Measure(f"{name}.stress", "Pa", meaning, partial(_stress, what), tuple(COLUMNS))
    for half in HALVES:
        meaning = f"frequency of the first mode, {half}-return, over all channels"
        yield Measure(f"{half}.frequency", "Hz", meaning, partial(_consensus, half), CHANNELS, True)
        for channel in CHANNELS:
            for what, unit, words in (("frequency", "Hz", "frequency"), ("amplitude", COLUMNS[channel].unit, "RMS of the envelope")):
                meaning = f"{words} of the first mode, {half}-return, in {channel}"
                of = partial(_vibration, half, channel, f"first_mode_{what}")
                yield Measure(f"{half}.{what}.{channel}", unit, meaning, of, CHANNELS, True)
    for name, meaning, number in (
        ("multiplier", "largest modulus of the Floquet multipliers", lambda orbit: math.hypot(*orbit.multipliers[0])),
        ("multiplier.real", "real part of that multiplier", lambda orbit: orbit.multipliers[0][0]),
        ("multiplier.imag", "imaginary part of that multiplier", lambda orbit: orbit.multipliers[0][1]),
    ):
        yield Measure(name, "1", meaning, partial(_of_orbit, number))
    yield Measure("period", "s", "time of a turn", _period)
    for name, meaning in (
        ("drive_work", "work of the drive, and of a force on the tip, in a turn"),
        ("dissipated_energy", "what the dampings take in a turn"),
    ):
        yield Measure(f"turn.{name}", "J", meaning, partial(_where_given, name, _per_turn), (name,))
    yield Measure("solve_seconds", "s", "wall time of the solve", lambda motion: (motion.run.solve_seconds or math.nan, math.nan))


#: Name -> measure, in the order in which they are listed.
MEASURES: Final[Mapping[str, Measure]] = MappingProxyType({each.name: each for each in _declared()})
