"""A running simulation of the open loop."""

import time

import numpy as np
from numpy.typing import NDArray

from engines.base import EngineFailure, Simulation
from engines.trajectory import Trajectory
from reference_model import integrate
from reference_model.constraints.joint import LEVER
from reference_model.constraints.model import OpenLoopModel
from reference_model.model import ObservationFailed


class OpenLoopSimulation(Simulation):
    """Advances the state vector of an open-loop model.

    Statistics of a trajectory: `right_hand_side_calls`, `degrees_of_freedom` (coordinates integrated), `largest_gap_rate` (m/s, the
    constraint at the level of velocities), and where the force's distribution is not conjugate to the motion `spurious_energy` (J, work
    of the slider force on crank and follower together, which an ideal joint does not do), `spurious_energy_moved` (J, the same without
    regard to its sign) and `largest_spurious_power` (W).
    """

    def __init__(self, model: OpenLoopModel, state: NDArray[np.float64], tolerance: float, setup_seconds: float) -> None:
        self.setup_seconds = setup_seconds
        self.time = 0.0
        self.model = model
        self.state = state
        self.tolerance = tolerance
        self._step = 0.0

    def advance(self, duration: float, output_step: float) -> Trajectory:
        """See `engines.base.Simulation.advance`."""
        intervals = round(duration / output_step)
        began = time.perf_counter()
        result = self.model.integrate(self.state, output_step, intervals, self.tolerance, self._step)
        states, known = result.states, result.end_time
        try:
            columns, joint = self.model.observe(states)
        except ObservationFailed as failure:
            states = states[: failure.row]
            known = output_step * max(failure.row - 1, 0)
            columns, joint = self.model.observe(states)
        columns["time"] = self.time + output_step * np.arange(len(states), dtype=np.float64)
        statistics = {
            "right_hand_side_calls": float(result.calls),
            "degrees_of_freedom": float(self.model.degrees_of_freedom),
            "largest_gap_rate": float(np.max(np.abs(joint["gap_rate"]), initial=0.0)),
        }
        if self.model.joint.distribution == LEVER and len(states):
            power = joint["joint_power"]
            statistics["spurious_energy"] = float(states[-1, -1] - states[0, -1])
            statistics["spurious_energy_moved"] = float(np.trapezoid(np.abs(power), dx=output_step))
            statistics["largest_spurious_power"] = float(np.max(np.abs(power)))
        trajectory = Trajectory(columns, time.perf_counter() - began, statistics)
        if result.status != integrate.REACHED_END or len(trajectory) <= intervals:
            cause, advice = self._reason(result.status)
            raise EngineFailure(self.time + known, cause, f"try {advice}", trajectory if len(trajectory) else None)
        self.state, self._step = result.states[-1], result.next_step
        self.time += duration
        return trajectory

    def _reason(self, status: int) -> tuple[str, str]:
        """Cause and advice."""
        if status == integrate.LEFT_FOLLOWER:
            return "the slider has left the follower's end", "a slower crank, a stiffer or longer follower"
        if status == integrate.TOO_MANY_CALLS:
            return "the limit of right-hand side evaluations is reached", "fewer shapes, a softer spring or a looser engine.tolerance"
        if self.model.joint.distribution == LEVER:
            return (
                "the force on the nodes has lost its hold on the gap at the slider, no step size gets past that",
                'four or more engine.elements, or engine.distribution="consistent"',
            )
        return "no step size gets past a state in which the crank tip is not beside the follower", "a finer discretization"
