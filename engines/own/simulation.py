"""A running simulation of one of this project's models, and the periodic steady state that a direct search finds."""

import math
import time
from dataclasses import dataclass
from typing import Any, Final, Protocol

import numpy as np

from quickreturn.engines.base import EngineFailure, NoSteadyState, Simulation, SteadyState
from quickreturn.engines.start import Start
from quickreturn.engines.trajectory import Trajectory, trajectory_type
from quickreturn.reference_model.arrays import Array
from quickreturn.reference_model.columns import JOINT_COLUMNS
from quickreturn.reference_model.cycles.periodic import NoPeriodicOrbit, PeriodicOrbit, largest_multiplier
from quickreturn.reference_model.integrate import LEFT_FOLLOWER, NOT_A_NUMBER, REACHED_END, STEP_TOO_SMALL, TOO_MANY_CALLS, Integration
from quickreturn.reference_model.joint import CHORDS, LEVER
from quickreturn.reference_model.model import BeamModel, ObservationFailed
from quickreturn.reference_model.state import BY_JOINT, State

_CAUSES: Final = {
    LEFT_FOLLOWER: ("the slider has left the follower's end", "try a slower crank, a stiffer or longer follower"),
    STEP_TOO_SMALL: (
        "the integrator finds no step that is small enough",
        "check the scene; the follower may be bent beyond what its shapes describe",
    ),
    TOO_MANY_CALLS: ("the limit of right-hand side evaluations is reached", "try fewer shapes or a looser engine.tolerance"),
    NOT_A_NUMBER: ("the loop cannot close any more", "check the scene; the follower may be bent beyond what its shapes describe"),
}
#: Slider position, over the smallest one in the tables, below which a step that fails has met their end.
_AT_THE_LOWER_END: Final = 1.001
_LOST_HOLD: Final = (
    "the force on the nodes has lost its hold on the gap at the slider, no step size gets past that",
    'try four or more engine.elements, or engine.distribution="consistent"',
)


class Model(Protocol):
    """A model that is marched on a uniform grid, such as a `BeamModel`."""

    scene: Any

    def integrate(self, y: Array, output_step: float, intervals: int, tolerance: float, first_step: float = 0.0, /) -> Integration:
        """States from the state `y`."""

    def observe(self, states: Array, /) -> dict[str, Array]:
        """Columns of a trajectory from states, a row each."""


class OwnSimulation(Simulation):
    """Advances the state vector of a model.

    Statistics of a trajectory: `right_hand_side_calls` and `integration_seconds`; with an open loop also `degrees_of_freedom` and
    `largest_gap_rate` (m/s); with the lever rule, whose constraint does work, also `spurious_energy` (J, its work on crank and follower
    together), `spurious_energy_moved` (J, the integral of the absolute power) and `largest_spurious_power` (W).
    """

    def __init__(self, model: Model, state: Array, tolerance: float, setup_seconds: float) -> None:
        self.setup_seconds = setup_seconds
        self.time = 0.0
        self.model = model
        self.state = state
        self.tolerance = tolerance
        self._step = 0.0

    def present_start(self) -> Start | None:
        """The present state as a start for any engine; None for models other than a `BeamModel`, which have too few shapes for that."""
        if not isinstance(self.model, BeamModel):
            return None
        deflection, rate = self.model.deflection(self.state)
        state = State.of(self.state)
        return Start(float(state.q[0]), float(state.u[0]), deflection, rate)

    def advance(self, duration: float, output_step: float) -> Trajectory:
        intervals = round(duration / output_step)
        began = time.perf_counter()
        result = self.model.integrate(self.state, output_step, intervals, self.tolerance, self._step)
        integrated = time.perf_counter()
        # read before the observables of the states overwrite it
        place = float(self.model.workspace.facts.s) if isinstance(self.model, BeamModel) else math.inf
        states, good = result.states, result.end_time
        try:
            columns = self.model.observe(states)
        except ObservationFailed as failure:
            states, good = states[: failure.row], output_step * max(failure.row - 1, 0)
            columns = self.model.observe(states)
        statistics = {"right_hand_side_calls": float(result.calls), "integration_seconds": integrated - began}
        statistics |= self._of_joint({name: columns.pop(name) for name in JOINT_COLUMNS if name in columns}, states, output_step)
        if self._force_jumps:
            columns.pop("follower_acceleration", None)
        columns["time"] = self.time + output_step * np.arange(len(states), dtype=np.float64)
        trajectory = trajectory_type(self.model.scene)(columns, time.perf_counter() - began, statistics)
        if result.status != REACHED_END or len(trajectory) <= intervals:
            cause, advice = _CAUSES.get(result.status, _CAUSES[NOT_A_NUMBER])
            if result.status == STEP_TOO_SMALL and (near := self._near_pivot(place)) is not None:
                cause, advice = near
            if self._is_lever and result.status != LEFT_FOLLOWER:
                cause, advice = _LOST_HOLD
            raise EngineFailure(self.time + good, cause, advice, trajectory if len(trajectory) else None)
        self.state, self._step = result.states[-1], result.next_step
        self.time += duration
        return trajectory

    def _near_pivot(self, place: float) -> tuple[str, str] | None:
        """Cause and advice if the slider's last `place` (m) is at the lower end of the shapes' tables; None elsewhere."""
        scene = self.model.scene
        if not isinstance(self.model, BeamModel) or scene.crank is None or place > _AT_THE_LOWER_END * self.model.parameters.tables.low:
            return None
        cause = f"the slider comes within {place:.3g} m of the follower's pivot, where the shapes end"
        if not scene.slider.is_rigid:
            return cause, "try a stiffer joint (slider.joint_stiffness), which does not let the follower fall off the slider"
        return cause, f"try a crank.length ({scene.crank.length:.6g} m) that differs more from mechanism.pivot_distance"

    @property
    def _is_lever(self) -> bool:
        return isinstance(self.model, BeamModel) and self.model.parameters.constraint == LEVER

    @property
    def _force_jumps(self) -> bool:
        """Whether the slider's force passes from node to node: the base then rings faster than rows show (RIVALS.md, section 3)."""
        return isinstance(self.model, BeamModel) and self.model.parameters.constraint in (LEVER, CHORDS)

    def _of_joint(self, joint: dict[str, Array], states: Array, output_step: float) -> dict[str, float]:
        """Statistics of an open loop from its `JOINT_COLUMNS`; none for a closed one."""
        if not joint:
            return {}
        assert isinstance(self.model, BeamModel)
        statistics = {
            "degrees_of_freedom": float(self.model.degrees_of_freedom),
            "largest_gap_rate": float(np.max(np.abs(joint["gap_rate"]), initial=0.0)),
        }
        if self._is_lever and len(states):
            power, work = joint["joint_power"], State.of(states).work[:, BY_JOINT]
            statistics["spurious_energy"] = float(work[-1] - work[0])
            statistics["spurious_energy_moved"] = float(np.trapezoid(np.abs(power), dx=output_step))
            statistics["largest_spurious_power"] = float(np.max(np.abs(power)))
        return statistics


@dataclass(frozen=True)
class FoundOrbit(SteadyState):
    """A periodic steady state of the explicit model."""

    simulation: OwnSimulation  # as in `SteadyState`
    orbit: PeriodicOrbit  # what the search found

    def simulation_again(self) -> OwnSimulation:
        """A new simulation in this state, so that the original one stays in it."""
        original = self.simulation
        return OwnSimulation(original.model, self.orbit.state, original.tolerance, original.setup_seconds)

    @property
    def start(self) -> Start:
        """The same state as a start for any engine."""
        start = self.simulation_again().present_start()
        assert start is not None
        return start

    def whole_multiplier(self) -> complex:
        """The largest multiplier by derivatives of the whole model. NoSteadyState: a cycle is broken."""
        assert isinstance(self.simulation.model, BeamModel)
        try:
            return largest_multiplier(self.simulation.model, self.orbit, self.simulation.tolerance)
        except NoPeriodicOrbit as reason:
            raise NoSteadyState(str(reason)) from reason
