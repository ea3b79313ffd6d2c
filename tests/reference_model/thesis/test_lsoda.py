"""LSODA's loop where the integration ends early."""

import numpy as np
import pytest

from quickreturn.reference_model.integrate import STEP_TOO_SMALL
from quickreturn.reference_model.thesis.model import integrate_lsoda


def test_what_was_done_until_a_pole_is_kept_and_counted() -> None:
    """The solution of y' = y^2 from 1 has its pole at 1 s; odeint leaves what comes after the tenth output step uninitialised."""
    evaluations = 0

    def equations(state: np.ndarray, rate: np.ndarray) -> bool:
        nonlocal evaluations
        evaluations += 1
        rate[0] = state[0] ** 2
        return True

    found = integrate_lsoda(equations, np.zeros(1), np.ones(1), 0.1, 30, np.array([1e-9]), 1.0, 1.0)
    assert found.status == STEP_TOO_SMALL
    assert found.end_time == pytest.approx(0.9)
    np.testing.assert_allclose(found.states[:, 0], 1.0 / (1.0 - 0.1 * np.arange(10)), rtol=1e-7)
    assert found.calls == pytest.approx(evaluations - len(found.states), abs=20)  # each state is checked once more
