"""A running simulation of the explicit model."""

import time
from typing import ClassVar, Literal

import numpy as np
from numpy.typing import NDArray

from engines.base import EngineFailure, Simulation
from engines.start import Start
from engines.trajectory import FollowerTrajectory, Trajectory
from reference_model import integrate
from reference_model.follower_model import ClampedModel, FixedShapeFollower
from reference_model.model import ExplicitModel, ObservationFailed
from reference_model.moving_model import MovingShapeModel

_CAUSES = {
    integrate.LEFT_FOLLOWER: ("the slider has left the follower's end", "try a slower crank, a stiffer or longer follower"),
    integrate.STEP_TOO_SMALL: (
        "the step size fell below 1e-13 s",
        "check the scene; the follower may be bent beyond what its shapes describe",
    ),
    integrate.TOO_MANY_CALLS: ("the limit of right-hand side evaluations is reached", "try fewer shapes or a looser engine.tolerance"),
    integrate.NOT_A_NUMBER: ("the loop cannot close any more", "check the scene; the follower may be bent beyond what its shapes describe"),
}


class ExplicitSimulation(Simulation):
    """Advances the state vector of an explicit model."""

    trajectory_type: ClassVar[type[Trajectory]] = Trajectory

    def __init__(
        self,
        model: ExplicitModel | MovingShapeModel | ClampedModel | FixedShapeFollower,
        state: NDArray[np.float64],
        tolerance: float,
        method: Literal["DOP853", "LSODA"],
        setup_seconds: float,
    ) -> None:
        self.setup_seconds = setup_seconds
        self.time = 0.0
        self.model = model
        self.state = state
        self.tolerance = tolerance
        self._method = method
        self._step = 0.0

    def present_start(self) -> Start:
        """The present state as a start for any engine.

        Raises:
            TypeError: the model has no moving shapes; only those are smooth enough to begin another engine with.
        """
        if not isinstance(self.model, MovingShapeModel):
            raise TypeError("only a model with moving shapes gives a start")
        deflection, rate = self.model.deflection(self.state)
        return Start(float(self.state[0]), float(self.state[self.model.modes + 2]), deflection, rate)

    def advance(self, duration: float, output_step: float) -> Trajectory:
        """See `engines.base.Simulation.advance`."""
        intervals = round(duration / output_step)
        began = time.perf_counter()
        if isinstance(self.model, MovingShapeModel):
            result = self.model.integrate(self.state, output_step, intervals, self.tolerance, self._step)
        else:
            result = self.model.integrate(self.state, output_step, intervals, self.tolerance, method=self._method, first_step=self._step)
        integrated = time.perf_counter()
        known = result.end_time
        try:
            columns = self.model.observe(result.states)
        except ObservationFailed as failure:
            columns = self.model.observe(result.states[: failure.row])
            known = output_step * max(failure.row - 1, 0)
        columns["time"] = self.time + output_step * np.arange(len(columns["tip_x"]), dtype=np.float64)
        done = time.perf_counter()
        statistics = {"right_hand_side_calls": float(result.calls), "integration_seconds": integrated - began}
        trajectory = self.trajectory_type(columns, done - began, statistics)
        if result.status != integrate.REACHED_END or len(trajectory) <= intervals:
            cause, advice = _CAUSES.get(result.status, _CAUSES[integrate.NOT_A_NUMBER])
            raise EngineFailure(self.time + known, cause, advice, trajectory if len(trajectory) else None)
        self.state, self._step = result.states[-1], result.next_step
        self.time += duration
        return trajectory


class FollowerSimulation(ExplicitSimulation):
    """The same for a model of the follower alone."""

    trajectory_type = FollowerTrajectory
