"""Engines with one mistake each are found out, by the check that concerns it; sound ones, and coarse ones that say so, are not accused."""

import dataclasses
import re
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from quickreturn.engines.base import AnyEngine, Comparison, Refusal
from quickreturn.engines.exudyn.engine import ExudynEngine
from quickreturn.engines.exudyn.settings import ExudynSettings
from quickreturn.engines.mujoco.engine import MujocoEngine
from quickreturn.engines.mujoco.settings import ChainSettings
from quickreturn.engines.own.reference import ReferenceEngine, ReferenceSettings
from quickreturn.engines.registry import engine
from quickreturn.engines.simple import SimpleEngine
from quickreturn.plugins.conform import promises as ladder_checks
from quickreturn.plugins.conform.bench import FOLLOWERS, Bench, Check, Fault, check_by, first_modelled
from quickreturn.plugins.conform.columns import check_first_row, examined, motion, relation
from quickreturn.plugins.conform.contract import GROUPS, conform, failures, repetition
from quickreturn.plugins.conform.promises import climb, frequencies, ladder, stated_errors
from quickreturn.plugins.conform.quantities import alone, followed, together, turning, with_everything
from quickreturn.plugins.conform.scenes import BASE, CHANGES, CHANGES_ALONE, FEATURES
from quickreturn.plugins.conform.tests.mutants import PLANTED, SOUND, column, of_frequencies
from quickreturn.reference_model.mechanism import Mechanism, Scene
from quickreturn.reference_model.scene_values import NAMED
from tests.engines.test_simple import ToyEngine

_GROUPS = {
    "ladder": ladder,
    "estimates": ladder,
    "frequencies": frequencies,
    "failures": failures,
    "the same the second time": lambda bench: repetition(bench, "not tried"),
    "the follower alone": alone,
}


def tried(engine: AnyEngine, name: str) -> Check:
    """The check of this name, without most of those before it."""
    bench = Bench(engine)
    if name == "an arm that turns fully":
        return check_by(name, turning, bench)
    if name == "quantity with everything on":
        return check_by(name, together, bench, bench.scene, FEATURES, frozenset(examined(bench, bench.mild).wrong))
    kind, _, quantity = name.partition("quantity " if name.startswith("quantity ") else ": ")
    for change in CHANGES if kind == "" else CHANGES_ALONE:
        if change.name == quantity:
            before = bench.mild if kind == "" else first_modelled(bench.engine, FOLLOWERS)
            return check_by(name, followed, bench, before.scene, change, frozenset(examined(bench, before).wrong))
    checks = next((checks for start, checks in _GROUPS.items() if name.startswith(start)), motion)(bench)
    return next(check for check in checks if check.check == name)


#: Mistakes of each kind that take a second: of a column, a quantity, frequencies, the joint, the drive, an arm that turns, a start.
_QUICK = (
    "strain sign", "force 0.4 rows late", "gauges exchanged", "the base's acceleration reversed", "chord",
    "follower damping doubled", "frequencies in rad/s", "weight of the crank turned round",
    "weight of the slider not in the drive", "folds the angle", "time restarts", "raises in check", "settings_for backwards",
)  # fmt: skip
#: Mistake -> what is said of it, where the one rule gives it.
_SAID = {
    "stiffness 2 %": "follower.bending_stiffness 1.02 times as large",
    "strain sign": "strain_2 is -1 times the right one",
    "percent": "strain_1 is 100 times the right one",
    "force 0.4 rows late": r"slider_force comes 0\.4 ms late",
    "crank angle from the start": r"crank_angle is the right one plus -3\.142",
    "gauges exchanged": "strain_1 holds strain_3",
    "follower damping doubled": "times the right effect of follower.damping",
    "base damping ignored": r"^0 times the right effect of base.damping",
    "half the joint stiffness": "times the right effect of slider.joint_stiffness",
    "frequencies in rad/s": "6.283, 6.283, 6.283 times",
    "raises in check": "KeyError",
}


@pytest.mark.parametrize("name", [name if name in _QUICK else pytest.param(name, marks=pytest.mark.verify) for name in PLANTED])
def test_a_mistake_is_found(name: str) -> None:
    kind, check = PLANTED[name]
    found = tried(kind(), check)
    assert found.status == "failed", found
    assert re.search(_SAID.get(name, ""), found.cause), found.cause


@pytest.mark.verify
def test_a_mistake_of_a_column_is_reported_once() -> None:
    found = conform(PLANTED["percent"][0](), groups=("motion", "resolution"))
    assert {check.check for check in found.failed} == {"column strain_1", "column strain_2", "column strain_3"}


def test_a_column_is_related_to_the_right_ones() -> None:
    time = 1e-3 * np.arange(200)
    right = {"time": time, "slider_force": np.sin(40.0 * time), "strain_1": np.cos(90.0 * time)}
    for found, words in (
        (-3.0 * right["slider_force"], "is -3 times the right one"),
        (right["slider_force"] + 0.5, "is the right one plus 0.5"),
        (np.sin(40.0 * (time - 4e-4)), "comes 0.4 ms late"),
        (right["strain_1"], "holds strain_1"),
    ):
        assert relation("slider_force", found, right)[0] == words


class EightLinks(MujocoEngine):
    name = "eight-links"

    def settings_for(self, accuracy: float, mechanism: Mechanism) -> ChainSettings:
        return super().settings_for(accuracy, mechanism).replaced(links=8)


class SixElements(ExudynEngine):
    name = "six-elements"

    def settings_for(self, accuracy: float, mechanism: Mechanism) -> ExudynSettings:
        return super().settings_for(accuracy, mechanism).replaced(elements=6)


Coarse = type("Coarse", (ReferenceEngine,), {"name": "coarse-by-default", "default_accuracy": 0.2})


def test_reference_is_not_accused() -> None:
    found = conform(ReferenceEngine(), groups=("motion", "resolution", "frequencies", "failures"))
    assert found.conforms, found.failed
    assert {check.status for check in found.checks} == {"passed"}


@pytest.mark.verify
@pytest.mark.parametrize(
    "name",
    [
        *("thesis", "reference", "exudyn", "mujoco", "mujoco-contact", "derived"),
        *("fixed-shapes", "multiplier", "stiff-spring", "moving-boundaries"),
    ],
)
def test_own_engines_are_not_accused(name: str) -> None:
    found = conform(engine(name))
    assert found.conforms, found.failed


@pytest.mark.verify
@pytest.mark.parametrize("coarse", [EightLinks(), SixElements(), Coarse()], ids=lambda engine: engine.name)
def test_coarse_engines_that_say_so_are_not_accused(coarse: AnyEngine) -> None:
    found = conform(coarse, groups=tuple(group for group in GROUPS if group != "repetition"))
    assert found.conforms, found.failed


def test_an_exception_in_the_first_check_is_a_failed_check() -> None:
    found = conform(type("Raising", (ReferenceEngine,), {"check": lambda self, mechanism: 1 / 0})(), groups=("motion",), quiet=True)
    assert [check.status for check in found.checks] == ["failed"]
    assert "ZeroDivisionError" in found.checks[0].cause


def test_an_engine_that_refuses_arms_that_turn_is_not_blamed() -> None:
    class Swinging(ReferenceEngine):
        def check(self, scene: Scene) -> None:
            super().check(scene)
            if scene.turns_fully:
                raise Refusal("crank.length: a crank longer than mechanism.pivot_distance is not modelled")

    check = tried(Swinging(), "an arm that turns fully")
    assert (check.status, check.cause.startswith("refused: crank.length")) == ("passed", True)


def test_every_quantity_that_an_engine_may_lack_is_changed() -> None:
    changes = {re.split(r",| along| with", change.name)[0] for change in (*CHANGES, *CHANGES_ALONE)}
    assert set(NAMED) - changes == set()


def test_everything_at_once_leaves_out_what_an_engine_does_not_have() -> None:
    bench = Bench(engine("multiplier"))
    accepted = set(with_everything(bench, bench.scene, FEATURES)[1])
    assert {"mechanism.gravity", "slider.friction", "follower.material_damping"} <= accepted
    assert not {"slider.joint_stiffness", "slider.joint_damping", "slider.preload"} & accepted
    assert len(with_everything(Bench(ReferenceEngine()), BASE, FEATURES)[1]) == len(FEATURES)


@pytest.mark.parametrize(("off", "status"), [(1e-5, "passed"), (-1e-5, "passed"), (0.05, "failed")])
def test_the_first_row_may_be_off_by_what_the_engine_says(off: float, status: str) -> None:
    """The engine with a single shape says that the base's angle is off by more than 1e-5."""
    tilted = type("Tilted", (column("follower_angle", lambda angle: angle + off),), {"settings_for": lambda *_: ReferenceSettings(modes=1)})
    bench = Bench(tilted())
    check = check_by("first row", check_first_row, bench, bench.mild, frozenset())
    assert check.status == status, check


class Boastful(ReferenceEngine):
    """Its errors are ten times what it says."""

    def comparisons(self, settings: ReferenceSettings, mechanism: Scene, output_step: float) -> tuple[Comparison, ...]:
        (pair,) = super().comparisons(settings, mechanism, output_step)
        return (dataclasses.replace(pair, factor=1.0 + 10.0 * (1.0 - pair.factor), before=None),)


def test_estimates_that_are_too_small_are_no_mistake_of_columns() -> None:
    found = conform(Boastful(), groups=("motion", "resolution"))
    assert {check.check.split(",")[0] for check in found.failed} == {"estimates hold"}


@pytest.mark.parametrize(("accuracy", "status"), [(0.3, "passed"), (0.05, "failed")])
def test_frequencies_are_judged_by_the_error_stated(accuracy: float, status: str) -> None:
    """Right in the first, and as far off in the second as an accuracy of 30 % lets expect."""
    two = of_frequencies(
        lambda scene, angle, count, settings: SOUND.natural_frequencies(scene, angle, count, settings)[:2] * np.array([1.0, 1.25])[:count]
    )
    assert tried(type("TwoModes", (two,), {"default_accuracy": accuracy})(), "frequencies").status == status


def test_guessed_errors_are_measured() -> None:
    """A guess 3.5 times too small; the toy's motion is made up, so that any true statement about it is a large one."""
    guessed, honest = (type("Stated", (ToyEngine,), {"quantities": tuple(NAMED), "errors": {4: error, 8: 0.01}})() for error in (0.3, 2.0))
    with pytest.raises(Fault, match=r"`errors` states 0.3 for resolution 4, measured in thesis-24 it is 1"):
        stated_errors(guessed)
    stated_errors(honest)


def test_a_simple_engine_without_attributes_says_what_is_missing() -> None:
    bare = type("Bare", (SimpleEngine,), {"name": "bare", "order": 2.0})
    with pytest.raises(TypeError, match=r"^class Bare lacks method, model, library, errors; docs/engine.md says"):
        bare()


class Run(dict[str, Any]):
    solve_seconds = 0.0


@pytest.mark.parametrize(
    ("errors", "slow", "rungs"),
    [
        ([0.05487, 0.0476, 0.04942, 0.016, 0.01], False, 2),  # of `nodal-load`, whose errors change their sign
        ([0.05487, 0.05, 0.05942, 0.016, 0.01], False, 4),
        ([0.05487, 0.05, 0.05942, 0.016, 0.01], True, 3),
        ([1e-6] * 4, False, 1),
    ],
)
def test_further_rungs_are_run_until_one_is_better(errors: list[float], slow: bool, rungs: int, monkeypatch: pytest.MonkeyPatch) -> None:
    def run(_: Any, rung: int) -> Run:
        found = Run(tip_deflection=np.full(3, 1.0 + errors[rung]))
        found.solve_seconds = 100.0 if slow and rung == 2 else 0.0
        return found

    monkeypatch.setattr(ladder_checks, "_right", lambda _: {"tip_deflection": np.ones(3)})
    bench: Any = SimpleNamespace(mild=None, scene=None, run=run, finer=lambda _, rung: rung + 1 if rung + 1 < len(errors) else None)
    first: Any = 0
    np.testing.assert_allclose(climb(bench, first), errors[:rungs], rtol=1e-9)
