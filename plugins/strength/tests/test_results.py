"""What the machine bears and does in a turn, as `run`, `simulate`, `explain` and their Python results say it."""

import json
import math
import re
from pathlib import Path

import numpy as np
import pytest

import quickreturn as qr
from quickreturn.cases.files.shown import in_lines
from quickreturn.cases.library import library_case
from quickreturn.cases.motion.solving import TrajectoryRequest
from quickreturn.cross_validation import CrossValidation
from quickreturn.engines.accurate import simulate
from quickreturn.engines.own.reference import ReferenceEngine
from quickreturn.engines.start import standard_start
from quickreturn.plugins.strength.loads import loads_job, loads_of_run
from quickreturn.reports.output import plain
from quickreturn.verdict_text import as_document, parts_of
from tests.quickreturn.conftest import Call
from tests.quickreturn.test_units_of_answers import machine
from tests.reports.plotted_results import made_up_result


@pytest.mark.verify
def test_run_says_it_in_words_in_json_and_as_a_table() -> None:
    result = made_up_result("example")
    run = result.runs["mujoco"]
    loads = loads_of_run(result.case.mechanism, run)
    assert loads is not None
    assert loads.stress is not None
    (case,) = json.loads(json.dumps(plain(as_document([result], ()))))["cases"]
    (document,) = (engine for engine in case["engines"] if engine["engine"] == "mujoco")
    stress = document["loads"]["stress"]
    assert (stress["value"], stress["unit"], stress["place"]) == (loads.stress.largest.value, "Pa", loads.stress.largest.place)
    assert document["loads"]["slider_force"]["value"] == pytest.approx(run.peak("slider_force"), rel=1e-3)
    assert case["resonance"]["harmonic"] == round(case["resonance"]["ratio"]) == 9
    frame = CrossValidation([result]).loads.set_index(["engine", "quantity"])
    assert frame.loc[("mujoco", "stress"), "value"] == loads.stress.largest.value
    words = in_lines(parts_of(result))
    assert f"largest stress {loads_of_reference(result):.2f} MPa" in words
    assert "the 9th harmonic is nearest" in words


def loads_of_reference(result: object) -> float:
    """Its largest stress, MPa."""
    found = loads_of_run(result.case.mechanism, result.runs["reference"])  # type: ignore[attr-defined]
    assert found is not None
    assert found.stress is not None
    return 1e-6 * found.stress.largest.value


def test_a_simulation_says_its_largest_stress() -> None:
    solution = qr.simulate(qr.case("example", duration=0.1), "reference", settings={"modes": 2}, store=False)
    stress = solution.loads.stress
    assert stress is not None
    follower = solution.case.scene.follower
    gauges = max(float(np.max(np.abs(solution[f"strain_{k}"]))) for k in (1, 2, 3))
    assert stress.largest.value >= follower.elastic_modulus * gauges
    assert math.isfinite(stress.largest.error)
    assert f"with the transient of its start, largest stress {1e-6 * stress.largest.value:.3f} MPa" in repr(solution)
    assert "`run` gives the settled machine" in repr(solution)
    assert "against yielding" in repr(solution)
    assert " and " not in repr(solution).partition("The arm holds")[2].partition("\n")[0], "no factor against fatigue"
    assert solution.loads.fatigue_factor is None, "a transient is no cycle"
    crank = stress.largest.crank_angle
    assert crank is not None
    # from 180 deg on for 0.1 s at some 120 rpm
    assert 180.0 <= math.degrees(crank) <= 260.0
    assert f"crank at {round(math.degrees(crank))}°" in repr(solution)


def test_loads_are_not_taken_from_those_of_another_strength() -> None:
    """The motion is the same, and comes from the store; the factor is another."""
    settings = {"modes": 2}
    factors = []
    for strength in ("100 MPa", "200 MPa"):
        case = qr.case("example", {"follower.yield_strength": strength}, duration=0.1)
        factor = qr.simulate(case, "reference", settings=settings, estimate=False).loads.yield_factor
        assert factor is not None
        factors.append(factor.value)
    assert factors[1] == pytest.approx(2.0 * factors[0])


def test_loads_of_a_trajectory_claim_the_largest_error_of_a_column() -> None:
    case = library_case("thesis-17")
    result = simulate(ReferenceEngine(), case.mechanism, standard_start(case.mechanism), 0.1, 1e-3)
    request = TrajectoryRequest(scene=case.scene, duration=0.1, output_step=1e-3, engine="reference")
    job = loads_job(request, result)
    deflection = job.function(*job.arguments).peaks["tip_deflection"]
    assert deflection is not None
    assert deflection.estimate == result.largest_errors["tip_deflection"]


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
