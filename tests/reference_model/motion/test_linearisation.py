"""The matrices of the implicit integrator against differences of the equations of motion."""

import numpy as np
import pytest

from quickreturn.reference_model.arrays import Array
from quickreturn.reference_model.entries import KERNEL, LINEARISED, WEIGHED
from quickreturn.reference_model.joint import CLOSED, MULTIPLIER, ROLLERS, Rollers, SliderConstraint
from quickreturn.reference_model.model import BeamModel
from quickreturn.reference_model.native.memory import Placed
from quickreturn.reference_model.shapes import clamped_free_modes
from tests.engines.scenes import run_24

SPRING = SliderConstraint(kind=ROLLERS, rollers=Rollers(plus=1e6, minus=1e6, damping=300.0), inertia=2e-2)
FORCE = SliderConstraint(kind=MULTIPLIER, stabilization=50.0)


class _Linearised:
    """A model's equations and their matrices in one state, straight and at rest but for the crank."""

    def __init__(self, model: BeamModel, crank_speed: float) -> None:
        self.model, self.y = model, model.straight_state(2.0, crank_speed)
        self._at = Placed(model.parameters), Placed(model.workspace)
        size = model.parameters.unknowns
        assert self.rate(self.y) is not None
        self.matrices = np.zeros((3, size, size))
        LINEARISED(*(each.address for each in self._at), self.matrices.ctypes.data, size)

    def rate(self, y: Array) -> Array:
        rate = np.empty_like(y)
        assert KERNEL(*(each.address for each in self._at), y.ctypes.data, rate.ctypes.data) == 1
        return rate

    def difference(self, place: int, step: float) -> Array:
        """Derivative of the accelerations by an entry of the state, m of them."""
        m, shift = self.model.parameters.speeds, np.zeros_like(self.y)
        shift[place] = step
        change = (self.rate(self.y + shift) - self.rate(self.y - shift)) / (2.0 * step)
        return change[m + 1 : 2 * m + 1]

    def solved(self, column: Array) -> Array:
        """Accelerations from a column of stiffness or damping, the slider's force eliminated."""
        m, (M, _, K) = self.model.parameters.speeds, self.matrices
        bordered = M.copy()
        bordered[:, m:] = K[:, m:]
        return np.asarray(-np.linalg.solve(bordered, column)[:m])


@pytest.mark.parametrize("constraint", [CLOSED, FORCE, SPRING])
def test_matrices_are_derivatives_of_the_accelerations(constraint: SliderConstraint) -> None:
    """By the amplitudes and their rates, of which the elastic forces and the dampings are the largest part."""
    scene = run_24(follower={"material_damping": 1e-4})
    state = _Linearised(BeamModel.staying(scene, clamped_free_modes(scene.follower.length, 5), constraint), 0.0)
    m = state.model.parameters.speeds
    for k in range(3, 6):
        for place, matrix, step in ((k, 2, 1e-7), (m + 1 + k, 1, 1e-4)):
            expected, found = state.difference(place, step), state.solved(state.matrices[matrix][:, k])
            assert np.linalg.norm(found - expected) < 0.02 * np.linalg.norm(expected), (k, matrix)


@pytest.mark.parametrize("constraint", [CLOSED, FORCE, SPRING])
def test_weighed_accelerations_are_products_with_the_mass_matrix(constraint: SliderConstraint) -> None:
    scene = run_24()
    state = _Linearised(BeamModel.staying(scene, clamped_free_modes(scene.follower.length, 4), constraint), 16.0)
    m, size = state.model.parameters.speeds, state.model.parameters.unknowns
    a, force = np.random.default_rng(4).normal(size=m), np.full(size + 1, np.nan)
    WEIGHED(*(each.address for each in state._at), a.ctypes.data, force.ctypes.data)
    np.testing.assert_allclose(force[:size], state.matrices[0][:, :m] @ a, rtol=1e-12)
    assert np.isnan(force[size])
