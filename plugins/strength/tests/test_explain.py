"""`explain` on the command line and in Python: the same sentences, from the run that `run` stores."""

import json
import math
import re
from pathlib import Path

import pytest

import quickreturn as qr
from tests.quickreturn.conftest import Call
from tests.quickreturn.test_units_of_answers import machine

#: Of the machine of the tests of units, in which the first mode is damped too much to ring.
TOPICS = ["whip", "strokes", "sides", "stress", "ringing", "drive", "bearings", "decay", "limit", "trust"]


def test_ten_sentences_in_words_as_a_document_and_in_python(call: Call) -> None:
    Path("lever.toml").write_text(machine(inches=False))
    document = json.loads(call("explain", "lever.toml", "--accuracy", "0.05", "--json").output)
    assert [each["topic"] for each in document] == TOPICS
    text = call("explain", "lever.toml", "--accuracy", "0.05")
    assert (text.code, text.errors) == (0, "")
    assert text.output.splitlines() == ["lever: lever", *(f"- {each['sentence']}" for each in document)]
    numbers = {each["topic"]: each["numbers"] for each in document}
    found = qr.explain("lever.toml", accuracy=0.05, quiet=True)
    assert {each.topic: dict(each.numbers) for each in found.statements} == numbers
    run = json.loads(call("run", "lever.toml", "--engine", "reference", "--accuracy", "0.05", "--json").output)
    known = run["cases"][0]["engines"][0]["numbers"]
    for topic, name, measure in (
        ("whip", "tip_acceleration", "peak.tip_acceleration"),
        ("stress", "stress", "peak.stress"),
        ("drive", "energy_back", "turn.returned_energy"),
        ("bearings", "O_force", "peak.crank_force"),
        ("decay", "multiplier", "multiplier"),
    ):
        assert (numbers[topic][name], numbers[topic][f"{name}_error"]) == (known[measure]["value"], known[measure]["error"])
    inches = json.loads(call("explain", "lever.toml", "--accuracy", "0.05", "--units", "inch", "--json").output)
    assert [each["numbers"] for each in inches] == [each["numbers"] for each in document]
    assert "in/s²" in inches[0]["sentence"]


@pytest.mark.verify
def test_the_speed_of_a_machine_that_works_against_a_brake_is_that_of_its_settled_turn(call: Call) -> None:
    """Torque over damping is 16.62 rad/s, the mean 12.45: the brake at P takes a quarter. Its run, `run` and `explain` tell one speed."""
    braked = ("thesis-24", "--set", "base.damping=1 N*m*s/rad", "--accuracy", "0.05", "--json")
    said = {each["topic"]: each["numbers"] for each in json.loads(call("explain", *braked).output)}
    ran = json.loads(call("run", *braked, "--engine", "reference").output)["cases"][0]
    mean = ran["engines"][0]["numbers"]["mean.crank_speed"]["value"]
    assert mean == pytest.approx(12.45, abs=0.01)
    ratio = said["ringing"]["first_mode"] * 2.0 * math.pi / mean
    assert (said["ringing"]["harmonic"], said["limit"]["order"]) == (8, 8)
    assert ran["resonance"]["ratio"] == pytest.approx(ratio, rel=1e-6)
    assert said["ringing"]["detuning"] == pytest.approx(ratio / 8.0 - 1.0, rel=1e-6)
    assert said["limit"]["resonant_speed"] == pytest.approx(mean * ratio / 8.0, rel=1e-6)


def test_an_engine_without_a_settled_turn_says_why(call: Call) -> None:
    answer = call("explain", "thesis-24", "--engine", "fake", "--set", "fake.behaviour=fails")
    assert answer.code == 3
    assert answer.output.splitlines() == ["thesis-24: Run 24: crank 4 in, six plates, 16.6 rad/s"]
    assert answer.errors.startswith("quickreturn: thesis-24: engine fake ")


@pytest.mark.verify
def test_where_it_says_so_the_stress_grows_as_the_square_of_the_speed(call: Call) -> None:
    Path("lever.toml").write_text(machine(inches=False))
    stress = []
    for speed in (60.0, 66.0):
        found = qr.explain(qr.case("lever.toml", {"crank.prescribed_speed": f"{speed} rpm"}), accuracy=0.01, quiet=True)
        said = {each.topic: each for each in found.statements}
        assert re.search("grows about as the square of the speed", said["limit"].sentence)
        stress.append(said["stress"].numbers["stress"])
    assert stress[1] / stress[0] == pytest.approx(1.1**2, rel=0.1)  # STILL
