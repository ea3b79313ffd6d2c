"""The explicit model with the loop left open and its constraint treated by one of the rival methods."""

import math
from dataclasses import dataclass, field
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import eig, null_space

from reference_model.constraints.gap import Speeds
from reference_model.constraints.joint import Joint
from reference_model.constraints.open_loop import close_loop, observe_open, open_equations, open_right_hand_side
from reference_model.constraints.workspace import OpenWorkspace, open_workspace
from reference_model.integrate import Integration, dop853
from reference_model.mechanism import Mechanism
from reference_model.model import ExplicitModel, ObservationFailed
from reference_model.observables import COLUMNS
from reference_model.parameters import build_workspace
from reference_model.rigid import rigid_motion
from reference_model.shapes import ShapeSet

Array = NDArray[np.float64]

#: Columns of `joint_out` in `observe_open`.
JOINT_COLUMNS: Final = ("gap_rate", "joint_power")


@dataclass(frozen=True)
class OpenLoopModel:
    """A scene with fixed shapes in which q2 is a coordinate of its own and the slider's constraint is a force.

    Args:
        mechanism: the scene; a slider without rotary inertia. Its joint stiffness is not read: `joint` says what the joint does.
        shapes: the follower's shapes (`no_shapes` if it is rigid; Hermite elements for nodal loads).
        joint: constraint treatment.
        recover: recover curvature and shape from equilibrium at output times; else the shapes are shown as they are.
    """

    mechanism: Mechanism
    shapes: ShapeSet
    joint: Joint
    recover: bool
    closed: ExplicitModel = field(init=False, repr=False)  # the same beam with the loop closed, for starts and observables
    _workspace: OpenWorkspace = field(init=False, repr=False)

    def __post_init__(self) -> None:
        closed = ExplicitModel(self.mechanism, self.shapes, True, self.recover)
        object.__setattr__(self, "closed", closed)
        object.__setattr__(self, "_workspace", open_workspace(build_workspace(closed.parameters.tables)))

    @property
    def degrees_of_freedom(self) -> int:
        """Number of coordinates integrated: q2, the flexible ones, and the crank unless its speed is prescribed."""
        return self.closed.degrees_of_freedom + 1

    def initial_state(self, crank_angle: float, crank_speed: float, eta: Array | None = None, eta_rate: Array | None = None) -> Array:
        """State vector (2 n + 7,) without gap or gap rate for given crank and flexible coordinates (zero unless given).

        Raises:
            ObservationFailed: the loop cannot be closed.
        """
        n, p = self.shapes.count, self.closed.parameters
        bend = np.zeros(n) if eta is None else np.asarray(eta, dtype=np.float64)
        bend_rate = np.zeros(n) if eta_rate is None else np.asarray(eta_rate, dtype=np.float64)
        speeds = Speeds(crank_angle, 0.0, bend, crank_speed, 0.0, bend_rate)
        closes, q2, q2_rate = close_loop(p, self._workspace.beam, speeds)
        if not closes:
            raise ObservationFailed(0)
        return np.concatenate([[crank_angle, q2], bend, [crank_speed, q2_rate], bend_rate, np.zeros(3)])

    def integrate(self, y: Array, output_step: float, intervals: int, tolerance: float, first_step: float = 0.0) -> Integration:
        """States on a uniform grid from the state `y`; see `reference_model.integrate.integrate_dop853`."""
        p = self.closed.parameters
        parameters: Any = (p, self.joint)  # a plain tuple chooses the equations of the open loop
        scales = self._error_scales(y) * tolerance
        return dop853(open_equations, parameters, self._workspace, y, output_step, intervals, scales, p.L, first_step)

    def _error_scales(self, y: Array) -> Array:
        """As `reference_model.integrate.error_scales`; a hundredth of a radian for q2 goes with a hundredth of L."""
        p = self.closed.parameters
        frequency = 10.0 * math.sqrt(p.EI / p.rhoA) / p.L**2 if p.n else 1.0
        size, speed = 0.01 * p.L, 0.1 * max(abs(float(y[p.n + 2])), 1.0)
        return np.array([0.1, 0.01, *[size] * p.n, speed, 0.01 * frequency, *[size * frequency] * p.n])

    def observe(self, states: Array) -> tuple[dict[str, Array], dict[str, Array]]:
        """Observables of states (k, 2 n + 7), and what the joint does: `JOINT_COLUMNS` (m/s, W); each of shape (k,).

        Raises:
            ObservationFailed: a state in which the crank tip is not beside the follower.
        """
        out, joint_out = np.zeros((len(states), len(COLUMNS))), np.zeros((len(states), len(JOINT_COLUMNS)))
        closed = self.closed
        rows = observe_open(
            closed.parameters,
            self.joint,
            self._workspace,
            closed._output_mesh,
            closed._output_workspace,
            np.ascontiguousarray(states),
            self.recover,
            out,
            joint_out,
        )
        if rows < len(states):
            raise ObservationFailed(rows)
        columns = dict(zip(COLUMNS, np.ascontiguousarray(out.T), strict=True))
        joint = dict(zip(JOINT_COLUMNS, np.ascontiguousarray(joint_out.T), strict=True))
        if self.joint.is_spring:
            columns["strain_energy"] += 0.5 * self.joint.stiffness * columns["constraint_gap"] ** 2
            # what the joint did not give back it has turned into heat
            stored = 0.5 * self.joint.stiffness * columns["constraint_gap"] ** 2
            columns["dissipated_energy"] -= states[:, -1] + stored
        return columns, joint

    def natural_frequencies(self, crank_angle: float, count: int) -> Array:
        """Lowest natural frequencies (Hz) with the crank held, follower straight, at rest, no gravity, undamped (equation R6.1).

        Where force and motion are not conjugate the equations are not symmetric: of complex roots the modulus.
        """
        squares = np.sort(np.abs(self._frozen_squares(crank_angle)))
        return np.asarray(np.sqrt(squares[:count]) / (2.0 * np.pi), dtype=np.float64)

    def growth_rates(self, crank_angle: float) -> Array:
        """Rates (1/s) at which the same small vibrations grow of themselves, one per pair of roots: zero for a conjugate joint."""
        return np.asarray(np.abs(np.real(np.sqrt(-self._frozen_squares(crank_angle).astype(complex)))), dtype=np.float64)

    def _frozen_squares(self, crank_angle: float) -> NDArray[np.complex128]:
        """Squares of the angular frequencies."""
        n, motion = self.shapes.count, rigid_motion(self.mechanism, np.array(crank_angle), 0.0)
        y = np.zeros(2 * n + 7)
        y[0], y[1] = crank_angle, float(motion.follower_angle)
        # mass matrix, row and spread are there even where the force that follows is not
        open_right_hand_side(self.closed.parameters, self.joint, self._workspace, y, np.empty_like(y))
        w = self._workspace
        mass, stiffness = w.beam.M[1:, 1:].copy(), np.zeros((n + 1, n + 1))
        stiffness[1:, 1:] = self.closed.parameters.stiffness
        row, spread = w.row[1:], w.spread[1:]
        if self.joint.is_spring:
            stiffness += self.joint.stiffness * np.outer(row, row)
        else:
            free, test = null_space(row[None, :]), null_space(spread[None, :])
            mass, stiffness = test.T @ mass @ free, test.T @ stiffness @ free
        # M v = v / omega^2 K v, not the other way round: round-off is relative to the largest eigenvalue
        found = 1.0 / eig(mass, stiffness, right=False)
        return np.asarray(found, dtype=np.complex128)
