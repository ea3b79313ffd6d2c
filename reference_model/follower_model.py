"""Models of the follower alone on a base that turns as prescribed: constants, integration and observables under one roof."""

from abc import ABC, abstractmethod
from dataclasses import dataclass, field
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from reference_model.clamped_observables import FOLLOWER_COLUMNS, observe_clamped
from reference_model.clamped_parameters import ClampedParameters, ClampedWorkspace, clamped_parameters, clamped_workspace
from reference_model.equations import right_hand_side
from reference_model.integrate import Integration, integrate_dop853, integrate_lsoda
from reference_model.mechanism import FollowerAlone
from reference_model.model import ObservationFailed, quadrature_cells
from reference_model.parameters import Workspace, build_parameters, build_workspace
from reference_model.prescribed_base import OnBase, observe_on_base
from reference_model.shapes import ShapeSet
from reference_model.tables import Tables, build_tables

Array = NDArray[np.float64]


class _FollowerModel(ABC):
    """What the models have in common: the state at rest, integration, and the names of the columns."""

    scene: FollowerAlone
    parameters: ClampedParameters | OnBase
    _workspace: ClampedWorkspace | Workspace

    @property
    def degrees_of_freedom(self) -> int:
        """Number of flexible coordinates; the base's angle is prescribed."""
        return self.parameters.n

    def state_at_rest(self) -> Array:
        """State vector (2 n + 4,) at time 0, the follower straight and still."""
        y = np.zeros(2 * self.parameters.n + 4)
        y[self.parameters.n + 1] = 1.0
        return y

    def can_move(self, y: Array) -> bool:
        """Whether the accelerations exist in the state `y`."""
        return bool(right_hand_side(self.parameters, self._workspace, y, np.empty_like(y)))

    def integrate(
        self,
        y: Array,
        output_step: float,
        intervals: int,
        tolerance: float,
        *,
        method: Literal["DOP853", "LSODA"] = "DOP853",
        first_step: float = 0.0,
    ) -> Integration:
        """States on a uniform grid from the state `y`; see `reference_model.integrate`."""
        if method == "LSODA":
            return integrate_lsoda(self.parameters, self._workspace, y, output_step, intervals, tolerance)
        return integrate_dop853(self.parameters, self._workspace, y, output_step, intervals, tolerance, first_step)

    @abstractmethod
    def _observe(self, states: Array, out: Array) -> int:
        """Fill a row of `out` for each state; the number of rows filled before a state that cannot be."""

    def observe(self, states: Array) -> dict[str, Array]:
        """Observables of states (k, 2 n + 4), by the names of `clamped_observables.FOLLOWER_COLUMNS`, each of shape (k,).

        Raises:
            ObservationFailed: a state that cannot be.
        """
        out = np.zeros((len(states), len(FOLLOWER_COLUMNS)))
        rows = self._observe(np.ascontiguousarray(states), out)
        if rows < len(states):
            raise ObservationFailed(rows)
        return dict(zip(FOLLOWER_COLUMNS, np.ascontiguousarray(out.T), strict=True))


@dataclass(frozen=True)
class ClampedModel(_FollowerModel):
    """The follower in its first `modes` (at least 1) clamped modes, of its tangent's angle: geometrically exact."""

    scene: FollowerAlone
    modes: int
    parameters: ClampedParameters = field(init=False, repr=False)
    _workspace: ClampedWorkspace = field(init=False, repr=False)

    def __post_init__(self) -> None:
        parameters = clamped_parameters(self.scene, self.modes)
        object.__setattr__(self, "parameters", parameters)
        object.__setattr__(self, "_workspace", clamped_workspace(parameters))

    def _observe(self, states: Array, out: Array) -> int:
        return observe_clamped(self.parameters, self._workspace, states, out)


@dataclass(frozen=True)
class FixedShapeFollower(_FollowerModel):
    """The follower in fixed shapes of its deflection: the thesis' beam, or the same exactly.

    Args:
        scene: the scene.
        shapes: the follower's shapes.
        exact_geometry: exact planar geometry, or the thesis' second-order foreshortening.
        recover: recover curvature and shape from equilibrium at output times; else the shapes are shown as they are.
        transverse_damping: the beam damping acts on the transverse velocity alone.
    """

    scene: FollowerAlone
    shapes: ShapeSet
    exact_geometry: bool
    recover: bool
    transverse_damping: bool = False
    parameters: OnBase = field(init=False, repr=False)
    _workspace: Workspace = field(init=False, repr=False)
    _output_mesh: Tables = field(init=False, repr=False)
    _output_workspace: Workspace = field(init=False, repr=False)

    def __post_init__(self) -> None:
        cells = quadrature_cells(self.shapes)
        beam = build_parameters(
            self.scene, self.shapes, exact_geometry=self.exact_geometry, cells=cells, transverse_damping=self.transverse_damping
        )
        mesh = build_tables(self.shapes, 2 * ((cells or len(self.shapes.edges) - 1) // 2 + 1))
        for name, value in (
            ("parameters", OnBase(beam, self.scene.spin_up.speed, self.scene.spin_up.time)),
            ("_workspace", build_workspace(beam.tables)),
            ("_output_mesh", mesh),
            ("_output_workspace", build_workspace(mesh)),
        ):
            object.__setattr__(self, name, value)

    def _observe(self, states: Array, out: Array) -> int:
        mesh, v = self._output_mesh, self._output_workspace
        return observe_on_base(self.parameters, self._workspace, mesh, v, states, self.recover, out)
