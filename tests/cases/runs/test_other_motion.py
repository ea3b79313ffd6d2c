"""A machine with two stable motions: `run` tells of the one that it did not settle on."""

import math
from dataclasses import replace

import pytest

from quickreturn.cases.library import library_case
from quickreturn.cases.runs.orbit import other_motion, periodic_state
from quickreturn.engines.own.reference import ReferenceEngine
from quickreturn.reference_model.mechanism import Mechanism, PrescribedSpeed


def machine(speed: float) -> Mechanism:
    """Run 24's, at a prescribed speed in rpm."""
    scene = library_case("thesis-24").mechanism
    return replace(scene, crank=replace(scene.crank, drive=PrescribedSpeed(speed=speed * math.pi / 30.0)))


@pytest.mark.parametrize(("speed", "told"), [(236.0, "coming from faster turning"), (150.0, "")])
def test_the_other_motion_is_told_where_there_is_one(speed: float, told: str) -> None:
    """Marching up and down confirms two stable motions between 233 and 239 rpm, and one at 150 rpm (tests/cases/sweep/test_study.py)."""
    scene = machine(speed)
    settings = ReferenceEngine().settings_for(1e-3, scene)
    found = periodic_state(scene, settings, None)
    assert found is not None
    sentence = other_motion(scene, found, settings)
    assert told in sentence
    assert bool(sentence) == bool(told)
