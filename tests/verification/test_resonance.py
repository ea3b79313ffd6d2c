"""The resonance curve of run 24's machine, confirmed by marching other engines up and down in speed."""

import dataclasses
import math
from functools import cache

import numpy as np
import pytest

from quickreturn.cases.motion.resonance import resonance
from quickreturn.engines.own.simulation import OwnSimulation
from quickreturn.engines.registry import usable_engine
from quickreturn.plugins.strength.case_loads import HARDLY, share_of
from quickreturn.plugins.studies.resonance_curve.search import _maxima
from quickreturn.reference_model.cycles.continuation import Branch, branch
from quickreturn.reference_model.cycles.cycle_family import CycleFamily
from quickreturn.reference_model.cycles.fixed_points import BranchPoint
from quickreturn.reference_model.mechanism import Mechanism, PrescribedSpeed
from tests.engines.scenes import run_24

RPM = math.pi / 30.0
LOW, HIGH = 140.0 * RPM, 250.0 * RPM
#: rpm, and the way on which a march comes to it: five points, two of them at one speed between the folds.
PLACES = ((150.0, 1), (166.5, 1), (236.0, 1), (236.0, -1), (246.0, -1))
CYCLES = 40
STEPS = 400  # a turn


def at_speed(speed: float) -> Mechanism:
    return run_24(crank={"drive": PrescribedSpeed(speed=speed)})


@cache
def curve() -> tuple[CycleFamily, Branch]:
    family = CycleFamily(at_speed, 5, 1e-10)
    return family, branch(family, family.orbit(LOW), LOW, LOW, HIGH)


def stable_point(speed: float, way: int) -> BranchPoint:
    """The stable point about a speed on the first part of the curve (1) or on its last one (-1)."""
    _, found = curve()
    stable = [each for each in found.points if not each.instability]
    ordered = stable if way > 0 else stable[::-1]
    return next(each for each in ordered if way * (each.parameter - speed) >= 0.0)


def peak(family: CycleFamily, point: BranchPoint) -> float:
    return float(np.max(np.abs(family.columns(point.point, point.parameter, STEPS)["tip_acceleration"])))


@pytest.mark.verify
@pytest.mark.parametrize(
    ("engine", "accuracy", "apart", "rpm", "way"),
    [
        *(("reference", 1e-3, 0.005, *place) for place in PLACES),
        *(("mujoco", 7e-3, 0.02, *place) for place in PLACES),
        ("exudyn", 3e-3, 0.02, *PLACES[1]),  # which takes minutes
    ],
)
def test_a_march_from_a_neighbouring_speed_settles_on_the_curve(engine: str, accuracy: float, apart: float, rpm: float, way: int) -> None:
    """Within some times the accuracy asked of the engine: near resonance an error of a frequency is a larger one of the peak."""
    family, _ = curve()
    goal, neighbour = stable_point(rpm * RPM, way), stable_point((rpm - way) * RPM, way)
    scene, chosen = at_speed(goal.parameter), usable_engine(engine)
    cycle, like = family.at(neighbour.parameter)
    start = OwnSimulation(cycle.model, cycle.state(neighbour.point, like), family.tolerance, 0.0).present_start()
    assert start is not None
    begun = dataclasses.replace(start, crank_speed=goal.parameter)
    turn = 2.0 * math.pi / goal.parameter
    simulation = chosen.prepare(scene, begun, chosen.settings_for(accuracy, scene))
    for _ in range(CYCLES):
        columns = simulation.advance(turn, turn / STEPS)
    found = float(np.max(np.abs(columns["tip_acceleration"])))
    assert found == pytest.approx(peak(family, goal), rel=apart)


@pytest.mark.verify
def test_harmonics_make_a_peak_where_they_have_a_quarter_of_the_acceleration_at_the_meeting() -> None:
    """Of run 24's machine the twelfth to ninth: what `HARDLY` is drawn from; where they have less than it, there is no peak."""
    low, high = 80.0 * RPM, 118.0 * RPM
    family = CycleFamily(at_speed, 3, 1e-9)
    points = branch(family, family.orbit(low), low, low, high).points
    first = resonance(at_speed(low))
    assert first is not None
    speeds = np.array([each.parameter for each in points])
    heights = np.array([peak(family, each) for each in points])
    peaks = {round(2.0 * math.pi * first.first_mode / each.value) for each in _maxima(points, heights, at_speed)}
    shares = {}
    for order in (9, 10, 11, 12):
        each = points[int(np.abs(2.0 * math.pi * first.first_mode / speeds - order).argmin())]
        shares[order] = share_of(order, family.columns(each.point, each.parameter, 256))
    assert peaks == {order for order, share in shares.items() if share is not None and share > 0.24}
    assert peaks == {9, 10}
    assert all(share is not None and share > HARDLY for share in shares.values()), "weak, but driven"
