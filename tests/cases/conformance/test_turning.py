"""An engine that is right about an arm that swings and wrong about one that turns fully is named; others are not accused."""

import re
from typing import Any

import pytest

from quickreturn.cases.conformance.bench import Bench
from quickreturn.cases.conformance.checks import Check
from quickreturn.cases.conformance.turning import turning
from quickreturn.engines.base import AnyEngine, Refusal
from quickreturn.engines.exudyn.engine import ExudynEngine
from quickreturn.engines.mujoco.engine import MujocoEngine
from quickreturn.engines.own.reference import ReferenceEngine
from quickreturn.reference_model.mechanism import Scene
from tests.engines import wrong_engines

#: Engine -> what is said of it.
WRONG = {
    "WrapsTheAngle": "follower_angle jumps by a turn",
    "BeginsATurnLate": "follower_angle is a turn too small",
    "FoldsTheAngle": "the slider is taken on the wrong side of the pivot",
    "SlidesBehind": "slider_position has the wrong sign",
    "TurnsTheDeflection": "tip_deflection is off by 9. %",
}


def tried(engine: AnyEngine) -> Check:
    (check,) = turning(Bench(engine, seconds=60.0))  # a limit leaves other output steps of the mild scene out
    return check


@pytest.mark.parametrize("name", [pytest.param(name, marks=[] if name == "FoldsTheAngle" else pytest.mark.verify) for name in WRONG])
def test_a_mistake_of_an_arm_that_turns_is_named(name: str) -> None:
    kind: Any = getattr(wrong_engines, name)
    check = tried(kind(ReferenceEngine()))
    assert check.status == "failed"
    assert re.search(WRONG[name], check.cause), check.cause
    assert check.advice


def test_the_reference_is_right() -> None:
    assert tried(ReferenceEngine()).status == "passed"


@pytest.mark.verify
@pytest.mark.parametrize("kind", [MujocoEngine, ExudynEngine])
def test_other_engines_are_right(kind: Any) -> None:
    assert tried(kind()).status == "passed"


def test_an_engine_that_refuses_such_arms_is_not_blamed() -> None:
    class Swinging(ReferenceEngine):
        def check(self, scene: Scene) -> None:
            super().check(scene)
            if scene.turns_fully:
                raise Refusal("crank.length: a crank longer than mechanism.pivot_distance is not modelled")

    check = tried(Swinging())
    assert (check.status, check.cause.startswith("refused: crank.length")) == ("passed", True)
