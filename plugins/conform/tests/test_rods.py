"""Rods without a mechanism: each mistake is found by the check that concerns it, right ones are not accused."""

import math
from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from quickreturn.engines.base import AnyEngine, Refusal, Simulation
from quickreturn.engines.exudyn.engine import ExudynEngine
from quickreturn.engines.mujoco.engine import MujocoEngine
from quickreturn.engines.own.reference import ReferenceEngine
from quickreturn.engines.trajectory import Trajectory
from quickreturn.plugins.conform.bench import Bench, Check, Fault
from quickreturn.plugins.conform.contract import conform
from quickreturn.plugins.conform.rods import _RIGHT, acceleration, ring, rods, strains
from quickreturn.plugins.conform.scenes import CLAMPED
from quickreturn.plugins.conform.tests.rod_engines import (
    MUTANTS,
    Elements,
    ElementsOfOneMetre,
    LinearMotion,
    LinearRod,
    Links,
    mistaken,
    of_elements,
)
from quickreturn.reference_model.mechanism import Scene
from quickreturn.reference_model.natural_modes import clamped_modes


def tried(tested: AnyEngine) -> dict[str, Check]:
    return {check.check: check for check in rods(Bench(tested))}


def alone(kind: Any) -> AnyEngine:
    """An engine that refuses the mechanism."""

    def check(self: Any, scene: Scene) -> None:
        if scene.crank is not None:
            raise Refusal("no crank")
        kind.check(self, scene)

    tested: AnyEngine = type(f"Only{kind.__name__}", (kind,), {"check": check})()
    return tested


def failed(found: dict[str, Check]) -> set[str]:
    return {name for name, check in found.items() if check.status == "failed"}


#: What `LinearRod` is wrong in, whatever else.
BEYOND = "rod: sag beyond small deflections"


@pytest.mark.parametrize("name", MUTANTS)
def test_a_mistake_of_a_rod_is_found(name: str) -> None:
    part, change, check = MUTANTS[name]
    found = tried(mistaken(part, change))
    assert failed(found) - {BEYOND} == {check}, found


def test_a_chain_for_small_deflections_is_right_in_them_and_wrong_beyond() -> None:
    found = tried(LinearRod())
    assert failed(found) == {BEYOND}
    assert {check.status for name, check in found.items() if name != BEYOND} == {"passed"}


@pytest.mark.parametrize("pieces", [2, *(pytest.param(count, marks=pytest.mark.verify) for count in (4, 16))])
def test_a_rod_of_few_accurate_pieces_is_not_accused(pieces: int) -> None:
    """Differences of three of its points are no strains: with two elements 0.56 of the closed form near the clamp."""
    found = tried(of_elements(Elements, (pieces, 1e-3), (2 * pieces, 1e-4)))
    assert {check.status for check in found.values()} == {"passed"}, found


def test_a_rod_is_read_from_less_than_one_vibration() -> None:
    """Two elements of 0.3 m with the matrices of 1 m: stiffness 0.3^3 and mass 1/0.3 times as large, a frequency of 0.3^2."""
    cause = tried(of_elements(ElementsOfOneMetre, (2, 1e-3), (4, 1e-4)))["rod: sags and frequencies"].cause
    assert f"sag under its weight {0.3**-4:.4g}" in cause
    assert f"sag by a force at its end {0.3**-3:.4g}" in cause
    assert float(cause.split("first frequency ")[1].split(",")[0]) == pytest.approx(0.09, rel=1e-3)


@pytest.mark.verify
def test_reference_as_a_rod_is_not_accused() -> None:
    found = tried(alone(ReferenceEngine))
    assert {check.status for check in found.values()} == {"passed"}, found
    assert len(found) == 6


@pytest.mark.verify
@pytest.mark.parametrize("kind", [ReferenceEngine, MujocoEngine, ExudynEngine])
def test_an_engine_that_models_a_rod_alone_is_judged(kind: Any) -> None:
    found = conform(alone(kind))
    assert found.conforms, found.failed
    assert all(check.status == "passed" for check in found.checks)


@pytest.mark.parametrize("options", [{}, {"groups": ("motion",)}, {"quick": True}], ids=str)
def test_whatever_groups_are_asked_for_a_rod_is_judged(options: Any) -> None:
    found = conform(mistaken(*MUTANTS["round section"][:2]), quiet=True, **options)
    assert found.conforms is False


def test_an_engine_that_refuses_everything_is_not_judged() -> None:
    class Nothing(ReferenceEngine):
        def check(self, scene: Scene) -> None:
            raise Refusal("nothing is modelled")

    assert conform(Nothing(), groups=("motion",), quiet=True).conforms is None


#: Mistake in a column -> the column, how it is changed, and what is said.
WRONG: dict[str, tuple[str, Callable[[np.ndarray], np.ndarray], str]] = {
    "an accelerometer's reading": ("tip_acceleration", lambda a: a + 9.81, "too large on average"),
    "acceleration with the wrong sign": ("tip_acceleration", lambda a: -a, "-1 times"),
    "an end that stands still": ("tip_deflection", lambda w: 0.0 * w, "0 times"),
    "curvature for strain": ("strain_1", lambda e: e / CLAMPED.follower.extreme_fibre, "669."),
    "double thickness": ("strain_3", lambda e: 2.0 * e, "times the closed form"),
}


class SpoiltRod(LinearRod):
    def __init__(self, column: str, change: Callable[[np.ndarray], np.ndarray]) -> None:
        self.column, self.change = column, change

    def prepare(self, scene: Any, start: Any, settings: Links, /) -> Simulation:
        motion: Any = LinearMotion(self, scene, settings.links)
        advance = motion.advance

        def spoilt(duration: float, output_step: float) -> Trajectory:
            run: Trajectory = advance(duration, output_step)
            return replace(run, columns=run.columns | {self.column: self.change(run[self.column])})

        motion.advance = spoilt
        return motion  # type: ignore[no-any-return]


@pytest.mark.parametrize("mistake", WRONG)
def test_a_wrong_column_of_a_rod_is_found(mistake: str) -> None:
    column, change, words = WRONG[mistake]
    with pytest.raises(Fault, match=words):
        (acceleration if column.startswith("tip_") else strains)(Bench(SpoiltRod(column, change)))


def test_sound_columns_of_a_rod_are_right() -> None:
    strains(Bench(LinearRod()))
    acceleration(Bench(LinearRod()))


def test_the_closed_frequencies_are_those_of_clamped_modes() -> None:
    assert _RIGHT[2:] == pytest.approx(clamped_modes(CLAMPED, 3).frequencies, rel=1e-9)


def test_a_record_shows_its_rest_frequencies_and_rates() -> None:
    time = 1e-3 * np.arange(661)
    sizes, frequencies, rates = np.array([0.97, 0.03, 2e-3]), np.array([12.1, 76.0, 212.0]), np.array([1.5, 60.0, 3.0])
    signal = -2.6e-3 * (1.0 - sizes @ (np.exp(-np.outer(rates, time)) * np.cos(2.0 * math.pi * np.outer(frequencies, time))))
    noise = 1e-10 * np.random.default_rng(3).standard_normal(len(time))
    found = ring(signal + noise, 1e-3)
    assert found.rest == pytest.approx(-2.6e-3, rel=1e-5)
    assert found.rates == pytest.approx(rates, rel=1e-2)
    assert found.frequencies == pytest.approx(np.hypot(frequencies, rates / (2.0 * math.pi)), rel=1e-4)
