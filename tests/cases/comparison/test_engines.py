"""Claims held against each other, on made-up results: whom against whom, with what tolerance, and how good each is."""

import math
from typing import Any

import numpy as np
import pytest

from quickreturn.cases.comparison.engines import CaseResult, compare, not_judged
from quickreturn.cases.comparison.pair import CONSENSUS, WAVEFORM, Difference
from quickreturn.cases.library import load_case
from quickreturn.cases.motion.cycle import ChannelMeasures
from quickreturn.cases.motion.endings import Ending
from quickreturn.cases.motion.number import Consensus
from quickreturn.cases.motion.request import Run
from quickreturn.cases.motion.time_scale import CHANNELS
from tests.changed_run import changed_run, measured

CASE = load_case("thesis-24")
PEAK = 2.0
TURNED = np.linspace(0.0, 2.0 * np.pi, 1001)
SIGNAL = PEAK * np.sin(TURNED)
RMS = PEAK / math.sqrt(2.0)  # in each half as well
SETTLING = 4e-4


def run(
    name: str, off: float = 0.0, claimed: float = 1e-3, status: str = Ending.SETTLED, estimate_of: str = "total", **changes: Any
) -> Run:
    """Numbers and signals off by `off` (extremes: of the peak), and claimed to be off by `claimed`; changes: of every measure."""
    settled = status in (Ending.SETTLED, Ending.INACCURATE)

    def measure(half: str, channel: str) -> ChannelMeasures:
        values: dict[str, Any] = {"minimum": -PEAK * (1.0 + off), "minimum_estimate": PEAK * claimed}
        values |= {"maximum": PEAK * (1.0 + off), "maximum_estimate": PEAK * claimed}
        for name, size, uncertainty in (("first_mode_frequency", 17.0, 0.1), ("first_mode_amplitude", 1.0, 0.03)):
            values |= {name: size * (1.0 + off), f"{name}_uncertainty": uncertainty, f"{name}_estimate": size * claimed}
        return measured(half, channel, **(values | changes))

    halves = ("pre", "post") if settled else ()
    return changed_run(
        Run(engine=name, estimate_of=estimate_of),
        status=status,
        settling_error=SETTLING,
        settling_errors=dict.fromkeys(CHANNELS, SETTLING * PEAK),
        unestimated="" if settled else status,
        measures=tuple(measure(half, channel) for half in halves for channel in CHANNELS),
        consensus=tuple(Consensus(half, 17.0 * (1.0 + off), 0.1) for half in halves),
        extreme_estimates={channel: dict.fromkeys(halves, PEAK * claimed) for channel in CHANNELS},
        waveform_estimates={channel: dict.fromkeys(halves, RMS * claimed) for channel in CHANNELS},
        cycle={"time": TURNED / 16.0, "crank_angle": np.pi + TURNED, **dict.fromkeys(CHANNELS, (1.0 + off) * SIGNAL)} if settled else {},
    )


def result(*runs: Run) -> CaseResult:
    return compare(CASE, {run.engine: run for run in runs})


def check_of(found: CaseResult, quantity: str, channel: str | None = "strain_1") -> Difference:
    return next(check for check in found.checks if (check.quantity, check.channel, check.half) == (quantity, channel, "pre"))


def test_a_tolerance_is_what_both_claim_and_what_the_measurement_leaves_open() -> None:
    found = result(run("reference", claimed=1e-3), run("a", off=2e-3, claimed=5e-3))
    assert check_of(found, "maximum").tolerance == pytest.approx(PEAK * (6e-3 + 2.0 * SETTLING))
    # signals that differ by 2e-3 share all but 2e-3 of the measurement's uncertainty
    assert check_of(found, "first_mode_frequency").tolerance == pytest.approx(17.0 * 6e-3 + 2e-3 * 0.2)
    assert check_of(found, "first_mode_amplitude").tolerance == pytest.approx(6e-3 + 2e-3 * 0.06)
    assert check_of(found, CONSENSUS, None).tolerance == pytest.approx(17.0 * 6e-3 + 2e-3 * 0.2)
    assert check_of(found, "waveform").tolerance == pytest.approx(RMS * (6e-3 + 2.0 * SETTLING), rel=1e-3)
    assert check_of(found, "largest_difference").tolerance == pytest.approx(PEAK * (6e-3 + 2.0 * SETTLING))
    assert check_of(found, "maximum").difference == pytest.approx(PEAK * 2e-3)
    assert check_of(found, "waveform").difference == pytest.approx(RMS * 2e-3, rel=1e-2)
    assert check_of(found, "largest_difference").difference == pytest.approx(PEAK * 2e-3, rel=1e-5)
    assert found.passed is True
    assert found.reason == ""


def test_a_kink_between_rows_is_no_disagreement() -> None:
    """Two engines have the same strain, whose slope jumps as the slider passes the gauge, at rows of other instants."""

    def sampled(name: str, turned: np.ndarray, power: int) -> Run:
        signals = dict.fromkeys(CHANNELS, PEAK * np.abs(np.sin(turned - 1.0)) ** power)
        cycle = {"time": turned / 16.0, "crank_angle": np.pi + turned, **signals}
        return changed_run(run(name, claimed=1e-9), cycle=cycle, settling_error=0.0, settling_errors=dict.fromkeys(CHANNELS, 0.0))

    rows = (TURNED, np.concatenate([[0.0], TURNED[1:-1] + 0.4 * TURNED[1], TURNED[-1:]]))
    for power, least, most in ((1, 1e-4 * PEAK, 1e-2 * PEAK), (2, 0.0, 1e-7 * PEAK)):  # with a kink, and smooth
        found = result(*(sampled(name, turned, power) for name, turned in zip(("reference", "a"), rows, strict=True)))
        for quantity in ("waveform", "largest_difference"):
            difference = check_of(found, quantity)
            assert difference.passed, (quantity, power)
            assert least * (0.1 if quantity == "waveform" else 1.0) < difference.unshared < most
            if power == 1:
                assert difference.tolerance - difference.unshared < 0.1 * abs(difference.difference)


def test_signals_that_have_nothing_in_common_share_no_uncertainty() -> None:
    other = run("a")
    columns = {**other.cycle, **dict.fromkeys(CHANNELS, -SIGNAL)}
    apart = result(run("reference"), changed_run(other, cycle=columns))
    assert check_of(apart, "first_mode_frequency").unshared == pytest.approx(0.2)
    averaged = result(run("reference"), changed_run(other, averaged_cycles=30))
    assert check_of(averaged, "first_mode_frequency").unshared == pytest.approx(0.2)
    assert {check.quantity for check in averaged.checks}.isdisjoint(WAVEFORM)


def test_what_is_left_to_the_steady_state_passes_through_the_fit() -> None:
    gains = {"variation": 0.5, "first_mode_frequency_gain": 0.4, "first_mode_amplitude_gain": 2.0}
    found = result(run("reference"), run("a", **gains))
    left = SETTLING * RMS / 0.5
    assert check_of(found, "first_mode_frequency").number.settling == pytest.approx(0.4 * 17.0 * left, rel=1e-3)
    assert check_of(found, "first_mode_amplitude").number.settling == pytest.approx(2.0 * left, rel=1e-3)
    assert check_of(found, "first_mode_frequency").tolerance == pytest.approx(17.0 * (2e-3 + 0.4 * left), rel=1e-3)


@pytest.mark.parametrize(("claimed", "passed"), [(0.02, True), (1e-3, False)])
def test_an_honest_coarse_engine_agrees_and_one_that_claims_too_much_departs(claimed: float, passed: bool) -> None:
    found = result(run("reference"), run("coarse", off=0.02, claimed=claimed))
    assert found.passed is passed
    assert found.accuracy_class("coarse") == "3 %"
    if not passed:
        assert set(found.departures) == {("coarse", "reference")}
        assert {check.quantity for check in found.missed} >= {"minimum", "maximum"}
        assert found.reason == "coarse and reference disagree by more than they claim"


@pytest.mark.parametrize(
    ("reference", "why"),
    [
        (run("reference", status=Ending.FAILED), "failed"),
        (run("reference", status="not settled"), "not settled"),
        (run("reference", status=Ending.REFUSED), "refused"),
    ],
)
def test_without_the_reference_the_others_are_held_against_the_first_that_settled(reference: Run, why: str) -> None:
    assert not_judged(reference) == why
    found = result(reference, run("a"), run("b"), run("c", off=0.05))
    assert {(check.engine, check.other) for check in found.checks} == {("b", "a"), ("c", "a")}
    assert set(found.departures) == {("c", "a")}


def test_a_reference_without_estimates_judges_nobody() -> None:
    reference = changed_run(run("reference"), unestimated="the run for their estimate failed")
    found = result(reference, run("a"), run("b"))
    assert {(check.engine, check.other) for check in found.checks} == {("b", "a")}
    assert found.accuracy_class("reference") is None


@pytest.mark.parametrize("kind", ["integration", "unverified"])
def test_an_engine_without_a_claim_on_its_whole_error_is_not_judged(kind: str) -> None:
    found = result(run("reference"), run("own", off=0.13, claimed=1e-6, estimate_of=kind), run("a"))
    assert {check.engine for check in found.checks} == {"a"}
    assert found.passed is True
    assert found.accuracy_class("own") == "worse"
    own = run("own", off=0.02, claimed=1e-6, estimate_of="integration")
    own = changed_run(own, unestimated="its own estimates cover the integration alone")
    assert result(run("reference"), own).accuracy_class("own") == "3 %"
    alone = result(run("reference"), run("own", off=0.13, estimate_of=kind))
    assert alone.passed is None
    assert alone.checks == ()
    assert "own: its estimate" in alone.reason


def test_nothing_to_judge_is_neither_good_nor_bad() -> None:
    for found in (result(run("a")), result(run("a"), run("b", status="not settled")), result(run("a", status=Ending.FAILED))):
        assert found.passed is None
        assert found.reason.startswith("nothing to compare with")


def test_a_claim_as_wide_as_the_number_says_nothing() -> None:
    found = result(run("reference"), run("a", claimed=0.5), run("b", claimed=0.03), run("c", claimed=0.5, off=1.0))
    by_engine = {name: {check.quantity: check.verdict for check in found.checks if check.engine == name} for name in "abc"}
    assert set(by_engine["a"].values()) == {"says nothing"}
    # 3 % is too wide for a frequency alone
    assert by_engine["b"] == {
        CONSENSUS: "says nothing",
        "first_mode_frequency": "says nothing",
        "first_mode_amplitude": "agrees",
        "minimum": "agrees",
        "maximum": "agrees",
        "waveform": "agrees",
        "largest_difference": "agrees",
    }
    assert set(by_engine["c"].values()) == {"disagrees"}
    counts = found.agreement
    assert sum(counts.values()) == len(found.checks)
    assert counts["disagree"] == len(found.missed) == len(found.checks) // 3
    assert found.passed is False
    nothing = result(run("reference"), run("a", claimed=0.5))
    assert (nothing.passed, nothing.agreement["agree"], nothing.missed) == (None, 0, ())
    assert nothing.reason.startswith(f"all {len(nothing.checks)} comparisons say nothing")


def test_a_run_that_misses_its_accuracy_is_judged_and_told() -> None:
    found = result(run("reference"), run("a", status=Ending.INACCURATE, off=0.01, claimed=0.01))
    assert found.missed == ()
    assert found.passed is False
    assert found.reason == "a did not deliver: inaccurate"


def test_what_has_no_estimate_is_not_compared() -> None:
    found = result(run("reference"), run("a", first_mode_frequency_estimate=None))
    assert {check.quantity for check in found.checks} == {"first_mode_amplitude", "minimum", "maximum", *WAVEFORM}
    # a frequency without an amplitude, and the other way round
    found = result(run("reference"), run("a", first_mode_amplitude=None, first_mode_amplitude_estimate=None))
    assert {check.quantity for check in found.checks} == {CONSENSUS, "first_mode_frequency", "minimum", "maximum", *WAVEFORM}
    found = result(run("reference"), run("a", **dict.fromkeys(("first_mode_frequency", "first_mode_frequency_estimate"))))
    assert {check.quantity for check in found.checks} == {"first_mode_amplitude", "minimum", "maximum", *WAVEFORM}


@pytest.mark.parametrize(("claimed", "expected"), [(1e-3, "0.1 %"), (1.1e-3, "0.3 %"), (0.0099, "1 %"), (0.099, "10 %"), (0.11, "worse")])
def test_a_class_covers_the_estimates_and_the_deviation(claimed: float, expected: str) -> None:
    found = result(run("reference"), run("a", claimed=claimed), run("b", off=claimed, claimed=1e-6))
    assert found.accuracy_class("a") == expected
    assert found.accuracy_class("b") == expected
    assert found.accuracy_class("reference") == "0.1 %"
