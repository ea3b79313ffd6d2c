"""What the page of one's own case says of the machine: numbers of its table, verdicts, and what happens in a turn."""

import dataclasses
import re
from typing import Any

import pytest

from quickreturn.cases.comparison.engines import CaseResult, compare
from quickreturn.cases.files.shown import Unit
from quickreturn.cases.files.units import in_si
from quickreturn.cases.motion.endings import Ending
from quickreturn.cases.motion.number import Number
from quickreturn.cases.motion.resonance import Resonance, resonance
from quickreturn.plugins.strength.case_loads import CaseLoads, leading_loads, loads_of_case, loads_on, numbers_of_case, share_of
from quickreturn.plugins.strength.loads import loads_of_run
from quickreturn.plugins.strength.page import machine_screen, machines, safety_figure, strength_finding
from quickreturn.plugins.strength.stress import ArmStress, Factor, Fatigue, section_modulus
from quickreturn.plugins.strength.words import name_of, verdict
from quickreturn.reports.page.chapters import chapters_of
from quickreturn.reports.page.content import Content
from quickreturn.reports.page.view import cycles
from quickreturn.reports.words import quantity
from tests.reports.pages import finding_of, one_run, plain, read, text_of
from tests.reports.plotted_results import made_up_result, with_run, with_strength
from tests.reports.reported_results import reported_result

#: 9.2 oscillations in a turn.
RESONANCE = Resonance(first_mode=18.4, lowest=12.1, crank=2.0)


def made_up_loads() -> CaseLoads:
    """12.346 MPa at 375 mm off by 1 %, an amplitude of 8 MPa about -0.02 MPa at 400 mm, safety 2 and 3, 9.2 oscillations in a turn."""
    found = loads_of_case(reported_result("example"))
    loads = found.loads["reference"]
    assert loads.stress is not None
    known = {"value": 12.346e6, "place": 0.375, "crank_angle": 5.65, "measurement": 0.0, "estimate": 0.12346e6}
    largest = dataclasses.replace(loads.stress.largest, **known)  # type: ignore[arg-type]
    amplitude = dataclasses.replace(loads.stress.amplitude, value=8e6, place=0.4)
    fatigue = Fatigue(equivalent=amplitude, notch_factor=1.0, amplitude=8e6, mean=-0.02e6, ranges=(16e6, 4e6))
    stress = dataclasses.replace(loads.stress, largest=largest, axial=Number(-0.05e6), amplitude=amplitude, mean=-0.02e6, fatigue=fatigue)
    factors = {"yield_factor": Factor(2.0, 1.9, 2.1, 0.05), "fatigue_factor": Factor(3.0, 2.9, 3.1, 0.03)}
    return with_resonance(CaseLoads(found.result, {"reference": dataclasses.replace(loads, stress=stress, modulus=70e9, **factors)}))


def with_resonance(case: CaseLoads, **known: Any) -> CaseLoads:
    """The same loads beside another first mode, whose error is 0.092 Hz; `known`: further values of `CaseLoads`."""
    made = dataclasses.replace(case)
    vars(made).update(resonance=RESONANCE, shift_of_motion=0.092, **{"share": None} | known)  # in place of what would be computed
    return made


def without(case: CaseLoads, *factors: str) -> CaseLoads:
    """The same loads without some safety factors."""
    return with_resonance(
        dataclasses.replace(case, loads={"reference": dataclasses.replace(case.loads["reference"], **dict.fromkeys(factors))})
    )


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


@pytest.fixture(scope="module")
def known() -> CaseLoads:
    return made_up_loads()


def test_the_heading_gives_stress_the_least_safety_and_resonance(known: CaseLoads) -> None:
    stress, away = "12.35 MPa at 375 mm from P", "harmonic 9 is 2.2 % from resonance"
    neither = without(known, "yield_factor", "fatigue_factor")
    hardly = with_resonance(known, share=0.003)
    for case, words, absent in (
        (known, [stress, "safety 2 against yielding", away], "fatigue"),
        (without(known, "yield_factor"), [stress, "safety 3 against fatigue", away], "yielding"),
        (neither, [stress, away], "safety"),
        (hardly, [stress], "harmonic"),  # no alarm
    ):
        told = plain(strength_finding([case]))
        assert all(each in told for each in words), told
        assert absent not in told
    assert strength_finding([neither, known]).startswith("example: ")  # of the first of several


def test_the_heading_is_about_the_first_case_of_the_page(example: CaseResult) -> None:
    assert finding_of(one_run(example), "strength") == plain(strength_finding([loads_of_case(example)]))
    other = dataclasses.replace(example, case=dataclasses.replace(example.case, name="other"))
    assert finding_of(one_run(other, example), "strength").startswith("other: ")


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


def test_each_notch_has_its_factor(known: CaseLoads) -> None:
    loads = known.loads["reference"]
    assert loads.stress is not None
    worst = loads.stress.fatigue  # 400 mm from P
    root = dataclasses.replace(worst, equivalent=dataclasses.replace(worst.equivalent, value=0.05e6, place=0.0), notch_factor=1.8)
    notched = dataclasses.replace(loads, stress=dataclasses.replace(loads.stress, notches=(root, worst)))
    factors = (Factor(3440.0, 3400.0, 3480.0, 0.01), loads.fatigue_factor)
    case = dataclasses.replace(known, loads={"reference": dataclasses.replace(notched, notch_factors=factors)})
    names = {load.quantity: load for _, load in numbers_of_case(case)}
    assert names["notch_1_fatigue_factor"].value == 3440.0
    assert names["notch_2_equivalent_amplitude"].place == 0.4
    assert name_of("notch_1_fatigue_factor").endswith(" 1")


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


def test_rows_have_units_and_names(example: CaseResult) -> None:
    found = {number.quantity: number for engine, number in numbers_of_case(loads_of_case(example)) if engine in ("reference", "")}
    assert found["stress"].unit == "Pa"
    assert found["frequency_ratio"].value == pytest.approx(found["mean_first_frequency"].value / 2.0)  # 120 rpm
    assert found["yield_factor"].value == pytest.approx(240e6 / found["stress"].value)


def test_a_machine_has_its_verdict_its_stress_and_its_warning(known: CaseLoads) -> None:
    screen = machine_screen(known, known.case.units)
    found = plain(" ".join(screen.sentences))
    assert all(each in found for each in ("The arm holds", "2 (± 5.0 %)", "3 (± 3.0 %)"))
    assert (screen.title, screen.warning) == (known.case.title, "")
    numbers = {plain(number): plain(meaning) for number, meaning in screen.figures}
    assert all(each in numbers["12.35 MPa"] for each in ("375 mm from P", "324°", "compression, 0.05000 MPa"))
    assert "yielding at 240 MPa; 3 against fatigue" in numbers["2"]
    assert "18.40 Hz" in numbers["9.20"]
    missed = with_run(known.result, "reference", status=Ending.INACCURATE)
    assert "reference estimates" in machine_screen(CaseLoads(missed, known.loads), known.case.units).warning
    nothing = machine_screen(CaseLoads(known.result, {}), known.case.units)
    assert "Provenance" in nothing.sentences[0]
    assert nothing.figures == []


def test_the_safety_figure_gives_the_factors_that_are_known(known: CaseLoads) -> None:
    assert [safety_figure(without(known, factor))[0] for factor in ("fatigue_factor", "yield_factor")] == ["2", "3"]
    both, given = ("yield_factor", "fatigue_factor"), ("yield_strength", "fatigue_strength")
    for unknown in (0, 1, 2):
        number, meaning = safety_figure(without(known, *both[:unknown]))
        assert [key in meaning for key in given] == [place < unknown for place in (0, 1)]
        assert (number == "–") == (unknown == 2)
