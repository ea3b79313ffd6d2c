"""Cycle after cycle of a running simulation, until the motion has settled."""

import math
from collections.abc import Iterator
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from cases.measures import CHANNELS, Cycle, Settling, cut_cycles
from engines.accurate import check_trajectory
from engines.base import EngineFailure, Simulation
from engines.trajectory import Trajectory, join

Columns = dict[str, NDArray[np.float64]]

#: Grid on which cycles are recorded, s: fifteen samples in a period of the third mode (132 Hz), so that extremes are met to 1 %.
OUTPUT_STEP: Final = 5e-4

#: A crank that takes longer for a turn, s, has come to rest for all that can be measured; the table of a cycle has 200,000 rows then.
SLOWEST_TURN: Final = 100.0
#: A crank that takes less, s, leaves fewer than twenty rows to a cycle.
FASTEST_TURN: Final = 20 * OUTPUT_STEP
#: A cycle is advanced in pieces of at most this length, s: nobody knows how long a crank that begins at rest will take.
LONGEST_PIECE: Final = 10.0


def settle(simulation: Simulation, crank_speed: float, document: dict[str, Any], multiplier: float = 0.0) -> Columns:
    """Advance cycle after cycle until settled or given up; the last whole cycle, column by column.

    Args:
        simulation: stands where the search begins.
        crank_speed: rad/s, about; only the length of the pieces depends on it.
        document: gets "settled", "cycles", "settling_error", "settling", "solve_seconds" and "simulated_seconds".
        multiplier: largest Floquet multiplier of the steady state, where it is known.

    Raises:
        EngineFailure: the run broke down, or the crank does not turn at a pace at which cycles can be measured.
    """
    settling = Settling(least_ratio=multiplier)
    for cycle in march(simulation, crank_speed, document):
        if settling.feed(channels_of(columns_of(cycle))) or settling.given_up:
            break
    error = settling.error_estimate
    document.update(settled=settling.settled, cycles=settling.cycles, settling_error=error if math.isfinite(error) else None)
    if not settling.settled:
        document["settling"] = settling.outlook.as_dict()
    return columns_of(cycle)


def march(simulation: Simulation, crank_speed: float, document: dict[str, Any]) -> Iterator[Cycle]:
    """The whole cycles of a simulation, with all its columns, without end; arguments and exceptions are those of `settle`."""
    solve_seconds, speed, last_passage = 0.0, crank_speed, simulation.time
    rows: Trajectory | None = None
    while True:
        turn = 2.0 * math.pi / abs(speed) if speed else math.inf
        stretch = OUTPUT_STEP * math.ceil(min(turn, LONGEST_PIECE) / OUTPUT_STEP)
        piece = simulation.advance(stretch, OUTPUT_STEP)
        check_trajectory(piece, stretch, OUTPUT_STEP)
        solve_seconds += piece.solve_seconds
        document.update(solve_seconds=solve_seconds, simulated_seconds=simulation.time)
        rows = join([rows, piece]) if rows else piece
        speed = float(np.mean(piece["crank_speed"]))
        try:
            cycles = whole_cycles(rows)
        except ValueError as halted:
            raise EngineFailure(
                simulation.time, "the crank stands still or turns back", "let it turn one way, by torque or speed"
            ) from halted
        if cycles:
            last_passage = simulation.time
        elif simulation.time - last_passage > SLOWEST_TURN:
            raise EngineFailure(simulation.time, f"the crank takes more than {SLOWEST_TURN:g} s for a turn", "let it turn faster")
        for cycle in cycles:
            check_pace(cycle)
            yield cycle
        if cycles:
            # the next cycle begins where this one ended; a few rows before that keep the interpolation whole
            first = max(0, int(np.searchsorted(rows["time"], cycles[-1].time[-1])) - 4)
            rows = Trajectory({name: values[first:] for name, values in rows.columns.items()}, 0.0)


def check_pace(cycle: Cycle) -> None:
    """Raise `EngineFailure` if the crank turns too fast for cycles to be recorded."""
    turn = float(cycle.time[-1] - cycle.time[0])
    if turn < FASTEST_TURN:
        raise EngineFailure(
            float(cycle.time[0]), f"the crank takes {turn:.3g} s for a turn", f"let it turn slower: {FASTEST_TURN:g} s or more"
        )


def whole_cycles(rows: Trajectory) -> list[Cycle]:
    """The whole cycles in a trajectory, with all its columns."""
    columns = dict(rows.columns)
    return cut_cycles(columns.pop("time"), columns.pop("crank_angle"), columns)


def columns_of(cycle: Cycle) -> Columns:
    """A cycle as the columns of a trajectory."""
    return {"time": cycle.time, "crank_angle": cycle.crank_angle, **cycle.channels}


def channels_of(cycle: Columns) -> Cycle:
    """What is measured of a cycle, without its other columns."""
    return Cycle(cycle["time"], cycle["crank_angle"], {name: cycle[name] for name in CHANNELS})
