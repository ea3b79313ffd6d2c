"""What a study may measure of a settled motion: names, units, meanings, and how far off each number may be."""

import difflib
import math
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from functools import cached_property
from types import MappingProxyType
from typing import Final

import numpy as np

from cases.errors import CaseError, as_written
from cases.loads import Claimed
from cases.loads.peak import Peak, of_column, of_vector
from cases.loads.stress import arm_stress
from cases.measures import CHANNELS
from cases.measures.cycle import HALVES
from cases.measures.extremes import extremes
from cases.runs.request import PeriodicOrbit, Run
from reference_model.columns import COLUMNS
from reference_model.mechanism import Mechanism

#: Value and how far off it may be, in the measure's unit; nan where not to be had.
Measured = tuple[float, float]
NOTHING: Final[Measured] = (math.nan, math.nan)


@dataclass(frozen=True)
class Motion:
    """A settled motion.

    Attributes:
        mechanism: the scene.
        run: what is known of it, as `run` would tell it.
        finer: the orbit that finer settings lead to, and its error over that of the run; None where there is none.
    """

    mechanism: Mechanism
    run: Run
    finer: tuple[PeriodicOrbit, float] | None = None

    @cached_property
    def claim(self) -> Claimed:
        """By how much a column may be off at a crank angle, by the engine's own estimate."""
        return Claimed(self.run)


@dataclass(frozen=True)
class Measure:
    """A number that a study may ask for.

    Attributes:
        name: as asked for.
        unit: SI.
        meaning: in words.
        of: takes it.
        columns: of the cycle that it needs.
        vibration: whether the first mode must be fitted for it, which takes longest.
    """

    name: str
    unit: str
    meaning: str
    of: Callable[[Motion], Measured]
    columns: tuple[str, ...] = ()
    vibration: bool = False


def measure(name: str) -> Measure:
    """The measure of a name. Raises CaseError for an unknown one, with the nearest."""
    if name in MEASURES:
        return MEASURES[name]
    near = difflib.get_close_matches(name, MEASURES, 3, 0.4)
    accepted = f"the nearest are {', '.join(near)}" if near else "`quickreturn sweep --help` lists them"
    raise CaseError("measure", None, as_written(name), "is unknown", accepted)


def _of_peak(peak: Peak | None) -> Measured:
    if peak is None:
        return NOTHING
    return peak.value, math.nan if peak.error is None else peak.error


def _peak(name: str) -> Callable[[Motion], Measured]:
    """Of the magnitude of a column, or of the vector whose parts are the columns `name`_x and `name`_y."""
    return lambda motion: _of_peak((of_column if name in COLUMNS else of_vector)(name, motion.run.cycle, motion.claim))


def _extreme(column: str, which: int) -> Callable[[Motion], Measured]:
    """The least (0) or greatest (1) value."""

    def of(motion: Motion) -> Measured:
        cycle = motion.run.cycle
        if column not in cycle:
            return NOTHING
        found = extremes(cycle["time"], cycle[column], cycle["time"][0], cycle["time"][-1])[which]
        estimate = motion.claim(column, float(np.interp(found.time, cycle["time"], cycle["crank_angle"])))
        return found.value, math.nan if estimate is None else found.uncertainty + estimate

    return of


def _rms(column: str) -> Callable[[Motion], Measured]:
    def of(motion: Motion) -> Measured:
        cycle = motion.run.cycle
        if column not in cycle:
            return NOTHING
        time = cycle["time"]
        return math.sqrt(float(np.trapezoid(cycle[column] ** 2, time)) / float(time[-1] - time[0])), _largest_claim(motion, column)

    return of


def _per_turn(column: str) -> Callable[[Motion], Measured]:
    def of(motion: Motion) -> Measured:
        cycle = motion.run.cycle
        if column not in cycle:
            return NOTHING
        return float(cycle[column][-1] - cycle[column][0]), 2.0 * _largest_claim(motion, column)

    return of


def _largest_claim(motion: Motion, column: str) -> float:
    begin, end = motion.run.cycle["crank_angle"][[0, -1]]
    known = [motion.claim(column, float(begin + part * (end - begin))) for part in (0.25, 0.75)]
    return max((each for each in known if each is not None), default=math.nan) if None not in known else math.nan


def _consensus(half: str) -> Callable[[Motion], Measured]:
    def of(motion: Motion) -> Measured:
        found = next((each for each in motion.run.consensus if each.half == half), None)
        if found is None or found.first_mode_frequency is None:
            return NOTHING
        return found.first_mode_frequency, _sum(found.first_mode_frequency_estimate, found.uncertainty)

    return of


def _vibration(half: str, channel: str, quantity: str) -> Callable[[Motion], Measured]:
    def of(motion: Motion) -> Measured:
        found = next((each for each in motion.run.measures if each.half == half and each.channel == channel), None)
        if found is None or (value := found.number(quantity)) is None:
            return NOTHING
        return value, _sum(found.estimate(quantity), found.number(f"{quantity}_uncertainty"))

    return of


def _sum(estimate: float | None, uncertainty: float | None) -> float:
    return math.nan if estimate is None or uncertainty is None else estimate + uncertainty


def _of_orbit(number: Callable[[PeriodicOrbit], float]) -> Callable[[Motion], Measured]:
    def of(motion: Motion) -> Measured:
        if motion.run.periodic_orbit is None:
            return NOTHING
        value = number(motion.run.periodic_orbit)
        if motion.finer is None:
            return value, math.nan
        orbit, factor = motion.finer
        return value, abs(number(orbit) - value) / abs(1.0 - factor)

    return of


def _period(motion: Motion) -> Measured:
    time = motion.run.cycle["time"]
    period = float(time[-1] - time[0])
    if motion.finer is None:
        return period, math.nan
    orbit, factor = motion.finer
    return period, abs(orbit.period - period) / abs(1.0 - factor)


def _of_column(name: str, unit: str) -> Iterator[Measure]:
    yield Measure(f"peak.{name}", unit, f"largest magnitude of {name} in a turn", _peak(name), (name,))
    yield Measure(f"min.{name}", unit, f"least value of {name} in a turn", _extreme(name, 0), (name,))
    yield Measure(f"max.{name}", unit, f"greatest value of {name} in a turn", _extreme(name, 1), (name,))
    yield Measure(f"rms.{name}", unit, f"root mean square of {name} over a turn", _rms(name), (name,))


def _of_half(half: str) -> Iterator[Measure]:
    yield Measure(
        f"{half}.frequency", "Hz", f"frequency of the first mode, {half}-return, over all channels", _consensus(half), CHANNELS, True
    )
    for channel in CHANNELS:
        where = f"of the first mode, {half}-return, in {channel}"
        frequency, amplitude = (_vibration(half, channel, f"first_mode_{quantity}") for quantity in ("frequency", "amplitude"))
        yield Measure(f"{half}.frequency.{channel}", "Hz", f"frequency {where}", frequency, CHANNELS, True)
        yield Measure(f"{half}.amplitude.{channel}", COLUMNS[channel].unit, f"RMS of the envelope {where}", amplitude, CHANNELS, True)


def _of_stress(what: str) -> Callable[[Motion], Measured]:
    def of(motion: Motion) -> Measured:
        stress = arm_stress(motion.mechanism, motion.run.cycle, motion.claim)
        return _of_peak(None if stress is None else getattr(stress, what))

    return of


def _declared() -> Iterator[Measure]:
    for name, column in COLUMNS.items():
        if name != "time":
            yield from _of_column(name, column.unit)
    for name, where in (("pivot_force", "P"), ("crank_force", "O")):
        yield Measure(f"peak.{name}", "N", f"largest force of the bearing {where}", _peak(name), (f"{name}_x", f"{name}_y"))
    yield Measure("peak.stress", "Pa", "largest bending stress along the arm", _of_stress("largest"), tuple(COLUMNS))
    yield Measure(
        "amplitude.stress", "Pa", "half the range of the stress in a turn, where that is largest", _of_stress("amplitude"), tuple(COLUMNS)
    )
    for half in HALVES:
        yield from _of_half(half)
    yield Measure(
        "multiplier", "1", "largest modulus of the Floquet multipliers", _of_orbit(lambda orbit: math.hypot(*orbit.multipliers[0]))
    )
    yield Measure("multiplier.real", "1", "real part of that multiplier", _of_orbit(lambda orbit: orbit.multipliers[0][0]))
    yield Measure("multiplier.imag", "1", "imaginary part of that multiplier", _of_orbit(lambda orbit: orbit.multipliers[0][1]))
    yield Measure("period", "s", "time of a turn", _period)
    yield Measure(
        "turn.drive_work", "J", "work of the drive, and of a force on the tip, in a turn", _per_turn("drive_work"), ("drive_work",)
    )
    dissipated = "dissipated_energy"
    yield Measure(f"turn.{dissipated}", "J", "what the dampings take in a turn", _per_turn(dissipated), (dissipated,))
    yield Measure("solve_seconds", "s", "wall time of the solve", lambda motion: (motion.run.solve_seconds or math.nan, math.nan))


#: Name -> measure, in the order in which they are listed.
MEASURES: Final[Mapping[str, Measure]] = MappingProxyType({each.name: each for each in _declared()})
