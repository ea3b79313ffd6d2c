"""Engines that are `reference` with one mistake each are found out; sound ones, and coarse ones that say so, are not accused."""

import math
import re
from typing import ClassVar

import numpy as np
import pytest

from quickreturn.cases.conformance import GROUPS, conform
from quickreturn.cases.conformance.alone import CHANGES as ALONE
from quickreturn.cases.conformance.bench import Bench
from quickreturn.cases.conformance.checks import check_by
from quickreturn.cases.conformance.motion import check_first_row
from quickreturn.cases.conformance.quantities import PARTS as PARTS_AT_ONCE
from quickreturn.cases.conformance.quantities import everything, followed
from quickreturn.cases.conformance.scenes import BASE, CHANGES
from quickreturn.cases.variation import Variation
from quickreturn.engines.base import AnyEngine, Simulation
from quickreturn.engines.exudyn.engine import ExudynEngine
from quickreturn.engines.exudyn.settings import ExudynSettings
from quickreturn.engines.mujoco.engine import MujocoEngine
from quickreturn.engines.mujoco.settings import ChainSettings
from quickreturn.engines.own.reference import ReferenceEngine, ReferenceSettings
from quickreturn.engines.registry import engine
from quickreturn.engines.relative import rms
from quickreturn.engines.simple import SimpleEngine
from quickreturn.engines.start import Start
from quickreturn.reference_model.mechanism import Mechanism
from quickreturn.reference_model.scene_values import NAMED, changed
from tests.cases.conformance.joint_mutants import JOINT
from tests.cases.conformance.mutants import MUTANTS as FIRST
from tests.cases.conformance.mutants import Columns, Mutant
from tests.cases.conformance.second_mutants import SECOND
from tests.cases.conformance.third_mutants import THIRD, RaisesInCheck

MUTANTS = FIRST | SECOND | THIRD


class EightLinks(MujocoEngine):
    name = "eight-links"

    def settings_for(self, accuracy: float, mechanism: Mechanism) -> ChainSettings:
        return super().settings_for(accuracy, mechanism).replaced(links=8)


class SixElements(ExudynEngine):
    name = "six-elements"

    def settings_for(self, accuracy: float, mechanism: Mechanism) -> ExudynSettings:
        return super().settings_for(accuracy, mechanism).replaced(elements=6)


class Stiffer(ReferenceEngine):
    """Stiffness and damping of its follower are too large by factors."""

    def __init__(self, times: float, damping: float = 1.0) -> None:
        self.wrong = Variation("wrong", scaled={"follower.bending_stiffness": times, "follower.damping": damping})

    def prepare(self, mechanism: Mechanism, start: Start, settings: ReferenceSettings) -> Simulation:
        return super().prepare(self.wrong.of(mechanism), start, settings)


#: One of a quantity that is 2 % off, one of frequencies: what takes seconds.
_QUICK_OF_JOINT = ("clearance doubled", "preload ignored")
_QUICK = ("stiffness 2 %", "frequencies in rad/s")


def _is_found_out(name: str) -> None:
    kind, pattern, group = MUTANTS[name]
    found = conform(kind(), groups=(group,))
    assert found.conforms is False
    causes = [check.cause for check in found.failed]
    assert any(re.search(pattern, cause) for cause in causes), causes
    assert all(check.advice for check in found.failed)


@pytest.mark.parametrize("name", _QUICK)
def test_a_mistake_is_named(name: str) -> None:
    _is_found_out(name)


@pytest.mark.verify
@pytest.mark.parametrize("groups", [("motion",), ("motion", "resolution")], ids="+".join)
def test_a_mistake_of_a_column_is_told_once(groups: tuple[str, ...]) -> None:
    found = conform(MUTANTS["percent"][0](), groups=groups)
    assert {check.check for check in found.failed} == {"column strain_1", "column strain_2", "column strain_3"}


@pytest.mark.verify
@pytest.mark.parametrize("times", [1.02, 1.05, 1.3])
def test_a_quantity_that_is_off_is_found_with_its_factor(times: float) -> None:
    """With a stiffness 1.3 times as large the motion is so different that the damping, which is right, seems to act half as strongly."""
    found = conform(Stiffer(times), groups=("motion", "quantities", "resolution"))
    (check,) = found.failed
    assert re.search(rf"follower.bending_stiffness {times:g}\d* times as large", check.cause), check.cause
    (damping,) = (each for each in found.checks if each.check == "quantity follower.damping")
    assert damping.status == "passed"


@pytest.mark.parametrize(
    ("times", "damping", "status", "words"),
    [
        (1.3, 1.0, "passed", "followed beside the mistake"),
        (1.3, 0.0, "failed", "is ignored"),
        (1.3, 1.3, "not judged", "so is the motion"),
        pytest.param(1.3, 2.0, "not judged", "so is the motion", marks=pytest.mark.verify),
        (1.0, 2.0, "failed", "acts"),
        pytest.param(1.0, 0.5, "failed", "acts", marks=pytest.mark.verify),
        (1.0, 0.0, "failed", "is ignored"),
    ],
)
def test_a_damping_is_held_against_the_scene_that_the_engine_acts_as(times: float, damping: float, status: str, words: str) -> None:
    """In the wrong scene a right damping seems to act half as strongly, and a wrong one is not taken for right."""
    bench, (change,) = Bench(Stiffer(times, damping)), (each for each in CHANGES if each.name == "follower.damping")
    acts_as = Variation("stiffer", scaled={"follower.bending_stiffness": times}) if times != 1.0 else None
    check = check_by("damping", followed, bench, bench.scene, change, acts_as is not None, set(), acts_as)
    assert check.status == status, check
    assert re.search(words, check.cause), check.cause


@pytest.mark.verify
@pytest.mark.parametrize("name", sorted(set(MUTANTS) - set(_QUICK)))
def test_every_mistake_is_named(name: str) -> None:
    _is_found_out(name)


def test_reference_is_not_accused() -> None:
    found = conform(ReferenceEngine(), groups=("motion", "resolution", "frequencies", "failures"))
    assert found.conforms, found.failed


@pytest.mark.verify
@pytest.mark.parametrize(
    "name", ["thesis", "reference", "exudyn", "mujoco", "fixed-shapes", "multiplier", "stiff-spring", "moving-boundaries", "derived"]
)
def test_own_engines_are_not_accused(name: str) -> None:
    found = conform(engine(name))
    assert found.conforms, found.failed


@pytest.mark.verify
@pytest.mark.parametrize("coarse", [EightLinks(), SixElements()], ids=lambda engine: engine.name)
def test_coarse_engines_that_say_so_are_not_accused(coarse: AnyEngine) -> None:
    found = conform(coarse, groups=tuple(group for group in GROUPS if group != "repetition"))
    assert found.conforms, found.failed


@pytest.mark.parametrize("name", [name if name in _QUICK_OF_JOINT else pytest.param(name, marks=pytest.mark.verify) for name in JOINT])
def test_a_mistake_with_the_joint_is_named(name: str) -> None:
    kind, pattern, tried = JOINT[name]
    (change,) = [each for each in CHANGES if each.name == tried]
    bench = Bench(kind())
    check = check_by(change.name, followed, bench, bench.scene, change, False, set())
    assert check.status == "failed"
    assert re.search(pattern, check.cause), check.cause


def test_every_quantity_that_an_engine_may_lack_is_changed() -> None:
    tried = {re.split(r",| along| with", change.name)[0] for change in (*CHANGES, *ALONE)}
    assert set(NAMED) - tried == set()


def test_everything_at_once_leaves_out_what_an_engine_does_not_have() -> None:
    parts = set(everything(Bench(engine("multiplier")))[1])
    assert {"mechanism.gravity", "slider.friction", "follower.material_damping"} <= parts
    assert not {"slider.joint_stiffness", "slider.joint_damping", "slider.joint_stiffness_minus", "slider.preload"} & parts
    assert len(everything(Bench(ReferenceEngine()))[1]) == len(PARTS_AT_ONCE)


def test_an_exception_in_check_costs_one_quantity() -> None:
    bench, told = Bench(RaisesInCheck()), set[str]()
    checks = {
        change.name: check_by(change.name, followed, bench, bench.scene, change, False, told)
        for change in CHANGES
        if change.name in ("slider.inertia", "tip.mass")
    }
    assert checks["slider.inertia"].status == "failed"
    assert "KeyError" in checks["slider.inertia"].cause
    assert checks["tip.mass"].status == "passed"


class WeightOfTheCrank(Mutant):
    """At a prescribed speed the crank's weight is in its torque with the wrong sign."""

    def spoil(self, columns: Columns, mechanism: Mechanism) -> None:
        if not mechanism.crank_is_free:
            angle, (g1, g2) = columns["crank_angle"], mechanism.gravity
            weight = mechanism.crank_moment * (g1 * np.sin(angle) - g2 * np.cos(angle))  # what holds the crank against it
            columns["crank_torque"] = columns["crank_torque"] - 2.0 * weight


class WeightOfTheSlider(Mutant):
    """At a prescribed speed the slider's weight is not in the crank's torque."""

    def spoil(self, columns: Columns, mechanism: Mechanism) -> None:
        if not mechanism.crank_is_free:
            angle, (g1, g2) = columns["crank_angle"], mechanism.gravity
            arm = mechanism.slider.mass * mechanism.crank.length
            columns["crank_torque"] = columns["crank_torque"] - arm * (g1 * np.sin(angle) - g2 * np.cos(angle))


class SlightlyTilted(Mutant):
    """Its base's angle is off by a part of what the engine, with a single shape, says of its error."""

    off: ClassVar[float]

    def settings_for(self, accuracy: float, mechanism: Mechanism) -> ReferenceSettings:
        return super().settings_for(accuracy, mechanism).replaced(modes=1)

    def spoil(self, columns: Columns, mechanism: Mechanism) -> None:
        columns["follower_angle"] = columns["follower_angle"] + self.off


@pytest.mark.parametrize(("off", "status"), [(1e-5, "passed"), (-1e-5, "passed"), (0.05, "failed")])
def test_the_first_row_may_be_off_by_what_the_engine_says(off: float, status: str) -> None:
    bench = Bench(type("Tilted", (SlightlyTilted,), {"off": off})())
    check = check_by("first row", check_first_row, bench, bench.mild, set())
    assert check.status == status, check


@pytest.mark.parametrize("kind", [WeightOfTheSlider, pytest.param(ReferenceEngine, marks=pytest.mark.verify)])
def test_the_weight_of_the_slider_at_a_prescribed_speed_is_looked_at(kind: type[AnyEngine]) -> None:
    bench = Bench(kind())
    (change,) = (each for each in CHANGES if each.name == "mechanism.gravity on the slider at a prescribed speed")
    check = check_by("weight", followed, bench, bench.scene, change, False, set())
    assert check.status == ("passed" if kind is ReferenceEngine else "failed"), check
    assert kind is ReferenceEngine or "mechanism.gravity on the slider at a prescribed speed is not followed" in check.cause


@pytest.mark.parametrize(
    ("kind", "status"), [(WeightOfTheCrank, "failed"), pytest.param(ReferenceEngine, "passed", marks=pytest.mark.verify)]
)
def test_the_weight_of_an_offset_crank_at_a_prescribed_speed_is_looked_at(kind: type[AnyEngine], status: str) -> None:
    bench = Bench(kind())
    (change,) = (each for each in CHANGES if each.name == "mechanism.gravity at a prescribed speed")
    found = check_by("weight", followed, bench, bench.scene, change, False, set())
    assert found.status == status, found
    assert kind is ReferenceEngine or "crank" in found.cause


def test_a_simple_engine_without_attributes_says_what_is_missing() -> None:
    bare = type("Bare", (SimpleEngine,), {"name": "bare", "order": 2.0})
    with pytest.raises(TypeError, match=r"^class Bare lacks method, model, library, errors; docs/engine.md says what each of them is$"):
        bare()


def test_every_change_is_one_that_the_scene_takes() -> None:
    for change in CHANGES:
        before = changed(BASE, change.context)
        assert change.of(before) != before, change.name
        for values in change.alike.values():
            changed(before, values)


def test_a_quantity_deep_in_a_scene_is_changed_and_nothing_else() -> None:
    other = changed(BASE, {"crank.torque": 1.0, "mechanism.gravity": (0.0, 1.0)})
    assert other.crank.drive.torque == 1.0  # type: ignore[union-attr]
    assert changed(other, {"crank.torque": 0.6, "mechanism.gravity": (0.0, 0.0)}) == BASE


def test_root_mean_square() -> None:
    assert rms(np.array([3.0, -3.0])) == 3.0
    assert math.isclose(rms(np.array([0.0, 1.0])), math.sqrt(0.5))
