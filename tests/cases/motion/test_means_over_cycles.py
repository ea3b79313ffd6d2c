"""Runs whose cycles keep changing: what becomes of cycles with known statistics, their means, and a rattling slider."""

import itertools
import math
from collections.abc import Iterator
from dataclasses import replace

import numpy as np
import pytest

from quickreturn.cases.library import load_case
from quickreturn.cases.motion.cycle import ChannelMeasures, CycleMeasures
from quickreturn.cases.motion.endings import Ending
from quickreturn.cases.motion.estimates import HalfSignal, MeasuredCycle, signal_estimates
from quickreturn.cases.motion.marching import AVERAGED, BOUND, GROUPS, mean_measures, settle, standard_error
from quickreturn.cases.motion.request import RunRequest
from quickreturn.cases.motion.settling import GREATEST_NUMBER, Cycle
from quickreturn.cases.motion.steady_state import steady_state
from quickreturn.cases.motion.time_scale import CHANNELS
from quickreturn.engines.error_parts import Compared
from quickreturn.reference_model.scene_values import changed
from tests.cases.motion.test_estimates import measures
from tests.changed_run import UNRESOLVED, measured

ANGLES = np.linspace(0.0, 2.0 * np.pi, 101)


def cycles(trend: float = 0.0, growth: float = 1.0, ratio: float = 0.5, seed: int = 1) -> Iterator[Cycle]:
    """A sine that approaches its steady state with `ratio`, under scatter of ten harmonics that grows from cycle to cycle, with a trend."""
    random = np.random.default_rng(seed)
    for number in itertools.count():
        scatter = 0.03 * growth**number * random.standard_normal(10) @ np.cos(np.outer(np.arange(1, 11), ANGLES))
        signal = np.sin(ANGLES) + (ratio**number + trend * number) * np.cos(3.0 * ANGLES) + scatter
        yield Cycle(0.5 * (number + ANGLES / (2.0 * np.pi)), np.pi + ANGLES, dict.fromkeys(CHANNELS, signal))


@pytest.mark.parametrize("seed", range(5))
def test_cycles_that_keep_changing_are_all_measured(seed: int) -> None:
    found, settling = settle(cycles(seed=seed))
    assert not settling.settled
    assert (len(found), settling.cycles) == (AVERAGED, GREATEST_NUMBER)
    assert found[-1]["time"][-1] == pytest.approx(0.5 * GREATEST_NUMBER)


@pytest.mark.parametrize("others", [{"trend": 0.02}, {"growth": 1.1}, {"growth": 0.94}, {"ratio": 0.98}])
@pytest.mark.parametrize("seed", range(5))
def test_drift_growth_and_a_slow_approach_are_not_averaged(others: dict[str, float], seed: int) -> None:
    found, settling = settle(cycles(**others, seed=seed))
    assert not settling.settled
    assert len(found) == 1


def test_estimates_compare_the_mean_extremes_and_the_mean_signals() -> None:
    """The other run's cycles are the same in another order, then all 0.2 higher, then with a peak of 1 at another angle in each."""
    signals = np.random.default_rng(2).standard_normal((AVERAGED, 360))
    peaks = signals + 10.0 * np.eye(AVERAGED, 360)

    def estimate(other: np.ndarray) -> float:
        halves = (HalfSignal.of(values) for values in (signals, other))
        one, two = (MeasuredCycle(measures(), {("pre", "strain_1"): half}, rms={}, change={}, numbers={}) for half in halves)
        return signal_estimates([Compared(one, two, 2.0)], HalfSignal.apart)["strain_1"]["pre"]

    assert estimate(signals[::-1]) == pytest.approx(0.0, abs=1e-14)
    assert estimate(signals + 0.2) == pytest.approx(0.2)
    assert estimate(peaks) == pytest.approx(np.mean(peaks.max(axis=1) - signals.max(axis=1)))


@pytest.mark.verify
def test_a_rattling_slider_repeats_in_statistics_only() -> None:
    """A rigid follower, which strikes the rollers several times in a turn."""
    rigid = load_case("example", {"follower.bending_stiffness": "inf"}).mechanism
    scene = changed(rigid, {"slider.joint_stiffness": 1e5, "slider.clearance": 5e-4, "slider.contact_damping": 0.5})
    run = steady_state(RunRequest(mechanism=scene, duration=0.1, engine="reference", estimated=False))
    assert (run.status, run.approach.settled) == (Ending.SETTLED, True)
    assert (run.approach.averaged_cycles, run.approach.cycles) == (AVERAGED, GREATEST_NUMBER)
    assert "means over the last 30 of 60 cycles" in run.remark
    acceleration, middle = run.cycle["tip_acceleration"], len(run.cycle["time"]) // 2
    halves = {"pre": acceleration[:middle], "post": acceleration[middle:]}
    apart = [
        abs(mean / last - 1.0)
        for measure in run.measured.measures
        if measure.channel == "tip_acceleration"
        for mean, last in zip((measure.minimum, measure.maximum), (halves[measure.half].min(), halves[measure.half].max()), strict=True)
    ]
    # means, and not the last cycle's: these lie in a scatter that is many times the standard error of the mean of thirty, though one of
    # them may lie near its mean by chance
    assert max(apart) > 0.01


def measure(frequency: float | None = 17.0, maximum: float = 5.0) -> ChannelMeasures:
    mode = {"first_mode_frequency": frequency, "first_mode_frequency_uncertainty": 0.3}
    mode |= {"first_mode_amplitude": 2.0, "first_mode_amplitude_uncertainty": 0.1}
    known = mode if frequency is not None else UNRESOLVED | {"reason": "too weak"}
    return measured(**known, minimum_uncertainty=0.2, maximum=maximum, maximum_uncertainty=0.1)


def mean(*found: ChannelMeasures) -> ChannelMeasures:
    return mean_measures([CycleMeasures((each,), ()) for each in found]).measures[0]


@pytest.mark.parametrize("one", [measure(), measure(None)])
def test_the_mean_of_one_cycle_is_the_cycle_to_the_last_digit(one: ChannelMeasures) -> None:
    assert mean(one) == one


def test_means_and_what_scatter_adds_to_their_uncertainties() -> None:
    """Frequencies 17 and 17.4, cycle about, in groups of five: the groups' means are 17.24 and 17.16 by turns."""
    found = mean(*(measure(17.0 + 0.4 * (number % 2), 5.0 + (number % 2)) for number in range(1, AVERAGED + 1)))
    assert found.first_mode_frequency == pytest.approx(17.2)
    error = 0.04 * math.sqrt(6.0 / 5.0) / math.sqrt(6.0)
    assert found.first_mode_frequency_uncertainty == pytest.approx(math.hypot(0.3, error))
    assert found.maximum == pytest.approx(5.5)
    assert found.maximum_uncertainty == pytest.approx(0.1 + BOUND * error / 0.4)
    assert found.minimum_uncertainty == pytest.approx(0.2)
    assert found.first_mode_amplitude_uncertainty == pytest.approx(0.1)


def test_a_mode_that_most_cycles_do_not_resolve_is_not_resolved() -> None:
    few, many = (mean(*(measure(17.0 if number < count else None) for number in range(AVERAGED))) for count in (14, 15))
    assert (few.first_mode_frequency, few.first_mode_amplitude_uncertainty, few.reason) == (None, None, "too weak")
    assert (many.first_mode_frequency, many.reason) == (17.0, "")


def test_the_consensus_is_that_of_the_means() -> None:
    one, other = measure(17.0), replace(measure(18.0), channel="strain_2")
    found = mean_measures([CycleMeasures((one, other), ()) for _ in range(AVERAGED)])
    assert [(each.half, each.first_mode_frequency) for each in found.consensus] == [("pre", 17.5)]


@pytest.mark.parametrize(("correlation", "told_of_it"), [(0.0, 1.0), (0.5, 0.855), (0.77, 0.64)])
def test_the_standard_error_of_correlated_cycles(correlation: float, told_of_it: float) -> None:
    """Against the variances of the means of 5 and of 30 correlated values in closed form, and against the scatter of 2000 such means.

    Of 2000 standard errors from six groups the mean square is known to 1.4 %, and so is the scatter.
    """

    def variance(count: int) -> float:
        numbers = np.arange(count)
        return float(np.mean(correlation ** np.abs(numbers[:, None] - numbers)))

    expected = math.sqrt((variance(AVERAGED // GROUPS) - variance(AVERAGED)) / (GROUPS - 1.0))
    assert expected / math.sqrt(variance(AVERAGED)) == pytest.approx(told_of_it, abs=0.01)
    random = np.random.default_rng(1)
    values = [random.standard_normal(2000)]
    while len(values) < AVERAGED:
        values.append(correlation * values[-1] + math.sqrt(1.0 - correlation**2) * random.standard_normal(2000))
    runs = np.array(values).T
    told = math.sqrt(np.mean([standard_error(run) ** 2 for run in runs]))
    assert told == pytest.approx(expected, rel=0.04)
    assert np.std(runs.mean(axis=1)) == pytest.approx(math.sqrt(variance(AVERAGED)), rel=0.05)
