"""Engines that are `reference` with one mistake each are found out; sound ones, and coarse ones that say so, are not accused."""

import dataclasses
import math
import re
import time
from collections.abc import Callable, Mapping
from typing import Any

import numpy as np
import pytest

from quickreturn.cases.conformance import GROUPS, conform, trial
from quickreturn.cases.conformance.alone import CHANGES as ALONE
from quickreturn.cases.conformance.bench import Bench
from quickreturn.cases.conformance.checks import Fault, check_by
from quickreturn.cases.conformance.quantities import PARTS as PARTS_AT_ONCE
from quickreturn.cases.conformance.quantities import everything, followed
from quickreturn.cases.conformance.repetition import ALONE as SCENES_ALONE
from quickreturn.cases.conformance.repetition import IN_TURN, PARTS, OtherProcesses, columns_of, elsewhere, repetition
from quickreturn.cases.conformance.resolution import does_something, stated_errors
from quickreturn.cases.conformance.scenes import BASE, CHANGES
from quickreturn.cases.variation import Variation
from quickreturn.engines.base import AnyEngine, Comparison, Simulation
from quickreturn.engines.exudyn.engine import ExudynEngine
from quickreturn.engines.exudyn.settings import ExudynSettings
from quickreturn.engines.mujoco.engine import MujocoEngine
from quickreturn.engines.mujoco.settings import ChainSettings
from quickreturn.engines.own.reference import ReferenceEngine, ReferenceSettings
from quickreturn.engines.registry import engine
from quickreturn.engines.relative import rms
from quickreturn.engines.settings import setting
from quickreturn.engines.simple import SimpleEngine
from quickreturn.engines.start import Start
from quickreturn.reference_model.mechanism import Mechanism, Scene
from quickreturn.reference_model.scene_values import NAMED, changed
from tests.cases.conformance.joint_mutants import JOINT
from tests.cases.conformance.mutants import MUTANTS as FIRST
from tests.cases.conformance.mutants import Columns, Mutant
from tests.cases.conformance.second_mutants import SECOND
from tests.cases.conformance.third_mutants import (
    THIRD,
    BuiltForAFollower,
    Coarse,
    Keeps,
    KeepsCrank,
    KeepsFollower,
    KeepsTip,
    RaisesInCheck,
    Slow,
    Threaded,
)
from tests.engines.test_simple import ToyEngine

MUTANTS = FIRST | SECOND | THIRD


class EightLinks(MujocoEngine):
    name = "eight-links"

    def settings_for(self, accuracy: float, mechanism: Mechanism) -> ChainSettings:
        return super().settings_for(accuracy, mechanism).replaced(links=8)


class SixElements(ExudynEngine):
    name = "six-elements"

    def settings_for(self, accuracy: float, mechanism: Mechanism) -> ExudynSettings:
        return super().settings_for(accuracy, mechanism).replaced(elements=6)


class Boastful(ReferenceEngine):
    """Its errors are ten times what it says."""

    def comparisons(self, settings: ReferenceSettings, mechanism: Scene, output_step: float) -> tuple[Comparison, ...]:
        (pair,) = super().comparisons(settings, mechanism, output_step)
        return (dataclasses.replace(pair, factor=1.0 + 10.0 * (1.0 - pair.factor), before=None),)


class Stiffer(ReferenceEngine):
    """Stiffness and damping of its follower are too large by factors."""

    def __init__(self, times: float, damping: float = 1.0) -> None:
        self.wrong = Variation("wrong", scaled={"follower.bending_stiffness": times, "follower.damping": damping})

    def prepare(self, mechanism: Mechanism, start: Start, settings: ReferenceSettings) -> Simulation:
        return super().prepare(self.wrong.of(mechanism), start, settings)


#: Time of a quick trial in which the slow engine makes a few runs, and what may be compiled or loaded besides, s.
SHORT = 4.0
TO_COMPILE = 60.0
#: One of a quantity that is 2 % off, one of frequencies: what takes seconds.
_QUICK_OF_JOINT = ("clearance doubled", "preload ignored", "friction without sign")
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


def test_estimates_that_are_too_small_are_no_mistake_of_columns() -> None:
    found = conform(Boastful(), groups=("motion", "resolution"))
    assert {check.check.split(",")[0] for check in found.failed} == {"estimates hold"}


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
        (1.3, 2.0, "not judged", "so is the motion"),
        (1.0, 2.0, "failed", "acts"),
        (1.0, 0.5, "failed", "acts"),
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


@pytest.mark.parametrize(("part", "status"), [(0.01, "passed"), (0.1, "failed")])
def test_last_digits_may_differ(part: float, status: str) -> None:
    """By a part of the engine's own error; here in the force, by some millionths of it."""
    bench = Bench(ReferenceEngine())
    errors, found = bench.estimates(dataclasses.replace(bench.mild, duration=0.1)), columns_of(bench.engine, IN_TURN)
    assert errors is not None
    first = found["the mild scene"]
    other = first | {"slider_force": first["slider_force"] + part * errors["slider_force"]}
    alone = {"the mild scene": first, "in another process": other} | {name: found[name] for name in PARTS}
    checks = {check.check: check.status for check in repetition(bench, OtherProcesses(found, alone))}
    assert checks.pop("the same from another process") == status
    assert set(checks.values()) == {"passed"}


@pytest.mark.verify
def test_threads_may_add_in_another_order(monkeypatch: pytest.MonkeyPatch) -> None:
    """Compared are processes that have one thread each, not the caller, who may have many."""
    monkeypatch.delenv("OPENBLAS_NUM_THREADS")
    other = elsewhere(Threaded())
    assert not other.reason
    assert all(check.status == "passed" for check in repetition(Bench(Threaded()), other))


def in_this_process(kind: type[Keeps]) -> OtherProcesses:
    """What `elsewhere` finds in other processes, each of which begins with nothing kept."""

    def begun_anew(name: str) -> dict[str, Any]:
        kind.kept.clear()
        return columns_of(kind(), (name,))[name]

    kind.kept.clear()
    in_turn = columns_of(kind(), IN_TURN)
    return OtherProcesses(in_turn, {name: begun_anew(name) for name in SCENES_ALONE})


@pytest.mark.parametrize("results", [in_this_process, pytest.param(lambda kind: elsewhere(kind()), marks=pytest.mark.verify)])
@pytest.mark.parametrize(("kind", "part"), [(KeepsCrank, "crank"), (KeepsTip, "tip"), (KeepsFollower, "follower")])
def test_a_part_kept_of_an_earlier_scene_is_named(kind: type[Keeps], part: str, results: Callable[[type[Keeps]], OtherProcesses]) -> None:
    failed = [check for check in repetition(Bench(kind()), results(kind)) if check.status == "failed"]
    assert [check.check for check in failed] == [f"nothing kept of an earlier {part}"]
    assert f"the {part} of an earlier scene is kept" in failed[0].cause


@pytest.mark.verify
def test_a_model_that_is_kept_until_the_follower_is_another_one_is_found() -> None:
    failed = [check for check in repetition(Bench(BuiltForAFollower()), elsewhere(BuiltForAFollower())) if check.status == "failed"]
    assert {check.check.rsplit(" ", 1)[1] for check in failed} == {"crank", "tip"}


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


def test_an_exception_in_the_first_check_is_told() -> None:
    (check,) = trial("motion", ("motion",), type("Raising", (ReferenceEngine,), {"check": lambda self, mechanism: 1 / 0})())["motion"]
    assert check.status == "failed"
    assert "ZeroDivisionError" in check.cause


@pytest.mark.verify
def test_a_quick_trial_says_what_it_left_out() -> None:
    began = time.monotonic()
    found = conform(Slow(), groups=("motion", "quantities"), seconds=SHORT, quiet=True)
    assert time.monotonic() - began < 3.0 * SHORT + TO_COMPILE
    assert {check.status for check in found.checks} <= {"passed", "not judged"}
    assert found.left_out
    assert f"{len(found.left_out)} checks are left out" in found.verdict
    assert all(check.cause and check.advice for check in found.checks if check.left_out)


def test_a_quick_trial_compares_the_motion_first() -> None:
    found = conform(ReferenceEngine(), groups=("motion", "resolution"), seconds=300.0, quiet=True)
    assert found.conforms
    assert found.left_out == ("resolution",)
    names = [check.check for check in found.checks]
    assert names[0].startswith("column ")
    assert names.index("column tip_deflection") < names.index("pieces continue") < names.index("the same with another output step")


def test_a_quick_trial_without_time_for_the_motion_is_not_judged() -> None:
    assert conform(Slow(), groups=("motion", "resolution"), seconds=1e-3, quiet=True).conforms is None


def test_an_engine_that_is_coarse_by_default_is_not_accused_of_its_order_of_accuracies() -> None:
    found = {check.check: check for check in conform(Coarse(), groups=("resolution",), quiet=True).checks}
    assert found["ladder: a smaller accuracy is finer"].status == "passed"


class WeightOfTheCrank(Mutant):
    """At a prescribed speed the crank's weight is in its torque with the wrong sign."""

    def spoil(self, columns: Columns, mechanism: Mechanism) -> None:
        if not mechanism.crank_is_free:
            angle, (g1, g2) = columns["crank_angle"], mechanism.gravity
            weight = mechanism.crank_moment * (g1 * np.sin(angle) - g2 * np.cos(angle))  # what holds the crank against it
            columns["crank_torque"] = columns["crank_torque"] - 2.0 * weight


@pytest.mark.parametrize(
    ("kind", "status"), [(WeightOfTheCrank, "failed"), pytest.param(ReferenceEngine, "passed", marks=pytest.mark.verify)]
)
def test_the_weight_of_an_offset_crank_at_a_prescribed_speed_is_looked_at(kind: type[AnyEngine], status: str) -> None:
    bench = Bench(kind())
    (change,) = (each for each in CHANGES if each.name == "mechanism.gravity at a prescribed speed")
    found = check_by("weight", followed, bench, bench.scene, change, False, set())
    assert found.status == status, found
    assert kind is ReferenceEngine or "crank" in found.cause


class TwoModes(ReferenceEngine):
    """Right in the first frequency, and as far off in the second as its accuracy of 30 % lets expect; no finer rung shows it."""

    name, default_accuracy, off = "two-modes", 0.3, 1.25

    def finer(self, settings: ReferenceSettings, excess: Mapping[str, float], output_step: float) -> None:
        return None

    def natural_frequencies(self, mechanism: Mechanism, crank_angle: float, count: int, settings: ReferenceSettings) -> Any:
        return super().natural_frequencies(mechanism, crank_angle, min(count, 2), settings) * np.array([1.0, self.off])[: min(count, 2)]


class TwoModesThatBoast(TwoModes):
    """The same, with an accuracy of 5 %."""

    default_accuracy = 0.05


class InOtherUnits(TwoModes):
    """A mistake that is within the error stated is one all the same."""

    def natural_frequencies(self, mechanism: Mechanism, crank_angle: float, count: int, settings: ReferenceSettings) -> Any:
        return 2.0 * np.pi * ReferenceEngine.natural_frequencies(self, mechanism, crank_angle, count, settings)


@pytest.mark.parametrize(("kind", "status"), [(TwoModes, "passed"), (TwoModesThatBoast, "failed"), (InOtherUnits, "failed")])
def test_frequencies_are_judged_by_the_error_stated(kind: type[AnyEngine], status: str) -> None:
    checks = {check.check: check for check in conform(kind(), groups=("frequencies",), quiet=True).checks}
    assert checks["frequencies: values"].status == status


@dataclasses.dataclass(frozen=True, kw_only=True)
class FewModes(ReferenceSettings):
    """One mode by default, so that `added_inertia`, which slows higher ones, can do nothing."""

    modes: int = setting(1, "number of modes", low=1, high=5)


class OneModeByDefault(ReferenceEngine):
    """All rungs have one mode."""

    name, settings_type = "one-mode", FewModes

    def settings_for(self, accuracy: float, scene: Scene) -> ReferenceSettings:
        return FewModes(tolerance=max(1e-4 * accuracy, 1e-9))

    def ladder(self, mechanism: Mechanism) -> tuple[ReferenceSettings, ...]:
        return (self.settings_for(0.05, mechanism),)


class IgnoresAddedInertia(OneModeByDefault):
    """The setting is read nowhere."""

    def prepare(self, scene: Any, start: Start | None, settings: Any) -> Simulation:
        return super().prepare(scene, start, settings.replaced(added_inertia=True))


@pytest.mark.parametrize(
    ("kind", "status"), [(OneModeByDefault, "passed"), pytest.param(IgnoresAddedInertia, "failed", marks=pytest.mark.verify)]
)
def test_a_setting_that_acts_only_beside_another_value_is_not_accused(kind: type[AnyEngine], status: str) -> None:
    (field,) = (each for each in dataclasses.fields(FewModes) if each.name == "added_inertia")
    assert check_by("setting", does_something, Bench(kind()), field).status == status


def test_a_simple_engine_without_attributes_says_what_is_missing() -> None:
    bare = type("Bare", (SimpleEngine,), {"name": "bare", "order": 2.0})
    with pytest.raises(TypeError, match=r"^class Bare lacks method, model, library, errors; docs/engine.md says what each of them is$"):
        bare()


def test_guessed_errors_are_measured() -> None:
    """A guess 3.5 times too small; the toy's motion is made up, so that any true statement about it is a large one."""
    guessed, honest = (type("Stated", (ToyEngine,), {"quantities": tuple(NAMED), "errors": {4: error, 8: 0.01}})() for error in (0.3, 2.0))
    with pytest.raises(Fault, match=r"`errors` states 0.3 for resolution 4, measured in thesis-24 it is 1.*times as much"):
        stated_errors(guessed, None)
    assert "measured" in stated_errors(honest, None)


def test_a_class_that_no_other_process_can_import_is_not_accused() -> None:
    found = conform(type("Local", (ReferenceEngine,), {})(), groups=("repetition",))
    assert found.conforms
    (check,) = [check for check in found.checks if check.check == "the same from another process"]
    assert check.status == "not judged"
    assert "entry point" in check.advice


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
    import numpy as np

    assert rms(np.array([3.0, -3.0])) == 3.0
    assert math.isclose(rms(np.array([0.0, 1.0])), math.sqrt(0.5))
