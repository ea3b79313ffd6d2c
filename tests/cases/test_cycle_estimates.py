"""Estimates of measures, on pairs of runs whose errors are known."""

import numpy as np
import pytest

from cases.cycle_estimates import MeasuredPair, mean_estimate, measured_pair, with_estimates
from cases.measures import CHANNELS, Consensus, CycleMeasures, Measure
from cases.steady_run import Pair

ANGLES = np.linspace(0.0, 2.0 * np.pi, 401)


def measures(error: float = 0.0, resolved: tuple[str, ...] = CHANNELS) -> CycleMeasures:
    """All numbers of all channels off by a multiple of `error` that tells them apart."""

    def of(half: str, channel: str) -> Measure:
        known = channel in resolved
        return Measure(
            half=half,
            channel=channel,
            first_mode_frequency=17.0 + error if known else None,
            first_mode_frequency_uncertainty=(0.1 if channel == "strain_1" else 0.2) if known else None,
            first_mode_amplitude=2.0 + 2.0 * error if known else None,
            first_mode_amplitude_uncertainty=0.1 if known else None,
            second_mode_frequency=None,
            minimum=-5.0 + 3.0 * error,
            maximum=5.0 + 4.0 * error,
            reason="",
        )

    found = tuple(of(half, channel) for half in ("pre", "post") for channel in CHANNELS)
    return CycleMeasures(found, tuple(Consensus(half, 17.0 + error if resolved else None, 0.1) for half in ("pre", "post")))


def pair(run: CycleMeasures, other: CycleMeasures, factor: float, difference: float = 0.0) -> MeasuredPair:
    return MeasuredPair(run, other, factor, {(m.half, m.channel): difference for m in run.measures})


def test_parts_are_differences_over_the_factor_less_one_and_add_up() -> None:
    # an error of 0.1 in the first part, of which the other run has four times as much; of 0.02 in the second, where it has a quarter
    delivered = measures(0.1)
    pairs = [pair(delivered, measures(0.4), 4.0), pair(measures(0.02), measures(0.005), 0.25)]
    for measure in with_estimates(delivered, pairs)["measures"]:
        assert measure["first_mode_frequency_estimate"] == pytest.approx(0.12)
        assert measure["first_mode_amplitude_estimate"] == pytest.approx(2.0 * 0.12)
        assert measure["minimum_estimate"] == pytest.approx(3.0 * 0.12)
        assert measure["maximum_estimate"] == pytest.approx(4.0 * 0.12)
        assert measure["minimum"] == -5.0 + 0.3


def test_extremes_that_are_alike_by_accident_are_not_taken_for_right() -> None:
    same = measures()
    for measure in with_estimates(same, [pair(same, same, 3.0, difference=0.4)])["measures"]:
        assert measure["maximum_estimate"] == measure["minimum_estimate"] == pytest.approx(0.2)
        assert measure["first_mode_frequency_estimate"] == 0.0


def test_what_one_run_does_not_resolve_has_no_estimate() -> None:
    delivered, blind = measures(0.1), measures(0.4, resolved=("strain_2",))
    for run, other in ((delivered, blind), (blind, delivered)):
        found = with_estimates(delivered, [pair(run, other, 4.0)])
        for measure in found["measures"]:
            assert (measure["first_mode_frequency_estimate"] is not None) == (measure["channel"] == "strain_2")
            assert measure["minimum_estimate"] is not None
        assert [consensus["first_mode_frequency_estimate"] for consensus in found["consensus"]] == pytest.approx([0.1, 0.1])


def test_without_pairs_there_are_no_estimates() -> None:
    found = with_estimates(measures(), [])
    numbers = [value for row in found["measures"] + found["consensus"] for key, value in row.items() if key.endswith("_estimate")]
    assert numbers == [None] * (8 * 4 + 2)


def test_a_mean_is_off_by_at_most_the_mean_of_what_its_channels_are_off_by() -> None:
    rows = [
        {"half": "pre", "channel": "strain_1", "first_mode_frequency_uncertainty": 0.1, "first_mode_frequency_estimate": 0.3},
        {"half": "pre", "channel": "strain_2", "first_mode_frequency_uncertainty": 0.2, "first_mode_frequency_estimate": 0.8},
        {"half": "post", "channel": "strain_2", "first_mode_frequency_uncertainty": 0.2, "first_mode_frequency_estimate": 9.0},
        {"half": "pre", "channel": "strain_3", "first_mode_frequency_uncertainty": None, "first_mode_frequency_estimate": None},
    ]
    assert mean_estimate(rows, "pre") == pytest.approx((100.0 * 0.3 + 25.0 * 0.8) / 125.0)
    assert mean_estimate(rows, "pre", ["strain_2"]) == pytest.approx(0.8)
    assert mean_estimate(rows, "pre", ["strain_3"]) is None


def test_signals_are_compared_by_crank_angle_in_each_half() -> None:
    """The second run is 0.02 higher after the return, and its rows lie elsewhere."""

    def cycle(angles: np.ndarray, offset: float) -> dict[str, np.ndarray]:
        signal = np.sin(angles) + offset * np.clip((angles - np.pi) * 1e3, 0.0, 1.0)
        return {"time": angles / 10.0, "crank_angle": np.pi + angles, **dict.fromkeys(CHANNELS, signal)}

    uneven = 2.0 * np.pi * (np.linspace(0.0, 1.0, 3001) ** 1.1)
    found = measured_pair(Pair(cycle(ANGLES, 0.0), cycle(uneven, 0.02), 2.0), lambda _: measures())
    for channel in CHANNELS:
        assert found.differences["pre", channel] < 1e-4
        assert found.differences["post", channel] == pytest.approx(0.02, rel=0.01)
