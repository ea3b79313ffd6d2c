"""What the page of one's own case says of the machine: numbers of its table, verdicts, and what happens in a turn."""

import dataclasses
import re

import pytest

from quickreturn.cases.comparison.engines import CaseResult, compare
from quickreturn.cases.files.shown import Unit
from quickreturn.cases.files.units import in_si
from quickreturn.cases.motion.resonance import resonance
from quickreturn.plugins.strength.case_loads import leading_loads, loads_of_case, loads_on, numbers_of_case, share_of
from quickreturn.plugins.strength.loads import loads_of_run
from quickreturn.plugins.strength.page import machines
from quickreturn.plugins.strength.stress import ArmStress, section_modulus
from quickreturn.plugins.strength.words import verdict
from quickreturn.reports.page.chapters import chapters_of
from quickreturn.reports.page.content import Content
from quickreturn.reports.page.view import cycles
from quickreturn.reports.words import quantity
from tests.reports.pages import finding_of, one_run, plain, read, text_of
from tests.reports.plotted_results import made_up_result, with_run, with_strength
from tests.reports.reported_results import reported_result


@pytest.fixture(scope="module")
def example() -> CaseResult:
    return reported_result("example")


@pytest.fixture(scope="module")
def stress(example: CaseResult) -> ArmStress:
    """The arm's stress in the example by reference."""
    loads = loads_of_run(example.case.mechanism, example.runs["reference"])
    assert loads is not None
    assert loads.stress is not None
    return loads.stress


def test_the_heading_gives_the_stress_and_the_least_safety_of_the_first_case(example: CaseResult, stress: ArmStress) -> None:
    told = finding_of(one_run(example), "strength")
    assert told.startswith(f"{1e-6 * stress.largest.value:.2f} MPa at {1e3 * (stress.largest.place or 0.0):.0f} mm from P, safety ")
    other = dataclasses.replace(example, case=dataclasses.replace(example.case, name="other"))
    assert finding_of(one_run(other, example), "strength") == f"other: {told}"


def test_each_notch_has_its_factor(example: CaseResult) -> None:
    notched = loads_of_case(with_strength(example, fatigue_strength=80e6, notch_places=(0.1, 0.3), notch_factors=(1.2, 2.0)))
    found = {load.quantity: load for engine, load in numbers_of_case(notched) if engine == "reference"}
    for number, place in ((1, 0.1), (2, 0.3)):
        amplitude = found[f"notch_{number}_equivalent_amplitude"]
        assert amplitude.place == place
        assert found[f"notch_{number}_fatigue_factor"].value == pytest.approx(80e6 / amplitude.value)
    assert found["fatigue_factor"].value <= min(found[f"notch_{number}_fatigue_factor"].value for number in (1, 2))


def test_the_first_screen_answers_with_the_numbers_of_the_table(example: CaseResult, stress: ArmStress) -> None:
    page, known = read(one_run(example)), loads_of_case(example)
    told = plain(page.text)
    rows = {(row[1][0], row[2][1]): row for row in page.tables["strength.csv"]}
    for name, unit in (("stress", "MPa"), ("crank_torque", "N*m"), ("pivot_force", "N"), ("slider_force", "N"), ("tip_deflection", "mm")):
        value = float(rows["reference", name][3][1])
        assert quantity(value, Unit(unit, in_si(unit))).replace("\N{NO-BREAK SPACE}", " ") in told
        assert rows["reference", name][4][0] != "–"  # each with its error
    assert float(rows["reference", "stress"][3][1]) == stress.largest.value
    assert f"{1e3 * float(rows['reference', 'stress'][5][1]):.0f} mm from P" in told
    first = resonance(example.case.mechanism, example.settled_speed)
    assert first is not None
    assert known.share == share_of(first.harmonic, example.runs["reference"].cycle)
    assert known.nearness in told
    assert f"{first.ratio:.2f}first mode" in told  # a large number and the words under it
    assert plain(verdict(known.loads["reference"])) in told
    assert told.index("largest stress") < told.index("Engines show or hide")


@pytest.mark.parametrize(("part", "words"), [(0.5, "does not hold"), (1.0, "too close to tell"), (3.0, "The arm holds")])
@pytest.mark.parametrize("key", ["yield_strength", "fatigue_strength"])
def test_a_factor_below_one_is_a_verdict(example: CaseResult, stress: ArmStress, key: str, part: float, words: str) -> None:
    borne = stress.largest if key == "yield_strength" else stress.amplitude
    strengths = dict.fromkeys(("yield_strength", "fatigue_strength")) | {key: part * borne.value}
    assert words in verdict(loads_of_case(with_strength(example, **strengths)).loads["reference"])


@pytest.mark.parametrize("part", [0.3, 2.0])
def test_an_error_of_tens_of_percent_lets_nobody_judge(example: CaseResult, stress: ArmStress, part: float) -> None:
    run = example.runs["reference"]
    moment = stress.largest.value * section_modulus(example.case.mechanism.follower)
    unsure = {name: dict.fromkeys(("pre", "post"), part * moment) for name in run.cycle}
    weak = with_strength(example, yield_strength=0.5 * stress.largest.value, fatigue_strength=None)
    page = text_of(one_run(with_run(weak, "reference", extreme_estimates=unsure)))
    assert "The arm does not hold" not in page
    assert "cannot be judged" in page


def test_without_strengths_the_page_says_which_keys_to_give(example: CaseResult) -> None:
    told = text_of(one_run(with_strength(example, yield_strength=None, fatigue_strength=None)))
    assert "The arm holds" not in told
    assert "give yield_strength and fatigue_strength in [follower]" in told


def test_the_thesis_keeps_its_first_screen_and_engines_without_moments_the_old_one(example: CaseResult) -> None:
    of_thesis = one_run()
    assert loads_on(of_thesis) == []
    assert machines(of_thesis) == {}
    assert not {"strength", "next"} & {chapter.id for chapter in chapters_of(of_thesis)}
    without = example
    for name, run in example.runs.items():
        without = with_run(without, name, cycle={key: values for key, values in run.cycle.items() if not key.startswith("moment")})
    assert "strength" not in [chapter.id for chapter in chapters_of(one_run(without))]
    assert "settled at the accuracy asked" in text_of(one_run(without))


def test_the_reference_leads_and_the_stress_of_others_stands_beside(example: CaseResult) -> None:
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
    along, stress = machines(content)["example"].along_arm, loads_of_case(result).stress
    assert max(map(abs, along["low"] + along["high"])) == pytest.approx(1e-6 * stress.largest.value, rel=0.03)
    assert along["at"] == pytest.approx((stress.largest.place or 0.0) / result.case.mechanism.follower.length)
    assert along["low"][-1] == pytest.approx(0.0, abs=0.03 * along["largest"])  # the light tip bears little
    (run,) = cycles(content.results, ["reference"], {"example": along}).runs
    assert run["stress"] == along
