"""Means over cycles that repeat in statistics only, on cycles whose statistics are known."""

import math
from dataclasses import replace

import numpy as np
import pytest

from quickreturn.cases.motion.cycle import ChannelMeasures, CycleMeasures
from quickreturn.cases.motion.marching import AVERAGED, BOUND, GROUPS, mean_measures, standard_error
from tests.changed_run import UNRESOLVED, measured


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
