"""From evidence to verdict, without any engine."""

from dataclasses import replace
from typing import Any

import pytest

from quickreturn.cases.motion.balances import LARGEST_GAP, LARGEST_JUMP, Balances
from quickreturn.plugins.methods.judging.verdicts import (
    ACCURATE,
    CONTRADICTED,
    DIVERGED,
    ENDED,
    LATER,
    MEANINGS,
    NOT_CONVERGED,
    OWN_EQUATIONS,
    REFUSED,
    Breakdown,
    Evidence,
    Verdict,
    contradicted,
    judge,
)

GOOD = Evidence(
    requested=0.01,
    duration=2.0,
    stretch=2.0,
    row=1e-3,
    error_estimate=0.004,
    finer_difference=0.0015,
    balances=Balances(energy_residual=1e-3),
)
#: The slider leaves the follower at 0.25 s, whatever the settings.
LEAVING = replace(GOOD, stretch=0.24, breakdown=Breakdown(time=0.25, cause="the slider left", at_the_end=True, finer_time=0.2505))
#: Two good solutions run apart after 0.4 s.
WILD = replace(GOOD, stretch=0.4, later={"extremes": 0.03, "spectrum": 0.05, "energy": 0.02})


def test_a_run_without_doubt_is_accurate_and_claims_its_larger_estimate() -> None:
    verdict = judge(GOOD)
    assert (verdict.kind, verdict.claimed_error, verdict.stretch) == (ACCURATE, 0.004, 2.0)
    assert judge(replace(GOOD, finer_difference=0.004)).claimed_error == 0.008  # twice the difference
    assert judge(replace(GOOD, finer_difference=None, balances=Balances())).kind == ACCURATE  # not every engine has all of it


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"error_estimate": 0.011}, "estimated error 0.011 exceeds the 0.01 asked"),
        ({"error_estimate": float("nan")}, "exceeds"),
        ({"error_estimate": None, "remark": "the coarser run failed"}, "the coarser run failed"),
        ({"error_estimate": None}, "cannot be estimated"),
        ({"finer_difference": 0.4}, "estimated error 0.8 exceeds"),
        ({"finer_failure": "failed at t = 1 s: the beam snapped"}, "with finer settings it failed at t = 1 s: the beam snapped"),
        ({"balances": Balances(energy_residual=0.021)}, "energy balance"),
        ({"balances": Balances(energy_residual=float("nan"))}, "energy balance"),
        ({"balances": Balances(constraint_gap=1.1 * LARGEST_GAP)}, "centre line"),
        ({"balances": Balances(crank_jump=1.1 * LARGEST_JUMP)}, "crank angle jumps"),
    ],
)
def test_every_doubt_suffices(change: dict[str, Any], words: str) -> None:
    verdict = judge(replace(GOOD, **change))
    assert verdict.kind == NOT_CONVERGED
    assert words in verdict.reason
    assert verdict.claimed_error is None


def test_a_refusal_is_told_as_the_engine_tells_it() -> None:
    assert judge(replace(GOOD, refused="slider.inertia: no")) == Verdict(REFUSED, "slider.inertia: no")


def test_a_breakdown_is_told_with_time_and_cause() -> None:
    verdict = judge(replace(GOOD, breakdown=Breakdown(time=0.3, cause="the beam snapped")))
    assert (verdict.kind, verdict.time) == (DIVERGED, 0.3)
    assert "0.3 s: the beam snapped" in verdict.reason
    assert verdict.claimed_error is None
    never_began = judge(replace(GOOD, breakdown=Breakdown(time=0.0, cause="stopped at the time limit of 9 s")))
    assert never_began == Verdict(DIVERGED, "stopped at the time limit of 9 s")


def test_the_end_of_a_scene_is_one_only_if_finer_settings_find_it_too() -> None:
    verdict = judge(LEAVING)
    assert (verdict.kind, verdict.time, verdict.claimed_error, verdict.stretch) == (ENDED, 0.25, 0.004, 0.24)
    assert verdict.time_uncertainty == pytest.approx(0.0005 + 1e-3)
    for finer_time in (None, 0.3):  # finer settings go on, or end elsewhere
        moved = judge(replace(LEAVING, breakdown=Breakdown(time=0.25, cause="the slider left", at_the_end=True, finer_time=finer_time)))
        assert moved.kind == NOT_CONVERGED
        assert "0.25 s" in moved.reason
    assert judge(replace(LEAVING, error_estimate=0.02)).kind == NOT_CONVERGED


def test_an_ill_conditioned_scene_is_accurate_up_to_its_horizon_and_says_what_is_known_beyond() -> None:
    verdict = judge(WILD)
    assert (verdict.kind, verdict.stretch) == (ACCURATE, 0.4)
    assert "up to 0.4 s" in verdict.reason
    assert "extremes to 0.03" in verdict.reason
    beyond = judge(replace(WILD, later={"extremes": 1.1 * LATER, "spectrum": 0.0}))
    assert beyond.kind == NOT_CONVERGED
    assert "extremes" in beyond.reason
    assert judge(replace(WILD, later=None)).kind == NOT_CONVERGED


def claim(error: float) -> Verdict:
    return Verdict(ACCURATE, "", error, 2.0)


def test_claims_that_cannot_both_hold_are_settled_by_the_majority() -> None:
    verdicts = {"a": claim(1e-3), "b": claim(3e-3), "odd": claim(1e-3)}
    found = contradicted(verdicts, {("a", "b"): 3e-3, ("a", "odd"): 0.08, ("b", "odd"): 0.081})
    assert {name: verdict.kind for name, verdict in found.items()} == {"a": ACCURATE, "b": ACCURATE, "odd": CONTRADICTED}
    assert "differs from" in found["odd"].reason


def test_two_claims_that_cannot_both_hold_are_both_doubted() -> None:
    found = contradicted({"a": claim(1e-3), "b": claim(1e-3)}, {("b", "a"): 0.0021})
    assert {verdict.kind for verdict in found.values()} == {CONTRADICTED}
    near = contradicted({"a": claim(1e-3), "b": claim(1e-3)}, {("a", "b"): 0.0019})
    assert {verdict.kind for verdict in near.values()} == {ACCURATE}


def test_who_claims_nothing_is_not_compared() -> None:
    verdicts = {"a": claim(1e-3), "b": judge(replace(GOOD, error_estimate=0.5)), "c": judge(replace(GOOD, refused="no"))}
    assert contradicted(verdicts, {("a", "b"): 0.5, ("a", "c"): 0.5}) == verdicts


def test_every_kind_is_explained() -> None:
    assert set(MEANINGS) == {ACCURATE, OWN_EQUATIONS, NOT_CONVERGED, CONTRADICTED, ENDED, DIVERGED, REFUSED}
