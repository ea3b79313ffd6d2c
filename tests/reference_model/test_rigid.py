"""The rigid mechanism: closed form, kinetostatics, and the flexible model's way there."""

import dataclasses
import math
from typing import Any

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from quickreturn.reference_model.arrays import Array
from quickreturn.reference_model.mechanism import Mechanism, PrescribedSpeed
from quickreturn.reference_model.rigid import rigid_kinetostatics, rigid_motion
from quickreturn.reference_model.slider import Slider
from tests.engines.scenes import run_24, with_parts
from tests.reference_model.motion.beam_runs import run
from tests.reference_model.thesis.thesis_runs import rigid

STIFF = {"bending_stiffness": math.inf}


def everything(**changes: dict[str, Any]) -> Mechanism:
    """Run 24 with all that the thesis leaves out."""
    full = run_24(gravity=(2.0, -9.81), slider=Slider(mass=0.3, inertia=4e-4), tip={"center_of_mass": 0.0127}, base={"damping": 0.01})
    return with_parts(full, **changes)


def place(mechanism: Mechanism, q1: float) -> tuple[float, float]:
    """S and q2 from the complex loop LA exp(i q1) - d = s exp(i q2)."""
    loop = mechanism.crank.length * np.exp(1j * q1) - mechanism.pivot_distance
    return float(abs(loop)), float(np.angle(-loop)) + math.pi


@pytest.mark.parametrize("q1", [math.pi, 2.0, 0.3, -1.1, 8.0])
def test_closed_form_and_its_derivatives(q1: float) -> None:
    mechanism, speed, acceleration, h = run_24(), 11.0, -70.0, 1e-4

    def at(t: float) -> Array:
        return np.array(place(mechanism, q1 + speed * t + 0.5 * acceleration * t * t))

    motion = rigid_motion(mechanism, np.array(q1), speed, acceleration)
    # fourth-order stencils: (speed h)^4 of the value, and rounding 1e-16 / h^2
    first = (at(-2 * h) - 8 * at(-h) + 8 * at(h) - at(2 * h)) / (12 * h)
    second = (-at(-2 * h) + 16 * at(-h) - 30 * at(0) + 16 * at(h) - at(2 * h)) / (12 * h * h)
    np.testing.assert_allclose([motion.slider_position, motion.follower_angle], at(0), atol=1e-14)
    np.testing.assert_allclose([motion.slider_speed, motion.follower_speed], first, atol=1e-8)
    np.testing.assert_allclose([motion.slider_acceleration, motion.follower_acceleration], second, atol=1e-4)


def energies(mechanism: Mechanism, q1: float) -> tuple[float, float]:
    """Inertia reduced to the crank (twice the kinetic energy at unit speed) and gravity's energy, from places of mass points alone."""
    beam, tip, slider, crank, h = mechanism.follower, mechanism.tip, mechanism.slider, mechanism.crank, 1e-3
    x, weights = np.polynomial.legendre.leggauss(3)
    x, weights = 0.5 * beam.length * (x + 1), 0.5 * beam.length * beam.mass_per_length * weights
    masses = np.r_[weights, tip.mass, crank.mass, slider.mass]

    def points(angle: float) -> Array:
        q2 = place(mechanism, angle)[1]
        on_follower = mechanism.pivot_distance + np.exp(1j * q2) * np.r_[x, beam.length + tip.center_of_mass]
        return np.r_[on_follower, np.exp(1j * angle) * np.array([crank.center_of_mass, crank.length])]

    def slope(function: Any) -> Any:
        return (function(q1 - 2 * h) - 8 * function(q1 - h) + 8 * function(q1 + h) - function(q1 + 2 * h)) / (12 * h)

    turning = slope(lambda angle: place(mechanism, angle)[1])
    reduced = masses @ np.abs(slope(points)) ** 2 + crank.inertia
    reduced += (mechanism.base.inertia + tip.inertia + slider.inertia) * turning**2
    height = points(q1)
    return float(reduced), float(-masses @ (mechanism.gravity[0] * height.real + mechanism.gravity[1] * height.imag))


@pytest.mark.parametrize("mechanism", [run_24(follower=STIFF), everything(follower=STIFF)], ids=["run 24", "everything"])
def test_infinite_stiffness_is_one_equation_for_the_crank(mechanism: Mechanism) -> None:
    """I(q1) q1'' + I'(q1) q1'^2 / 2 + V'(q1) = T - c q1' - c2 (dq2/dq1)^2 q1', all by differences of places."""
    drive, h = mechanism.crank.drive, 1e-3

    def equation(_: float, y: Array) -> list[float]:
        q1, speed = y
        inertia, _v = energies(mechanism, q1)
        before, after = energies(mechanism, q1 - h), energies(mechanism, q1 + h)
        slopes = [(b - a) / (2 * h) for a, b in zip(before, after, strict=True)]
        turning = (place(mechanism, q1 + h)[1] - place(mechanism, q1 - h)[1]) / (2 * h)
        damping = drive.damping + mechanism.base.damping * turning**2  # type: ignore[union-attr]
        torque = drive.torque - damping * speed - slopes[1] - 0.5 * slopes[0] * speed**2  # type: ignore[union-attr]
        return [speed, torque / inertia]

    columns = run(rigid(mechanism), 0.5, 50, 1e-11)[1]
    times = np.linspace(0.0, 0.5, 51)
    found = solve_ivp(equation, (0, 0.5), [math.pi, drive.initial_speed], "DOP853", times, rtol=1e-10, atol=1e-10)
    # second-order differences with h = 1e-3: 1e-6 of the derivative terms
    np.testing.assert_allclose(columns["crank_angle"], found.y[0], atol=2e-6)
    np.testing.assert_allclose(columns["crank_speed"], found.y[1], atol=2e-5)
    motion = rigid_motion(mechanism, columns["crank_angle"], columns["crank_speed"])
    np.testing.assert_allclose(columns["slider_position"], motion.slider_position, rtol=1e-13)
    np.testing.assert_allclose(columns["follower_angle"], motion.follower_angle, rtol=1e-13)
    assert np.max(np.abs(columns["tip_deflection"])) == 0.0


@pytest.mark.parametrize("prescribed", [False, True])
def test_kinetostatics_is_the_dynamics_read_backwards(prescribed: bool) -> None:
    mechanism = everything(follower=STIFF)
    if prescribed:
        mechanism = dataclasses.replace(mechanism, crank=dataclasses.replace(mechanism.crank, drive=PrescribedSpeed(speed=-14.0)))
    model = rigid(mechanism)
    states, columns = run(model, 0.5, 40, 1e-10)
    acceleration = np.zeros(len(states))
    if not prescribed:
        for row, y in enumerate(states):
            rate = np.empty_like(y)
            assert model.right_hand_side(y, rate)
            acceleration[row] = rate[1]
    force, torque = rigid_kinetostatics(mechanism, columns["crank_angle"], columns["crank_speed"], acceleration)
    # closed forms on both sides: rounding
    np.testing.assert_allclose(columns["slider_force"], force, atol=1e-10 * np.max(np.abs(force)))
    np.testing.assert_allclose(columns["crank_torque"], torque, atol=1e-10 * np.max(np.abs(torque)))
