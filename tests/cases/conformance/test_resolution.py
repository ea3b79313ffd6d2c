"""`conform` judges errors that an engine states, its frequencies by them, and its settings."""

import dataclasses
from collections.abc import Mapping
from typing import Any

import numpy as np
import pytest

from quickreturn.cases.conformance import conform
from quickreturn.cases.conformance.bench import Bench
from quickreturn.cases.conformance.checks import Fault, check_by
from quickreturn.cases.conformance.resolution import does_something, stated_errors
from quickreturn.engines.base import AnyEngine, Comparison, Simulation
from quickreturn.engines.own.reference import ReferenceEngine, ReferenceSettings
from quickreturn.engines.settings import setting
from quickreturn.engines.start import Start
from quickreturn.reference_model.mechanism import Mechanism, Scene
from quickreturn.reference_model.scene_values import NAMED
from tests.cases.conformance.third_mutants import Coarse
from tests.engines.test_simple import ToyEngine


class Boastful(ReferenceEngine):
    """Its errors are ten times what it says."""

    def comparisons(self, settings: ReferenceSettings, mechanism: Scene, output_step: float) -> tuple[Comparison, ...]:
        (pair,) = super().comparisons(settings, mechanism, output_step)
        return (dataclasses.replace(pair, factor=1.0 + 10.0 * (1.0 - pair.factor), before=None),)


def test_estimates_that_are_too_small_are_no_mistake_of_columns() -> None:
    found = conform(Boastful(), groups=("motion", "resolution"))
    assert {check.check.split(",")[0] for check in found.failed} == {"estimates hold"}


def test_an_engine_that_is_coarse_by_default_is_not_accused_of_its_order_of_accuracies() -> None:
    found = {check.check: check for check in conform(Coarse(), groups=("resolution",), quiet=True).checks}
    assert found["ladder: a smaller accuracy is finer"].status == "passed"


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


def test_guessed_errors_are_measured() -> None:
    """A guess 3.5 times too small; the toy's motion is made up, so that any true statement about it is a large one."""
    guessed, honest = (type("Stated", (ToyEngine,), {"quantities": tuple(NAMED), "errors": {4: error, 8: 0.01}})() for error in (0.3, 2.0))
    with pytest.raises(Fault, match=r"`errors` states 0.3 for resolution 4, measured in thesis-24 it is 1.*times as much"):
        stated_errors(guessed, None)
    assert "measured" in stated_errors(honest, None)
