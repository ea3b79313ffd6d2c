"""One engine on one scene, brought to its steady state, with an error estimate of its own.

First the standard start is simulated over the case's duration, to the accuracy asked (`engines.accurate`): that fixes the settings
and their error estimate. With these settings the simulation then runs cycle after cycle until it has settled
(`cases.measures.steady_state`). An engine that finds its periodic steady state directly need not run there; where it finds none, or
an unstable one, it marches like the others. What is kept is the last cycle, with every column of the trajectory.
"""

import math
import time
from dataclasses import dataclass, field
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from cases.measures import CHANNELS, Cycle, Settling, cut_cycles
from engines.accurate import check_trajectory, simulate
from engines.base import Engine, EngineFailure, NoSteadyState, Refusal, Simulation
from engines.registry import engine as engine_of_name
from engines.settings import SettingError, Settings
from engines.start import Start, standard_start
from engines.trajectory import Trajectory, join
from reference_model.mechanism import Mechanism

#: Grid on which cycles are recorded, s: fifteen samples in a period of the third mode (132 Hz), so that extremes are met to 1 %.
OUTPUT_STEP: Final = 5e-4

#: A crank that takes longer for a turn, s, has come to rest for all that can be measured; the table of a cycle has 200,000 rows then.
SLOWEST_TURN: Final = 100.0
#: A crank that takes less, s, leaves fewer than twenty rows to a cycle.
FASTEST_TURN: Final = 20 * OUTPUT_STEP
#: A cycle is advanced in pieces of at most this length, s: nobody knows how long a crank that begins at rest will take.
LONGEST_PIECE: Final = 10.0

#: Rows recorded after the end of a cycle, so that its last instant is not interpolated at the edge of the table.
ROWS_AFTER: Final = 4

SETTLED: Final = "settled"  # and the accuracy reached by the engine's own estimate
INACCURATE: Final = "inaccurate"  # settled, but the estimate misses the accuracy asked
NOT_SETTLED: Final = "not settled"
FAILED: Final = "failed"
REFUSED: Final = "refused"  # the engine cannot model this scene, and says so
UNAVAILABLE: Final = "unavailable"  # the engine cannot be used on this machine


@dataclass(frozen=True, kw_only=True)
class Task:
    """What a run is asked to do; everything in it determines the result."""

    mechanism: Mechanism
    duration: float  # s, the stretch on which the error is estimated
    engine: str
    accuracy: float | None = None  # error of the tip deflection; None: the engine's default
    settings: dict[str, str] = field(default_factory=dict)
    start: Start | None = None  # None: the standard start


@dataclass(frozen=True)
class SteadyRun:
    """How it went: a JSON document and the last cycle, column by column (shape (n,), from farthest to farthest)."""

    document: dict[str, Any]
    cycle: dict[str, NDArray[np.float64]]


def steady_run(task: Task) -> SteadyRun:
    """Carry out a task. What an engine does wrong becomes part of the document; nothing is raised for it.

    Raises:
        MemoryError, OSError: for lack of memory, disk or the like. That is the machine's doing, not the engine's, and may be otherwise
            the next time.
    """
    engine = engine_of_name(task.engine)
    began = time.perf_counter()
    document: dict[str, Any] = {
        "engine": engine.name,
        "method": engine.method,
        "accuracy": task.accuracy or engine.default_accuracy,
        "status": REFUSED,
        "remark": "",
        "settled": False,
        "cycles": 0,
        "settling_error": None,
        "solve_seconds": None,
        "periodic_orbit": None,
    }
    cycle: dict[str, NDArray[np.float64]] = {}
    try:
        reason = engine.unavailable()
        if reason:
            return SteadyRun({**document, "status": UNAVAILABLE, "remark": reason}, {})
        document["version"] = engine.version()
        settings, start = _settle_settings(engine, task, document)
        cycle = _found_directly(engine, task.mechanism, start, settings, document)
        if not cycle:
            cycle = settle(engine.prepare(task.mechanism, start, settings), start.crank_speed, document)
        if not document["settled"]:
            document["status"] = NOT_SETTLED
            _add_remark(document, f"not settled after {document['cycles']} cycles")
        else:
            document["status"] = SETTLED if document["reached"] else INACCURATE
    except (Refusal, SettingError) as refusal:
        document["remark"] = str(refusal)
    except EngineFailure as failure:
        document.update(status=FAILED, remark=str(failure), failure_time=failure.time, cause=failure.cause, advice=failure.advice)
        cycle = dict(failure.partial.columns) if failure.partial is not None else {}
    except (MemoryError, OSError):
        raise
    except Exception as error:  # a third-party engine may raise anything, and must not take the others with it
        cause = f"the engine raised {type(error).__name__}: {(str(error).splitlines() or ['no message'])[0]}"
        document.update(status=FAILED, remark=cause, cause=cause)
    document["wall_seconds"] = time.perf_counter() - began
    return SteadyRun(document, cycle)


def _settle_settings(engine: Engine, task: Task, document: dict[str, Any]) -> tuple[Settings, Start]:
    """The settings that reach the accuracy from the task's start, with their estimate in the document."""
    start = task.start or standard_start(task.mechanism)
    duration = OUTPUT_STEP * round(task.duration / OUTPUT_STEP)
    result = simulate(engine, task.mechanism, start, duration, OUTPUT_STEP, task.settings, task.accuracy)
    document.update(
        accuracy=result.accuracy,
        settings=result.settings.as_dict(),
        remark=result.remark,
        reached=result.reached,
        error_estimate=result.error_estimate,
        error_estimates=result.error_estimates,
        setup_seconds=result.setup_seconds,
        compile_seconds=result.compile_seconds,
        estimate_seconds=result.estimate_seconds + result.solve_seconds,
        degrees_of_freedom=result.description.degrees_of_freedom,
    )
    return result.settings, start


def _found_directly(
    engine: Engine, mechanism: Mechanism, start: Start, settings: Settings, document: dict[str, Any]
) -> dict[str, NDArray[np.float64]]:
    """One cycle of the periodic steady state, column by column; empty where the engine must march, with the reason in the document."""
    try:
        found = engine.steady_state(mechanism, start, settings)
    except NoSteadyState as reason:
        _add_remark(document, f"marched, because no periodic state was found directly: {reason}")
        return {}
    if found is None:
        return {}
    document["periodic_orbit"] = {
        "period": found.period,
        "multipliers": [[multiplier.real, multiplier.imag] for multiplier in found.multipliers],
        "stable": found.stable,
        "iterations": found.iterations,
    }
    if not found.stable:
        _add_remark(document, f"marched, because the periodic state found is not stable: a multiplier of {abs(found.multipliers[0]):.3g}")
        return {}
    duration = OUTPUT_STEP * (math.ceil(found.period / OUTPUT_STEP) + ROWS_AFTER)
    piece = found.simulation.advance(duration, OUTPUT_STEP)
    check_trajectory(piece, duration, OUTPUT_STEP)
    document.update(
        settled=True,
        cycles=math.ceil(found.cycles_of_work),
        settling_error=found.residual,
        solve_seconds=found.solve_seconds + piece.solve_seconds,
        simulated_seconds=found.cycles_of_work * found.period + duration,
    )
    cycle = whole_cycles(piece)[0]
    _check_pace(cycle)
    document["periodic_orbit"]["period"] = float(cycle.time[-1] - cycle.time[0])
    return {"time": cycle.time, "crank_angle": cycle.crank_angle, **cycle.channels}


def _add_remark(document: dict[str, Any], remark: str) -> None:
    document["remark"] = f"{document['remark']}; {remark}" if document["remark"] else remark


def settle(simulation: Simulation, crank_speed: float, document: dict[str, Any]) -> dict[str, NDArray[np.float64]]:
    """Advance cycle after cycle until settled or given up; the last whole cycle, column by column.

    Args:
        simulation: stands where the search begins.
        crank_speed: rad/s, about; only the length of the pieces depends on it.
        document: gets "settled", "cycles", "settling_error", "solve_seconds" and "simulated_seconds".

    Raises:
        EngineFailure: the run broke down, or the crank does not turn at a pace at which cycles can be measured.
    """
    settling = Settling()
    solve_seconds = 0.0
    speed, last_passage = crank_speed, simulation.time
    rows: Trajectory | None = None
    last: Cycle | None = None
    while not (settling.settled or settling.given_up):
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
            _check_pace(cycle)
            last = cycle
            if settling.feed(Cycle(cycle.time, cycle.crank_angle, {name: cycle.channels[name] for name in CHANNELS})):
                break
        if last is not None and cycles:
            # the next cycle begins where this one ended; a few rows before that keep the interpolation whole
            first = max(0, int(np.searchsorted(rows["time"], last.time[-1])) - 4)
            rows = Trajectory({name: values[first:] for name, values in rows.columns.items()}, 0.0)
    error = settling.error_estimate
    document.update(settled=settling.settled, cycles=settling.cycles, settling_error=error if math.isfinite(error) else None)
    return {"time": last.time, "crank_angle": last.crank_angle, **last.channels} if last else {}


def _check_pace(cycle: Cycle) -> None:
    turn = float(cycle.time[-1] - cycle.time[0])
    if turn < FASTEST_TURN:
        raise EngineFailure(
            float(cycle.time[0]), f"the crank takes {turn:.3g} s for a turn", f"let it turn slower: {FASTEST_TURN:g} s or more"
        )


def whole_cycles(rows: Trajectory) -> list[Cycle]:
    """The whole cycles in a trajectory, with all its columns."""
    columns = dict(rows.columns)
    return cut_cycles(columns.pop("time"), columns.pop("crank_angle"), columns)
