"""The measures of loads and of the drive in a settled motion.

What motor, flywheel and bearings are chosen by are functions of a turn, whose torque is that at the crank's shaft (`at_shaft`).

Between rows, torque, power and the powers of a force count as straight lines, whose integrals are exact: errors are of second order in the
spacing of rows.

The torque of the drive over the crank angle q1 is the series T = mean + sum of A_n cos(n q1 - phi_n).

A flywheel takes the part of a varying torque that a motor of constant torque does not give. With the energy fluctuation dE, the range of
the integral of T - mean over the crank angle, the speed omega varies by delta = (max - min) / mean if crank and flywheel together have the
inertia J = dE / (delta omega^2) (Norton, Design of Machinery, chapter on dynamic force analysis; Budynas and Nisbett, Shigley's Mechanical
Engineering Design, chapter on flywheels).

The load that fatigues a rolling bearing in a turn as a varying force F does is P = (integral of F^p |dtheta| / integral of |dtheta|)^(1/p),
theta being the angle between the rings, p = 3 for ball and 10/3 for roller bearings: the life of ISO 281 goes by revolutions and (C/P)^p,
and damage adds linearly (Palmgren and Miner; Harris and Kotzalas, Essential Concepts of Bearing Technology, mean effective load). For a
bearing that swings to and fro this holds if the swing is wider than the distance of two rolling elements (Harris, Rumbarger and
Butterfield, NREL/TP-500-42362, 2009).
"""

import math
from collections.abc import Callable, Iterator
from dataclasses import replace
from functools import partial
from typing import Final

import numpy as np

from quickreturn.cases.motion.extremes import extremes, of_vector
from quickreturn.cases.motion.measure import Measure, SettledMotion, number_of
from quickreturn.cases.motion.number import NO_NUMBER, Number
from quickreturn.cases.motion.of_turn import OfTurn, Turn, mean_speed
from quickreturn.plugins.strength.loads import Loads, loads_in
from quickreturn.plugins.strength.stress import ArmStress
from quickreturn.reference_model.arrays import Array
from quickreturn.reference_model.columns import AXIAL, COLUMNS
from quickreturn.reference_model.interpolation import CubicSpline

#: Columns whose product is the power of the drive.
POWER: Final = ("crank_torque", "crank_speed")
#: Number of harmonics of the torque.
HARMONICS: Final = 8
#: Kind of rolling bearing -> exponent p of its life (ISO 281).
EXPONENTS: Final = {"ball": 3.0, "roller": 10.0 / 3.0}
#: Force -> columns of its components, and columns whose difference is the angle that its bearing turns.
BEARINGS: Final = {
    "pivot_force": (("pivot_force_x", "pivot_force_y"), ("follower_angle",)),
    "crank_force": (("crank_force_x", "crank_force_y"), ("crank_angle",)),
    "slider_force": (("slider_force",), ("crank_angle", "follower_angle")),
}
#: Columns for the torque of the drive at the shaft and its power over time, and for the torque over the crank angle.
_OVER_TIME: Final = ("time", *POWER)
_OVER_ANGLE: Final = ("time", "crank_angle", "crank_torque")


def torque(turn: Turn) -> Array:
    """Torque of the drive in each row, N m."""
    return turn["crank_torque"]


def power(turn: Turn) -> Array:
    """Power of the drive in each row, W; negative where the machine gives it back."""
    return turn["crank_torque"] * turn["crank_speed"]


def mean(signal: Callable[[Turn], Array], turn: Turn) -> float:
    """Mean of a signal over time."""
    return _mean(turn["time"], signal(turn))


def rms(signal: Callable[[Turn], Array], turn: Turn) -> float:
    """Root mean square of a signal over time."""
    return math.sqrt(_mean(turn["time"], signal(turn) ** 2))


def energy(sign: float, turn: Turn) -> float:
    """Energy that the drive gives in a turn while its power has a sign (1), or takes back (-1), J; not negative."""
    values, steps = sign * power(turn), np.diff(turn["time"])
    before, after = values[:-1], values[1:]
    means = (np.maximum(before, 0.0) + np.maximum(after, 0.0)) / 2.0
    one, other = (each[before * after < 0.0] for each in (before, after))
    means[before * after < 0.0] = np.maximum(one, other) ** 2 / (2.0 * np.abs(one - other))
    return float(means @ steps)


def to_and_fro(turn: Turn) -> float:
    """Energy that the RMS of the power makes in a turn, J."""
    return rms(power, turn) * float(np.ptp(turn["time"]))


def harmonic(order: int, wave: Callable[[Array], Array], turn: Turn) -> float:
    """Part A_n cos(phi_n) of a harmonic of the torque, with the cosine as `wave`, or A_n sin(phi_n), N m; nan if rows are too few."""
    angle = turn["crank_angle"]
    if angle.size <= 2 * order:
        return math.nan
    varying = turn["crank_torque"] - _mean(angle, turn["crank_torque"])
    return 2.0 * _mean(angle, varying * wave(order * angle))


def energy_fluctuation(turn: Turn) -> float:
    """Range of the integral of the torque about its mean over the crank angle, J."""
    angle = turn["crank_angle"]
    varying = turn["crank_torque"] - _mean(angle, turn["crank_torque"])
    before, after, steps = varying[:-1], varying[1:], np.diff(angle)
    sums = np.append(0.0, np.cumsum((before + after) / 2.0 * steps))
    turns = before * after < 0.0  # the extremes are where the torque is its mean
    between = sums[:-1][turns] + (before**2 * steps)[turns] / (2.0 * (before - after)[turns])
    return float(np.ptp(np.append(sums, between)))


def equivalent_load(force: str, exponent: float, turn: Turn) -> float:
    """Constant force that fatigues a bearing as its force in the turn does, N; nan for one that does not turn."""
    parts, angles = BEARINGS[force]
    size = np.sqrt(sum(turn[name] ** 2 for name in parts)) ** exponent
    angle, *others = (turn[name] for name in angles)
    turned = np.abs(np.diff(angle - sum(others)))
    total = float(turned.sum())
    return float((size[:-1] + size[1:]) @ turned / (2.0 * total)) ** (1.0 / exponent) if total > 0.0 else math.nan


def pivot_angle(turn: Turn) -> float:
    """Angle that the bearing P turns in a turn of the crank, to and fro added, rad."""
    time, curve = turn["time"], CubicSpline(turn["time"], turn["follower_angle"])
    return float(np.abs(np.diff(curve(np.sort(np.append(time, curve.turning_points()))))).sum())


def _mean(over: Array, values: Array) -> float:
    return float(np.trapezoid(values, over)) / float(over[-1] - over[0])


def harmonic_parts(order: int) -> tuple[OfTurn, OfTurn]:
    """The parts of a harmonic of the torque in phase with the cosine and the sine of so many times the crank angle."""

    def part(name: str, words: str, wave: Callable[[Array], Array]) -> OfTurn:
        meaning, of = f"part of harmonic {order} of the drive's torque in phase with the {words}", partial(harmonic, order, wave)
        return OfTurn(f"torque.harmonic_{order}.{name}", "N m", meaning, _OVER_ANGLE, of, scale=partial(rms, torque), prescribed=True)

    return part("cos", "cosine", np.cos), part("sin", "sine", np.sin)


ENERGY_FLUCTUATION: Final = OfTurn(
    "flywheel.energy",
    "J",
    "range of the integral of the drive's torque about its mean over the crank angle",
    _OVER_ANGLE,
    energy_fluctuation,
    size=True,
    scale=to_and_fro,
    prescribed=True,
)


def _of_turn() -> Iterator[OfTurn]:
    """The measures that a function gives of the columns of a turn."""
    yield OfTurn(
        "mean.crank_torque", "N m", "mean torque of the drive at the shaft", _OVER_TIME, partial(mean, torque), scale=partial(rms, torque)
    )
    yield OfTurn(
        "mean.drive_power", "W", "mean power of the drive at the shaft", _OVER_TIME, partial(mean, power), scale=partial(rms, power)
    )
    yield OfTurn("rms.drive_power", "W", "root mean square of the power of the drive", _OVER_TIME, partial(rms, power), size=True)
    for name, does, sign in (("driven", "gives", 1.0), ("returned", "takes back", -1.0)):
        meaning, of = f"energy that the drive {does}", partial(energy, sign)
        yield OfTurn(f"turn.{name}_energy", "J", meaning, _OVER_TIME, of, scale=to_and_fro)
    for order in range(1, HARMONICS + 1):
        yield from harmonic_parts(order)
    yield ENERGY_FLUCTUATION
    for force, (parts, angles) in BEARINGS.items():
        for kind, exponent in EXPONENTS.items():
            meaning = f"constant load that fatigues a {kind} bearing as {force} does over the angle that the bearing turns"
            needs, of = ("time", *dict.fromkeys((*parts, *angles))), partial(equivalent_load, force, exponent)
            yield OfTurn(f"equivalent.{force}.{kind}", "N", meaning, needs, of, size=True)
    meaning = "angle that the bearing P turns in a turn"
    yield OfTurn("turn.pivot_angle", "rad", meaning, ("time", "follower_angle"), pivot_angle, size=True)


def _bearing(name: str, motion: SettledMotion) -> Number:
    return of_vector(name, motion.run.cycle, motion.claim) or NO_NUMBER


def _load(number: Callable[[Loads], Number | None], motion: SettledMotion) -> Number:
    return number(motion.of(loads_in)) or NO_NUMBER


def _stress(number: Callable[[ArmStress], Number], motion: SettledMotion) -> Number:
    return _load(lambda loads: None if loads.stress is None else number(loads.stress), motion)


def _factor(against: str, motion: SettledMotion) -> Number:
    """A safety factor, with the error to the farther end of its interval; `NO_NUMBER` where the strength is not given."""
    factor = motion.of(loads_in).factors.get(against)
    return NO_NUMBER if factor is None else Number(factor.value, None if factor.highest is None else factor.highest - factor.value)


def _harmonic(order: int, is_phase: bool, motion: SettledMotion) -> Number:
    """Amplitude of a harmonic of the torque, or its phase; the error of both parts counts in full."""
    cosine, sine = (number_of(part, motion) for part in harmonic_parts(order))
    amplitude = math.hypot(cosine.value, sine.value)
    estimate = None if cosine.estimate is None or sine.estimate is None else cosine.estimate + sine.estimate
    number = Number(amplitude, estimate, cosine.measurement + sine.measurement, cosine.settling + sine.settling)
    if not is_phase:
        return number
    return replace(number.times(1.0 / amplitude), value=math.atan2(sine.value, cosine.value)) if amplitude > 0.0 else NO_NUMBER


def _power(sign: float, motion: SettledMotion) -> Number:
    """Largest power that the drive gives (1) or takes back (-1), W; 0 where it never does."""
    if not {*POWER} <= motion.run.cycle.keys():
        return NO_NUMBER
    cycle = motion.cycle
    ((_, largest),) = extremes(cycle["time"], sign * power(cycle))
    angle = float(np.interp(largest.time, cycle["time"], cycle["crank_angle"]))
    errors = [motion.claim(column, angle) for column in POWER]
    largest_torque, speed = (float(np.abs(cycle[column]).max()) for column in POWER)
    sizes = speed, largest_torque
    estimate = None if None in errors else sum(error * size for error, size in zip(errors, sizes, strict=True) if error is not None)
    return replace(largest, value=max(0.0, largest.value), estimate=estimate, crank_angle=angle % (2.0 * math.pi))


def _flywheel(motion: SettledMotion) -> Number:
    """Inertia about O for the wanted fluctuation of the crank's speed."""
    wanted, energy = motion.mechanism.crank.wanted_fluctuation, number_of(ENERGY_FLUCTUATION, motion)
    return NO_NUMBER if wanted is None else energy.times(1.0 / (wanted * mean_speed(motion.run.cycle) ** 2))


def _of_loads() -> Iterator[Measure]:
    """The measures that need more than the columns of a turn."""
    for name, where in (("pivot_force", "P"), ("crank_force", "O")):
        meaning = f"largest force of the bearing {where}"
        yield Measure(f"peak.{name}", "N", meaning, partial(_bearing, name), (f"{name}_x", f"{name}_y"), size=True)
    all_columns = tuple(COLUMNS)
    meaning, of = "largest stress along the arm, by bending and the normal force", partial(_stress, lambda stress: stress.largest)
    yield Measure("peak.stress", "Pa", meaning, of, all_columns, size=True)
    meaning, of = "half the range of the stress in a turn, where that is largest", partial(_stress, lambda stress: stress.amplitude)
    yield Measure("amplitude.stress", "Pa", meaning, of, all_columns, size=True)
    meaning = "largest magnitude of the stress along the arm by the normal force alone"
    yield Measure("peak.axial_stress", "Pa", meaning, partial(_load, lambda loads: loads.axial_stress), AXIAL, size=True)
    meaning = "amplitude of the fully reversed stress that is as bad as the worst cycle, with notches and mean"
    of = partial(_stress, lambda stress: stress.fatigue.equivalent)
    yield Measure("equivalent.stress", "Pa", meaning, of, all_columns, of_material=True)
    meaning = "cycles of stress in a turn where it is worst for fatigue, by rainflow counting"
    of = partial(_stress, lambda stress: Number(float(len(stress.fatigue.ranges)), 0.0))
    yield Measure("cycles.stress", "1", meaning, of, all_columns, of_material=True)
    for against, meaning in (
        ("yielding", "yield strength over the largest stress"),
        ("fatigue", "fatigue strength over the equivalent stress"),
    ):
        yield Measure(f"factor.{against}", "1", meaning, partial(_factor, against), all_columns, of_material=True)
    for sign, name, does in ((1.0, "drive_power", "gives"), (-1.0, "returned_power", "takes back")):
        meaning, needs = f"largest power that the drive {does} in a turn", ("time", "crank_angle", *POWER)
        yield Measure(f"peak.{name}", "W", meaning, partial(_power, sign), needs)
    for order in range(1, HARMONICS + 1):
        name, of_order = f"torque.harmonic_{order}", f"harmonic {order} of the drive's torque over the crank angle"
        yield Measure(name, "N m", f"amplitude of {of_order}", partial(_harmonic, order, False), _OVER_ANGLE)
        meaning = f"{order} times the crank angle at which {of_order} is largest"
        yield Measure(f"{name}.phase", "rad", meaning, partial(_harmonic, order, True), _OVER_ANGLE)
    meaning = (
        "inertia about O of crank and flywheel with which the speed fluctuates by crank.wanted_fluctuation under a motor's constant torque"
    )
    yield Measure("flywheel.inertia", "kg m^2", meaning, _flywheel, (*_OVER_TIME, "crank_angle"))


#: All of them, for the catalogue (`cases.motion.catalogue`).
MEASURES: Final = (*_of_loads(), *_of_turn())
