"""What the machine bears, as `run`, `simulate` and their Python results say it."""

import json
import math

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
from tests.reports.plotted_results import made_up_result


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
