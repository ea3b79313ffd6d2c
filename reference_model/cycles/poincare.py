"""A cycle of the explicit model as a map: from one passage of the slider's farthest place to the next (a Poincare map).

At the farthest place, q1 = 180 deg + k 360 deg, the free quantities are eta, q1' (unless prescribed) and eta' (equation 10.1); the
slider's arc length follows from the loop, and energies do not act back. A cycle is integrated in time over its estimated duration,
then in the crank angle, forward or back, to exactly the farthest place (M. Henon, On the numerical computation of Poincare maps,
Physica D 5, 1982, 412).
"""

import math
from dataclasses import dataclass
from functools import cached_property
from typing import Final

import numpy as np
from numpy.typing import NDArray

from quickreturn.reference_model.arrays import Array
from quickreturn.reference_model.entries import STEPS
from quickreturn.reference_model.integrate import LEFT_FOLLOWER, NOT_A_NUMBER, REACHED_END, STEP_TOO_SMALL, TOO_MANY_CALLS
from quickreturn.reference_model.model import BeamModel
from quickreturn.reference_model.motion.layout import state_size
from quickreturn.reference_model.state import State

#: Number of states along a cycle from which their sizes are taken.
ROWS: Final = 16
#: Steps of the method in the crank angle (order 4) for each step of the integrator in time (order 8): as accurate over a few of the latter.
PARTS: Final = 16
#: Largest number of steps in the crank angle: more would cost as much as another cycle.
LONGEST_REST: Final = 2000

_CAUSES: Final = {
    LEFT_FOLLOWER: "the slider left the follower's end",
    STEP_TOO_SMALL: "the step size fell below its least",
    TOO_MANY_CALLS: "it took too many evaluations",
    NOT_A_NUMBER: "the loop cannot close any more",
}


class CycleBroken(Exception):
    """No whole cycle begins in a state: the loop does not close, the integration ends early, or the crank stands still.

    Attributes:
        left: whether the slider leaves the follower.
    """

    def __init__(self, reason: str, *, left: bool = False) -> None:
        super().__init__(reason)
        self.left = left


@dataclass(frozen=True)
class Passage:
    """The slider's passage through its farthest place, and the motion that leads there.

    Attributes:
        state: state vector at the passage, shape (2 n + 5,).
        duration: of the motion, s.
        calls: right-hand sides evaluated.
        step: size of the step with which the integration may go on, s.
        states: some on the way, shape (k, 2 n + 5).
        free: numbers of the free quantities in a state.
    """

    state: Array
    duration: float
    calls: int
    step: float
    states: Array
    free: NDArray[np.intp]

    @cached_property
    def sizes(self) -> Array:
        """RMS along the motion of all eta together, of q1' or of all eta' together, for each free quantity, shape as the point's."""
        sizes = np.empty(self.states.shape[1])
        block, states = State.of(sizes), State.of(self.states)
        for of_block, values in ((block.eta, states.eta), (block.u[:1], states.u[:, :1]), (block.eta_rate, states.eta_rate)):
            of_block[:] = np.sqrt(np.mean(np.sum(values**2, axis=1)))
        return sizes[self.free]


class PoincareMap:
    """The map of a model's cycle for its free quantities, here called the point.

    Args:
        model: a model that closes the loop (`BeamModel.closes_loop`).
        tolerance: of the integration.

    Attributes:
        cycles: number of cycles simulated so far.
        calls: right-hand sides evaluated so far.
    """

    def __init__(self, model: BeamModel, tolerance: float) -> None:
        self.model = model
        self.parameters = model.parameters
        self.tolerance = tolerance
        self.cycles = 0
        self.calls = 0
        self._places = State.of(np.arange(state_size(self.parameters)))
        crank = self._places.u[: 1 - self.parameters.first]
        self._free = np.concatenate([self._places.eta, crank, self._places.eta_rate])

    def point(self, state: Array) -> Array:
        """The free quantities of a state."""
        return state[self._free]

    def state(self, point: Array, like: Array) -> Array:
        """The state with these free quantities, zero energies, and the crank angle and any prescribed crank speed of the state `like`.

        Raises:
            CycleBroken: the loop cannot be closed.
        """
        y = like.copy()
        y[self._free] = point
        State.of(y).work[:] = 0.0
        if not self._close_loop(y):
            raise CycleBroken("the loop cannot be closed")
        return y

    def belongs_to(self, modes: int) -> NDArray[np.bool_]:
        """Whether each free quantity is one of the first `modes` modes or the crank's speed, shape as the point's."""
        return np.isin(self._free, [*self._places.eta[:modes], self._places.u[0], *self._places.eta_rate[:modes]])

    def noise(self, state: Array) -> Array:
        """Size of the integration's local error for each free quantity, shape as the point's."""
        return self.tolerance * self.model.error_scales(float(State.of(state).u[0]))[self._free]

    def time_to_go(self, state: Array) -> float:
        """Estimated time (s) from a state to the slider's next passage through its farthest place."""
        crank_angle, crank_speed = float(State.of(state).q[0]), float(State.of(state).u[0])
        return (_next_farthest(crank_angle, crank_speed) - crank_angle) / crank_speed

    def passage(self, start: Array, duration: float, step: float = 0.0) -> Passage:
        """The slider's next passage through its farthest place.

        Args:
            start: state vector, at any crank angle.
            duration: estimated time until the passage, s.
            step: size of the first step, s; 0 as in `integrate.dop853`.

        Raises:
            CycleBroken: the motion does not get there.
        """
        begin = State.of(start)
        end = _next_farthest(float(begin.q[0]), float(begin.u[0]))
        states = [start[None]]
        elapsed, calls = 0.0, 0
        for _ in range(3):
            result = self.model.integrate(states[-1][-1], duration / ROWS, ROWS, self.tolerance, step)
            calls, step = calls + result.calls, result.next_step
            if result.status != REACHED_END:
                raise CycleBroken(f"the integration ended within the cycle: {_CAUSES[result.status]}", left=result.status == LEFT_FOLLOWER)
            reached = State.of(result.states[-1])
            if reached.u[0] * begin.u[0] <= 0.0:
                raise CycleBroken("the crank stood still within the cycle")
            states.append(result.states[1:])
            elapsed += duration
            duration = (end - reached.q[0]) / reached.u[0]
            if duration < 4.0 * step:
                break
        y = states[-1][-1].copy()
        # steps of the implicit integrator are longer than the fastest vibration lets these be
        parts = 1 + int(abs(duration) * max(PARTS / step, float(self.model.workspace.watched[1])))
        if parts > LONGEST_REST:
            raise CycleBroken("the cycle ended far from the slider's farthest place")
        elapsed += turn_to(self.model, y, end, parts)
        if not math.isfinite(elapsed):
            raise CycleBroken("the crank stood still")
        self.cycles += 1
        self.calls += calls + 4 * parts
        return Passage(y, elapsed, calls + 4 * parts, step, np.concatenate(states), self._free)

    def _close_loop(self, y: Array) -> bool:
        """Set the slider's place in `y` so that |p(s)| = |PC|, by the secant method from the straight follower; False if that fails."""
        p, facts = self.parameters, self.model.workspace.facts
        state = State.of(y)
        distance = math.hypot(p.LA * math.cos(state.q[0]) - p.d, p.LA * math.sin(state.q[0]))
        s, slope, last_s, last_excess, excess = distance, 1.0, 0.0, 0.0, math.inf
        for i in range(30):
            state.s[0] = s
            if not self.model.can_move(y):
                return False
            excess = float(abs(facts.foot)) - distance
            if abs(excess) < 1e-15 * p.L:
                return True
            if i > 0 and s != last_s:
                slope = (excess - last_excess) / (s - last_s)
            last_s, last_excess = s, excess
            s -= excess / slope
        return abs(excess) < 1e-12 * p.L


def _next_farthest(crank_angle: float, crank_speed: float) -> float:
    """The next crank angle 180 deg + k 360 deg (rad) in the direction of rotation; from such an angle on, a whole turn later."""
    sign = math.copysign(1.0, crank_speed)
    turns = math.floor((sign * crank_angle - math.pi) / (2.0 * math.pi) + 1e-9) + 1
    return sign * (math.pi + 2.0 * math.pi * turns)


def turn_to(model: BeamModel, y: Array, angle: float, parts: int) -> float:
    """Move the state `y`, in place, to a crank angle (rad) by `parts` classical Runge-Kutta steps of equal angle (equation 10.3).

    Returns:
        The time (s) that passes; nan if a state on the way is impossible.
    """
    equations, scratch = model.equations, np.empty((6, len(y)))
    at = equations.function, equations.parameters, equations.workspace
    moved = STEPS(*at, y.ctypes.data, len(y), angle, parts, scratch.ctypes.data)
    return float(scratch[5, 0]) if moved else math.nan
