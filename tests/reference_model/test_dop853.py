"""The integrator's coefficients, and the splines of its tables, against those of scipy."""

import numpy as np
import pytest
import scipy

from quickreturn.reference_model import dop853
from quickreturn.reference_model.beam.tables import spline_coefficients


def test_coefficients_are_those_of_scipy() -> None:
    ours, scipys = dop853.A, scipy.integrate.DOP853
    np.testing.assert_array_equal(ours[:12, :12], scipys.A)
    np.testing.assert_array_equal(ours[12, :12], scipys.B)
    for name in ("E3", "E5"):
        np.testing.assert_array_equal(getattr(dop853, name), getattr(scipys, name))


@pytest.mark.parametrize("nodes", [np.linspace(0.2, 0.6, 25), np.geomspace(1.0, 3.0, 7)], ids=["even", "uneven"])
def test_splines_are_those_of_scipy(nodes: np.ndarray) -> None:
    values = np.random.default_rng(5).normal(size=(len(nodes), 6))
    np.testing.assert_array_equal(spline_coefficients(nodes, values), scipy.interpolate.CubicSpline(nodes, values).c.transpose(1, 0, 2))
