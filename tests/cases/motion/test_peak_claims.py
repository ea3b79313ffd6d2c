"""Claims of peaks in a trajectory: the error of a peak may be larger than that of its column in the mean."""

import itertools

import numpy as np
import pytest

from quickreturn.cases.library import library_case
from quickreturn.engines.accurate import simulate
from quickreturn.engines.error_parts import TIP, Compared, parts_of
from quickreturn.engines.one_run import run_once
from quickreturn.engines.own.reference import ReferenceEngine, ReferenceSettings
from quickreturn.engines.start import standard_start
from quickreturn.engines.trajectory import Trajectory
from quickreturn.reference_model.mechanism import Mechanism
from tests.verification.random_machines import sensible_machines
from tests.verification.random_scenes import random_scenes

REQUIRED = [name for name in Trajectory.required if name != "time"]
COLUMNS = ("tip_deflection", "strain_1", "strain_2", "slider_force", "moment_03", "pivot_force_x")


def test_a_fault_at_the_peak_alone_is_claimed_there() -> None:
    """A row of a thousand errs by a tenth: in the mean that is 0.4 %."""
    time = np.linspace(0.0, 1.0, 1001)
    right = np.sin(2.0 * np.pi * time)
    wrong = np.where(np.arange(1001) == 250, 0.9, right)
    run, finer = (Trajectory({"time": time, **dict.fromkeys(REQUIRED, values)}, 0.0) for values in (wrong, right))
    parts, largest = parts_of(run, [Compared(run, finer, 0.0)], 1.0)
    assert parts[TIP][0].error < 0.005
    assert largest["strain_2"] == pytest.approx(0.1)


def test_the_error_of_a_moment_at_a_light_end_is_relative_to_the_arm() -> None:
    """The base of a light bearing block asks for a thousandth of the moment in the arm, half of which is ringing."""
    time = np.linspace(0.0, 1.0, 1001)
    arm = np.sin(2.0 * np.pi * time)
    right, wrong = ({"moment_05": 2.0 * arm, "moment_11": 0.1 * arm, "moment_base": size * arm} for size in (2e-3, 1e-3))
    run, finer = (Trajectory({"time": time, **dict.fromkeys(REQUIRED, arm), **moments}, 0.0) for moments in (wrong, right))
    parts, largest = parts_of(run, [Compared(run, finer, 0.0)], 1.0)
    assert parts["moment_base"][0].error == pytest.approx(5e-4)
    assert largest["moment_base"] == pytest.approx(1e-3)


def ratios(mechanism: Mechanism, duration: float) -> list[float]:
    """Errors of peaks at an accuracy of 1e-2 over their claims, against nine modes."""
    engine, start = ReferenceEngine(), standard_start(mechanism)
    result = simulate(engine, mechanism, start, duration, 1e-3, accuracy=1e-2)
    truth = run_once(engine, mechanism, start, duration, 1e-3, ReferenceSettings(modes=9, tolerance=1e-9)).trajectory
    found = result.trajectory
    return [
        float(abs(np.max(np.abs(found[name])) - np.max(np.abs(truth[name]))) / result.largest_errors[name])
        for name in COLUMNS
        if result.largest_errors.get(name)
    ]


@pytest.mark.verify
def test_peaks_are_within_their_claims() -> None:
    """Of the thesis' runs and 24 random machines; the relative error of the column in the mean was 1.27 times too small."""
    drawn = [*itertools.islice(random_scenes(603), 12), *itertools.islice(sensible_machines(603), 12)]
    scenes = [
        *((library_case(f"thesis-{number:02d}").mechanism, 0.5) for number in range(1, 25)),
        *((each.mechanism, 1.0) for each in drawn),
    ]
    found = [ratio for scene in scenes for ratio in ratios(*scene)]
    assert sum(ratio > 1.0 for ratio in found) <= 0.05 * len(found)
    assert max(found) < 1.5
