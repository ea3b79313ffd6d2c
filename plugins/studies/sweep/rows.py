"""A row of a study: neighbouring scenes, one after the other, each begun in the settled motion of the one before.

`reference` finds each periodic state from its neighbour's, so a row follows one branch of motions if there are several, and its results
depend on the direction: hence a row is computed as a whole, and stored under one key. The other engines, and scenes whose periodic state is
not found directly, are computed as `run` does, from the periodic state that `reference` found; or from the standard start, if the engine
cannot begin with a bent follower.
"""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Final

import numpy as np

from quickreturn.cases.motion.catalogue import measure
from quickreturn.cases.motion.cycle import measure_cycle
from quickreturn.cases.motion.endings import Ending
from quickreturn.cases.motion.estimates import MOTION, MeasuredCycle, MeasuredNumbers
from quickreturn.cases.motion.marching import output_step
from quickreturn.cases.motion.measure import SettledMotion
from quickreturn.cases.motion.of_turn import at_shaft, crank_damping
from quickreturn.cases.motion.orbit import compared_orbits, orbit_of, periodic_state, stability_of
from quickreturn.cases.motion.request import Approach, Computation, PeriodicOrbit, Run, RunRequest
from quickreturn.cases.motion.stability import NOT_CONVERGED, multiplier_of, nearly_one
from quickreturn.cases.motion.steady_state import steady_state
from quickreturn.cases.motion.time_scale import CHANNELS, time_scale
from quickreturn.engines import progress
from quickreturn.engines.base import EngineFailure, NoSteadyState, Refusal
from quickreturn.engines.error_parts import Compared
from quickreturn.engines.own.reference import ReferenceEngine, ReferenceSettings
from quickreturn.engines.own.simulation import FoundOrbit
from quickreturn.engines.registry import engine as engine_of_name
from quickreturn.engines.trajectory import Columns
from quickreturn.reference_model.arrays import Array
from quickreturn.reference_model.mechanism import Mechanism

#: Statuses of points besides those of runs and of `cases.motion.stability`.
LEFT: Final = "slider left"
OPEN: Final = "loop cannot close"
#: Status of a run -> status of its point, if that is a different word.
_ENDINGS: Final = {Ending.INACCURATE: NOT_CONVERGED, Ending.NOT_SETTLED: NOT_CONVERGED, Ending.UNAVAILABLE: Ending.FAILED}


@dataclass(frozen=True)
class Impossible:
    """A scene whose parts do not fit together: the status of its point, and the reason."""

    status: str
    sentence: str


@dataclass(frozen=True, kw_only=True)
class MeasureRequest:
    """The measures to take of each scene."""

    measures: tuple[str, ...]  # names
    engine: str = "reference"  # name
    claims: bool = True  # whether each number gets its error estimate, which takes a finer run
    accuracy: float | None = None  # error of the tip deflection; None: the engine's default
    settings: Mapping[str, str] = field(default_factory=dict)  # of the engine, as texts
    duration: float = 2.0  # s, on which engines that march from the standard start estimate their error


@dataclass(frozen=True)
class Row:
    """Measures and statuses of the points of a row."""

    values: Array  # of each measure, nan where unavailable, shape (points, measures)
    errors: Array  # errors of the values by the engine's own estimate, likewise
    statuses: tuple[str, ...]  # status of each point
    sentences: tuple[str, ...]  # reason of each status, "" if the point settled


def row(scenes: Sequence[Mechanism | Impossible], asked: MeasureRequest) -> Row:
    """Measure neighbouring scenes. The failure of an engine becomes the status of its point and raises nothing.

    Args:
        scenes: in the order in which one continues the other.
        asked: what to measure.
    """
    measures = [measure(name) for name in asked.measures]
    near: FoundOrbit | None = None
    numbers = np.full((len(scenes), len(measures), 2), math.nan)
    endings = []
    for place, scene in enumerate(scenes):
        progress.tell(engine=asked.engine, phase=f"point {place + 1} of {len(scenes)}")
        if isinstance(scene, Impossible):
            endings.append((scene.status, scene.sentence))
            continue
        point = _Point(scene, asked)
        near = point.settle(near)
        if point.motion is not None:
            found = [each.of(point.motion) for each in measures]
            numbers[place] = [(each.value, each.error) for each in found]
            point.doubt(*(each.says_nothing(one.value, one.error) for each, one in zip(measures, found, strict=True)))
        endings.append((point.status, point.sentence))
    return Row(numbers[:, :, 0], numbers[:, :, 1], tuple(status for status, _ in endings), tuple(sentence for _, sentence in endings))


class _Point:
    """One scene of a row.

    Attributes:
        motion: the settled motion; None where there is none.
        status: status of the point.
        sentence: reason of the status; "" if it settled.
    """

    def __init__(self, scene: Mechanism, asked: MeasureRequest) -> None:
        self._scene, self._asked = scene, asked
        self._engine = engine_of_name(asked.engine)
        self.motion: SettledMotion | None = None
        self.status: str = Ending.FAILED
        self.sentence = ""

    def settle(self, near: FoundOrbit | None) -> FoundOrbit | None:
        """Find the settled motion, from a neighbour's or anew; return the periodic state from which the next point may begin."""
        try:
            settings = self._settings()
            state = periodic_state(self._scene, settings, near) if self._engine.begins_bent else None
            if state is not None and isinstance(self._engine, ReferenceEngine):
                self._measure(state, settings)
            else:
                self._run(state)
        except NoSteadyState as reason:
            self.status, self.sentence = _ending(str(reason), NOT_CONVERGED), f"no periodic state was found: {reason}"
        except Refusal as refusal:
            self.status, self.sentence = Ending.REFUSED, str(refusal)
        except EngineFailure as failure:
            self.status, self.sentence = _ending(str(failure), Ending.FAILED), str(failure)
        else:
            return state or near
        return near

    def doubt(self, *clauses: str) -> None:
        """Take a point whose numbers say nothing as one that has not converged."""
        told = "; ".join(filter(None, clauses))
        if told and self.status == Ending.SETTLED:
            self.status, self.sentence = NOT_CONVERGED, f"{told}; ask for a smaller accuracy"

    def _settings(self) -> ReferenceSettings:
        """Settings of `reference`: runs of all engines begin in its periodic state. Raises Refusal."""
        reference = ReferenceEngine()
        self._engine.check(self._scene)
        if not isinstance(self._engine, ReferenceEngine):
            return reference.settings_for(reference.default_accuracy, self._scene)
        return reference.settings_for(self._asked.accuracy or reference.default_accuracy, self._scene).with_texts(
            dict(self._asked.settings)
        )

    def _measure(self, state: FoundOrbit, settings: ReferenceSettings) -> None:
        """Measure one turn of the periodic state, and one with finer settings for the error estimate."""
        step, compared, orbit = output_step(self._scene), list[Compared[FoundOrbit]](), PeriodicOrbit.of(state)
        if self._asked.claims or nearly_one(state):
            try:
                compared = compared_orbits(self._scene, state, settings)
            except (NoSteadyState, EngineFailure) as reason:
                self.sentence = f"no error estimate: with finer settings no periodic state was found: {reason}"
        self.status = Ending.SETTLED
        if nearly_one(state) or any(measure(name).multipliers for name in self._asked.measures):
            multiplier = multiplier_of(state, compared)
            orbit, self.status = PeriodicOrbit.of(state, multiplier), multiplier.status
            self.sentence = multiplier.sentence or self.sentence
        cycle = _turn(state, step)
        shown = [runs.mapped(lambda one: cycle if one is state else _turn(one, step)) for runs in compared if self._asked.claims]
        self.motion = SettledMotion(self._scene, self._measured(state, orbit, cycle, shown))

    def _measured(self, state: FoundOrbit, orbit: PeriodicOrbit, cycle: Columns, comparisons: Sequence[Compared[Columns]]) -> Run:
        """The turn as `run` would report it, reduced to what the measures need."""
        measures = [measure(name) for name in self._asked.measures]
        damping = crank_damping(self._scene)
        scale = time_scale(self._scene) if any(one.vibration for one in measures) else None
        needed_by = (name for one in measures for name in one.columns)
        columns = dict.fromkeys(name for name in (*needed_by, MOTION, *(CHANNELS if scale else ())) if name in cycle)

        def measured(turn: Columns) -> MeasuredCycle:
            given = at_shaft(turn, damping)
            needed = {name: given[name] for name in ("time", "crank_angle", *columns)}
            channels = {name: turn[name] for name in CHANNELS if scale is not None}
            return MeasuredCycle.of([needed], measure_cycle(scale, turn["time"], turn["crank_angle"], channels))

        compared = [pair.mapped(measured) for pair in comparisons]
        run = Run(
            engine=self._engine.name,
            estimate_of="total",
            status=Ending.SETTLED,
            computation=Computation(solve_seconds=state.solve_seconds),
            approach=Approach(settled=True, settling_error=state.residual, periodic_orbit=orbit),
            cycle=cycle,
        )
        if scale is None and not compared:
            return run
        return replace(run, measured=MeasuredNumbers.of((compared[0].run if compared else measured(cycle)).measures, compared))

    def _run(self, state: FoundOrbit | None) -> None:
        """Measure as `run` does, from the periodic state of `reference` if there is one."""
        asked = self._asked
        multiplier = None if state is None else stability_of(self._scene, state, self._settings())
        orbit = None if state is None or multiplier is None else orbit_of(state, multiplier)
        run = steady_state(
            RunRequest(
                mechanism=self._scene,
                duration=asked.duration,
                engine=asked.engine,
                accuracy=asked.accuracy,
                settings=dict(asked.settings),
                estimated=asked.claims,
                orbit=orbit,
            )
        )
        status = _ENDINGS.get(run.ending, run.status)
        # the remark of a usable run may say that a finer one broke down
        self.status, self.sentence = status if run.usable else _ending(run.remark, status), run.remark
        if multiplier is not None and multiplier.status != Ending.SETTLED and run.status == Ending.NOT_SETTLED:
            self.status = multiplier.status
        if run.usable:
            self.motion = SettledMotion(self._scene, run)


def _turn(state: FoundOrbit, step: float) -> Columns:
    """One turn of a periodic state, from the slider's farthest place on, recorded at about this step (s)."""
    rows = math.ceil(state.period / step)
    return dict(state.simulation_again().advance(state.period, state.period / rows).columns)


def _ending(cause: str, otherwise: str) -> str:
    """Status of a point whose run broke down, by the words of the cause."""
    return LEFT if "left the follower" in cause else otherwise
