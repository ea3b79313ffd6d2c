"""Stiff followers reach their steady state: the yardstick is there for ordinary machines, too."""

from dataclasses import replace

import numpy as np
import pytest

from quickreturn.cases.library import load_case
from quickreturn.cases.motion.endings import Ending
from quickreturn.cases.motion.request import RunRequest
from quickreturn.cases.motion.steady_state import steady_state
from quickreturn.engines.registry import MAIN
from quickreturn.reference_model.mechanism import Mechanism, PrescribedSpeed, TorqueDrive


def run_24(stiffness: float, *, driven: bool) -> Mechanism:
    scene = load_case("thesis-24").mechanism
    follower = replace(scene.follower, bending_stiffness=stiffness * scene.follower.bending_stiffness)
    crank = scene.crank if driven else replace(scene.crank, drive=PrescribedSpeed(speed=scene.crank.drive.initial_speed))
    return replace(scene, follower=follower, crank=crank)


def shaper(arm: str, *, driven: bool) -> Mechanism:
    """The library's scene, on its prescribed speed or on a motor that has it for a mean."""
    scene = load_case(f"hard-shaper-{arm}").mechanism
    speed = scene.crank.drive.initial_speed
    drive = TorqueDrive(torque=5.0 * speed, damping=5.0, initial_speed=speed)
    return replace(scene, crank=replace(scene.crank, drive=drive, inertia=2.0)) if driven else scene


def check(scene: Mechanism, engine: str = "reference") -> None:
    run = steady_state(RunRequest(mechanism=scene, duration=2.0, engine=engine, estimated=False))
    assert run.status == Ending.SETTLED, run.remark
    assert run.approach.cycles < 30
    # isolated spikes of the acceleration were what kept it from settling: a twentieth of its size on every fiftieth row
    acceleration = run.cycle["tip_acceleration"]
    jumps = np.abs(np.diff(acceleration, 2))
    assert np.max(jumps) < 0.02 * np.max(np.abs(acceleration))


LATER = pytest.mark.verify


@pytest.mark.parametrize(
    ("arm", "driven"),
    [("steel", True), *(pytest.param(*each, marks=LATER) for each in (("steel", False), ("aluminium", True), ("aluminium", False)))],
)
def test_the_shaper_settles(arm: str, driven: bool) -> None:
    check(shaper(arm, driven=driven))


@pytest.mark.verify
@pytest.mark.parametrize("stiffness", [1.0, 10.0, 1e3, 1e5])
def test_run_24_settles_at_a_prescribed_speed_with_any_stiffness_from_its_own_on(stiffness: float) -> None:
    check(run_24(stiffness, driven=False))


@pytest.mark.verify
@pytest.mark.parametrize("engine", MAIN)
@pytest.mark.parametrize("stiffness", [10.0**power for power in range(6)])
def test_run_24_settles_in_every_engine(stiffness: float, engine: str) -> None:
    check(run_24(stiffness, driven=True), engine)
