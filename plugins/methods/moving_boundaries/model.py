"""The model of one scene: shapes, equations, integration and observables under one roof."""

from typing import Final

import numpy as np

from quickreturn.plugins.methods.moving_boundaries import tables as t
from quickreturn.plugins.methods.moving_boundaries.equations import MovingBoundariesParameters, MovingBoundariesWorkspace
from quickreturn.plugins.methods.moving_boundaries.observables import observables
from quickreturn.reference_model.arrays import Array
from quickreturn.reference_model.constants import characteristic_frequency, constants, crank_speed_scale, pace
from quickreturn.reference_model.integrate import Equations, Integration, dop853
from quickreturn.reference_model.mechanism import Mechanism
from quickreturn.reference_model.native.memory import Placed
from quickreturn.reference_model.native.objects import Entry
from quickreturn.reference_model.rigid import deflection_scale, follower_inertia, rigid_motion
from quickreturn.reference_model.state import State

#: The equations of motion.
KERNEL: Final = Entry("quickreturn.plugins.methods.moving_boundaries.equations:kernel", 4 * "i")


class MovingBoundariesModel:
    """A beam across the line from the pivot to the slider, the crank at constant speed.

    Args:
        scene: the mechanism, its crank's speed prescribed, its slider's joint rigid and without rotary inertia.
        modes: number of shapes, at least 1; a rigid follower has none.
        foreshortening: whether the model has the beam's shortening along the line, to second order.

    Attributes:
        made_before: wall time (s) that an earlier model spent on parts that this one reuses.
        shapes: number of shapes.
    """

    closes_loop = True

    def __init__(self, scene: Mechanism, modes: int, foreshortening: bool) -> None:
        self.scene = scene
        self._shapes = t.shapes_of(scene, modes, foreshortening)
        self.made_before, self.shapes = self._shapes.seconds, 0 if scene.follower.is_rigid else modes
        known = {**constants(scene), "EI": scene.follower.bending_stiffness}
        inertia, moment = follower_inertia(scene)
        self.parameters = MovingBoundariesParameters(
            **{name: known[name] for name in MovingBoundariesParameters._fields if name in known},
            n=self.shapes,
            inertia=inertia,
            moment=moment,
            low=self._shapes.low,
            high=self._shapes.high,
            coefficients=self._shapes.coefficients,
        )
        rows, signals = np.zeros((3, self.parameters.coefficients.shape[2])), np.zeros((t.VECTORS + t.MATRICES, 4))
        self.workspace = MovingBoundariesWorkspace(rows, signals, np.zeros(4), np.zeros(2))
        self._at = Placed(self.parameters), Placed(self.workspace)

    def straight_state(self, crank_angle: float, crank_speed: float) -> Array:
        """State vector (2 n + 4,) with the follower straight and moving as the rigid mechanism does."""
        y = np.zeros(2 * self.shapes + 4)
        State.of(y, slider=False).q[0], State.of(y, slider=False).u[0] = crank_angle, crank_speed
        return y

    def bent_state(
        self, crank_angle: float, crank_speed: float, slider: tuple[float, float], x: Array, angle: Array, angle_rate: Array
    ) -> Array:
        """State vector closest to a given shape; see `reference_model.model.BeamModel.bent_state`. Rates are those of equation 2.4."""
        y = self.straight_state(crank_angle, crank_speed)
        state = State.of(y, slider=False)
        line = rigid_motion(self.scene, np.array(crank_angle), crank_speed)
        assert self._shapes.family is not None
        psi, psi_l = self._shapes.family.angles(float(line.slider_position), x)
        state.eta[:] = np.linalg.lstsq(psi, angle, rcond=None)[0]
        moved = psi_l @ state.eta * line.slider_speed
        state.eta_rate[:] = np.linalg.lstsq(psi, angle_rate - moved, rcond=None)[0]
        return y

    def rate(self, y: Array) -> Array:
        """dy/dt of a state that can move; the workspace holds forces and signals afterwards."""
        rate = np.empty(len(y))
        self._evaluate(y, rate)
        return rate

    def can_move(self, y: Array) -> bool:
        """Whether the accelerations exist in the state `y`."""
        return self._evaluate(y, np.empty_like(y))

    def _evaluate(self, y: Array, rate: Array) -> bool:
        p, w = self._at
        y = np.ascontiguousarray(y, dtype=float)
        return KERNEL(p.address, w.address, y.ctypes.data, rate.ctypes.data) == 1

    @property
    def equations(self) -> Equations:
        """The equations of motion as the integrator takes them."""
        p, w = self._at
        return Equations(KERNEL.address, p.address, w.address, self.workspace.watched)

    def integrate(self, y: Array, output_step: float, intervals: int, tolerance: float, first_step: float = 0.0) -> Integration:
        """States on a uniform grid from the state `y`; see `reference_model.integrate.dop853`."""
        scales, rate = self._scales(y, tolerance), pace(self.scene, self.shapes)
        return dop853(self.equations, y, output_step, intervals, scales, self._shapes.reach, rate, first_step)

    def observe(self, states: Array) -> dict[str, Array]:
        """Observables of states (k, 2 n + 4), each of shape (k,), by the names in `reference_model.columns`."""
        evaluated = [(self.rate(y), self.workspace.signals.copy(), self.workspace.facts.copy()) for y in np.ascontiguousarray(states)]
        _, signals, facts = map(np.array, zip(*evaluated, strict=True))
        return observables(self.scene, self._shapes, states, signals, facts)

    def _scales(self, y: Array, tolerance: float) -> Array:
        """Accepted local error of each controlled state; sizes as in `reference_model.model.BeamModel.error_scales`."""
        follower, n, frequency = self.scene.follower, self.shapes, characteristic_frequency(self.scene, self.shapes)
        size = deflection_scale(self.scene) * np.sqrt((follower.mass_per_length or 1.0) * follower.length)
        speed = crank_speed_scale(self.scene, float(State.of(y, slider=False).u[0]))
        return tolerance * np.array([0.1, *[size] * n, speed, *[size * frequency] * n])
