"""Machines such as an engineer would bring: they settle, and engines agree within what they claim."""

import itertools
import math
from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from quickreturn.cases.comparison.campaign import cross_validate
from quickreturn.cases.comparison.engines import CaseResult
from quickreturn.cases.comparison.pair import Pair
from quickreturn.cases.files.case import Case
from quickreturn.cases.motion.marching import channels_of
from quickreturn.cases.motion.request import Run
from quickreturn.cases.motion.settling import on_common_grid
from quickreturn.cases.motion.time_scale import CHANNELS
from quickreturn.cases.running.store import Store
from quickreturn.cases.running.workshop import Workshop
from quickreturn.engines.trajectory import rms
from quickreturn.reference_model.rigid import crank_pace
from tests.slices import Portion
from tests.verification.random_machines import sensible_machines
from tests.verification.random_scenes import Scene

ENGINES = ("reference", "mujoco")
SEED, SEED_OF_THREE = 603, 20261130
#: A machine whose disturbances die away faster must settle; a slower one may be refused before it marches.
SURELY_SETTLING = 0.85
#: Part of the machines that may be too violent, and are listed.
TOO_VIOLENT = 0.05
#: Machines that a slice of the long tests computes.
DRAWN, DRAWN_BY_THREE = 10, 5


def machines(count: int, seed: int = SEED) -> list[Case]:
    """Cases of the first `count` machines, their error estimated over one turn."""
    return [case_of(scene) for scene in itertools.islice(sensible_machines(seed), count)]


def case_of(scene: Scene) -> Case:
    turn = 2.0 * math.pi / crank_pace(scene.mechanism)
    return replace(scene.case, duration=turn)


def multiplier(result: CaseResult) -> float | None:
    """Largest modulus of the Floquet multipliers, where the reference found a periodic state."""
    orbit = result.runs["reference"].approach.periodic_orbit
    return max((abs(complex(*each)) for each in orbit.multipliers), default=None) if orbit else None


def deflections_differ(run: Run, other: Run) -> float:
    """Largest difference of the tip deflections of the settled cycle at equal crank angles, over the sum of what both claim, per half."""
    name = "tip_deflection"
    deflection, compared = (on_common_grid(channels_of(each.cycle, [name]))[name] for each in (run, other))
    halves = zip(("pre", "post"), np.split(np.abs(deflection - compared), 2), strict=True)
    unsettled = sum((each.approach.settling_error or 0.0) * rms(compared) for each in (run, other))
    claims = [each.measured.extreme_estimates[name] for each in (run, other)]
    return max(float(away.max()) / (unsettled + sum(claim[half] for claim in claims)) for half, away in halves)


def verdict(result: CaseResult) -> str:
    """What is wrong with a machine (a clause), "" if it settled and its engines agree."""
    slow = multiplier(result)
    for name, run in result.runs.items():
        if run.status == "settled":
            continue
        told = run.status == "not settled" and "not marched" in run.remark and "multiplier" in run.remark
        if not (told and slow is not None and slow >= SURELY_SETTLING):
            return f"{name} {run.status}: {run.remark}"
    if any(run.status != "settled" for run in result.runs.values()):
        return ""
    if result.passed is not True:
        return result.reason
    ratio = deflections_differ(*result.runs.values())
    return "" if ratio <= 1.0 else f"deflections differ by {ratio:.2g} times what both claim"


def check(results: Sequence[CaseResult], record_property: Any) -> None:
    wrong = {result.case.name: found for result in results if (found := verdict(result))}
    record_property("settled", sum(all(run.status == "settled" for run in result.runs.values()) for result in results))
    record_property("too violent", wrong)
    # of a few machines one may be among the violent ones
    assert len(wrong) <= max(1, TOO_VIOLENT * len(results)), wrong


@pytest.mark.verify
def test_two_hundred_machines_settle_and_engines_agree(record_property: Any, portion: Portion) -> None:
    check(cross_validate(portion(machines(200), DRAWN), Workshop(Store()), ENGINES), record_property)


@pytest.mark.verify
def test_three_engines_exceed_their_claims_in_one_comparison_of_a_thousand_at_most(portion: Portion) -> None:
    results = cross_validate(portion(machines(60, SEED_OF_THREE), DRAWN_BY_THREE), Workshop(Store()), (*ENGINES, "exudyn"))
    checks = [check for result in results for check in result.checks]
    missed = [check for check in checks if not check.passed]
    assert len(missed) <= max(1, len(checks) // 1000), missed


@pytest.mark.verify
def test_few_links_that_the_slider_shakes_claim_their_error() -> None:
    """Chains of 9 and 13 links err alike in a lightly damped arm; only the third chain, of 19, shows that their error does not fall."""
    case = machines(20, SEED_OF_THREE)[19]
    settings = {"reference": {"modes": "9", "tolerance": "1e-8"}, "mujoco": {"links": "9"}}
    [result] = cross_validate([case], Workshop(Store()), ENGINES, settings=settings)
    pair = Pair(result.runs["mujoco"], result.runs["reference"], "their waveforms")
    for half, channel in itertools.product(("pre", "post"), CHANNELS):
        found = pair.difference("waveform", half, channel)
        assert found is not None
        assert found.number.estimate is not None
        assert abs(found.difference) <= found.number.estimate + found.number.settling, (half, channel, found)
