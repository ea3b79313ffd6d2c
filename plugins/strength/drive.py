"""What motor, flywheel and bearings are chosen by: functions of a turn, whose torque is that at the crank's shaft (`at_shaft`).

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
from collections.abc import Callable
from typing import Final

import numpy as np
from numpy.typing import NDArray

from quickreturn.cases.motion.of_turn import Turn
from quickreturn.reference_model.splines import CubicSpline

Array = NDArray[np.float64]

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


def drive_power(turn: Turn) -> Array:
    """Power of the drive in each row, W; negative where the machine gives it back."""
    return turn["crank_torque"] * turn["crank_speed"]


def mean_torque(turn: Turn) -> float:
    """Mean over time, N m."""
    return _mean(turn["time"], turn["crank_torque"])


def mean_power(turn: Turn) -> float:
    """Mean over time, W."""
    return _mean(turn["time"], drive_power(turn))


def rms_torque(turn: Turn) -> float:
    """Root mean square over time, N m."""
    return math.sqrt(_mean(turn["time"], turn["crank_torque"] ** 2))


def rms_power(turn: Turn) -> float:
    """Root mean square over time, W."""
    return math.sqrt(_mean(turn["time"], drive_power(turn) ** 2))


def energy(sign: float, turn: Turn) -> float:
    """Energy that the drive gives in a turn while its power has a sign (1), or takes back (-1), J; not negative."""
    power, steps = sign * drive_power(turn), np.diff(turn["time"])
    before, after = power[:-1], power[1:]
    mean = (np.maximum(before, 0.0) + np.maximum(after, 0.0)) / 2.0
    one, other = (power[before * after < 0.0] for power in (before, after))
    mean[before * after < 0.0] = np.maximum(one, other) ** 2 / (2.0 * np.abs(one - other))
    return float(mean @ steps)


def to_and_fro(turn: Turn) -> float:
    """Energy that the RMS of the power makes in a turn, J."""
    return rms_power(turn) * float(np.ptp(turn["time"]))


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
