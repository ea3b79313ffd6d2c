"""The first mode's frequency in simulated steady motion, against a truth that does not pass through the fit.

The truth: `vibration_truth`.
"""

import itertools
from functools import cache

import numpy as np
import pytest
from scipy.interpolate import CubicSpline

from quickreturn.cases.library import load_case
from quickreturn.cases.motion.time_scale import time_scale
from tests.cases.motion.vibration_truth import LAUNCHES, SteadyVibration, steady_vibration
from tests.verification.random_scenes import random_scenes

#: Driven hard and mildly, with the greatest and the least crank, and the two where only the amplitude is uncertain.
SHORT = (2, 4, 8, 10, 17, 24)


@cache
def run(number: int) -> SteadyVibration:
    found = steady_vibration(load_case(f"thesis-{number:02d}").mechanism)
    assert found is not None
    return found


@pytest.fixture(scope="module")
def vibrations() -> dict[int, SteadyVibration]:
    return {number: run(number) for number in SHORT}


def assert_claims_hold(found: list[SteadyVibration]) -> None:
    """At least 95 % of the frequencies lie within two of their standard deviations."""
    for z in (np.concatenate(parts) for parts in zip(*(each.z() for each in found), strict=True)):
        assert np.mean(np.abs(z) <= 2.0) >= 0.95
    for each in found:
        if not any(part.size for part in each.z()):
            continue  # nothing is claimed: of a vibration that dies within the half the truth, too, depends on how it is launched (1 %)
        assert np.all(np.array(each.scatter) / np.sqrt(LAUNCHES) < 1e-3 * np.array(each.truth))  # half of the 0.2 % it must be good to


@pytest.mark.verify
def test_frequencies_of_steady_states_lie_within_their_claims(vibrations: dict[int, SteadyVibration]) -> None:
    assert_claims_hold(list(vibrations.values()))
    errors = [
        agreed.first_mode_frequency / truth - 1.0
        for number in (4, 8, 10, 24)
        for agreed, truth in zip(vibrations[number].measures.consensus, vibrations[number].truth, strict=True)
        if agreed.first_mode_frequency is not None
    ]
    assert len(errors) == 8
    # -0.36 % in the mean, -0.8 % at worst; on the path of the crank held still, and without the modes dragged along, -0.64 and -1.04 %
    assert abs(np.mean(errors)) < 0.005
    assert np.abs(errors).max() < 0.01


@pytest.mark.verify
def test_time_scale_of_the_moving_mechanism_is_that_of_a_small_vibration(vibrations: dict[int, SteadyVibration]) -> None:
    for number in (4, 8, 10, 24):
        steady = vibrations[number]
        scale = time_scale(load_case(f"thesis-{number:02d}").mechanism)
        angle = CubicSpline(steady.cycle.time, steady.cycle.crank_angle)
        middle = float(CubicSpline(steady.cycle.crank_angle, steady.cycle.time)(steady.cycle.crank_angle[0] + np.pi))
        for start, end, truth in zip((steady.cycle.time[0], middle), (middle, steady.cycle.time[-1]), steady.truth, strict=True):
            instants = np.linspace(start, end, 400)
            running = scale.running_frequencies(angle(instants), angle(instants, 1))[:, 0].mean()
            assert running == pytest.approx(truth, rel=4e-3)  # what the slow deflection and the vibration's own size do is left out


@pytest.mark.parametrize(("number", "half"), [(2, "pre"), (17, "pre"), (17, "post")])
def test_frequency_is_there_where_only_the_amplitude_is_uncertain(number: int, half: str) -> None:
    steady = run(number)
    (measure,) = [m for m in steady.measures.measures if m.half == half and m.channel == "tip_acceleration"]
    assert measure.first_mode_frequency is not None
    assert measure.first_mode_frequency == pytest.approx(steady.truth[half == "post"], rel=0.02)  # found: 1.0, 1.8 and 0.7 %
    assert measure.first_mode_amplitude is None
    assert measure.first_mode_amplitude_uncertainty is None
    assert "amplitude" in measure.reason
    assert "frequency" not in measure.reason


@pytest.mark.verify
def test_frequencies_of_all_runs_lie_within_their_claims() -> None:
    assert_claims_hold([run(number) for number in range(1, 25)])


@pytest.mark.verify
def test_frequencies_of_random_scenes_lie_within_their_claims() -> None:
    """Scenes of a seed that nothing was tuned to; of some, no steady state is found directly."""
    found = [steady_vibration(scene.mechanism) for scene in itertools.islice(random_scenes(4711), 40)]
    resolved = [each for each in found if each is not None]
    assert len(resolved) >= 20
    assert_claims_hold(resolved)
