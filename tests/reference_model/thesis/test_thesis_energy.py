"""Conservation and balance: laws that hold whatever the equations' details."""

import numpy as np
import pytest

from quickreturn.reference_model.mechanism import PrescribedSpeed
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
