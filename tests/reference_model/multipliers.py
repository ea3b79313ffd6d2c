"""All Floquet multipliers of a model, by derivatives along each of its quantities."""

import numpy as np
from numpy.typing import NDArray

from quickreturn.plugins.methods.moving_boundaries.model import MovingBoundariesModel
from quickreturn.reference_model.constants import pace
from quickreturn.reference_model.cycles.periodic import PeriodicOrbit, _Cycle, _jacobian, eigenvalues
from quickreturn.reference_model.cycles.poincare import PoincareMap
from quickreturn.reference_model.integrate import dop853
from quickreturn.reference_model.model import BeamModel
from quickreturn.reference_model.state import State


def floquet_multipliers(model: BeamModel, orbit: PeriodicOrbit, integration: float = 1e-9) -> NDArray[np.complex128]:
    """The 2 n + 1 multipliers (2 n with prescribed speed) of the whole model, largest modulus first; each costs a cycle."""
    return eigenvalues(_jacobian(_Cycle.of(PoincareMap(model, integration), orbit.state, orbit.period)))


def linear_multipliers(model: MovingBoundariesModel, crank_speed: float, tolerance: float = 1e-9) -> NDArray[np.complex128]:
    """The eigenvalues of the monodromy matrix of a turn (equation 5.4), largest modulus first, shape (2 n,); crank_speed: rad/s."""
    straight = model.straight_state(np.pi, crank_speed)
    places = State.of(np.arange(len(straight)), slider=False)
    free = np.concatenate([places.eta, places.eta_rate])
    scales = model._scales(straight, tolerance)
    sizes, starts = scales[free] / tolerance, np.tile(straight, (1 + len(free), 1))
    starts[1:, free] = np.diag(sizes)
    turn, rate = 2.0 * np.pi / abs(crank_speed), pace(model.scene, model.shapes)
    ends = np.array([dop853(model.equations, y, turn, 1, scales, np.inf, rate).states[-1, free] for y in starts])
    return eigenvalues((ends[1:] - ends[0]).T / sizes[:, None])
