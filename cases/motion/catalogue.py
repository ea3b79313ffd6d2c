"""The catalogue of measures of a settled motion: name, unit, meaning, and the number with its error.

`run` with its JSON document and the page's tables, `sweep`, and the resonance curve take their measures from here.
"""

import difflib
import math
import re
from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property, partial
from types import MappingProxyType
from typing import Final

import numpy as np

from quickreturn.cases.files.errors import Argument, CaseError, as_written
from quickreturn.cases.loads import Claimed, Factor, Loads, drive, loads_of
from quickreturn.cases.loads.drive import Turn
from quickreturn.cases.loads.peak import of_vector
from quickreturn.cases.loads.stress import ArmStress
from quickreturn.cases.motion.cycle import HALVES
from quickreturn.cases.motion.estimates import NUMBER, TIME
from quickreturn.cases.motion.extremes import extremes
from quickreturn.cases.motion.number import NO_NUMBER, Number
from quickreturn.cases.motion.of_turn import OF_TURN, OfTurn, TableColumn, by_spacing, harmonic_parts, mean_speed, rms_over_time
from quickreturn.cases.motion.request import PeriodicOrbit, Run
from quickreturn.cases.motion.time_scale import CHANNELS
from quickreturn.reference_model.columns import AXIAL, COLUMNS
from quickreturn.reference_model.mechanism import Mechanism

ARGUMENT: Final = Argument("measures")

#: Meaning of the measure `multiplier`.
MULTIPLIER: Final = "largest modulus of the Floquet multipliers of crank speed and the two lowest modes (higher modes may ring longer)"
#: Part of a fit's uncertainty that counts as error, besides the difference from the fit to the finer run's motion. Fits to nearly equal
#: motions share nearly all of it: with this part 698 frequencies and amplitudes of 40 machines were off by at most 0.8 of the claim.
FITTED: Final = 0.1
#: Relative round-off of the instants at which a turn begins and ends.
ROUND_OFF: Final = 1e-12
#: Error of a size over the size above which it says nothing.
SAYS_NOTHING: Final = 0.5
#: Part of the last step of the search for a periodic motion that is left as its error, see `ORBIT_TOLERANCE` of `reference`.
LEFT_BY_SEARCH: Final = 0.1


@dataclass(frozen=True)
class SettledMotion:
    """A settled motion: a machine, and the run that shows it."""

    mechanism: Mechanism
    run: Run
    _extremes: dict[str, tuple[Number, Number]] = field(default_factory=dict, init=False, repr=False, compare=False)

    @cached_property
    def claim(self) -> Claimed:
        """Error of a column at a crank angle, by the engine's own estimate."""
        return Claimed(self.run)

    @cached_property
    def loads(self) -> Loads:
        """Loads on the parts, with the stress along the arm."""
        return loads_of(self.mechanism, self.run.cycle, self.claim)

    def extremes(self, column: str) -> tuple[Number, Number]:
        """Least and greatest value of a column that the engine gives."""
        if column not in self._extremes:
            cycle = self.run.cycle
            ((low, high),) = extremes(cycle["time"], cycle[column])
            self._extremes[column] = self._claimed(column, low), self._claimed(column, high)
        return self._extremes[column]

    def _claimed(self, column: str, extreme: Number) -> Number:
        angle = float(np.interp(extreme.time, self.run.cycle["time"], self.run.cycle["crank_angle"]))
        return replace(extreme, estimate=self.claim(column, angle), crank_angle=angle % (2.0 * math.pi))


@dataclass(frozen=True)
class Measure:
    """A number of a settled motion."""

    name: str  # as asked for
    unit: str  # SI
    meaning: str  # in words
    of: Callable[[SettledMotion], Number]  # computes it; `NO_NUMBER` where the motion has none
    columns: tuple[str, ...] = ()  # columns of the cycle that it needs
    vibration: bool = False  # whether the first mode must be fitted for it, which takes longest
    multipliers: bool = False  # whether it needs the multiplier of the whole model, which takes some more turns
    size: bool = False  # whether it is a size: an error as large as `SAYS_NOTHING` of it leaves nothing of the number
    of_material: bool = False  # whether it depends on strengths or notches, which move nothing
    in_tables: TableColumn | None = None  # how the tables of a run show it; None: not at all

    def says_nothing(self, value: float, error: float) -> str:
        """Why a number with its error says nothing (a clause); "" if it says something, or if the error is unknown."""
        if not self.size or not error > SAYS_NOTHING * abs(value) > 0.0:
            return ""
        return f"the error of {self.name} is {error / abs(value):.2g} times its value, which says nothing"


def measure(name: str) -> Measure:
    """The measure of a name. CaseError: it is unknown; the nearest are named."""
    if name in MEASURES:
        return MEASURES[name]
    near = difflib.get_close_matches(name, MEASURES, 3, 0.4)
    accepted = f"the nearest are {', '.join(near)}" if near else "`quickreturn sweep --help` lists them"
    raise CaseError(ARGUMENT, None, as_written(name), "is unknown", accepted)


def of_columns(name: str, unit: str) -> Iterator[Measure]:
    """The measures of a column of the trajectory."""
    kinds: tuple[tuple[str, str, Callable[[str, SettledMotion], Number]], ...] = (
        ("peak", f"largest magnitude of {name} in a turn", _peak),
        ("min", f"least value of {name} in a turn", partial(_extreme, 0)),
        ("max", f"greatest value of {name} in a turn", partial(_extreme, 1)),
        ("rms", f"root mean square of {name} over a turn", _rms),
    )
    for kind, meaning, of in kinds:
        yield Measure(f"{kind}.{name}", unit, meaning, partial(_where_given, name, of), (name,), size=kind in ("peak", "rms"))


def _where_given(column: str, of: Callable[[str, SettledMotion], Number], motion: SettledMotion) -> Number:
    """A measure of a column; `NO_NUMBER` if the engine does not deliver it, or for the angle of a follower that turns fully."""
    grows = column == "follower_angle" and motion.mechanism.turns_fully
    return of(column, motion) if column in motion.run.cycle and not grows else NO_NUMBER


def _peak(column: str, motion: SettledMotion) -> Number:
    largest = max(motion.extremes(column), key=lambda extreme: abs(extreme.value))
    return replace(largest, value=abs(largest.value))


def _extreme(which: int, column: str, motion: SettledMotion) -> Number:
    """The least (0) or greatest (1) value."""
    return motion.extremes(column)[which]


def _bearing(name: str, motion: SettledMotion) -> Number:
    return of_vector(name, motion.run.cycle, motion.claim) or NO_NUMBER


def _stress(number: Callable[[ArmStress], Number], motion: SettledMotion) -> Number:
    return NO_NUMBER if motion.loads.stress is None else number(motion.loads.stress)


def _axial_stress(motion: SettledMotion) -> Number:
    return motion.loads.axial_stress or NO_NUMBER


def _factor(name: str, motion: SettledMotion) -> Number:
    """A safety factor, with the error to the farther end of its interval; `NO_NUMBER` where the strength is not given."""
    factor: Factor | None = getattr(motion.loads, name)
    return NO_NUMBER if factor is None else Number(factor.value, None if factor.highest is None else factor.highest - factor.value)


def _rms(column: str, motion: SettledMotion) -> Number:
    def rms(turn: Turn) -> float:
        return rms_over_time(turn["time"], turn[column])

    value, spacing = rms(motion.run.cycle), by_spacing(rms, motion.run.cycle, ("time", column))
    return Number(value, _estimate(motion, column, "rms"), spacing, settling=_left(motion) * value)


def _per_turn(column: str, motion: SettledMotion) -> Number:
    """Change of a column in a turn."""
    values = motion.run.cycle[column]
    return Number(float(values[-1] - values[0]), _estimate(motion, column, "change"), settling=_left(motion) * float(np.ptp(values)))


def _of_turn(declared: OfTurn, motion: SettledMotion) -> Number:
    if not {*declared.columns} <= motion.run.cycle.keys() or (declared.prescribed and motion.mechanism.crank_is_free):
        return NO_NUMBER
    turn = drive.at_shaft(motion.run.cycle, drive.crank_damping(motion.mechanism))
    value, spacing = declared.of(turn), declared.by_spacing(turn)
    # of a motor's torque little may be left at the shaft: it settles as the whole does
    scale = abs((declared.scale or declared.of)(motion.run.cycle))
    return Number(value, _estimate(motion, declared.name, NUMBER), spacing, settling=_left(motion) * scale)


def _harmonic(order: int, is_phase: bool, motion: SettledMotion) -> Number:
    """Amplitude of a harmonic of the torque, or its phase; the error of both parts counts in full."""
    cosine, sine = (_of_turn(part, motion) for part in harmonic_parts(order))
    amplitude = math.hypot(cosine.value, sine.value)
    estimate = None if cosine.estimate is None or sine.estimate is None else cosine.estimate + sine.estimate
    number = Number(amplitude, estimate, cosine.measurement + sine.measurement, cosine.settling + sine.settling)
    if not is_phase:
        return number
    return replace(number.times(1.0 / amplitude), value=math.atan2(sine.value, cosine.value)) if amplitude > 0.0 else NO_NUMBER


def _power(sign: float, motion: SettledMotion) -> Number:
    """Largest power that the drive gives (1) or takes back (-1), W; 0 where it never does."""
    if not {*drive.POWER} <= motion.run.cycle.keys():
        return NO_NUMBER
    damping = drive.crank_damping(motion.mechanism)
    cycle = drive.at_shaft(motion.run.cycle, damping)
    ((_, largest),) = extremes(cycle["time"], sign * drive.drive_power(cycle))
    angle = float(np.interp(largest.time, cycle["time"], cycle["crank_angle"]))
    errors = [motion.claim(column, angle) for column in drive.POWER]
    torque, speed = (float(np.abs(cycle[column]).max()) for column in drive.POWER)
    sizes = speed, torque + damping * speed
    estimate = None if None in errors else sum(error * size for error, size in zip(errors, sizes, strict=True) if error is not None)
    return replace(largest, value=max(0.0, largest.value), estimate=estimate, crank_angle=angle % (2.0 * math.pi))


def _flywheel(motion: SettledMotion) -> Number:
    """Inertia about O for the wanted fluctuation of the crank's speed (`cases.loads.drive`)."""
    wanted, energy = motion.mechanism.crank.wanted_fluctuation, MEASURES["flywheel.energy"].of(motion)
    return NO_NUMBER if wanted is None else energy.times(1.0 / (wanted * mean_speed(motion.run.cycle) ** 2))


def _estimate(motion: SettledMotion, name: str, what: str) -> float | None:
    """The engine's estimate of the error of a number over a turn (`Run.turn_estimates`); None if it has none."""
    return motion.run.measured.turn_estimates.get(name, {}).get(what)


def _left(motion: SettledMotion) -> float:
    """Relative distance from the steady state."""
    part = 1.0 if motion.run.approach.periodic_orbit is None else LEFT_BY_SEARCH
    return part * (motion.run.approach.settling_error or 0.0)


def _consensus(half: str, motion: SettledMotion) -> Number:
    consensus = motion.run.consensus_of(half)
    return _fitted(None if consensus is None else consensus.number)


def _vibration(half: str, channel: str, quantity: str, motion: SettledMotion) -> Number:
    measure = motion.run.measure(half, channel)
    return _fitted(None if measure is None else measure.number(quantity))


def _fitted(number: Number | None) -> Number:
    return NO_NUMBER if number is None else replace(number, measurement=FITTED * number.measurement)


def _multiplier(number: Callable[[PeriodicOrbit], tuple[float, float | None]], motion: SettledMotion) -> Number:
    orbit = motion.run.approach.periodic_orbit
    if orbit is None:
        return NO_NUMBER
    return Number(*number(orbit))


def _period(motion: SettledMotion) -> Number:
    time = motion.run.cycle["time"]
    value = float(time[-1] - time[0])
    left = _left(motion) if motion.mechanism.crank_is_free else ROUND_OFF
    return Number(value, _estimate(motion, TIME, "change"), settling=left * value)


def _solve_seconds(motion: SettledMotion) -> Number:
    return Number(motion.run.computation.solve_seconds or math.nan)


def _declared() -> Iterator[Measure]:
    for name, column in COLUMNS.items():
        if name != "time":
            yield from of_columns(name, column.unit)
    for name, where in (("pivot_force", "P"), ("crank_force", "O")):
        yield Measure(
            f"peak.{name}", "N", f"largest force of the bearing {where}", partial(_bearing, name), (f"{name}_x", f"{name}_y"), size=True
        )
    stresses: tuple[tuple[str, str, Callable[[ArmStress], Number]], ...] = (
        ("peak", "largest stress along the arm, by bending and the normal force", lambda stress: stress.largest),
        ("amplitude", "half the range of the stress in a turn, where that is largest", lambda stress: stress.amplitude),
    )
    for name, meaning, of in stresses:
        yield Measure(f"{name}.stress", "Pa", meaning, partial(_stress, of), tuple(COLUMNS), size=True)
    meaning = "largest magnitude of the stress along the arm by the normal force alone"
    yield Measure("peak.axial_stress", "Pa", meaning, _axial_stress, AXIAL, size=True)
    of_fatigue: tuple[tuple[str, str, str, Callable[[SettledMotion], Number]], ...] = (
        (
            *("equivalent.stress", "Pa", "amplitude of the fully reversed stress that is as bad as the worst cycle, with notches and mean"),
            partial(_stress, lambda stress: stress.fatigue.equivalent),
        ),
        (
            *("cycles.stress", "1", "cycles of stress in a turn where it is worst for fatigue, by rainflow counting"),
            partial(_stress, lambda stress: Number(float(len(stress.fatigue.ranges)), 0.0)),
        ),
        ("factor.yielding", "1", "yield strength over the largest stress", partial(_factor, "yield_factor")),
        ("factor.fatigue", "1", "fatigue strength over the equivalent stress", partial(_factor, "fatigue_factor")),
    )
    for name, unit, meaning, taken in of_fatigue:
        yield Measure(name, unit, meaning, taken, tuple(COLUMNS), of_material=True)
    for half in HALVES:
        meaning = f"frequency of the first mode, {half}-return, over all channels"
        in_tables = TableColumn(f"f₁ {half}", ".2f", in_terminal=".3f")
        yield Measure(f"{half}.frequency", "Hz", meaning, partial(_consensus, half), CHANNELS, True, in_tables=in_tables)
        for channel in CHANNELS:
            for what, unit, words in (("frequency", "Hz", "frequency"), ("amplitude", COLUMNS[channel].unit, "RMS of the envelope")):
                meaning = f"{words} of the first mode, {half}-return, in {channel}"
                of = partial(_vibration, half, channel, f"first_mode_{what}")
                yield Measure(f"{half}.{what}.{channel}", unit, meaning, of, CHANNELS, True)
    for name, meaning, number in (
        ("multiplier", MULTIPLIER, lambda orbit: (math.hypot(*orbit.multipliers[0]), orbit.multiplier_error)),
        ("multiplier.real", "real part of that multiplier", lambda orbit: (orbit.multipliers[0][0], orbit.multiplier_distance)),
        ("multiplier.imag", "imaginary part of that multiplier", lambda orbit: (orbit.multipliers[0][1], orbit.multiplier_distance)),
    ):
        yield Measure(name, "1", meaning, partial(_multiplier, number), multipliers=True)
    yield Measure("period", "s", "time of a turn", _period)
    for name, meaning in (
        ("drive_work", "work of the drive, and of a force on the tip, in a turn"),
        ("dissipated_energy", "energy dissipated in a turn"),
    ):
        yield Measure(f"turn.{name}", "J", meaning, partial(_where_given, name, _per_turn), (name,))
    for sign, name, does in ((1.0, "drive_power", "gives"), (-1.0, "returned_power", "takes back")):
        meaning, needs = f"largest power that the drive {does} in a turn", ("time", "crank_angle", *drive.POWER)
        yield Measure(f"peak.{name}", "W", meaning, partial(_power, sign), needs)
    for order in range(1, drive.HARMONICS + 1):
        of_order, (part, _) = f"harmonic {order} of the drive's torque over the crank angle", harmonic_parts(order)
        for ending, unit, meaning in (
            ("", "N m", f"amplitude of {of_order}"),
            (".phase", "rad", f"{order} times the crank angle at which {of_order} is largest"),
        ):
            of = partial(_harmonic, order, bool(ending))
            yield Measure(f"torque.harmonic_{order}{ending}", unit, meaning, of, part.columns)
    yield Measure(
        "flywheel.inertia",
        "kg m^2",
        "inertia about O of crank and flywheel with which the speed fluctuates by crank.wanted_fluctuation under a motor's constant torque",
        _flywheel,
        (*drive.POWER, "time", "crank_angle"),
    )
    for one in OF_TURN:
        of = partial(_of_turn, one)
        yield Measure(one.name, one.unit, one.meaning, of, one.columns, size=one.size, in_tables=one.in_tables)
    yield Measure("solve_seconds", "s", "wall time of the solve", _solve_seconds)


#: Name -> measure, in the order in which they are listed.
MEASURES: Final[Mapping[str, Measure]] = MappingProxyType({each.name: each for each in _declared()})


#: The measures that the tables of a run show.
IN_TABLES: Final = {name: each.in_tables for name, each in MEASURES.items() if each.in_tables is not None}


def numbers(mechanism: Mechanism, run: Run, names: Iterable[str] = MEASURES) -> dict[str, Number]:
    """Some numbers of a run by the names of their measures; empty if it has no usable cycle."""
    motion = SettledMotion(mechanism, run)
    return {name: MEASURES[name].of(motion) for name in names} if run.usable else {}


def listed() -> list[Measure]:
    """The measures for a list: those that every column of a trajectory has stand there once, for COLUMN, those of a harmonic for N."""
    of_every_column = {each.name for name in COLUMNS for each in of_columns(name, "")}
    chosen = [each for name, each in MEASURES.items() if name not in of_every_column and not re.search(r"harmonic_(?!1)", name)]
    harmonics = ("harmonic_1", "harmonic_N"), ("harmonic 1", f"harmonic N (1 to {drive.HARMONICS})"), ("1 times", "N times")
    for one, general in harmonics:
        chosen = [replace(each, name=each.name.replace(one, general), meaning=each.meaning.replace(one, general)) for each in chosen]
    return [*of_columns("COLUMN", "the column's unit"), *chosen]
