"""What is read off a cycle (a burst, counted extremes, the half that a soft roller carries), and the emulator of it with its error."""

import numpy as np
import pytest

from quickreturn.cases.library.thesis import run_case
from quickreturn.cases.motion.orbit import find_orbit
from quickreturn.cases.motion.settling import Cycle
from quickreturn.cases.motion.time_scale import CHANNELS
from quickreturn.plugins.thesis.inference.emulator import Emulator, features
from quickreturn.plugins.thesis.inference.response import DISAGREEMENT, Request, _half, _ring, counted_frequency, respond
from quickreturn.plugins.thesis.inference.unknowns import NAMES, PRINTED, scene_of, spread
from quickreturn.reference_model.mechanism import Mechanism
from quickreturn.reference_model.natural_modes import frozen_crank_modes
from quickreturn.reference_model.scene_values import changed

PERIOD = 0.378  # s


def cycle_with(frequency: float, amplitude: float) -> Cycle:
    """Evenly turning: a slow part, and a burst just after the return, in which strain 2 goes against 1 and 3."""
    time = np.linspace(0.0, PERIOD, 757)
    slow = np.sin(2.0 * np.pi * time / PERIOD)
    burst = amplitude * np.sin(2.0 * np.pi * frequency * time) * (np.abs(time / PERIOD - 7.0 / 12.0) < 1.0 / 8.0)
    signals = {name: slow + (-burst if name == "strain_2" else burst) for name in CHANNELS}
    return Cycle(time, np.pi * (1.0 + 2.0 * time / PERIOD), signals)


@pytest.mark.parametrize("frequency", [80.0, 100.0, 132.0, 160.0])
def test_a_burst_at_the_return_is_found_with_its_frequency_strength_and_signs(frequency: float) -> None:
    ring = _ring(cycle_with(frequency, 10.0))
    assert ring.frequency == pytest.approx(frequency, abs=2.0)  # an eighth of the resolution of 63 ms
    assert ring.rms == pytest.approx(10.0 / np.sqrt(2.0), rel=0.05)  # the ends of the burst lie outside the band in part
    assert ring.signs[0] < -0.95
    assert ring.signs[1] > 0.95


def test_extremes_are_counted_as_an_eye_does() -> None:
    time = np.linspace(0.0, 0.5, 5001)
    wave = np.sin(2.0 * np.pi * 17.0 * time)
    assert counted_frequency(time, wave) == pytest.approx(17.0, rel=1e-3)
    assert counted_frequency(time, wave + 0.01 * np.sin(2.0 * np.pi * 300.0 * time)) == pytest.approx(17.0, rel=2e-2)
    assert counted_frequency(time, np.sin(2.0 * np.pi * 2.0 * time)) is None  # three extremes: no frequency


def test_halves_in_which_the_channels_disagree_have_no_fit() -> None:
    class Fit:
        def __init__(self, frequency: float) -> None:
            self.frequency, self.frequency_uncertainty, self.amplitude = frequency, 0.1, 1.0

    alike, apart = ([{"a": Fit(17.0), "b": Fit(17.0 * (1.0 + times * DISAGREEMENT))}] for times in (0.5, 3.0))
    assert _half("pre", alike, [None]).fitted == pytest.approx(17.0, rel=0.01)
    assert _half("pre", apart, [None]).fitted is None


def of_held_crank(scene: Mechanism) -> float:
    """Mean first frequency with the crank held, Hz, over a half turn at even speed."""
    return float(np.mean([frozen_crank_modes(scene, angle, 1).frequencies[0] for angle in np.linspace(0.0, np.pi, 61)]))


def machine(**of: float) -> np.ndarray:
    return np.array([{**PRINTED, **of}[name] for name in NAMES])


@pytest.mark.verify
@pytest.mark.parametrize("half", ["pre", "post"])
def test_a_soft_roller_changes_the_half_that_it_carries_by_what_its_spring_does_to_the_crank_held(half: str) -> None:
    """An eigenvalue problem says by how much: no march and no fit is in it."""
    mechanism = run_case(24).mechanism
    start = find_orbit(mechanism).begin
    assert start is not None
    rollers = {"plus": 20.0, "minus": 1000.0} if half == "post" else {"plus": 1000.0, "minus": 20.0}
    printed, soft = respond((Request(mechanism, start), Request(scene_of(machine(**rollers), 24), start)))
    expected = of_held_crank(changed(mechanism, {"slider.joint_stiffness": 2e4})) / of_held_crank(mechanism) - 1.0
    assert expected < -0.01
    for name in ("pre", "post"):
        new, old = soft.halves[name].fitted, printed.halves[name].fitted
        assert new is not None
        assert old is not None
        # along the half the spring's effect goes from 0 to -3.2 %, so that the mean depends on where the mode is strong; 0.3 % is the floor
        # of the measure (`cases.motion.first_mode.FREQUENCY_FLOOR`), of each of the two
        assert new / old - 1.0 == pytest.approx(expected if name == half else 0.0, abs=0.006)


GENERATOR = np.random.default_rng(7)
MACHINES = spread(GENERATOR.random((120, len(NAMES))))
OTHERS = spread(GENERATOR.random((400, len(NAMES))))


def law(machines: np.ndarray) -> np.ndarray:
    """A smooth number that no polynomial of the features is."""
    return np.sin(2.0 * machines[:, 0]) + 0.3 * np.exp(-machines[:, 4]) * np.log(machines[:, 5])


def test_the_error_at_unseen_machines_is_the_one_that_it_states() -> None:
    noise = 0.02 * GENERATOR.standard_normal(len(MACHINES))
    found = Emulator(features(MACHINES), features(OTHERS))(law(MACHINES) + noise)
    actual = np.sqrt(np.mean((found.mean - law(OTHERS)) ** 2 + 0.02**2))  # what is unseen has noise, too
    assert 0.6 < found.error / actual < 1.6


def test_a_linear_number_is_exact_and_missing_ones_are_left_out() -> None:
    known, wanted = features(MACHINES), features(OTHERS)
    values = known @ np.arange(1.0, known.shape[1] + 1.0)
    values[::5] = np.nan
    found = Emulator(known, wanted)(values)
    assert found.mean == pytest.approx(wanted @ np.arange(1.0, known.shape[1] + 1.0), abs=0.02)
    assert found.count == 96
