"""The catalogue of measures of a settled motion: name, unit, meaning, and the number with its error.

`run` with its JSON document and the page's tables, `sweep`, and the resonance curve take their measures from here.
"""

import difflib
import math
import re
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import replace
from functools import partial
from itertools import starmap
from types import MappingProxyType
from typing import Final

import numpy as np

from quickreturn.cases.files.errors import Argument, CaseError, as_written
from quickreturn.cases.motion.cycle import HALVES, VIBRATION
from quickreturn.cases.motion.estimates import TIME
from quickreturn.cases.motion.measure import Measure, SettledMotion, number_of
from quickreturn.cases.motion.number import NO_NUMBER, Number
from quickreturn.cases.motion.of_turn import OF_TURN, OfTurn, TableColumn, Turn, by_spacing, of_plugins, rms_over_time
from quickreturn.cases.motion.request import PeriodicOrbit, Run
from quickreturn.cases.motion.time_scale import CHANNELS
from quickreturn.reference_model.columns import COLUMNS
from quickreturn.reference_model.mechanism import Mechanism

ARGUMENT: Final = Argument("measures")

#: Meaning of the measure `multiplier`.
MULTIPLIER: Final = "largest modulus of the Floquet multipliers of crank speed and the two lowest modes (higher modes may ring longer)"
#: Part of a fit's uncertainty that counts as error, besides the difference from the fit to the finer run's motion. Fits to nearly equal
#: motions share nearly all of it: with this part 698 frequencies and amplitudes of 40 machines were off by at most 0.8 of the claim.
FITTED: Final = 0.1
#: Relative round-off of the instants at which a turn begins and ends.
ROUND_OFF: Final = 1e-12


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


def _rms(column: str, motion: SettledMotion) -> Number:
    def rms(turn: Turn) -> float:
        return rms_over_time(turn["time"], turn[column])

    spacing = by_spacing(rms, motion.cycle, ("time", column))
    return Number(rms(motion.cycle), motion.estimate(column, "rms"), spacing, settling=motion.left * rms(motion.run.cycle))


def _per_turn(column: str, motion: SettledMotion) -> Number:
    """Change of a column in a turn."""
    values, size = motion.cycle[column], float(np.ptp(motion.run.cycle[column]))
    return Number(float(values[-1] - values[0]), motion.estimate(column, "change"), settling=motion.left * size)


def _consensus(half: str, motion: SettledMotion) -> Number:
    consensus = motion.run.consensus_of(half)
    number = None if consensus is None else consensus.number
    if number is None:
        return NO_NUMBER
    channels = [each for name in CHANNELS if (each := motion.run.number(VIBRATION[0], half, name)) is not None]
    weights = np.array([each.measurement for each in channels]) ** -2.0
    left = float(weights @ [each.settling for each in channels] / weights.sum())
    return _fitted(replace(number, settling=left))


def _vibration(half: str, channel: str, quantity: str, motion: SettledMotion) -> Number:
    return _fitted(motion.run.number(quantity, half, channel))


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
    left = motion.left if motion.mechanism.crank_is_free else ROUND_OFF
    return Number(value, motion.estimate(TIME, "change"), settling=left * value)


def _solve_seconds(motion: SettledMotion) -> Number:
    return Number(motion.run.computation.solve_seconds or math.nan)


def _declared() -> Iterator[Measure]:
    for name, column in COLUMNS.items():
        if name != "time":
            yield from of_columns(name, column.unit)
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
    for one in (*OF_TURN, *of_plugins()):
        if isinstance(one, OfTurn):
            of = partial(number_of, one)
            yield Measure(one.name, one.unit, one.meaning, of, one.columns, size=one.size, in_tables=one.in_tables)
        else:
            yield one
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
    """The measures for a list: those of every column of a trajectory stand there once, for COLUMN; those with a number once, for N."""
    of_every_column = {each.name for name in COLUMNS for each in of_columns(name, "")}
    alike: dict[str, list[Measure]] = {}
    for name, each in MEASURES.items():
        if name not in of_every_column:
            alike.setdefault(re.sub(r"_\d+", "_N", name), []).append(each)
    return [*of_columns("COLUMN", "the column's unit"), *starmap(_general, alike.items())]


def _general(name: str, alike: Sequence[Measure]) -> Measure:
    """The line for measures that differ in a number alone."""
    if len(alike) == 1:
        return alike[0]
    return replace(alike[0], name=name, meaning=f"{re.sub('1', 'N', alike[0].meaning)} (N: 1 to {len(alike)})")
