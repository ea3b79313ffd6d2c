"""What the pictures compute for themselves: deflection curve, load torque, spectrogram. Against closed forms."""

import math

import numpy as np
import pytest

from cases.case_file import load_case
from reference_model.mechanism import Mechanism
from reference_model.rigid import rigid_kinetostatics, rigid_motion
from reports.plots.deflection import Deflection
from reports.plots.forces import load_torque
from reports.plots.spectrogram import spectrogram

Columns = dict[str, np.ndarray]
SCENE = load_case("thesis-24").mechanism


def _bent_by(scene: Mechanism, tip_force: float, angles: np.ndarray) -> tuple[Columns, np.ndarray, np.ndarray]:
    """A beam on pivot and slider, loaded at its tip: columns, slope at the slider, deflection at L/3 (small slopes).

    With the moment M = R x up to the slider and M = F (L - x) beyond, R s = F (L - s), the curvature M/EI is integrated by hand.
    """
    L, EI, d, LA = scene.follower.length, scene.follower.bending_stiffness, scene.pivot_distance, scene.crank.length
    chord = rigid_motion(scene, angles, 0.0)
    s = chord.slider_position
    R = tip_force * (L - s) / s
    slope_at_slider = R * s**2 / (2.0 * EI)  # relative to the base tangent
    at_slider = R * s**3 / (6.0 * EI)
    beyond = L - s
    tip = at_slider + slope_at_slider * beyond + tip_force * beyond**3 / (3.0 * EI)
    base_angle = chord.follower_angle - np.arcsin(at_slider / s)
    columns = {
        "crank_angle": angles,
        "follower_angle": base_angle,
        "slider_position": s,
        "tip_deflection": tip,
        "slider_force": -(R + tip_force),
    }
    for number, gauge in enumerate(scene.follower.strain_gauges, start=1):
        moment = np.where(gauge <= s, R * gauge, tip_force * (L - gauge))
        columns[f"strain_{number}"] = moment / EI * scene.follower.thickness / 2.0
    assert d > LA
    third = L / 3.0  # before the slider
    return columns, slope_at_slider, R * third**3 / (6.0 * EI)


ANGLES = np.linspace(math.pi, 3.0 * math.pi, 37)


def test_deflection_of_a_beam_on_two_supports() -> None:
    columns, slope, at_third = _bent_by(SCENE, 0.3, ANGLES)
    curve = Deflection(SCENE, columns)
    L = SCENE.follower.length
    # the closed form is of the family fitted; at_slider enters through sines of angles of 0.01, hence not to round-off
    np.testing.assert_allclose(curve.slope_at_slider(), slope, rtol=1e-6)
    np.testing.assert_allclose(curve.at(np.array([L / 3.0]))[:, 0], at_third, rtol=1e-6)
    np.testing.assert_allclose(curve.at(np.array([L]))[:, 0], columns["tip_deflection"], rtol=1e-9)
    np.testing.assert_allclose(curve.at(np.array([0.0, L]), 2), 0.0, atol=1e-9)  # 1/m, of curvatures of 0.1
    np.testing.assert_allclose(curve.at(np.array([0.0]), 1), 0.0, atol=1e-15)


def test_a_slider_at_the_tip_or_at_a_gauge_still_has_a_curve() -> None:
    columns, _, _ = _bent_by(SCENE, 0.3, ANGLES[:1])
    for place in (SCENE.follower.length, SCENE.follower.strain_gauges[2]):
        curve = Deflection(SCENE, columns | {"slider_position": np.array([place])})
        assert np.all(np.abs(curve.at(np.linspace(0.0, SCENE.follower.length, 9))) < 0.1)


def test_a_rigid_follower_is_straight() -> None:
    scene = load_case("rigid").mechanism
    columns, _, _ = _bent_by(SCENE, 0.3, ANGLES)
    assert not np.any(Deflection(scene, columns).at(np.linspace(0.0, scene.follower.length, 5)))


def test_load_torque_of_the_rigid_mechanism() -> None:
    """Kinetostatics: the drive gives the load and the crank's own friction, at constant speed nothing else."""
    scene, speed = load_case("rigid").mechanism, 16.6
    motion = rigid_motion(scene, ANGLES, speed)
    force, drive = rigid_kinetostatics(scene, ANGLES, speed)
    zeros = np.zeros(ANGLES.size)
    columns = {
        "crank_angle": ANGLES,
        "follower_angle": motion.follower_angle,
        "slider_position": motion.slider_position,
        "tip_deflection": zeros,
        "slider_force": force,
        **{f"strain_{gauge}": zeros for gauge in (1, 2, 3)},
    }
    friction = scene.crank.drive.damping * speed  # type: ignore[union-attr]  # the library's scene has a torque drive
    np.testing.assert_allclose(load_torque(scene, columns), drive - friction, atol=1e-12)  # N m, of torques of 1


@pytest.mark.parametrize("frequency", [20.0, 60.0, 130.0])
def test_spectrogram_shows_a_sine_where_it_is(frequency: float) -> None:
    """0.5 s hold 10, 30 and 65 of them: whole numbers, so that they are periodic."""
    time = np.linspace(0.0, 0.5, 1001)
    frequencies = np.arange(0.0, 180.1, 1.0)
    amplitude = spectrogram(time, 3.0 * np.sin(2.0 * math.pi * frequency * time), np.linspace(0.0, 0.5, 11), frequencies, 0.04)
    assert np.all(frequencies[np.argmax(amplitude, axis=0)] == frequency)
    np.testing.assert_allclose(amplitude[int(frequency)], 3.0, rtol=1e-4)  # cubic interpolation, 15 samples a period


def test_spectrogram_follows_a_burst_across_the_end_of_the_period() -> None:
    time = np.linspace(0.0, 1.0, 2001)
    away = np.minimum(time, 1.0 - time)  # from the period's ends
    burst = np.exp(-0.5 * (away / 0.05) ** 2) * np.cos(2.0 * math.pi * 40.0 * time)
    amplitude = spectrogram(time, burst, np.array([0.0, 0.5, 1.0]), np.array([40.0]), 0.03)[0]
    assert amplitude[0] == pytest.approx(amplitude[2], rel=1e-9)  # the same instant of a periodic signal
    # a Gaussian of 0.05 s seen through one of 0.03 s: the amplitude sinks by the ratio of the widths
    assert amplitude[0] == pytest.approx(0.05 / math.hypot(0.05, 0.03), rel=1e-3)
    assert amplitude[1] < 1e-6
