"""The thesis' model of one scene: shapes, compiled equations, integration and observables under one roof."""

import math

import numpy as np
from numpy.typing import NDArray

from quickreturn.reference_model.columns import ROW, by_column, recorded_columns
from quickreturn.reference_model.constants import characteristic_frequency, crank_speed_scale
from quickreturn.reference_model.integration import Integration
from quickreturn.reference_model.mechanism import Scene
from quickreturn.reference_model.model import ObservationFailed
from quickreturn.reference_model.native.memory import Placed
from quickreturn.reference_model.shapes import ShapeSet
from quickreturn.reference_model.state import State
from quickreturn.reference_model.thesis.equations import base_right_hand_side, right_hand_side
from quickreturn.reference_model.thesis.lsoda import integrate_lsoda
from quickreturn.reference_model.thesis.parameters import build_parameters, build_workspace, state_size
from quickreturn.reference_model.thesis.tables import POINTS

Array = NDArray[np.float64]

_NO_ROW = np.empty(0)


class ThesisModel:
    """The pseudo-coordinate model of a scene in shapes of its deflection.

    Args:
        scene: the mechanism, with a rigid slider joint, or the follower alone.
        shapes: the follower's shapes (`no_shapes` if it is rigid).
        exact_geometry: exact planar geometry, or the thesis' second-order foreshortening.

    Raises:
        UnsuitableShapes: a slider with rotary inertia on shapes whose curvature jumps.
    """

    def __init__(self, scene: Scene, shapes: ShapeSet, exact_geometry: bool) -> None:
        self.scene = scene
        self.shapes = shapes
        self.parameters = build_parameters(scene, shapes, exact_geometry=exact_geometry, cells=quadrature_cells(shapes))
        self.workspace = build_workspace(self.parameters.tables)
        self._alone = scene.crank is None
        self._function = base_right_hand_side if self._alone else right_hand_side
        self._at = Placed(self.parameters), Placed(self.workspace)
        inertia = scene.follower.mass * scene.follower.length**2 + (scene.crank_inertia if scene.crank else 0.0)
        self._unseen = 1e3 * inertia * characteristic_frequency(scene, shapes.count) ** 2  # J, beside which no energy matters

    @property
    def degrees_of_freedom(self) -> int:
        """Number of free speeds: the flexible coordinates, and the crank unless its speed is prescribed."""
        return self.shapes.count + (1 if self.parameters.crank_is_free else 0)

    def initial_state(self, crank_angle: float, crank_speed: float, eta: Array | None = None, eta_rate: Array | None = None) -> Array:
        """State vector (2 n + 4,) for given crank and flexible coordinates (zero unless given)."""
        y = np.zeros(state_size(self.parameters))
        state = State.of(y, slider=False)
        state.q[0], state.u[0] = crank_angle, crank_speed
        if eta is not None:
            state.eta[:] = eta
        if eta_rate is not None:
            state.eta_rate[:] = eta_rate
        return y

    def state_at_rest(self) -> Array:
        """State vector of the follower alone at time 0, straight and still."""
        return self.initial_state(0.0, 1.0)

    def right_hand_side(self, y: Array, rate: Array, row: Array = _NO_ROW) -> bool:
        """Write dy/dt of a state to `rate`, and its observables to `row` (numbers of a `ROW`) if given; False for an impossible state."""
        p, w = self._at
        return bool(self._function(p.address, w.address, y, rate, row))

    def can_move(self, y: Array) -> bool:
        """Whether the loop closes and the accelerations exist in the state `y`."""
        return self.right_hand_side(y, np.empty_like(y))

    def error_scales(self, crank_speed: float) -> Array:
        """Size of each controlled state, to which the relative tolerance refers, as in `reference_model.model.BeamModel.error_scales`."""
        p = self.parameters
        frequency = characteristic_frequency(self.scene, p.n)
        shape, speed = p.deflection_scale, crank_speed_scale(self.scene, crank_speed)
        return np.array([0.1, *[shape] * p.n, speed, *[shape * frequency] * p.n])

    def integrate(self, y: Array, output_step: float, intervals: int, tolerance: float, first_step: float = 0.0) -> Integration:
        """States on a uniform grid from the state `y` by LSODA (thesis, section 5.2), which ignores `first_step`."""
        scales = self.error_scales(float(State.of(y, slider=False).u[0])) * tolerance
        limit = math.inf if self._alone else self.parameters.L
        return integrate_lsoda(
            self.right_hand_side, self.workspace.watched, y, output_step, intervals, scales, limit, tolerance * self._unseen
        )

    def observe(self, states: Array) -> dict[str, Array]:
        """Observables of states (k, 2 n + 4), each of shape (k,), by the names in `reference_model.columns`.

        Raises:
            ObservationFailed: a state in which the loop cannot close.
        """
        rows = np.zeros(len(states), ROW)
        rate = np.empty(states.shape[1])
        numbers = rows.view(np.float64).reshape(len(rows), ROW.itemsize // 8)
        for k, (y, row) in enumerate(zip(np.ascontiguousarray(states), numbers, strict=True)):
            if not self.right_hand_side(y, rate, row):
                raise ObservationFailed(k)
        return recorded_columns(by_column(rows), alone=self._alone, bends=self.shapes.count > 0)

    def project_deflection(self, deflection: Array, slope: Array) -> Array:
        """Flexible coordinates (n,) closest in least squares to a deflection (m), and to a slope times L, at `projection_points`."""
        if self.shapes.count == 0:
            return np.zeros(0)
        x, length = self.projection_points(), self.scene.follower.length
        A = np.vstack([self.shapes.evaluate(x), length * self.shapes.evaluate(x, 1)])
        return np.linalg.lstsq(A, np.concatenate([deflection, length * slope]), rcond=None)[0]

    def projection_points(self) -> Array:
        """Arc lengths (m) at which `project_deflection` takes deflection and slope."""
        return np.linspace(0.0, self.scene.follower.length, 8 * (self.shapes.count + 4) + 1)


def quadrature_cells(shapes: ShapeSet) -> int:
    """Number of cells of the quadrature mesh: 0 (the shapes' own cells) for elements, else enough for products of the highest modes.

    With POINTS Gauss points a cell, a wave of the product of the two highest modes has about pi points.
    """
    if not shapes.has_continuous_curvature or len(shapes.edges) == 2:
        return 0
    return max(2, int(np.ceil(np.pi * shapes.count / POINTS)) + 2)
