"""Balances of a motion, and what a run says where they are violated."""

from collections.abc import Callable

import numpy as np
import pytest

from quickreturn.cases.motion.balances import crank_jump, energy_residual
from quickreturn.cases.motion.endings import Ending
from quickreturn.cases.motion.request import Run, RunRequest
from quickreturn.cases.motion.steady_state import steady_state
from quickreturn.engines.base import Simulation
from quickreturn.engines.registry import engine
from quickreturn.engines.settings import Settings
from quickreturn.engines.start import Start
from quickreturn.engines.trajectory import Columns, Trajectory
from quickreturn.reference_model.mechanism import Mechanism
from tests.engines.scenes import run_24
from tests.engines.wrong_engines import Disguised


def test_a_balance_that_does_not_close_and_a_jump_are_measured() -> None:
    time = np.linspace(0.0, 1.0, 101)
    columns = {name: np.zeros_like(time) for name in ("gravity_energy", "dissipated_energy", "drive_work")}
    columns |= {"time": time, "kinetic_energy": np.cos(time) ** 2, "strain_energy": np.sin(time) ** 2}
    largest = float(np.sin(1.0) ** 2)
    assert energy_residual(columns) == pytest.approx(0.0, abs=1e-12)
    assert energy_residual(columns | {"dissipated_energy": 0.03 * time}) == pytest.approx(0.03 / largest)
    assert energy_residual(columns | {"dissipated_energy": 0.03 * time, "drive_work": 0.03 * time}) == pytest.approx(0.0, abs=1e-12)
    assert energy_residual({"time": time, "kinetic_energy": time}) is None

    turning = {"time": time, "crank_angle": 10.0 * time, "crank_speed": np.full_like(time, 10.0)}
    assert crank_jump(turning) == pytest.approx(0.0, abs=1e-12)
    jumped = turning | {"crank_angle": np.where(time < 0.5, 10.0 * time, 10.0 * time - 0.05)}
    assert crank_jump(jumped) == pytest.approx(0.5)  # half of the 0.1 rad that a row turns


class Spoiled(Simulation):
    """A sound simulation whose columns are changed."""

    def __init__(self, sound: Simulation, spoil: Callable[[Columns], Columns]) -> None:
        self._sound, self._spoil, self.setup_seconds, self.time = sound, spoil, sound.setup_seconds, sound.time

    def advance(self, duration: float, output_step: float) -> Trajectory:
        run = self._sound.advance(duration, output_step)
        self.time += duration
        return Trajectory({**run.columns, **self._spoil(run.columns)}, run.solve_seconds, run.statistics)


class Spoiling(Disguised):
    """Marches, with columns changed by `spoil`."""

    def __init__(self, spoil: Callable[[Columns], Columns]) -> None:
        super().__init__(engine("reference"))
        self._spoil = spoil

    def prepare(self, mechanism: Mechanism, start: Start, settings: Settings) -> Simulation:
        return Spoiled(self.sound.prepare(mechanism, start, settings), self._spoil)


def settled(spoil: Callable[[Columns], Columns], monkeypatch: pytest.MonkeyPatch) -> Run:
    monkeypatch.setattr("quickreturn.cases.motion.steady_state.engine_of_name", lambda _: Spoiling(spoil))
    return steady_state(RunRequest(mechanism=run_24(), duration=0.1, engine="spoiling", accuracy=1e-2, estimated=False))


@pytest.mark.parametrize(
    ("spoil", "told"),
    [
        (lambda _: {}, ""),
        (lambda columns: {"dissipated_energy": 1.1 * columns["dissipated_energy"]}, "doubtful: the energy balance is violated by"),
        (
            lambda columns: {"constraint_gap": columns["constraint_gap"] + 2e-4},
            "doubtful: the slider is off the centre line by up to 0.0002",
        ),
        (lambda columns: {"crank_speed": 1.03 * columns["crank_speed"]}, "doubtful: the crank angle jumps"),
    ],
    ids=["nothing", "energy", "gap", "speed"],
)
def test_a_run_tells_a_balance_that_it_violates(spoil: Callable[[Columns], Columns], told: str, monkeypatch: pytest.MonkeyPatch) -> None:
    run = settled(spoil, monkeypatch)
    assert run.status == Ending.SETTLED
    assert run.remark.startswith(told) if told else "doubtful" not in run.remark
