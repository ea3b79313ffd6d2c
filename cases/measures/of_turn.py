"""Measures that a function gives of the columns of a turn.

A new one is declared in `OF_TURN`, and appears wherever measures do (`cases.measures.catalogue`). The engine's estimate of its error comes
from the same function of the turns that the engine compares (`cases.runs.estimates`).
"""

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import partial
from typing import Final

import numpy as np
from numpy.typing import NDArray

from quickreturn.reference_model.witnesses import Witness

Array = NDArray[np.float64]
#: Columns of a turn from the slider's farthest place to the next, by name, in SI units, each of shape (rows,).
Turn = Mapping[str, Array]

#: Witness of what numpy computes from a turn, but for the largest difference.
PLAIN: Final = partial(
    Witness,
    "plain numpy on rows of 0.1 ms of `mujoco`",
    test="tests/verification/test_witnesses.py::test_plain_numpy_on_a_link_chain_confirms_the_measures_of_a_turn",
)


@dataclass(frozen=True)
class TableColumn:
    """How the tables of a run show a measure."""

    head: str  # heading
    form: str  # format in the page, e.g. ".2f"
    unit: str = ""  # unit in the page; "": that in which the page shows the SI unit
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
    witness: Witness  # confirms it
    size: bool = False  # whether it is a size, which is not negative
    in_tables: TableColumn | None = None  # None: tables do not show it; it is a variable of `sweep`, and a key of the JSON document

    def by_spacing(self, turn: Turn) -> float:
        """Uncertainty from the spacing of rows: the difference to the number of every second row, and the last one.

        It covers the error of a number whose order in the spacing is one or higher. Engines are compared on the same rows, so that their
        estimates do not show it.
        """
        count = len(turn["time"])
        half = np.unique(np.append(np.arange(0, count, 2), count - 1))
        return abs(self.of(turn) - self.of({name: turn[name][half] for name in self.columns}))


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


#: The declarations.
OF_TURN: Final = (
    OfTurn(
        "mean.crank_speed",
        "rad/s",
        "mean speed of the crank in a turn",
        ("time", "crank_angle"),
        mean_speed,
        PLAIN(2e-5),
        size=True,
        in_tables=TableColumn("mean", ".3f", group="crank speed", key="crank_speed"),
    ),
    OfTurn(
        "variation.crank_speed",
        "1",
        "range of the crank's speed in a turn over its mean",
        ("time", "crank_angle", "crank_speed"),
        variation_of_speed,
        PLAIN(5e-4),
        size=True,
        in_tables=TableColumn("max − min", ".1f", "%", "crank speed", "crank_speed_variation"),
    ),
)
