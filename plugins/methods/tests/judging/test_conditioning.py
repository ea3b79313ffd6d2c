"""Conditioning of made-up motions whose dependence on the parameters is known in closed form."""

import math
from dataclasses import replace

import numpy as np
import pytest

from quickreturn.cases.files.case_file import load_case
from quickreturn.engines.trajectory import REQUIRED, Trajectory
from quickreturn.plugins.methods.judging.conditioning import CHANGE, ILL, conditioning, variations
from quickreturn.reference_model.mechanism import Mechanism, PrescribedSpeed, TorqueDrive

MECHANISM = load_case("thesis-24").mechanism
SPEED = MECHANISM.crank.drive.initial_speed
STIFFNESS = MECHANISM.follower.bending_stiffness


def motion(mechanism: Mechanism, duration: float, output_step: float) -> Trajectory:
    """Deflection (EI / EI of run 24)^2 times a sine of the crank angle, whose phase depends on the damping more and more."""
    time = np.arange(round(duration / output_step) + 1) * output_step
    angle = math.pi + mechanism.crank.drive.initial_speed * time
    columns = {name: np.zeros_like(time) for name in REQUIRED} | {"time": time, "crank_angle": angle}
    phase = 1e3 * (mechanism.follower.damping / MECHANISM.follower.damping - 1.0) * 0.01 * time**2
    columns["tip_deflection"] = (mechanism.follower.bending_stiffness / STIFFNESS) ** 2 * np.sin(3.0 * angle + phase)
    return Trajectory(columns, 0.0)


@pytest.fixture(autouse=True)
def _made_up(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("quickreturn.plugins.methods.judging.conditioning._run", motion)


def test_changes_of_a_known_motion() -> None:
    found = conditioning(MECHANISM, 2.0, 1e-3)
    assert found.changes["stiffness"] == pytest.approx((1.0 + CHANGE) ** 2 - 1.0, rel=1e-9)
    # phase 3 x change x speed x time: its RMS over 2 s, on a sine
    assert found.changes["speed"] == pytest.approx(3.0 * CHANGE * SPEED * 2.0 / math.sqrt(3.0), rel=0.03)
    assert found.changes["speed at the same crank angle"] < 1e-6  # it only comes sooner
    # phase 0.01 t²: the RMS of t² over 2 s is 4 / sqrt(5)
    assert found.changes["damping"] == pytest.approx(0.01 * 4.0 / math.sqrt(5.0), rel=0.02)
    assert found.horizon == 2.0


def test_the_horizon_is_where_a_change_exceeds_the_limit() -> None:
    # 0.01 t² / sqrt(5) = ILL, on a sine: at t = sqrt(5 sqrt(5)) = 3.34 s
    found = conditioning(MECHANISM, 8.0, 1e-3)
    assert found.horizon == pytest.approx(math.sqrt(ILL * math.sqrt(5.0) / 0.01), rel=0.02)
    assert found.horizon == pytest.approx(round(found.horizon, 3), abs=1e-9)  # on the grid


def test_a_few_rows_beyond_the_horizon_are_not_told_apart() -> None:
    horizon = conditioning(MECHANISM, 8.0, 1e-3).horizon
    assert conditioning(MECHANISM, horizon + 5e-3, 1e-3).horizon == horizon + 5e-3
    assert conditioning(MECHANISM, horizon + 0.1, 1e-3).horizon == horizon


def test_what_is_changed() -> None:
    scenes = {each.name: each.of(MECHANISM) for each in variations(MECHANISM)}
    factor = 1.0 + CHANGE
    follower = MECHANISM.follower
    assert scenes["stiffness"] == replace(MECHANISM, follower=replace(follower, bending_stiffness=factor * STIFFNESS))
    assert scenes["damping"].follower.damping == factor * follower.damping
    assert scenes["damping"].base.damping == factor * MECHANISM.base.damping
    drive, nominal = scenes["speed"].crank.drive, MECHANISM.crank.drive
    assert isinstance(drive, TorqueDrive)
    assert isinstance(nominal, TorqueDrive)
    assert (drive.torque, drive.initial_speed, drive.damping) == (factor * nominal.torque, factor * nominal.initial_speed, nominal.damping)
    prescribed = replace(MECHANISM, crank=replace(MECHANISM.crank, drive=PrescribedSpeed(speed=10.0)))
    assert variations(prescribed)[2].of(prescribed).crank.drive == PrescribedSpeed(speed=10.0 * factor)
