"""The distance to resonance in closed form, and what is said of a crank that hardly turns before anything is computed."""

import dataclasses
import math

import pytest

from quickreturn.cases.library import load_case
from quickreturn.cases.motion.resonance import resonance, slow_turns
from quickreturn.reference_model.mechanism import Base, PrescribedSpeed
from tests.engines.scenes import run_24


def test_a_turn_with_thousands_of_vibrations_is_told_with_its_time_and_what_to_do() -> None:
    told = slow_turns(load_case("thesis-24", {"crank.prescribed_speed": "0.1 rpm"}))
    assert "600 s for a turn" in told
    assert "about 10,000 times" in told
    assert "about 12 min" in told
    assert "higher speed" in told


@pytest.mark.parametrize("name", ["thesis-24", "rigid", "spin-up"])
def test_usual_machines_are_not_spoken_of(name: str) -> None:
    assert slow_turns(load_case(name)) == ""


def test_a_uniform_beam_is_that_of_the_textbook() -> None:
    """A crank that hardly reaches leaves the support at 0.7 L: pinned, supported, free, without bodies; beta L = 3.88535145."""
    bare = run_24(base=Base(), tip=None)
    beam, drive = bare.follower, PrescribedSpeed(speed=-20.0)
    scene = dataclasses.replace(
        bare, pivot_distance=0.7 * beam.length, crank=dataclasses.replace(bare.crank, length=1e-4 * beam.length, drive=drive)
    )
    right = 3.88535145**2 / (2.0 * math.pi * beam.length**2) * math.sqrt(beam.bending_stiffness / beam.mass_per_length)
    found = resonance(scene)
    assert found is not None
    # the first power of the crank's length averages out over the turn, its square is 1e-8
    assert found.first_mode == pytest.approx(right, rel=1e-6)
    assert found.crank == pytest.approx(20.0 / (2.0 * math.pi))
    assert found.ratio == pytest.approx(right * 2.0 * math.pi / 20.0, rel=1e-6)
    assert found.harmonic == round(found.ratio)
    assert found.resonant_speed * found.harmonic == pytest.approx(2.0 * math.pi * right, rel=1e-6)
    assert found.resonant_speed == pytest.approx(20.0 * (1.0 + found.detuning))
    assert resonance(run_24(follower={"bending_stiffness": math.inf})) is None
