"""The explicit model of one scene: shapes, compiled equations, integration and observables under one roof."""

from dataclasses import dataclass, field
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from reference_model.dynamics import right_hand_side
from reference_model.integrate import Integration, integrate_dop853, integrate_lsoda
from reference_model.mechanism import Mechanism
from reference_model.observables import COLUMNS, observe
from reference_model.parameters import Parameters, Workspace, build_parameters, build_workspace, state_size
from reference_model.shapes import ShapeSet
from reference_model.tables import POINTS, Tables, build_tables

Array = NDArray[np.float64]


class ObservationFailed(RuntimeError):
    """A state whose observables cannot be evaluated. `row` is its index."""

    def __init__(self, row: int) -> None:
        super().__init__(f"state {row} cannot be evaluated")
        self.row = row


@dataclass(frozen=True)
class ExplicitModel:
    """The pseudo-coordinate model of a scene with fixed shapes.

    Args:
        mechanism: the scene; a rigid slider joint.
        shapes: the follower's shapes (`no_shapes` if it is rigid).
        exact_geometry: exact planar geometry, or the thesis' second-order foreshortening.
        recover: recover curvature and shape from equilibrium at output times; else the shapes are shown as they are.
        transverse_damping: the beam damping acts on the transverse velocity alone.

    Raises:
        UnsuitableShapes: a slider with rotary inertia on shapes whose curvature jumps.
    """

    mechanism: Mechanism
    shapes: ShapeSet
    exact_geometry: bool
    recover: bool
    transverse_damping: bool = False
    parameters: Parameters = field(init=False, repr=False)
    _workspace: Workspace = field(init=False, repr=False)
    _output_mesh: Tables = field(init=False, repr=False)
    _output_workspace: Workspace = field(init=False, repr=False)

    def __post_init__(self) -> None:
        cells = quadrature_cells(self.shapes)
        parameters = build_parameters(
            self.mechanism, self.shapes, exact_geometry=self.exact_geometry, cells=cells, transverse_damping=self.transverse_damping
        )
        mesh = build_tables(self.shapes, 2 * ((cells or len(self.shapes.edges) - 1) // 2 + 1))
        for name, value in (
            ("parameters", parameters),
            ("_workspace", build_workspace(parameters.tables)),
            ("_output_mesh", mesh),
            ("_output_workspace", build_workspace(mesh)),
        ):
            object.__setattr__(self, name, value)

    @property
    def degrees_of_freedom(self) -> int:
        """Number of free speeds: the flexible coordinates, and the crank unless its speed is prescribed."""
        return self.shapes.count + (1 if self.mechanism.crank_is_free else 0)

    def initial_state(self, crank_angle: float, crank_speed: float, eta: Array | None = None, eta_rate: Array | None = None) -> Array:
        """State vector (2 n + 4,) for given crank and flexible coordinates (zero unless given)."""
        n = self.shapes.count
        y = np.zeros(state_size(self.parameters))
        y[0], y[n + 1] = crank_angle, crank_speed
        if eta is not None:
            y[1 : n + 1] = eta
        if eta_rate is not None:
            y[n + 2 : 2 * n + 2] = eta_rate
        return y

    def integrate(
        self,
        y: Array,
        output_step: float,
        intervals: int,
        tolerance: float,
        *,
        method: Literal["DOP853", "LSODA"],
        first_step: float = 0.0,
    ) -> Integration:
        """States on a uniform grid from the state `y`; see `reference_model.integrate`."""
        if method == "LSODA":
            return integrate_lsoda(self.parameters, self._workspace, y, output_step, intervals, tolerance)
        return integrate_dop853(self.parameters, self._workspace, y, output_step, intervals, tolerance, first_step)

    def observe(self, states: Array) -> dict[str, Array]:
        """Observables of states (k, 2 n + 4), by the names of `reference_model.observables.COLUMNS`, each of shape (k,).

        Raises:
            ObservationFailed: a state in which the loop cannot close.
        """
        out = np.zeros((len(states), len(COLUMNS)))
        rows = observe(
            self.parameters, self._workspace, self._output_mesh, self._output_workspace, np.ascontiguousarray(states), self.recover, out
        )
        if rows < len(states):
            raise ObservationFailed(rows)
        return dict(zip(COLUMNS, np.ascontiguousarray(out.T), strict=True))

    def can_move(self, y: Array) -> bool:
        """Whether the loop closes and the accelerations exist in the state `y`."""
        return bool(right_hand_side(self.parameters, self._workspace, y, np.empty_like(y)))

    def project_deflection(self, deflection: Array, slope: Array) -> Array:
        """Flexible coordinates (n,) closest to a deflection (m) and slope given at `projection_points`, in the mass norm and slope."""
        if self.shapes.count == 0:
            return np.zeros(0)
        x = self.projection_points()
        A = np.vstack([self.shapes.evaluate(x), self.mechanism.follower.length * self.shapes.evaluate(x, 1)])
        b = np.concatenate([deflection, self.mechanism.follower.length * slope])
        return np.linalg.lstsq(A, b, rcond=None)[0]

    def projection_points(self) -> Array:
        """Arc lengths (m) at which `project_deflection` wants deflection and slope."""
        return np.linspace(0.0, self.mechanism.follower.length, 8 * (self.shapes.count + 4) + 1)


def quadrature_cells(shapes: ShapeSet) -> int:
    """Cells of the quadrature mesh: 0 (the shapes' own) for elements, else enough for products of the highest modes.

    POINTS Gauss points a cell must come to about pi points for every wave of a product of two of the highest modes.
    """
    if not shapes.has_continuous_curvature or len(shapes.edges) == 2:
        return 0
    return max(2, int(np.ceil(np.pi * shapes.count / POINTS)) + 2)
