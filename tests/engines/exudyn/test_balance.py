"""Steps keep the energy balance of arms that hardly bend, and soft arms keep the steps that their deflection needs."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from quickreturn.cases.library import load_case
from quickreturn.cases.motion.balances import Balances
from quickreturn.engines.exudyn import settings as ladder
from quickreturn.engines.exudyn.engine import ExudynEngine
from quickreturn.engines.one_run import run_once
from quickreturn.engines.start import standard_start

ENGINE = ExudynEngine()


@pytest.mark.parametrize("case", ["hard-shaper-steel", "hard-ei-x1000"])
def test_steps_keep_the_energy_balance_of_an_arm_that_hardly_bends(case: str) -> None:
    """The deflection alone is right with plain steps of 1 ms, which leave 9 and 340 % of the largest bending energy."""
    mechanism, accuracy = load_case(case).mechanism, 1e-2
    settings = ENGINE.settings_for(accuracy, mechanism)
    columns = run_once(ENGINE, mechanism, standard_start(mechanism), 0.3, 1e-3, settings).trajectory.columns
    assert Balances.of(columns, mechanism).violated(accuracy) == ""


@given(accuracy=st.floats(1e-4, 5e-2), frequency=st.floats(1.0, 1e5))
def test_only_steps_that_leave_too_much_energy_become_others(accuracy: float, frequency: float) -> None:
    """To within the rounding of steps to two digits, which is 5 % at most."""
    rung = ladder.rung_for(accuracy, 1.0, moves_much=True)
    found = ladder.balanced(rung, accuracy, frequency)
    left = ladder.LEFT_BY_STEPS[found.extrapolated] * (found.step * frequency) ** 2
    assert left <= 2.0 * accuracy * 1.05**2 or found.step <= ladder.SHORTEST_FOR_BALANCE
    assert found == rung or (found.extrapolated and found.step <= rung.step)
    assert found == rung or ladder.LEFT_BY_STEPS[rung.extrapolated] * (rung.step * frequency) ** 2 > 2.0 * accuracy
