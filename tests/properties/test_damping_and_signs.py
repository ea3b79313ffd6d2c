"""What `docs/case-file.md` says of damping and of the force against the motion, by simulations."""

import math

import numpy as np
import pytest
from scipy.interpolate import CubicSpline

import quickreturn as qr
from quickreturn.cases.files.case import Case
from quickreturn.reference_model.natural_modes import frozen_crank_modes

#: A weight that begins to act sets the follower swinging; the crank hardly turns.
SWINGING = {
    "mechanism.gravity": '["0 m/s^2", "-1 m/s^2"]',
    "crank.prescribed_speed": "1e-4 rad/s",
    "base.damping": "0 N*m*s/rad",
    "simulation.duration": "1.5 s",
}
#: A base that does not turn with the vibration, and no body at the tip.
HELD = {"base.inertia": "1000 kg*m^2", "tip.mass": "0 kg", "tip.inertia": "0 kg*m^2"}
RATIO = 0.005


def first_frequency(case: Case) -> float:
    """Of the follower's vibration with the crank held at its start, Hz; a held base alone would rock more slowly than once a second."""
    frequencies = frozen_crank_modes(case.mechanism, case.mechanism.crank.initial_angle, 2).frequencies
    return float(frequencies[frequencies > 1.0][0])


def ratio(case: Case) -> float:
    """Damping ratio of the first mode, by the logarithmic decrement of the tip's swings."""
    found = qr.simulate(case, settings={"modes": 2}, estimate=False, store=False, quiet=True).trajectory
    curve = CubicSpline(found["time"], found["tip_deflection"])
    turns = curve.derivative().roots(extrapolate=False)
    turns = turns[turns > 0.1]  # s: higher modes have died away
    swings = np.abs(np.diff(curve(turns)))
    swings = swings[: int(np.argmax(np.append(swings < 0.02 * swings[0], True)))]
    decrement = -2.0 * np.polyfit(np.arange(swings.size), np.log(swings), 1)[0]
    return float(decrement / (2.0 * math.pi))


def damped(more: dict[str, str], tau: float, per_length: float) -> Case:
    damping = {"follower.material_damping": f"{tau:.9g} s", "follower.damping": f"{per_length:.9g} N*s/m^2"}
    return qr.case("thesis-24", SWINGING | more | damping)


@pytest.mark.parametrize("more", [{}, HELD], ids=["run 24", "held base"])
def test_material_damping_is_the_ratio_over_pi_f(more: dict[str, str]) -> None:
    frequency = first_frequency(damped(more, 0.0, 0.0))
    assert ratio(damped(more, RATIO / (math.pi * frequency), 0.0)) == pytest.approx(RATIO, rel=0.01)


def test_damping_per_length_is_four_pi_f_times_mass_and_ratio_where_the_base_does_not_turn() -> None:
    free = damped(HELD, 0.0, 0.0)
    per_length = 4.0 * math.pi * first_frequency(free) * free.mechanism.follower.mass_per_length * RATIO
    assert ratio(damped(HELD, 0.0, per_length)) == pytest.approx(RATIO, rel=0.01)
    # a base that turns with the vibration adds to it: 5.9 times, as the document says of run 24
    free = damped({}, 0.0, 0.0)
    per_length = 4.0 * math.pi * first_frequency(free) * free.mechanism.follower.mass_per_length * RATIO
    assert ratio(damped({}, 0.0, per_length)) == pytest.approx(5.9 * RATIO, rel=0.02)


@pytest.mark.parametrize("way", [1, -1])
def test_against_the_motion_of_the_working_stroke(way: int) -> None:
    """Crank from 90 to 270 deg: down and along the normal for a positive speed, so that a force along +n2 takes energy there."""
    case = qr.case("rigid", {"crank.prescribed_speed": f"{60 * way} rpm", "simulation.duration": "1 s"})
    found = qr.simulate(case, settings={"modes": 1} if not case.mechanism.follower.is_rigid else None, store=False, quiet=True).trajectory
    angle = np.degrees(found["crank_angle"]) % 360.0
    slow = (angle > 90.0) & (angle < 270.0)
    down = np.gradient(found["tip_y"], found["time"])[slow]
    assert (way * down < 0.0).all()
    assert (way * np.gradient(found["follower_angle"], found["time"])[slow] > 0.0).all()
