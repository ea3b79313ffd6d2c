"""Rods without a mechanism: each mistake is named, right ones are not accused, and the closed forms and the fit are checked by others."""

import math
import re
from typing import Any

import numpy as np
import pytest

from quickreturn.cases.conformance import GROUPS, conform
from quickreturn.cases.conformance.bench import Bench
from quickreturn.cases.conformance.checks import Check
from quickreturn.cases.conformance.clamped import Mistake, right, ring
from quickreturn.cases.conformance.rods import _CRITICAL, SCENE, motion_alone, rods
from quickreturn.engines.base import AnyEngine, EngineFailure, Refusal, Simulation
from quickreturn.engines.exudyn.engine import ExudynEngine
from quickreturn.engines.mujoco.engine import MujocoEngine
from quickreturn.engines.own.reference import ReferenceEngine
from quickreturn.engines.registry import engine
from quickreturn.reference_model.mechanism import FollowerAlone, Scene
from quickreturn.reference_model.natural_modes import clamped_modes
from quickreturn.reference_model.scene_values import changed
from tests.cases.conformance.rod_engines import MUTANTS, Elements, ElementsOfOneMetre, LinearRod, Links, of_elements


def tried(tested: AnyEngine) -> dict[str, Check]:
    return {check.check: check for check in rods(Bench(tested, alone=motion_alone(tested)))}


def alone(kind: Any) -> AnyEngine:
    """An engine that refuses the mechanism."""

    def check(self: Any, scene: Scene) -> None:
        if scene.crank is not None:
            raise Refusal("no crank")
        kind.check(self, scene)

    tested: AnyEngine = type(f"Only{kind.__name__}", (kind,), {"check": check})()
    return tested


@pytest.mark.parametrize("name", MUTANTS)
def test_a_mistake_of_a_rod_is_named_once(name: str) -> None:
    kind, words = MUTANTS[name]
    failed = [check for check in tried(kind()).values() if check.status == "failed" and "small deflections" not in check.check]
    assert len(failed) == 1, failed
    assert re.search(words, failed[0].cause), failed[0].cause
    assert failed[0].advice


def test_a_chain_for_small_deflections_is_right_in_them_and_wrong_beyond() -> None:
    found = tried(LinearRod())
    beyond = found.pop("rod: sag beyond small deflections")
    assert {check.status for check in found.values()} == {"passed"}, found
    assert len(found) == 7
    assert beyond.status == "failed"
    assert "small deflections are right" in beyond.advice


class Breaks(LinearRod):
    """It breaks down with the larger damping by its finest settings."""

    def prepare(self, scene: FollowerAlone, start: Any, settings: Links, /) -> Simulation:
        if settings.links == 20 and scene.follower.damping > 0.05 * _CRITICAL["follower.damping"]:
            raise EngineFailure(0.0, "no number any more", "try smaller steps")
        return super().prepare(scene, start, settings)


class Level(LinearRod):
    """It deflects nowhere without damping."""

    def prepare(self, scene: FollowerAlone, start: Any, settings: Links, /) -> Simulation:
        moves = super().prepare(scene, start, settings)
        if scene.follower.damping == scene.follower.material_damping == 0.0:
            moves.rest, moves.state = 0.0 * moves.rest, 0.0 * moves.state  # type: ignore[attr-defined]
        return moves


def test_a_run_that_breaks_down_is_told_with_its_settings_and_damping() -> None:
    (check,) = tried(Breaks()).values()
    assert check.status == "failed"
    assert check.cause == "a run breaks down: no number any more, with links=20 and a damping ratio of 0.08"


def test_a_rod_that_does_not_sag_is_no_error_of_the_check() -> None:
    found = tried(Level())
    assert found["rod: sag under its weight"].status == "failed"
    assert found["rod: decay by follower.damping"].status == "not judged"
    assert not any("ZeroDivision" in check.cause for check in found.values())


@pytest.mark.parametrize("pieces", [2, 4, pytest.param(16, marks=pytest.mark.verify)])
def test_a_rod_of_few_accurate_pieces_is_not_accused(pieces: int) -> None:
    """Differences of three of its points are no strains: with two elements 0.56 of the closed form near the clamp."""
    found = tried(of_elements(Elements, (pieces, 1e-3), (2 * pieces, 1e-4)))
    assert {check.status for check in found.values()} == {"passed"}, found


def test_a_rod_is_read_from_less_than_one_vibration() -> None:
    """Two elements of 0.3 m with the matrices of 1 m: stiffness 0.3^3 and mass 1/0.3 times as large, a frequency of 0.3^2."""
    found = tried(of_elements(ElementsOfOneMetre, (2, 1e-3), (4, 1e-4)))
    times = {name: check.cause for name, check in found.items() if check.status == "failed"}
    assert times["rod: sag by a force at its end"].startswith(f"its sag is {0.3**-3:.4g} times")
    assert times["rod: sag under its weight"].startswith(f"its sag is {0.3**-4:.4g} times")
    assert float(times["rod: three frequencies"].split()[3]) == pytest.approx(0.09, rel=1e-3)
    assert len(times) == 3  # the decay is not judged


def test_a_rod_that_does_not_come_back_is_told_as_that() -> None:
    (check,) = tried(of_elements(ElementsOfOneMetre, (16, 1e-3), (32, 1e-4))).values()
    assert check.status == "failed"
    assert check.cause == "in 0.66 s the rod does not come back; a right one vibrates eight times"


def test_reference_as_a_rod_is_not_accused() -> None:
    found = tried(alone(ReferenceEngine))
    assert {check.status for check in found.values()} == {"passed"}, found
    assert len(found) == 8


@pytest.mark.verify
@pytest.mark.parametrize("kind", [ReferenceEngine, MujocoEngine, ExudynEngine])
def test_an_engine_that_models_a_rod_alone_is_judged(kind: Any) -> None:
    found = conform(alone(kind))
    assert found.conforms, found.failed
    assert all(check.status == "passed" for check in found.checks)


@pytest.mark.parametrize("groups", [tuple(GROUPS), ("motion",), ("repetition",)], ids=len)
def test_whatever_groups_are_asked_for_a_rod_is_judged(groups: tuple[str, ...]) -> None:
    found = conform(MUTANTS["round section"][0](), groups=groups, quiet=True)
    assert found.conforms is False
    assert "does not conform" in found.verdict


def test_a_quick_trial_judges_a_rod() -> None:
    found = conform(MUTANTS["a segment too many"][0](), groups=("motion",), quick=True, quiet=True)
    assert found.conforms is False


@pytest.mark.parametrize("name", ["reference", "mujoco", "thesis", "multiplier"])
def test_an_engine_with_a_mechanism_is_tried_with_it(name: str) -> None:
    assert motion_alone(engine(name)) is None


def test_an_engine_that_refuses_everything_is_not_judged() -> None:
    class Nothing(ReferenceEngine):
        def check(self, scene: Scene) -> None:
            raise Refusal("nothing is modelled")

    found = conform(Nothing(), groups=("motion",), quiet=True)
    assert found.conforms is None


def test_a_mistake_acts_as_closed_forms_say() -> None:
    """A clamp that turns by c L/EI adds 4 c and 3 c to the sags, a mass at the end 8/3 of its ratio to that under the weight."""
    follower, gravity, mass = SCENE.follower, -9.81, 0.1
    known = right(follower, gravity, mass)
    assert Mistake().acts(follower, gravity, mass).over(known) == pytest.approx(np.ones(5), rel=1e-4)
    assert known.frequencies == pytest.approx(clamped_modes(SCENE, 3).frequencies, rel=1e-9)
    turned = Mistake(clamp=0.03).acts(follower, gravity, mass).over(known)
    assert turned[:2] == pytest.approx([1.12, 1.09], rel=1e-9)
    # Blevins, table 8-1, beam hinged by a spring k and free: b (sin cosh - cos sinh) c - (1 + cos cosh) = 0 for b^2 ~ frequency
    b = 1.8751040687 * math.sqrt(turned[2])
    assert 0.03 * b * (math.cos(b) * math.sinh(b) - math.sin(b) * math.cosh(b)) + 1.0 + math.cos(b) * math.cosh(b) == pytest.approx(
        0.0, abs=1e-4
    )
    heavier = Mistake(end=0.03).acts(follower, gravity, mass).over(known)
    assert heavier[:2] == pytest.approx([1.08, 1.0], rel=1e-9)
    with_mass = changed(SCENE, {"tip.mass": 0.03 * follower.mass_per_length * follower.length, "tip.inertia": 0.0})
    expected = clamped_modes(with_mass, 3).frequencies
    assert heavier[2:] * known.frequencies == pytest.approx(expected, rel=1e-4)
    lighter = Mistake(end=-0.03).acts(follower, gravity, mass).over(known)
    assert lighter[0] == pytest.approx(0.92, rel=1e-9)


def test_a_record_tells_its_rest_frequencies_and_rates() -> None:
    time = 1e-3 * np.arange(661)
    sizes, frequencies, rates = np.array([0.97, 0.03, 2e-3]), np.array([12.1, 76.0, 212.0]), np.array([1.5, 60.0, 3.0])
    signal = -2.6e-3 * (1.0 - sizes @ (np.exp(-np.outer(rates, time)) * np.cos(2.0 * math.pi * np.outer(frequencies, time))))
    noise = 1e-10 * np.random.default_rng(3).standard_normal(len(time))
    found = ring(signal + noise, 1e-3)
    assert found.rest == pytest.approx(-2.6e-3, rel=1e-5)
    assert found.rates == pytest.approx(rates, rel=1e-2)
    assert found.frequencies == pytest.approx(np.hypot(frequencies, rates / (2.0 * math.pi)), rel=1e-4)
