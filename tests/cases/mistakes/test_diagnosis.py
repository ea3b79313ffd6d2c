"""What a column's difference tells if the engine does not say how far off it may be."""

import numpy as np
import pytest

from quickreturn.cases.mistakes.diagnosis import diagnose
from quickreturn.plugins.conform.scenes import ALONE as SCENE


@pytest.mark.parametrize(("factor", "told"), [(0.6, False), (0.04, True), (1e-3, True), (0.0, True)])
def test_a_column_that_hardly_moves_is_no_coarse_one(factor: float, told: bool) -> None:
    time = np.linspace(0.0, 1.0, 201)
    right = {"time": time, "strain_1": 1e-5 * np.sin(20.0 * time), "tip_x": np.cos(3.0 * time)}
    # what is left has another shape, as that of a coarse model has
    found = factor * (right["strain_1"] + 3e-6 * np.cos(31.0 * time))
    assert (diagnose("strain_1", found, right["strain_1"], None, right, SCENE) is not None) == told
