"""One engine on one scene, brought to its steady state, with an error estimate of its own.

A run begins in the periodic state that `reference` found (`cases.orbit`), or in the standard start. From the one as many cycles as
settling takes at least, from the other the case's duration is simulated to the accuracy asked (`engines.accurate`): that fixes the
settings and their error estimate. Where there is an orbit the standard start would be no measure of it: a stiff follower rings for
thousands of cycles if its load, or its weight, is there of a sudden. With these settings the simulation then runs cycle after cycle
until it has settled (`cases.measures.steady_state`). An engine that finds its periodic steady
state directly need not run there; where it finds none it marches like the others. If it is known
beforehand that marching cannot settle, it is not begun. What is kept is the last cycle, with every column of the trajectory.

At the same instant of the way the runs are taken by which the engine estimates its error (`Comparison`): from the same start, after as
many cycles. They show what the settings do to whatever is measured in the cycle (`cases.cycle_estimates`).
"""

import contextlib
import math
import time
from collections.abc import Mapping
from dataclasses import dataclass, field
from itertools import islice
from typing import Any, Final

import numpy as np

from cases.marching import Columns, columns_of, march, output_step, settle, whole_cycles
from cases.measures import CHANNELS
from cases.measures.steady_state import FEWEST_CYCLES
from cases.orbit import UNKNOWN_ERROR, Orbit
from engines.accurate import Compared, check_trajectory, compared, same_motion, simulate
from engines.base import Engine, EngineFailure, NoSteadyState, Refusal, Simulation, SteadyState
from engines.registry import engine as engine_of_name
from engines.settings import SettingError, Settings
from engines.start import Start, standard_start
from engines.trajectory import Trajectory
from reference_model.mechanism import Mechanism

#: By how much an engine's cycles may be longer than those of `reference`.
LONGER: Final = 1.01

#: Rows recorded after the end of a cycle, so that its last instant is not interpolated at the edge of the table.
ROWS_AFTER: Final = 4

SETTLED: Final = "settled"  # and the accuracy reached by the engine's own estimate
INACCURATE: Final = "inaccurate"  # settled, but the estimate misses the accuracy asked
NOT_SETTLED: Final = "not settled"
FAILED: Final = "failed"
REFUSED: Final = "refused"  # the engine cannot model this scene, and says so
UNAVAILABLE: Final = "unavailable"  # the engine cannot be used on this machine

STANDARD: Final = "standard"  # where a run began
FROM_ORBIT: Final = "periodic orbit of reference"
DIRECT: Final = "found directly"  # no march: the engine's own search


@dataclass(frozen=True, kw_only=True)
class Task:
    """What a run is asked to do; everything in it determines the result."""

    mechanism: Mechanism
    duration: float  # s, the stretch on which the error is estimated from the standard start
    engine: str
    accuracy: float | None = None  # error of the tip deflection; None: the engine's default
    settings: dict[str, str] = field(default_factory=dict)
    estimated: bool = True  # whether the measures of the cycle shall have estimates, which takes some runs more
    straight: bool = False  # march from the standard start even if there is an orbit to begin in
    orbit: Orbit | None = None  # where to begin, as found by `cases.runner`; None: the standard start

    @property
    def start(self) -> Start:
        """Where the run begins."""
        found = self._begun_from
        return (found and found.start) or standard_start(self.mechanism)

    def estimated_on(self, step: float) -> float:
        """The stretch on which the error is estimated, s: from the periodic state a little more than the fewest cycles that settle."""
        found = self._begun_from
        stretch = self.duration if found is None else FEWEST_CYCLES * LONGER * found.period
        return step * math.ceil(stretch / step - 1e-9)

    @property
    def _begun_from(self) -> Orbit | None:
        """The orbit that the run begins in; None: the standard start."""
        return None if self.straight or self.orbit is None or self.orbit.start is None else self.orbit


@dataclass(frozen=True)
class SteadyRun:
    """How it went: a JSON document and the last cycle, column by column (shape (n,), from farthest to farthest).

    Attributes:
        document: see `steady_run`.
        cycle: empty where there is none.
        compared: the same cycle in the runs by which the engine estimates its error, column by column; empty where they are not to be had.
        unestimated: why `compared` is empty (a clause), "" if it is not.
    """

    document: dict[str, Any]
    cycle: Columns
    compared: tuple[Compared[Columns], ...] = ()
    unestimated: str = ""


Runs = Mapping[Settings, Trajectory]


class Hopeless(Exception):
    """Marching cannot settle; the text is a sentence that says why."""


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
        "estimate_of": engine.estimates,
        "accuracy": task.accuracy or engine.default_accuracy,
        "status": REFUSED,
        "remark": "",
        "start": None,
        "settled": False,
        "cycles": 0,
        "settling_error": None,
        "settling_errors": None,
        "settling": None,
        "solve_seconds": None,
        "periodic_orbit": None,
    }
    cycle: Columns = {}
    others: tuple[Compared[Columns], ...] = ()
    unestimated = "there is no settled cycle"
    try:
        reason = engine.unavailable()
        if reason:
            return SteadyRun({**document, "status": UNAVAILABLE, "remark": reason}, {})
        document["version"] = engine.version()
        settings, done = _settings(engine, task, document)
        way = _Way(engine, task, settings, done, document)
        cycle = way.cycle()
        if document["settled"]:
            document["status"] = SETTLED if document["reached"] else INACCURATE
            if engine.estimates == "integration":
                unestimated = "its own estimates are of the integration alone"
            elif not task.estimated:
                unestimated = "none were asked for"
            else:
                others, unestimated = way.compared(cycle)
        else:
            document["status"] = NOT_SETTLED
    except (Refusal, SettingError) as refusal:
        document["remark"] = str(refusal)
    except Hopeless as reason:
        document["status"] = NOT_SETTLED
        _add_remark(document, str(reason))
    except EngineFailure as failure:
        document.update(status=FAILED, remark=str(failure), failure_time=failure.time, cause=failure.cause, advice=failure.advice)
        cycle = dict(failure.partial.columns) if failure.partial is not None else {}
    except (MemoryError, OSError):
        raise
    except Exception as error:  # a third-party engine may raise anything, and must not take the others with it
        cause = _words_of(error)
        document.update(status=FAILED, remark=cause, cause=cause)
    document["wall_seconds"] = time.perf_counter() - began
    return SteadyRun(document, cycle, others, unestimated)


def _words_of(error: Exception) -> str:
    return f"the engine raised {type(error).__name__}: {(str(error).splitlines() or ['no message'])[0]}"


def _settings(engine: Engine, task: Task, document: dict[str, Any]) -> tuple[Settings, Runs]:
    """The settings that reach the accuracy from where the run begins, with their estimate in the document, and all runs made for it."""
    step = output_step(task.mechanism)
    result = simulate(engine, task.mechanism, task.start, task.estimated_on(step), step, task.settings, task.accuracy)
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
    return result.settings, result.runs


class _Way:
    """How the steady cycle of a run is come by, so that runs with other settings can go the same way."""

    def __init__(self, engine: Engine, task: Task, settings: Settings, done: Runs, document: dict[str, Any]) -> None:
        self._engine, self._mechanism, self._settings, self._document = engine, task.mechanism, settings, document
        self._done = done
        self._step = output_step(task.mechanism)
        self._start = task.start
        self._orbit = None if task.straight else task.orbit

    def cycle(self) -> Columns:
        """The settled cycle, or the last one where it did not settle.

        Raises:
            Hopeless: that it will not settle is known beforehand.
            EngineFailure: the run broke down.
        """
        document, orbit, multiplier = self._document, self._orbit, None
        if cycle := self._found_directly():
            return cycle
        document["start"] = STANDARD
        if orbit is not None and orbit.start is None and not orbit.multiplier:
            _add_remark(document, f"begun in the standard start, for `reference` found no periodic state: {orbit.reason}")
        elif orbit is not None:
            if hopeless := orbit.hopeless(_error(document)):
                raise Hopeless(hopeless)
            document["start"], multiplier = FROM_ORBIT, orbit.multiplier
        made = self._done[self._settings]  # the run for the estimate began in the same start; it may be all that is needed
        cycle = settle(whole_cycles(made), document, multiplier)
        if document["settled"]:
            document.update(solve_seconds=made.solve_seconds, simulated_seconds=float(made["time"][-1]))
            return cycle
        cycle = settle(march(self._prepared(self._settings), self._start.crank_speed, self._step, document), document, multiplier)
        if not document["settled"]:
            _add_remark(document, f"not settled after {document['cycles']} cycles: {document['settling']['sentence']}")
        return cycle

    def compared(self, cycle: Columns) -> tuple[tuple[Compared[Columns], ...], str]:
        """The same cycle in the runs by which the engine estimates its error, and why there are none.

        Args:
            cycle: of the delivered run.
        """
        known: dict[Settings, Columns | EngineFailure] = {self._settings: cycle}

        def run(settings: Settings) -> Columns:
            if settings not in known:
                known[settings] = self._same_cycle(settings)
            found = known[settings]
            if isinstance(found, EngineFailure):
                raise found
            return found

        pairs = self._engine.comparisons(self._settings, self._mechanism, self._step)
        if any(pair.run == pair.other for pair in pairs):
            return (), "these settings leave no others to compare with"
        try:
            found = tuple(compared(pair, run) for pair in pairs)
        except EngineFailure as failure:
            return (), f"the run for their estimate {failure}"
        except (MemoryError, OSError):
            raise
        except Exception as error:  # what is delivered stays good
            return (), f"the run for their estimate: {_words_of(error)}"
        if not self._mechanism.follower.is_rigid and any(same_motion(runs.run, runs.other) for runs in found):
            return (), "the run to compare with is the same to the last digit"
        return found, ""

    def _same_cycle(self, settings: Settings) -> Columns | EngineFailure:
        """The steady cycle with other settings: found directly like the delivered one, or after as many cycles; settled at least."""
        try:
            if self._document["start"] == DIRECT:
                with contextlib.suppress(NoSteadyState):
                    found = self._searched(settings)
                    if found is not None and found.stable:
                        return self._one_cycle(found)[0]
                settling: dict[str, Any] = {}
                cycle = settle(march(self._prepared(settings), self._start.crank_speed, self._step, settling), settling)
                unsettled = EngineFailure(0.0, "neither settled nor found a periodic state", "try other settings")
                return cycle if settling["settled"] else unsettled
            if settings in self._done:
                made = whole_cycles(self._done[settings])
                if len(made) >= self._document["cycles"]:
                    return columns_of(made[self._document["cycles"] - 1])
            cycles = march(self._prepared(settings), self._start.crank_speed, self._step, {})
            return columns_of(next(islice(cycles, self._document["cycles"] - 1, None)))
        except EngineFailure as failure:
            return failure

    def _prepared(self, settings: Settings) -> Simulation:
        return self._engine.prepare(self._mechanism, self._start, settings)

    def _searched(self, settings: Settings) -> SteadyState | None:
        return self._engine.steady_state(self._mechanism, self._start, settings)

    def _found_directly(self) -> Columns:
        """One cycle of the periodic steady state; empty where the engine must march, with the reason in the document."""
        document = self._document
        try:
            found = self._searched(self._settings)
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
            raise Hopeless(Orbit(None, abs(found.multipliers[0])).hopeless(0.0))
        cycle, piece = self._one_cycle(found)
        document.update(
            start=DIRECT,
            settled=True,
            cycles=math.ceil(found.cycles_of_work),
            settling_error=found.residual,
            settling_errors={name: found.residual * float(np.max(np.abs(cycle[name]))) for name in CHANNELS},
            solve_seconds=found.solve_seconds + piece.solve_seconds,
            simulated_seconds=found.cycles_of_work * found.period + float(piece["time"][-1]),
        )
        document["periodic_orbit"]["period"] = float(cycle["time"][-1] - cycle["time"][0])
        return cycle

    def _one_cycle(self, found: SteadyState) -> tuple[Columns, Trajectory]:
        duration = self._step * (math.ceil(found.period / self._step) + ROWS_AFTER)
        piece = found.simulation.advance(duration, self._step)
        check_trajectory(piece, duration, self._step)
        cycle = whole_cycles(piece)[0]
        return columns_of(cycle), piece


def _error(document: dict[str, Any]) -> float:
    """What the engine errs by in a few cycles, by its largest estimate over the case's duration."""
    estimates = [estimate for name in CHANNELS if (estimate := document["error_estimates"].get(name)) is not None]
    return max(estimates, default=UNKNOWN_ERROR)


def _add_remark(document: dict[str, Any], remark: str) -> None:
    document["remark"] = f"{document['remark']}; {remark}" if document["remark"] else remark
