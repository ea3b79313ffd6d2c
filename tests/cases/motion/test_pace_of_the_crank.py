"""A steady state needs a crank that turns, neither too slowly nor too fast to be measured; anything else ends with a sentence."""

import math
from itertools import islice

import numpy as np
import pytest

from quickreturn.cases.library import load_case
from quickreturn.cases.motion.endings import Ending
from quickreturn.cases.motion.marching import March, settle
from quickreturn.cases.motion.request import RunRequest
from quickreturn.cases.motion.steady_state import steady_state
from quickreturn.engines.base import EngineFailure
from quickreturn.engines.start import Start
from quickreturn.engines.trajectory import Trajectory
from tests.engines.fake_engine import FakeSettings, FakeSimulation

STEP = 5e-4  # s


class Turning(FakeSimulation):
    """The fake motion with a crank that begins at one speed and approaches another at a rate of 1/s."""

    def __init__(self, first: float, final: float) -> None:
        super().__init__(Start(math.pi, first), FakeSettings())
        self._speeds = (first, final)

    def advance(self, duration: float, output_step: float) -> Trajectory:
        trajectory = super().advance(duration, output_step)
        first, final = self._speeds
        time = trajectory["time"]
        trajectory.columns["crank_speed"] = final + (first - final) * np.exp(-time)
        trajectory.columns["crank_angle"] = math.pi + final * time - (first - final) * np.expm1(-time)
        for name in ("tip_acceleration", "strain_1", "strain_2", "strain_3"):  # settled at once
            trajectory.columns[name] = np.cos(trajectory["crank_angle"])
        return trajectory


@pytest.mark.parametrize(
    ("first", "final", "told"),
    [
        (0.0, 0.0, "failed at t = 10 s: the crank stands still or turns back; let it turn one way, by torque or speed"),
        (10.0, -10.0, "the crank stands still or turns back"),
        (10.0, 1e-9, "the crank takes more than 100 s for a turn; let it turn faster"),
        (1e-9, 1e-9, "the crank takes more than 100 s for a turn; let it turn faster"),
        (1e6, 1e6, "the crank takes 6.28e-06 s for a turn, much less than its drive says"),
        (10.0, 1e4, "for a turn, much less than its drive says"),
    ],
)
def test_a_crank_that_does_not_turn_ends_the_search_with_a_sentence(first: float, final: float, told: str) -> None:
    with pytest.raises(EngineFailure) as failure:
        settle(March(Turning(first, final), first, STEP))
    assert told in str(failure.value)
    assert failure.value.time < 300.0


def test_a_run_whose_crank_stalls_says_so() -> None:
    """A motor that cannot lift its own flywheel."""
    scene = load_case("example", {"follower.bending_stiffness": "inf", "crank.initial_speed": "0 rpm", "crank.center_of_mass": "50 mm"})
    run = steady_state(RunRequest(mechanism=scene.mechanism, duration=0.5, engine="reference"))
    assert run.status == Ending.FAILED
    assert "the crank stands still or turns back" in run.remark
    assert run.computation.solve_seconds > 0.0


@pytest.mark.parametrize(("first", "final"), [(0.0, 10.0), (0.5, 10.0), (10.0, 2.0), (-10.0, -9.0)])
def test_a_crank_that_finds_its_speed_settles(first: float, final: float) -> None:
    (cycle,), settling = settle(March(Turning(first, final), first, STEP))
    assert settling.settled
    # one turn at the final speed; by the fourth cycle, the earliest that can settle, exp(-t) has died away to below 5 %
    assert cycle["time"][-1] - cycle["time"][0] == pytest.approx(2.0 * math.pi / abs(final), rel=0.05)


def test_a_march_that_goes_on_from_a_run_is_the_same_march() -> None:
    """What was simulated for the estimate is not simulated again."""
    whole, begun = Turning(9.0, 9.0), Turning(9.0, 9.0)
    piece = begun.advance(1.9, STEP)
    on = March(begun, 9.0, STEP, piece)
    for one, other in islice(zip(March(whole, 9.0, STEP), on, strict=False), 5):
        np.testing.assert_allclose((one.time[0], one.time[-1]), (other.time[0], other.time[-1]), rtol=1e-12)
        np.testing.assert_allclose(one.crank_angle[-1], other.crank_angle[-1])


class Trembling(Turning):
    """A motion that repeats exactly, with a vibration for which the rows are few."""

    def advance(self, duration: float, output_step: float) -> Trajectory:
        trajectory = super().advance(duration, output_step)
        trajectory.columns["tip_acceleration"] = np.cos(trajectory["crank_angle"]) + 0.03 * np.sin(400.0 * trajectory["crank_angle"])
        return trajectory


def test_rows_that_are_too_few_for_a_vibration_are_taken_closer() -> None:
    """At 9 rad/s a turn is 1396.3 rows, 3.5 to a period of the vibration: each turn's rows meet it at other phases."""
    march = March(Trembling(9.0, 9.0), 9.0, STEP)
    (cycle,), settling = settle(march, multiplier=0.9, halve_step=march.halve_step)
    assert settling.settled
    assert settling.cycles < 15
    assert len(cycle["time"]) == pytest.approx(2 * 1396, abs=4)
    _, alone = settle(March(Trembling(9.0, 9.0), 9.0, STEP), multiplier=0.9)
    assert not alone.settled


@pytest.mark.parametrize(("multiplier", "rattles"), [(None, False), (0.9, True)])
def test_rows_stay_as_they_are_where_noise_may_be_the_motion(multiplier: float | None, rattles: bool) -> None:
    march = March(Trembling(9.0, 9.0), 9.0, STEP)
    found, _ = settle(march, multiplier, rattles, march.halve_step)
    assert len(found[-1]["time"]) == pytest.approx(1396, abs=3)
