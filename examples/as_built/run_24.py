"""Run 24 in SI units, and what the constructions of all programs share."""

import csv
import math
import sys
from collections.abc import Callable, Mapping
from typing import Any, Final

import numpy as np

#: Run 24, SI, with material damping (s) in place of damping against the base.
SCENE: Final = {
    "pivot_distance": 0.4572,
    "crank_length": 0.1016,
    "crank_mass": 17.5126835,
    "crank_center": 0.0762,
    "crank_inertia": 4.51939316e-05,
    "torque": 1.12984829,
    "crank_damping": 0.0679903552,
    "crank_speed": 16.617773,
    "base_inertia": 1.69477244e-05,
    "base_damping": 2.25969658e-06,
    "length": 0.635,
    "mass_per_length": 0.328181484,
    "bending_stiffness": 6.10759695,
    "thickness": 0.003175,
    "width": 0.0381,
    "material_damping": 1e-4,
    "tip_mass": 0.0507867822,
    "tip_inertia": 2.21450265e-06,
}
#: Radius of a roller or pin, m.
RADIUS: Final = 0.005
#: From P to the crank's pin at the start, m.
REACH: Final = SCENE["pivot_distance"] + SCENE["crank_length"]
#: Of a table.
COLUMNS: Final = ("time", "crank_angle", "tip_deflection", "constraint_gap")


def chain_row(q1: float, angles: np.ndarray) -> tuple[float, float, float]:
    """Crank angle, tip deflection and gap of a chain of equal links, from the hinges' angles."""
    h = SCENE["length"] / len(angles)
    e = np.exp(1j * np.cumsum(angles))
    corners = np.concatenate([[0.0], np.cumsum(h * e)])
    pin = SCENE["crank_length"] * np.exp(1j * q1) - SCENE["pivot_distance"]
    local = (pin - corners[:-1]) / e
    nearest = local[np.argmin(np.abs(local.real - h / 2.0))]
    return q1, (corners[-1] / e[0]).imag, abs(nearest.imag)


def aside(angles: np.ndarray) -> float:
    """Distance of a chain's tip from the line through O and P, m."""
    return -SCENE["length"] / len(angles) * float(np.sin(np.cumsum(angles)).sum())


def bent_chain(n: int, deflection: float) -> np.ndarray:
    """Angles of the hinges, with the crank at 180 deg and a force on the tip that moves it."""
    h, angles = SCENE["length"] / n, np.full(n, math.pi)
    places = h * np.arange(1, n)
    # the moment falls from the slider to the tip, and to the pivot
    inboard = places / REACH * (SCENE["length"] - REACH)
    bend = np.where(places < REACH, inboard, SCENE["length"] - places)
    # of the corners, from the first link's line
    shape = h * np.concatenate([[0.0, 0.0], np.cumsum(np.cumsum(bend))])
    at_pin = np.interp(REACH, h * np.arange(n + 1), shape)
    size = deflection / (shape[-1] - at_pin * SCENE["length"] / REACH)
    angles[0] -= size * at_pin / REACH
    angles[1:] = size * bend
    return angles


def ring(signal: np.ndarray, step: float) -> tuple[float, float]:
    """Frequency (Hz) and damping ratio of the spectrum's largest peak.

    Phase and size of the signal about that peak, smoothed by a window, turn and fall with them.
    """
    window, times = np.hanning(len(signal) // 4), step * np.arange(len(signal))
    if not np.isfinite(signal).all():
        return math.nan, math.nan
    spectrum = np.abs(np.fft.rfft((signal - signal.mean()) * np.hanning(len(signal))))
    near = np.fft.rfftfreq(len(signal), step)[np.argmax(spectrum)]
    slow = np.convolve(
        (signal - signal.mean()) * np.exp(-2j * np.pi * near * times), window, "valid"
    )
    middle = times[: len(slow)]
    turning = np.polyfit(middle, np.unwrap(np.angle(slow)), 1)[0]
    rate = -np.polyfit(middle, np.log(np.abs(slow)), 1)[0]
    frequency = near + float(turning) / (2.0 * math.pi)
    return frequency, float(rate) / (2.0 * math.pi * frequency)


def write_table(machines: Mapping[str, Any], simulate: Callable[[Any], Any]) -> None:
    """What the arguments of the command line ask for: the names, or a table of one construction."""
    name, *file_name = sys.argv[1:] or [""]
    if name not in machines or len(file_name) != 1:
        return print(*machines, sep="\n")
    columns, _ = simulate(machines[name])
    with open(file_name[0], "w", newline="", encoding="utf-8") as file:
        csv.writer(file).writerows([list(columns), *np.array(list(columns.values())).T.tolist()])
    return None
