"""Conservation and balance: laws that hold whatever the equations' details; LSODA's loop where the integration ends early."""

import numpy as np
import pytest

from quickreturn.reference_model.integrate import STEP_TOO_SMALL
from quickreturn.reference_model.mechanism import PrescribedSpeed
from quickreturn.reference_model.thesis.model import integrate_lsoda
from tests.engines.scenes import run_24
from tests.reference_model.motion.beam_runs import balance, follower_energy, run
from tests.reference_model.thesis.thesis_runs import period, thesis, undriven


@pytest.mark.parametrize(("elements", "exact"), [(1, False), pytest.param(2, True, marks=pytest.mark.verify)])
def test_energy_is_conserved_over_twenty_cycles(elements: int, exact: bool) -> None:
    """What LSODA leaves at its tolerance; found: 4e-9 with one cubic."""
    mechanism = undriven()
    model = thesis(mechanism, elements=elements, exact=exact)
    _, columns = run(model, 20 * period(mechanism), 1000, 1e-10)
    assert np.ptp(balance(columns)) < 1e-8 * follower_energy(model, columns)


def test_work_of_a_prescribed_speed_is_what_becomes_of_it() -> None:
    mechanism = run_24(crank={"drive": PrescribedSpeed(speed=17.0)}, gravity=(0.0, -9.81))
    _, columns = run(thesis(mechanism, elements=2, exact=True), 1.0, 2000, 1e-10)
    assert np.ptp(columns["drive_work"]) > 0.5  # J
    assert np.ptp(balance(columns)) < 1e-8
    # the torque shown is the one that does the work: trapezoidal rule on 2000 points, second order
    torque = columns["crank_torque"]
    work = np.concatenate([[0.0], np.cumsum(0.5 * (torque[1:] + torque[:-1])) * 17.0 / 2000])
    assert np.max(np.abs(work - columns["drive_work"])) < 2e-3 * np.ptp(columns["drive_work"])


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
