"""The thesis' model of one scene: shapes, compiled equations, integration and observables under one roof."""

import math
import warnings
from collections.abc import Callable

import numpy as np
import scipy  # whose parts are imported when they are used

from quickreturn.reference_model.arrays import Array, eigh
from quickreturn.reference_model.columns import ROW, by_column, recorded_columns
from quickreturn.reference_model.constants import characteristic_frequency, crank_speed_scale
from quickreturn.reference_model.integrate import LEFT_FOLLOWER, NOT_A_NUMBER, REACHED_END, STEP_TOO_SMALL, TOO_MANY_CALLS, Integration
from quickreturn.reference_model.mechanism import Mechanism, Scene
from quickreturn.reference_model.model import ObservationFailed
from quickreturn.reference_model.native.memory import Placed
from quickreturn.reference_model.shapes import ShapeSet
from quickreturn.reference_model.state import State
from quickreturn.reference_model.thesis.equations import base_right_hand_side, right_hand_side
from quickreturn.reference_model.thesis.parameters import POINTS, build_parameters, build_tables, build_workspace, state_size

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


def integrate_lsoda(
    equations: Callable[[Array, Array], bool],
    watched: Array,
    y: Array,
    output_step: float,
    intervals: int,
    scales: Array,
    limit: float,
    unseen: float,
) -> Integration:
    """States on a uniform grid.

    Args:
        equations: function that writes dy/dt of a state to its second argument; False for an impossible state.
        watched: array whose first entry is the slider position in the state evaluated last, m.
        y: state at the start; not changed.
        output_step: grid of the output, s.
        intervals: number of output steps.
        scales: accepted local error of each controlled state, in its unit. The controlled states come first.
        limit: slider position at which the integration ends, m.
        unseen: accepted local error of the energies, J: so large that they do not matter, because they are quadratures.
    """
    size = len(y)
    rate = np.empty(size)

    def fun(_: float, state: Array) -> Array:
        equations(state, rate)
        return rate

    errors = np.full(size, unseen)
    errors[: len(scales)] = scales
    times = output_step * np.arange(intervals + 1)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", scipy.integrate.ODEintWarning)
        states, info = scipy.integrate.odeint(
            fun, y, times, tfirst=True, rtol=1e-14, atol=errors, mxstep=100_000, full_output=True, printmessg=False
        )
    good, status, last = len(states), REACHED_END, intervals - 1
    if info["message"] != "Integration successful.":
        # odeint does not initialise what comes after the first output step whose end it did not reach
        last = int(np.argmax(info["tcur"] < times[1:] - 1e-9 * output_step))
        good, status = 1 + last, TOO_MANY_CALLS if info["message"].startswith("Excess work") else STEP_TOO_SMALL
    for row in range(good):
        if not (np.all(np.isfinite(states[row])) and equations(states[row], rate)):
            good, status = row, NOT_A_NUMBER
            break
        if watched[0] > limit:
            good, status = row, LEFT_FOLLOWER
            break
    return Integration(states[:good], status, times[max(good - 1, 0)], int(info["nfe"][last]), 0.0)


def shape_frequencies(mechanism: Mechanism, shapes: ShapeSet, support: float, count: int) -> Array:
    """Lowest natural frequencies (Hz) of the straight follower at rest in these shapes, the slider held at arc length `support`.

    With the crank held the constraint is q2 = -sum phi_i(s) eta_i / s (equation 7.1), so that a rigid rotation goes with every shape
    (equations 7.2 and 7.3). Undamped, without gravity. By Rayleigh's principle the frequencies lie above the converged ones.

    Args:
        mechanism: the scene; its follower must be flexible.
        shapes: the follower's shapes.
        support: s, m.
        count: number of frequencies, or the number of shapes if that is less.
    """
    beam, tip = mechanism.follower, mechanism.tip_body
    tables = build_tables(shapes, 0)
    at_support = shapes.evaluate(np.array([support]))[0]
    turn = -at_support / support
    field = tables.phi + tables.x[:, None] * turn
    arm = beam.length + tip.center_of_mass
    end = tables.end_phi + tip.center_of_mass * tables.end_dphi + arm * turn
    end_turn = tables.end_dphi + turn
    slider_turn = shapes.evaluate(np.array([support]), 1)[0] + turn
    mass = beam.mass_per_length * field.T @ (tables.weights[:, None] * field)
    mass += mechanism.base.inertia * np.outer(turn, turn) + tip.mass * np.outer(end, end) + tip.inertia * np.outer(end_turn, end_turn)
    mass += mechanism.slider.inertia * np.outer(slider_turn, slider_turn)
    stiffness = beam.bending_stiffness * tables.ddphi.T @ (tables.weights[:, None] * tables.ddphi)
    # M v = v / omega^2 K v, not the other way round: round-off is relative to the largest eigenvalue
    inverse_squares = eigh(mass, stiffness)[0][::-1][:count]
    return 1.0 / (2.0 * np.pi * np.sqrt(inverse_squares))
