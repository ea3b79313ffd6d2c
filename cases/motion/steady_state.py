"""One engine on one scene, brought to its steady state, with an error estimate of its own.

A run begins in the periodic state that `reference` found (`cases.motion.orbit`), or in the standard start. From the periodic state two
cycles are simulated, from the standard start the case's duration, to the accuracy asked (`engines.accurate`): this fixes the settings and
their error estimate. If there is an orbit, the standard start would mislead: a stiff follower rings for thousands of cycles after a sudden
load or weight. With these settings the simulation then runs cycle after cycle until it has settled (`cases.motion.settling`). An engine
that finds its periodic steady state directly need not march; if it finds none it marches like the others. If it is known beforehand that
marching cannot settle, it is not begun. The last cycle is kept, with every column of the trajectory. If the cycles keep changing because
the slider rattles between its rollers, the last thirty are measured, and means over them are compared (`cases.motion.marching`).

The runs by which the engine estimates its error (`Comparison`) are compared after as many cycles from the same start: from the orbit the
last cycle of the error estimate, which needs no further simulation, otherwise the last cycle. They show the effect of the settings on each
measure of the cycle (`cases.motion.estimates`). In a rattling motion they begin where the run itself has ended, if its engine can tell.
"""

import contextlib
import math
import time
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import replace
from itertools import islice
from typing import Any, Final

import numpy as np

from quickreturn.cases.motion.balances import Balances
from quickreturn.cases.motion.endings import Ending
from quickreturn.cases.motion.estimates import MeasuredNumbers, measured_cycles
from quickreturn.cases.motion.marching import March, channels_of, columns_of, is_determined, output_step, periodic_cycle, settle
from quickreturn.cases.motion.orbit import UNKNOWN_ERROR, Orbit, compared_orbits, settled_pairs
from quickreturn.cases.motion.request import DIRECT, ESTIMATED_CYCLES, FROM_ORBIT, STANDARD, Computation, PeriodicOrbit, Run, RunRequest
from quickreturn.cases.motion.settling import Cycle, on_common_grid, relative_change
from quickreturn.cases.motion.stability import NOT_CONVERGED, Multiplier, multiplier_of, nearly_one
from quickreturn.cases.motion.time_scale import CHANNELS
from quickreturn.engines import progress
from quickreturn.engines.accurate import simulate
from quickreturn.engines.base import AnyEngine, EngineFailure, NoSteadyState, Refusal, SteadyState
from quickreturn.engines.error_parts import Compared, NoEstimate, all_compared
from quickreturn.engines.one_run import CompletedRun, Remembered, raised
from quickreturn.engines.own.reference import ReferenceSettings
from quickreturn.engines.own.simulation import FoundOrbit
from quickreturn.engines.registry import engine as engine_of_name
from quickreturn.engines.settings import SettingError, Settings, as_texts
from quickreturn.engines.start import Start
from quickreturn.engines.trajectory import Columns
from quickreturn.reference_model.errors import OF_THE_MACHINE

#: Cycles after which a change of the settings no longer shows in a rattling motion. Runs of the thesis that begin off their cycle by two
#: engines' errors settle in 4 to 9; what remains after five disappears in the mean over thirty.
CYCLES_AFTER_CHANGE: Final = 5

#: Least error of the tip deflection for which the balances of a settled cycle must hold. In the library the energy's holds to 4e-3.
BALANCED: Final = 0.01


class Hopeless(Exception):
    """Marching cannot settle; the text is a sentence that says why."""


def steady_state(request: RunRequest) -> Run:
    """Carry out a request. A failure of an engine becomes part of the run and is not raised.

    Raises:
        MemoryError, OSError, ImportError: lack of memory, disk, a library or the like, which is due to the machine and not to the
            engine, and may not repeat.
    """
    began = time.perf_counter()
    unfinished = _RunInProgress(engine_of_name(request.engine), request)
    try:
        unfinished.simulate()
    except (Refusal, SettingError) as refusal:
        unfinished.note(remark=str(refusal))
    except Hopeless as reason:
        unfinished.note(status=Ending.NOT_SETTLED)
        unfinished.add_remark(str(reason))
    except EngineFailure as failure:
        partial = {} if failure.partial is None else dict(failure.partial.columns)
        unfinished.note(status=Ending.FAILED, remark=str(failure), cycle=partial)
        unfinished.note(cause=failure.cause, advice=failure.advice, failure_time=failure.time)
    except OF_THE_MACHINE:
        raise
    except Exception as error:  # a third-party engine may raise anything, and must not take the others with it
        unfinished.note(status=Ending.FAILED, remark=raised(error), cause=raised(error), cycle={})
    unfinished.measure()
    unfinished.note("computation", wall_seconds=time.perf_counter() - began)
    return unfinished.run


class _RunInProgress:
    """Finds the steady cycle of a run, and those of runs with other settings in the same way.

    Attributes:
        run: the result so far.
    """

    def __init__(self, engine: AnyEngine, request: RunRequest) -> None:
        self._engine, self._request, self._mechanism = engine, request, request.mechanism
        self._step = 0.0
        self._done: Mapping[Settings, CompletedRun] = {}
        self._cycles: tuple[Columns, ...] = ()  # the measured cycles
        self._compared: tuple[Compared[tuple[Columns, ...]], ...] = ()
        self._found: FoundOrbit | None = None  # the delivered orbit, near which those for the error estimate are searched
        self._early: tuple[Columns, ...] = ()  # of a march from the orbit: its first cycles, of which the last is compared
        self._rattling: Start | None = None  # the state after cycles that repeat in statistics only
        self._periodic_state = Remembered(self._searched)
        self._neutral = False  # whether disturbances neither grow nor die away
        self.run = Run.begun(request, engine)

    def note(self, part: str = "", **fields: Any) -> None:
        """Set fields of the result, or of one of its parts; names as in `Run`."""
        self.run = replace(self.run, **({part: replace(getattr(self.run, part), **fields)} if part else fields))

    def add_remark(self, remark: str) -> None:
        """Add a sentence to the remark of the result."""
        self.note(remark=f"{self.run.remark}; {remark}" if self.run.remark else remark)

    def simulate(self) -> None:
        """Choose the settings, find the settled cycle, and repeat it in the runs of the error estimate.

        Raises:
            Refusal, SettingError: the engine does not take the scene.
            Hopeless: it is known beforehand that it will not settle.
            EngineFailure: a run failed.
        """
        self.note(version=self._engine.version())
        refines = not self._mechanism.slider.has_corners or bool(self._request.settings)
        self._choose_settings(refines)
        self._cycles = self._settled_cycles()
        if not refines and self.run.approach.averaged_cycles == 1 and not self.run.computation.reached:
            self._choose_settings(True)
            self._cycles = self._settled_cycles()
        self.note(cycle=self._cycles[-1] if self._cycles else Columns())
        approach = self.run.approach
        if approach.turn is None and not approach.settled:
            self.note(status=Ending.NOT_SETTLED)
            return
        settled = Ending.NEUTRAL if self._neutral else Ending.SETTLED
        steady = settled if self.run.computation.reached else Ending.INACCURATE
        self.note(status=steady if approach.turn is None else Ending.TRANSIENT)
        if violated := Balances.of(self._cycles[-1], self._mechanism).violated(max(self.run.computation.accuracy or 0.0, BALANCED)):
            self.add_remark(f"doubtful: {violated}")
        if self._engine.estimates == "integration":
            self.note("measured", unestimated="its own estimates cover the integration alone")
        elif not self._request.estimated:
            self.note("measured", unestimated="none were asked for")
        else:
            self._compared, why = self._compare()
            self.note("measured", unestimated=why)

    def measure(self) -> None:
        """Measure the settled cycle, with error estimates from the compared runs."""
        if not self.run.usable:
            return
        of_runs = {id(self._cycles): self._cycles}  # a run may be compared with several
        for runs in self._compared:
            runs.mapped(lambda cycles: of_runs.setdefault(id(cycles), cycles))
        counted = [cycles[-self.run.approach.averaged_cycles :] for cycles in of_runs.values()]
        measured = dict(zip(of_runs, measured_cycles(self._mechanism, counted), strict=True))
        others = [runs.mapped(lambda cycles: measured[id(cycles)]) for runs in self._compared]
        self.note(measured=MeasuredNumbers.of(measured[id(self._cycles)].measures, others, self.run.measured.unestimated))

    def _choose_settings(self, refines: bool) -> None:
        """Find the settings that reach the accuracy from the run's start, with their error estimate and all runs for it.

        No settings reach it in a rattling motion, where paths diverge. Unless `refines`, the engine's settings for this accuracy without
        rattling are taken.
        """
        request, self._step = self._request, output_step(self._mechanism)
        self._start = request.start
        stretch = request.estimated_on(self._step)
        settings, accuracy, target = request.settings, request.accuracy, request.accuracy or self._engine.default_accuracy
        if not refines:
            self._engine.check(self._mechanism)
            settings, accuracy = as_texts(self._engine.settings_for(target, self._mechanism).as_dict()), None
        estimate = request.estimated or not request.settings or accuracy is not None  # settings that are given need none
        result = simulate(self._engine, self._mechanism, self._start, stretch, self._step, settings, accuracy, estimate)
        self._settings, self._done = result.delivered, result.runs
        within = result.error_estimate is not None and result.error_estimate <= target
        asked: dict[str, Any] = {} if refines else {"accuracy": target, "reached": within}
        self.note(remark=result.remark if estimate else "", computation=replace(Computation.of(result), **asked))

    def _settled_cycles(self) -> tuple[Columns, ...]:
        """The settled cycle, or the last ones if they keep changing; the turn asked for, if there is one."""
        if self._request.turn is not None:
            return (self._turn(self._request.turn),)
        of_reference = self._request.orbit
        orbit = None if self._request.straight else of_reference
        multiplier = 0.0 if is_determined(self._mechanism) else None if of_reference is None else of_reference.multiplier
        if self._request.straight and multiplier is not None and multiplier >= 1.0:
            multiplier = None  # of a motion that the march leaves
        if cycle := self._direct_cycle():
            return (cycle,)
        self.note("approach", start=STANDARD)
        if orbit is not None and orbit.begin is None and not orbit.multiplier:
            self.add_remark(f"begun in the standard start, because `reference` found no periodic state: {orbit.reason}")
        elif orbit is not None:
            errors = self.run.computation.error_estimates  # in a few cycles: on the stretch from the run's start
            known = (error for name in CHANNELS if (error := errors.get(name)) is not None)
            if hopeless := orbit.hopeless(max(known, default=UNKNOWN_ERROR)):
                raise Hopeless(hopeless)
            self.note("approach", start=FROM_ORBIT)
        progress.tell(phase="marching")
        self._early, march, far = (), self._march(self._settings), self.run.approach.start == STANDARD
        try:
            cycles, settling = settle(self._noted(march), multiplier, self._mechanism.slider.has_corners, march.halve_step, far=far)
        finally:
            self.note("computation", solve_seconds=march.solve_seconds)
        self.note("approach", settled=settling.settled or len(cycles) > 1, cycles=settling.cycles, averaged_cycles=max(len(cycles), 1))
        if math.isfinite(settling.error_estimate):
            self.note("approach", settling_error=settling.error_estimate, settling_errors=settling.errors)
        if len(cycles) > 1:
            self._early, self._rattling = (), march.present_start()
            self.note("computation", reached=self._request.accuracy is None)
            self.note("approach", settling_errors=dict.fromkeys(CHANNELS, 0.0), settling=settling.outlook)
            self.add_remark(
                f"it repeats in statistics only: measures are means over the last {len(cycles)} of {settling.cycles} cycles, each of which"
                f" differs from the one before by about {settling.outlook.change:.2g} of the signals' RMS"
            )
        elif not settling.settled:
            self.note("approach", settling=settling.outlook)
            self.add_remark(f"not settled after {settling.cycles} cycles: {settling.outlook.sentence()}")
        if self.run.approach.settled and multiplier is None and not self._mechanism.loses_energy:
            self._neutral = True
            self.add_remark("a disturbance neither grows nor dies away, because nothing in the scene takes energy from it")
        return cycles

    def _noted(self, cycles: Iterable[Cycle]) -> Iterator[Cycle]:
        """The same cycles; keeps the one that is compared with other settings' in a march from the orbit."""
        for number, cycle in enumerate(cycles, 1):
            if self.run.approach.start == FROM_ORBIT and number <= ESTIMATED_CYCLES:
                self._early = (*self._early, columns_of(cycle))
            yield cycle

    def _turn(self, number: int) -> Columns:
        """A turn of the run from the standard start, counted from 1."""
        self.note("approach", start=STANDARD, turn=number, cycles=number, settling_errors=dict.fromkeys(CHANNELS, 0.0))
        march = self._march(self._settings)
        cycle = columns_of(next(islice(march, number - 1, None)))
        self.note("computation", solve_seconds=march.solve_seconds)
        return cycle

    def _compare(self) -> tuple[tuple[Compared[tuple[Columns, ...]], ...], str]:
        """The same cycles in the runs of the engine's error estimate, or why there are none."""
        run = Remembered(self._same_cycles, {self._settings: self._early or self._cycles})
        progress.tell(phase="estimating the cycle's error")
        pairs, bends = settled_pairs(self._engine, self._settings, self._mechanism), not self._mechanism.follower.is_rigid
        try:
            found = all_compared(pairs, self._settings, run, lambda cycles: cycles[-1], bends=bends)
            return tuple(runs.growing(self._growth) for runs in found), ""
        except NoEstimate as reason:
            return (), str(reason)
        except EngineFailure as failure:
            return (), f"the run for their estimate {failure}"
        except OF_THE_MACHINE:
            raise
        except Exception as error:  # the delivered cycle stays good
            return (), f"the run for their estimate: {raised(error)}"

    def _growth(self, run: tuple[Columns, ...], other: tuple[Columns, ...]) -> float:
        """Largest ratio of an error in the delivered cycle to that in the compared one, by two runs' first cycles from the orbit.

        In a mode of which m remains after a cycle, what each cycle adds has grown to 1 - m^k of its limit in cycle k: that is at most
        1/(1 - m^k) times as large. It is also at most what the last two cycles differ by, times m + m^2 + ..., more.
        """
        if not self._early or self._request.orbit is None:
            return 1.0
        m = self._request.orbit.multiplier or 0.0
        (one, two), (other_one, other_two) = ([on_common_grid(channels_of(cycle)) for cycle in cycles[-2:]] for cycles in (run, other))
        apart = relative_change(two, other_two)
        grows = {name: two[name] - other_two[name] - one[name] + other_one[name] + other_two[name] for name in two}
        last = relative_change(other_two, grows)
        by_last = 1.0 + m / (1.0 - m) * last / apart if apart > 0.0 else math.inf
        return min(1.0 / (1.0 - m**ESTIMATED_CYCLES), by_last)

    def _same_cycles(self, settings: Settings) -> tuple[Columns, ...]:
        """The steady cycles with other settings: found directly like the delivered one, or after as many cycles; settled at least.

        If cycles repeat in statistics only, these runs begin where the delivered one has ended.
        """
        averaged = self.run.approach.averaged_cycles
        if self._rattling is not None:
            march = March(self._engine.prepare(self._mechanism, self._rattling, settings), self._rattling.crank_speed, self._step)
            return tuple(columns_of(cycle) for cycle in islice(march, CYCLES_AFTER_CHANGE, CYCLES_AFTER_CHANGE + averaged))
        if self.run.approach.start != DIRECT:
            number, count = (ESTIMATED_CYCLES, ESTIMATED_CYCLES) if self._early else (self.run.approach.cycles, averaged)
            return tuple(columns_of(cycle) for cycle in islice(self._march(settings), number - count, number))
        with contextlib.suppress(NoSteadyState):
            state = self._periodic_state(settings)
            if state is not None and (state.stable or self._neutral):
                return (columns_of(periodic_cycle(state, self._step)[0]),)
        multiplier = 0.0 if is_determined(self._mechanism) else None
        march = self._march(settings)
        cycles, settling = settle(march, multiplier, self._mechanism.slider.has_corners, march.halve_step)
        if not settling.settled:
            raise EngineFailure(0.0, "neither settled nor found a periodic state", "try other settings")
        return cycles

    def _march(self, settings: Settings) -> March:
        """Cycle after cycle from the start; a run for the error estimate began there, too, and is continued."""
        if (done := self._done.get(settings)) is not None:
            return March(done.simulation, self._start.crank_speed, self._step, done.trajectory)
        return March(self._engine.prepare(self._mechanism, self._start, settings), self._start.crank_speed, self._step)

    def _searched(self, settings: Settings) -> SteadyState | None:
        near = () if self._found is None else (self._found,)
        return self._engine.steady_state(self._mechanism, self._start, settings, *near)

    def _multiplier(self, state: FoundOrbit) -> Multiplier:
        """The largest multiplier of the delivered orbit, with its error where one is asked for or the stability depends on it."""
        assert isinstance(self._settings, ReferenceSettings)
        compared_with: list[Compared[FoundOrbit]] = []
        if self._request.estimated or nearly_one(state):
            with contextlib.suppress(NoSteadyState, EngineFailure):
                compared_with = compared_orbits(self._mechanism, state, self._settings, self._periodic_state)
        try:
            return multiplier_of(state, compared_with)
        except NoSteadyState:  # a disturbed cycle is broken: the search's own multiplier is left
            return Multiplier(complex(state.multipliers[0]), None)

    def _direct_cycle(self) -> Columns:
        """One cycle of the periodic steady state; empty if the engine must march, with the reason in the remark."""
        progress.tell(phase="searching the periodic state")
        try:
            state = self._periodic_state(self._settings)
        except NoSteadyState as reason:
            self.add_remark(f"marched, because no periodic state was found directly: {reason}")
            return {}
        if state is None:
            return {}
        multiplier = None
        if isinstance(state, FoundOrbit) and isinstance(self._settings, ReferenceSettings):
            self._found = state  # near which those that the multiplier is compared with are searched
            multiplier = self._multiplier(state)
        orbit = PeriodicOrbit.of(state, multiplier)
        self.note("approach", periodic_orbit=orbit)
        if multiplier is not None:
            if multiplier.status == NOT_CONVERGED:
                raise Hopeless(multiplier.sentence)
            self._neutral = multiplier.status == Ending.NEUTRAL
            if self._neutral:
                self.add_remark(multiplier.sentence)
        if not orbit.stable and not self._neutral:
            raise Hopeless(Orbit(None, math.hypot(*orbit.multipliers[0])).hopeless(0.0))
        whole, piece = periodic_cycle(state, self._step)
        cycle = columns_of(whole)
        self.note("computation", solve_seconds=state.solve_seconds + piece.solve_seconds)
        errors = {name: state.residual * float(np.max(np.abs(cycle[name]))) for name in CHANNELS}
        self.note("approach", start=DIRECT, settled=True, cycles=math.ceil(state.cycles_of_work), settling_error=state.residual)
        self.note("approach", settling_errors=errors, periodic_orbit=replace(orbit, period=float(cycle["time"][-1] - cycle["time"][0])))
        return cycle
