"""What the page of one's own case says of the machine: numbers of its table, in words that fit them."""

import dataclasses
import re

import pytest

from quickreturn.cases.loads import loads_of_run, resonance
from quickreturn.cases.loads.stress import section_modulus
from quickreturn.cases.runs.comparison import CaseResult, compare
from quickreturn.reports.findings.loads import leading_loads, loads_of_case
from quickreturn.reports.page.chapters import chapters_of
from quickreturn.reports.page.content import Content
from quickreturn.reports.page.view import cycles
from quickreturn.reports.tables.strength import of_case
from quickreturn.reports.words import quantity
from tests.reports.pages import one_run, read, text_of
from tests.reports.plotted_results import made_up_result, with_run
from tests.reports.reported_results import reported_result


def with_strength(result: CaseResult, **strengths: float | None) -> CaseResult:
    """The same results of an arm of another material."""
    mechanism = result.case.mechanism
    scene = dataclasses.replace(mechanism, follower=dataclasses.replace(mechanism.follower, **strengths))
    return dataclasses.replace(result, case=dataclasses.replace(result.case, scene=scene))


@pytest.fixture(scope="module")
def example() -> CaseResult:
    return reported_result("example")


def test_the_first_screen_answers_with_the_numbers_of_the_table(example: CaseResult) -> None:
    page, told = read(one_run(example)), text_of(one_run(example))
    loads = loads_of_run(example.case.mechanism, example.runs["reference"])
    assert loads is not None
    assert loads.stress is not None
    rows = {(row[1][0], row[2][1]): row for row in page.tables["strength.csv"]}
    for name, unit in (("stress", "MPa"), ("crank_torque", "N m"), ("pivot_force", "N"), ("slider_force", "N"), ("tip_deflection", "mm")):
        value = float(rows["reference", name][3][1])
        assert quantity(value, unit).replace("\N{NO-BREAK SPACE}", " ") in told
        assert rows["reference", name][4][0] != "–"  # each with its error
    assert float(rows["reference", "stress"][3][1]) == loads.stress.largest.value
    place = float(rows["reference", "stress"][6 - 1][1])
    assert f"{1e3 * place:.0f} mm from P" in told
    first = resonance(example.case.mechanism)
    assert first is not None
    assert first.sentence in told
    assert f"{first.ratio:.2f}first mode" in told  # a large number and the words under it
    assert loads_of_case(example).verdict in told
    assert told.index("largest stress") < told.index("Engines show or hide")


@pytest.mark.parametrize(
    ("part", "sentence"),
    [
        (0.5, "The arm does not hold: the safety factor is 0.5 "),
        (1.0, "too close to tell"),
        (3.0, "The arm holds: the safety factor is 3 "),
    ],
)
@pytest.mark.parametrize("key", ["yield_strength", "fatigue_strength"])
def test_a_factor_below_one_is_told_in_a_sentence(example: CaseResult, key: str, part: float, sentence: str) -> None:
    loads = loads_of_run(example.case.mechanism, example.runs["reference"])
    assert loads is not None
    assert loads.stress is not None
    borne = loads.stress.largest if key == "yield_strength" else loads.stress.amplitude
    strengths = dict.fromkeys(("yield_strength", "fatigue_strength")) | {key: part * borne.value}
    assert sentence in loads_of_case(with_strength(example, **strengths)).verdict


def test_one_factor_below_one_is_enough(example: CaseResult) -> None:
    loads = loads_of_run(example.case.mechanism, example.runs["reference"])
    assert loads is not None
    assert loads.stress is not None
    material = {"yield_strength": 0.5 * loads.stress.largest.value, "fatigue_strength": loads.stress.amplitude.value}
    told = loads_of_case(with_strength(example, **material)).verdict
    assert told == "The arm does not hold: the safety factor is 0.5 against yielding and 1 against fatigue."


@pytest.mark.parametrize(("part", "words"), [(0.3, "30 % of it: the safety factor is 0.5 (0.38"), (2.0, " or more)")])
def test_an_error_of_tens_of_percent_lets_nobody_judge(example: CaseResult, part: float, words: str) -> None:
    run = example.runs["reference"]
    stress = loads_of_case(example).loads["reference"].stress
    assert stress is not None
    moment = stress.largest.value * section_modulus(example.case.mechanism.follower)
    unsure = {name: dict.fromkeys(("pre", "post"), part * moment) for name in run.cycle}
    result = with_run(
        with_strength(example, yield_strength=0.5 * stress.largest.value, fatigue_strength=None), "reference", extreme_estimates=unsure
    )
    told = loads_of_case(result).verdict.replace("\N{NO-BREAK SPACE}", " ")
    assert told.startswith("Whether the arm holds cannot be judged")
    assert words in told
    page = text_of(one_run(result))
    assert "The arm does not hold" not in page
    assert "cannot be judged" in page
    assert words.rpartition("(")[2] in page


def test_without_strengths_the_page_says_which_keys_to_give(example: CaseResult) -> None:
    told = text_of(one_run(with_strength(example, yield_strength=None, fatigue_strength=None)))
    assert "The arm holds" not in told
    assert "give yield_strength and fatigue_strength in [follower]" in told


def test_the_thesis_keeps_its_first_screen_and_engines_without_moments_the_old_one(example: CaseResult) -> None:
    of_thesis = one_run()
    assert of_thesis.loads == []
    assert "strength" not in [chapter.id for chapter in chapters_of(of_thesis)]
    assert not any(run["stress"] for run in cycles(of_thesis.results, ["reference"], of_thesis.loads).runs)
    without = example
    for name, run in example.runs.items():
        without = with_run(without, name, cycle={key: values for key, values in run.cycle.items() if not key.startswith("moment")})
    assert "strength" not in [chapter.id for chapter in chapters_of(one_run(without))]
    assert "settled at the accuracy asked" in text_of(one_run(without))


def test_the_engine_that_leads_is_the_reference_and_others_are_told_beside(example: CaseResult) -> None:
    run = example.runs["mujoco"]
    cycle = {name: (1.1 if name.startswith("moment") else 1.0) * values for name, values in run.cycle.items()}
    both = compare(example.case, {"mujoco": dataclasses.replace(run, cycle=cycle), "reference": example.runs["reference"]})
    found = loads_of_case(both)
    assert found.lead == leading_loads(both).lead == "reference"
    assert found.departures()["mujoco"] == pytest.approx(0.1, abs=0.01)
    assert re.search(r"mujoco finds 10(\.0)? % more", text_of(one_run(both)))
    assert loads_of_case(dataclasses.replace(both, runs={"mujoco": both.runs["mujoco"]})).lead == "mujoco"


def test_what_is_drawn_along_the_arm_is_what_the_cycle_reaches() -> None:
    result = made_up_result("example")
    content = Content(results=[result])
    (run,) = cycles(content.results, ["reference"], content.loads).runs
    stress = loads_of_case(result).loads["reference"].stress
    assert stress is not None
    assert max(map(abs, run["stress"]["low"] + run["stress"]["high"])) == pytest.approx(1e-6 * stress.largest.value, rel=0.03)
    assert run["stress"]["at"] == pytest.approx((stress.largest.place or 0.0) / result.case.mechanism.follower.length)
    assert run["stress"]["low"][-1] == pytest.approx(0.0, abs=0.03 * run["stress"]["largest"])  # the light tip bears little


def test_rows_have_units_and_names(example: CaseResult) -> None:
    found = {number.quantity: number for engine, number in of_case(loads_of_case(example)) if engine in ("reference", "")}
    assert found["stress"].unit == "Pa"
    assert found["frequency_ratio"].value == pytest.approx(found["mean_first_frequency"].value / 2.0)  # 120 rpm
    assert found["yield_factor"].value == pytest.approx(240e6 / found["stress"].value)
