"""Measures that a function gives of the columns of a turn.

A new one is declared in `OF_TURN`, or by a plugin (`engines.plugins.Plugin.measures`), and appears wherever measures do
(`cases.motion.catalogue`). The engine's estimate of its error comes from the same function of the turns that the engine compares
(`cases.motion.estimates`).
"""

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import cache
from typing import Any, Final

import numpy as np

from quickreturn.engines.plugins import found, places
from quickreturn.reference_model.arrays import Array
from quickreturn.reference_model.mechanism import Mechanism

#: Columns of a turn from the slider's farthest place to the next, by name, in SI units, each of shape (rows,).
Turn = Mapping[str, Array]


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


def crank_damping(mechanism: Mechanism) -> float:
    """Damping of the crank, N m s/rad; 0 at a prescribed speed."""
    return mechanism.crank.drive.damping


def at_shaft(turn: Turn, damping: float) -> dict[str, Array]:
    """The turn with torque and work that reach the crank's shaft: torque and damping (N m s/rad) stand for a motor and its characteristic.

    What the damping takes is then no part of the energy dissipated.
    """
    if damping == 0.0 or "crank_speed" not in turn:
        return dict(turn)
    time, speed = turn["time"], turn["crank_speed"]
    taken = damping * np.append(0.0, np.cumsum((speed[1:] ** 2 + speed[:-1] ** 2) * np.diff(time) / 2.0))
    less = {"crank_torque": damping * speed, "drive_work": taken, "dissipated_energy": taken}
    return {name: values - less[name] if name in less else values for name, values in turn.items()}


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
)


@cache
def of_plugins() -> tuple[Any, ...]:
    """What plugins declare: each an `OfTurn`, or a `cases.motion.measure.Measure`."""
    return tuple(each for place in places("measures") for each in found(place))


def declared() -> tuple[OfTurn, ...]:
    """`OF_TURN` and those of plugins."""
    return OF_TURN + tuple(each for each in of_plugins() if isinstance(each, OfTurn))
