"""Probabilities of statements against closed forms."""

import math

import numpy as np
import pytest
from scipy.stats import binom, norm

from quickreturn.plugins.thesis.inference.emulator import Emulated
from quickreturn.plugins.thesis.inference.study import RUNS
from quickreturn.plugins.thesis.inference.words import (
    FREQUENCIES,
    MISREAD,
    READING,
    RING_FREQUENCY,
    RING_SEEN,
    VOTES,
    Predicted,
    at_least,
    least_number,
    likelihoods,
    published,
)

QUANTITIES = ("pre_frequency", "post_frequency", "post_over_pre_frequency", "pre_amplitude", "post_amplitude")


def predicted(ratio: float, ring: float = 132.0, error: float = 0.0) -> Predicted:
    """One machine with the same ratios of all quantities in all runs."""
    number = Emulated(np.array([math.log(ratio)]), error, 100)
    single = {
        "first": 24.0,
        "ring": math.log(ring),
        "seen": 0.7,
        "signs": 0.4,
        "tip_acceleration": math.log(254.0),
        "strain": math.log(1.5e-4),
    }
    of_example = {name: Emulated(np.array([value]), 0.0, 100) for name, value in single.items()}
    return Predicted({name: [number] * len(RUNS) for name in QUANTITIES}, of_example, (np.array([ring]), np.array([ring])))


def test_unlike_runs_have_the_sum_over_all_outcomes() -> None:
    shown = np.array([0.2, 0.5, 0.9])
    two = 0.2 * 0.5 * 0.1 + 0.2 * 0.5 * 0.9 + 0.8 * 0.5 * 0.9
    assert at_least(2, shown[:, None])[0] == pytest.approx(two + 0.2 * 0.5 * 0.9, rel=1e-12)


def test_shares_are_numbers_of_runs() -> None:
    assert [least_number(share, 10) for share in (1.0, 0.9, 0.75, 0.5)] == [10, 9, 8, 6]  # "usually" is more than half


def test_a_statement_has_the_normal_probability_of_its_range_in_the_binomial_number_of_runs() -> None:
    votes, weights = likelihoods(predicted(1.01), published())
    assert weights.sum() == pytest.approx(1.0)
    assert set(votes) == set(VOTES)
    ends = norm.cdf((np.log((0.97, 1.05)) - math.log(1.01)) / READING)
    shown = MISREAD / 2.0 + (1.0 - MISREAD) * (ends[1] - ends[0])
    assert votes["pre-frequency"][0, 0] == pytest.approx(binom.sf(least_number(0.9, len(RUNS)) - 1, len(RUNS), shown), rel=1e-9)


def test_the_bias_is_common_to_all_runs() -> None:
    """A bias of 3 % makes equal halves differ in all runs at once, so that its weight, not a power of it, is the probability."""
    votes, weights = likelihoods(predicted(1.0), published(), bias=0.03)
    shifted = float(votes["post-excess"][0] @ weights)
    assert 0.1 < shifted < norm.sf(2.0 / 3.0) + 0.15
    alone, _ = likelihoods(predicted(1.0), published(), bias=0.0)
    shown = MISREAD / 2.0 + (1.0 - MISREAD) * norm.sf(math.log(1.02) / (math.sqrt(2.0) * READING))
    assert alone["post-excess"][0, 0] == pytest.approx(binom.sf(least_number(0.5, len(RUNS)) - 1, len(RUNS), shown), rel=1e-9)
    assert shifted > 50.0 * alone["post-excess"][0, 0]


def test_the_ring_votes_twice() -> None:
    near, far = (likelihoods(predicted(1.0, ring), published())[0] for ring in (132.0, 90.0))
    assert near[RING_FREQUENCY][0, 0] == pytest.approx(1.0)
    assert far[RING_FREQUENCY][0, 0] == pytest.approx(math.exp(-0.5 * (42.0 / 8.0) ** 2), rel=1e-3)
    assert near[RING_SEEN] == far[RING_SEEN] == pytest.approx(0.7)


def test_a_recording_stands_in_the_place_of_the_words_on_its_quantity() -> None:
    measured = {"pre_frequency": {24: 1.02}}
    votes, _ = likelihoods(predicted(1.0), published(), measured=measured)
    assert votes["pre-frequency"][0, 0] == pytest.approx(math.exp(-0.5 * (math.log(1.02) / READING) ** 2), rel=1e-9)
    words, _ = likelihoods(predicted(1.0), published())
    assert all(np.array_equal(votes[name], words[name]) for name in FREQUENCIES if name != "pre-frequency")


def test_recorded_halves_do_not_vote_twice() -> None:
    measured = {name: {24: 1.02} for name in ("pre_frequency", "post_frequency", "post_over_pre_frequency")}
    votes, _ = likelihoods(predicted(1.0), published(), measured=measured)
    assert "post-excess" not in votes
    assert {"pre-frequency", "post-frequency"} < set(votes)


def test_a_number_that_is_not_known_in_any_run_does_not_vote() -> None:
    unknown = predicted(1.0, error=math.inf)
    assert "pre-frequency" not in likelihoods(unknown, published())[0]
