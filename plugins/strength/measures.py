"""The measures of loads and of the drive in a settled motion."""

import math
from collections.abc import Callable, Iterator
from dataclasses import replace
from functools import partial
from typing import Final

import numpy as np
from numpy.typing import NDArray

from quickreturn.cases.motion.extremes import extremes
from quickreturn.cases.motion.measure import Measure, SettledMotion, number_of
from quickreturn.cases.motion.number import NO_NUMBER, Number
from quickreturn.cases.motion.of_turn import OfTurn, at_shaft, crank_damping, mean_speed
from quickreturn.plugins.strength import drive
from quickreturn.plugins.strength.loads import Loads, loads_in
from quickreturn.plugins.strength.peak import of_vector
from quickreturn.plugins.strength.stress import ArmStress
from quickreturn.reference_model.columns import AXIAL, COLUMNS

Array = NDArray[np.float64]

#: Columns for the torque of the drive at the shaft and its power over time, and for the torque over the crank angle.
_POWER: Final = ("time", *drive.POWER)
_OVER_ANGLE: Final = ("time", "crank_angle", "crank_torque")


def harmonic_parts(order: int) -> tuple[OfTurn, OfTurn]:
    """The parts of a harmonic of the torque in phase with the cosine and the sine of so many times the crank angle."""

    def part(name: str, words: str, wave: Callable[[Array], Array]) -> OfTurn:
        meaning, of = f"part of harmonic {order} of the drive's torque in phase with the {words}", partial(drive.harmonic, order, wave)
        return OfTurn(f"torque.harmonic_{order}.{name}", "N m", meaning, _OVER_ANGLE, of, scale=drive.rms_torque, prescribed=True)

    return part("cos", "cosine", np.cos), part("sin", "sine", np.sin)


ENERGY_FLUCTUATION: Final = OfTurn(
    "flywheel.energy",
    "J",
    "range of the integral of the drive's torque about its mean over the crank angle",
    _OVER_ANGLE,
    drive.energy_fluctuation,
    size=True,
    scale=drive.to_and_fro,
    prescribed=True,
)


def _of_turn() -> Iterator[OfTurn]:
    """The measures that a function gives of the columns of a turn."""
    yield OfTurn("mean.crank_torque", "N m", "mean torque of the drive at the shaft", _POWER, drive.mean_torque, scale=drive.rms_torque)
    yield OfTurn("mean.drive_power", "W", "mean power of the drive at the shaft", _POWER, drive.mean_power, scale=drive.rms_power)
    yield OfTurn("rms.drive_power", "W", "root mean square of the power of the drive", _POWER, drive.rms_power, size=True)
    for name, does, sign in (("driven", "gives", 1.0), ("returned", "takes back", -1.0)):
        meaning, of = f"energy that the drive {does}", partial(drive.energy, sign)
        yield OfTurn(f"turn.{name}_energy", "J", meaning, _POWER, of, scale=drive.to_and_fro)
    for order in range(1, drive.HARMONICS + 1):
        yield from harmonic_parts(order)
    yield ENERGY_FLUCTUATION
    for force, (parts, angles) in drive.BEARINGS.items():
        for kind, exponent in drive.EXPONENTS.items():
            meaning = f"constant load that fatigues a {kind} bearing as {force} does over the angle that the bearing turns"
            needs, of = ("time", *dict.fromkeys((*parts, *angles))), partial(drive.equivalent_load, force, exponent)
            yield OfTurn(f"equivalent.{force}.{kind}", "N", meaning, needs, of, size=True)
    meaning = "angle that the bearing P turns in a turn"
    yield OfTurn("turn.pivot_angle", "rad", meaning, ("time", "follower_angle"), drive.pivot_angle, size=True)


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
    if not {*drive.POWER} <= motion.run.cycle.keys():
        return NO_NUMBER
    damping = crank_damping(motion.mechanism)
    cycle = at_shaft(motion.run.cycle, damping)
    ((_, largest),) = extremes(cycle["time"], sign * drive.drive_power(cycle))
    angle = float(np.interp(largest.time, cycle["time"], cycle["crank_angle"]))
    errors = [motion.claim(column, angle) for column in drive.POWER]
    torque, speed = (float(np.abs(cycle[column]).max()) for column in drive.POWER)
    sizes = speed, torque + damping * speed
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
        meaning, needs = f"largest power that the drive {does} in a turn", ("time", "crank_angle", *drive.POWER)
        yield Measure(f"peak.{name}", "W", meaning, partial(_power, sign), needs)
    for order in range(1, drive.HARMONICS + 1):
        name, of_order = f"torque.harmonic_{order}", f"harmonic {order} of the drive's torque over the crank angle"
        yield Measure(name, "N m", f"amplitude of {of_order}", partial(_harmonic, order, False), _OVER_ANGLE)
        meaning = f"{order} times the crank angle at which {of_order} is largest"
        yield Measure(f"{name}.phase", "rad", meaning, partial(_harmonic, order, True), _OVER_ANGLE)
    meaning = (
        "inertia about O of crank and flywheel with which the speed fluctuates by crank.wanted_fluctuation under a motor's constant torque"
    )
    yield Measure("flywheel.inertia", "kg m^2", meaning, _flywheel, (*_POWER, "crank_angle"))


#: All of them, for the catalogue (`cases.motion.catalogue`).
MEASURES: Final = (*_of_loads(), *_of_turn())
