"""Measures that a function gives of the columns of a turn.

A new one is declared in `OF_TURN`, and appears wherever measures do (`cases.motion.catalogue`). The engine's estimate of its error comes
from the same function of the turns that the engine compares (`cases.motion.estimates`).
"""

import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from functools import partial
from typing import Final

import numpy as np
from numpy.typing import NDArray

from quickreturn.cases.loads import drive
from quickreturn.cases.loads.drive import Turn

Array = NDArray[np.float64]


@dataclass(frozen=True)
class TableColumn:
    """How the tables of a run show a measure."""

    head: str  # heading
    form: str  # format in the page, e.g. ".2f"
    unit: str = ""  # unit in the page; "": that of the case for the SI unit
    group: str = ""  # heading above this and its neighbours
    key: str = ""  # heading in the CSV file, without the unit; "": the measure's name
    in_terminal: str = ""  # format in the terminal, in SI; "": it is not shown there


@dataclass(frozen=True)
class OfTurn:
    """A number that a function gives of the columns of a turn."""

    name: str  # as asked for
    unit: str  # SI
    meaning: str  # in words
    columns: tuple[str, ...]  # columns that the function needs
    of: Callable[[Turn], float]  # gives the number, SI
    size: bool = False  # whether it is a size, which is not negative
    # size of what goes to and fro, of which a part is left to the steady state; None: the number itself
    scale: Callable[[Turn], float] | None = None
    prescribed: bool = False  # whether only a crank at a prescribed speed has it
    in_tables: TableColumn | None = None  # None: tables do not show it; it is a variable of `sweep`, and a key of the JSON document

    def by_spacing(self, turn: Turn) -> float:
        """Uncertainty from the spacing of rows, see `by_spacing`."""
        return by_spacing(self.of, turn, self.columns)


def by_spacing(of: Callable[[Turn], float], turn: Turn, columns: Sequence[str]) -> float:
    """Uncertainty of a number from the spacing of rows: the larger difference to those of every second row, with even or odd numbers.

    Both have the first row and the last one. It covers the error of a number whose order in the spacing is one or higher. Engines are
    compared on the same rows, so that their estimates do not show it.
    """
    value, count = of(turn), len(turn["time"])
    halves = (np.unique([0, *range(first, count, 2), count - 1]) for first in (0, 1))
    return max(abs(value - of({name: turn[name][half] for name in columns})) for half in halves)


def rms_over_time(time: Array, values: Array) -> float:
    """Root mean square of a signal over time, both of shape (n,)."""
    return math.sqrt(float(np.trapezoid(values**2, time)) / float(time[-1] - time[0]))


def mean_speed(turn: Turn) -> float:
    """Mean speed of the crank in either direction, rad/s."""
    angle, time = turn["crank_angle"], turn["time"]
    return abs(float(angle[-1] - angle[0]) / float(time[-1] - time[0]))


def variation_of_speed(turn: Turn) -> float:
    """Range of the crank's speed over its mean."""
    return float(turn["crank_speed"].max() - turn["crank_speed"].min()) / mean_speed(turn)


#: Columns for the torque of the drive at the shaft and its power over time, and for the torque over the crank angle.
_POWER: Final = ("time", *drive.POWER)
_OVER_ANGLE: Final = ("time", "crank_angle", "crank_torque")


def harmonic_parts(order: int) -> tuple[OfTurn, OfTurn]:
    """The parts of a harmonic of the torque in phase with the cosine and the sine of so many times the crank angle."""

    def part(name: str, words: str, wave: Callable[[Array], Array]) -> OfTurn:
        meaning, of = f"part of harmonic {order} of the drive's torque in phase with the {words}", partial(drive.harmonic, order, wave)
        return OfTurn(f"torque.harmonic_{order}.{name}", "N m", meaning, _OVER_ANGLE, of, scale=drive.rms_torque, prescribed=True)

    return part("cos", "cosine", np.cos), part("sin", "sine", np.sin)


def _of_bearings() -> Iterator[OfTurn]:
    """Equivalent loads of the bearings."""
    for force, (parts, angles) in drive.BEARINGS.items():
        for kind, exponent in drive.EXPONENTS.items():
            yield OfTurn(
                f"equivalent.{force}.{kind}",
                "N",
                f"constant load that fatigues a {kind} bearing as {force} does over the angle that the bearing turns",
                ("time", *dict.fromkeys((*parts, *angles))),
                partial(drive.equivalent_load, force, exponent),
                size=True,
            )


#: The declarations.
OF_TURN: Final = (
    OfTurn(
        "mean.crank_speed",
        "rad/s",
        "mean speed of the crank in a turn",
        ("time", "crank_angle"),
        mean_speed,
        size=True,
        in_tables=TableColumn("mean", ".3f", group="crank speed", key="crank_speed"),
    ),
    OfTurn(
        "variation.crank_speed",
        "1",
        "range of the crank's speed in a turn over its mean",
        ("time", "crank_angle", "crank_speed"),
        variation_of_speed,
        size=True,
        in_tables=TableColumn("max − min", ".1f", "%", "crank speed", "crank_speed_variation"),
    ),
    OfTurn("mean.crank_torque", "N m", "mean torque of the drive at the shaft", _POWER, drive.mean_torque, scale=drive.rms_torque),
    OfTurn("mean.drive_power", "W", "mean power of the drive at the shaft", _POWER, drive.mean_power, scale=drive.rms_power),
    OfTurn("rms.drive_power", "W", "root mean square of the power of the drive", _POWER, drive.rms_power, size=True),
    OfTurn("turn.driven_energy", "J", "energy that the drive gives", _POWER, partial(drive.energy, 1.0), scale=drive.to_and_fro),
    OfTurn("turn.returned_energy", "J", "energy that the drive takes back", _POWER, partial(drive.energy, -1.0), scale=drive.to_and_fro),
    *(part for order in range(1, drive.HARMONICS + 1) for part in harmonic_parts(order)),
    OfTurn(
        "flywheel.energy",
        "J",
        "range of the integral of the drive's torque about its mean over the crank angle",
        _OVER_ANGLE,
        drive.energy_fluctuation,
        size=True,
        scale=drive.to_and_fro,
        prescribed=True,
    ),
    *_of_bearings(),
    OfTurn("turn.pivot_angle", "rad", "angle that the bearing P turns in a turn", ("time", "follower_angle"), drive.pivot_angle, size=True),
)
