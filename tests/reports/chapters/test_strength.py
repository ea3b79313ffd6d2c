"""What the page of one's own case says of the machine: numbers of its table, in words that fit them."""

import dataclasses
import re

import pytest
from quickreturn.reports.chapters.strength import fatigue_sentences, finding, lacking, mode_sentences, strength_table, stress_sentences

from quickreturn.cases.loads import Factor, loads_of_run, resonance, share_of
from quickreturn.cases.loads.fatigue import Fatigue
from quickreturn.cases.loads.stress import ArmStress, section_modulus
from quickreturn.cases.runs.comparison import CaseResult, compare
from quickreturn.cases.shown import Unit
from quickreturn.cases.units import in_si
from quickreturn.reports.page.chapters import chapters_of
from quickreturn.reports.page.content import Content
from quickreturn.reports.page.view import cycles
from quickreturn.reports.results.loads import CaseLoads, leading_loads, loads_of_case, name_of, notch_lines, numbers_of_case, settled_speed
from quickreturn.reports.words import quantity
from tests.reports.made_up_loads import made_up_loads, with_resonance, without
from tests.reports.pages import finding_of, one_run, plain, read, text_of
from tests.reports.plotted_results import made_up_result, with_run, with_strength
from tests.reports.reported_results import reported_result

NO_MEAN = "The mean stress does not count: that takes tensile_strength."


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


def test_the_heading_gives_stress_safety_and_resonance(known: CaseLoads) -> None:
    stress, resonance = "12.35 MPa at 375 mm from P", "harmonic 9 is 2.2 % from resonance"
    assert plain(finding([known])) == f"{stress}, safety 2 against yielding; {resonance}"
    assert plain(finding([without(known, "yield_factor")])) == f"{stress}, safety 3 against fatigue; {resonance}"
    tired = dataclasses.replace(known.loads["reference"], yield_factor=known.loads["reference"].fatigue_factor)
    tired = dataclasses.replace(tired, fatigue_factor=known.loads["reference"].yield_factor)
    assert ", safety 2 against fatigue; " in plain(finding([dataclasses.replace(known, loads={"reference": tired})]))  # the least counts
    neither = without(known, "yield_factor", "fatigue_factor")
    assert plain(finding([neither])) == f"{stress}; {resonance}"
    neither = with_resonance(neither, None)
    assert plain(finding([neither])) == stress
    assert plain(finding([neither, known])) == f"example: {stress}"  # of the first of several
    hardly = dataclasses.replace(known, shares={"reference": 0.003})
    assert plain(finding([with_resonance(hardly)])) == f"{stress}, safety 2 against yielding", "no alarm"


def test_the_heading_is_about_the_first_case_of_the_page(example: CaseResult) -> None:
    loads = loads_of_case(example)
    assert finding_of(one_run(example), "strength") == plain(finding([loads]))
    two = one_run(reported_result("hard-speed-x2"), example)
    assert finding_of(two, "strength").startswith("hard-speed-x2: ")


def test_the_sentences_say_where_the_arm_is_stressed_and_how_the_stress_varies(known: CaseLoads) -> None:
    told = plain(stress_sentences(known))
    holds = "The arm holds: the safety factor is 2 (± 5.0 %) against yielding and 3 (± 3.0 %) against fatigue."
    most = "By reference, the arm is stressed most 375 mm from P, with 12.35 MPa when the crank stands at 324°"
    strain = "(a surface strain of 176.4 µε): compression, 0.05000 MPa of it from the normal force"  # 12.346 MPa / 70 GPa
    widest = "The range of stress in a turn is widest 400 mm from P: an amplitude of 8.000 MPa about zero."
    assert told == f"{holds} {most} {strain}. {widest}"
    loads = known.loads["reference"]
    assert loads.stress is not None
    mean = dataclasses.replace(loads, stress=dataclasses.replace(loads.stress, mean=0.05e6))
    assert plain(stress_sentences(CaseLoads(known.case, {"reference": mean}))).endswith("about a mean of 0.05000 MPa.")
    alone = dataclasses.replace(loads, stress=dataclasses.replace(loads.stress, axial=None))
    assert "176.4 µε); the engine gives no normal force, so that this is bending alone." in plain(
        stress_sentences(CaseLoads(known.case, {"reference": alone}))
    )


def test_the_sentences_on_fatigue_give_place_notch_mean_and_cycles(known: CaseLoads) -> None:
    told = plain(fatigue_sentences(known))
    worst = "For fatigue the arm is worst 400 mm from P: an amplitude of 8.000 MPa about zero."
    assert told == f"{worst} A turn has 2 cycles of stress there, with ranges of 16.00 MPa and 4.000 MPa. {NO_MEAN}"
    loads = known.loads["reference"]
    assert loads.stress is not None
    number = dataclasses.replace(loads.stress.fatigue.equivalent, value=16.4e6, place=0.42)
    ranges = (15e6, 5e6, 4e6, 3e6, 2e6)
    fatigue = Fatigue(equivalent=number, notch_factor=2.0, amplitude=7.5e6, mean=4e6, ranges=ranges)
    notched = dataclasses.replace(loads, stress=dataclasses.replace(loads.stress, fatigue=fatigue))
    strong = known.case.scene.follower
    scene = dataclasses.replace(known.case.scene, follower=dataclasses.replace(strong, tensile_strength=700e6))
    case = dataclasses.replace(known.case, scene=scene)
    assert plain(fatigue_sentences(CaseLoads(case, {"reference": notched}))) == (
        "For fatigue the arm is worst 420 mm from P, where the notch factor is 2: an amplitude of 7.500 MPa about a mean of 4.000 MPa is as"
        " bad as a fully reversed one of 16.40 MPa. A turn has 5 cycles of stress there, with ranges of 15.00 MPa, 5.000 MPa, 4.000 MPa and"
        " 2 smaller ones."
    )


def test_the_sentences_on_the_first_mode_give_both_frequencies(known: CaseLoads) -> None:
    told = plain(mode_sentences(known))
    assert told.startswith("The first mode, with the crank held, has 18.40 Hz in the mean over the turn, 9.20 times the crank’s 2.000 Hz.")
    assert "Of the crank’s speed the 9th harmonic is nearest to the first mode; the two meet at 122.7 rpm, 2.2 % faster." in told
    hardly = dataclasses.replace(known, shares={"reference": 0.003})
    words = "the 9th harmonic is nearest to the first mode and hardly drives it: harmonics 7 to 11 make 0.3 % of the tip's acceleration."
    assert words in plain(mode_sentences(with_resonance(hardly)))
    assert told.endswith(
        "from 12.10 Hz up, so a resonance is blunt. The rotation of the crank, and its compliance under a driving torque, change"
        " the mean by 0.5 %; this is taken as its error."
    )
    assert mode_sentences(with_resonance(known, None)) == ""


def test_the_keys_that_are_missing_are_named(known: CaseLoads) -> None:
    cases = {(): "", ("yield_factor",): "yield", ("fatigue_factor",): "fatigue", ("yield_factor", "fatigue_factor"): "both"}
    told = {which: lacking(without(known, *factors).loads["reference"]) for factors, which in cases.items()}
    assert told[""][1] == []
    assert told["yield"] == ("No factor against yielding", ["yield_strength"])
    assert told["fatigue"] == ("No factor against fatigue", ["fatigue_strength"])
    assert told["both"] == ("No safety factor", ["yield_strength", "fatigue_strength"])


def test_the_first_screen_answers_with_the_numbers_of_the_table(example: CaseResult, stress: ArmStress) -> None:
    page, told = read(one_run(example)), text_of(one_run(example))
    rows = {(row[1][0], row[2][1]): row for row in page.tables["strength.csv"]}
    for name, unit in (("stress", "MPa"), ("crank_torque", "N*m"), ("pivot_force", "N"), ("slider_force", "N"), ("tip_deflection", "mm")):
        value = float(rows["reference", name][3][1])
        assert quantity(value, Unit(unit, in_si(unit))).replace("\N{NO-BREAK SPACE}", " ") in told
        assert rows["reference", name][4][0] != "–"  # each with its error
    assert float(rows["reference", "stress"][3][1]) == stress.largest.value
    place = float(rows["reference", "stress"][6 - 1][1])
    assert f"{1e3 * place:.0f} mm from P" in told
    first = resonance(example.case.mechanism, settled_speed(example))
    assert first is not None
    share = share_of(first.harmonic, example.runs["reference"].cycle)
    assert first.sentence(example.case.units, share) in told
    assert f"{first.ratio:.2f}first mode" in told  # a large number and the words under it
    assert plain(loads_of_case(example).verdict) in told
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
def test_a_factor_below_one_is_told_in_a_sentence(example: CaseResult, stress: ArmStress, key: str, part: float, sentence: str) -> None:
    borne = stress.largest if key == "yield_strength" else stress.amplitude
    strengths = dict.fromkeys(("yield_strength", "fatigue_strength")) | {key: part * borne.value}
    assert sentence in loads_of_case(with_strength(example, **strengths)).verdict


def test_one_factor_below_one_is_enough(example: CaseResult, stress: ArmStress) -> None:
    material = {"yield_strength": 0.5 * stress.largest.value, "fatigue_strength": stress.amplitude.value}
    told = loads_of_case(with_strength(example, **material)).verdict
    errors = [f"(± {100.0 * each.error / each.value:.2g} %)" for each in (stress.largest, stress.amplitude)]
    both = f"0.5 {errors[0]} against yielding and 1 {errors[1]} against fatigue"
    assert plain(told) == f"The arm does not hold: the safety factor is {both}."


def test_each_notch_is_told_and_whether_it_decides(known: CaseLoads) -> None:
    loads = known.loads["reference"]
    assert loads.stress is not None
    worst = loads.stress.fatigue  # 400 mm from P
    root = dataclasses.replace(worst, equivalent=dataclasses.replace(worst.equivalent, value=0.05e6, place=0.0), notch_factor=1.8)
    notched = dataclasses.replace(loads, stress=dataclasses.replace(loads.stress, notches=(root, worst)))
    factors = (Factor(3440.0, 3400.0, 3480.0, 0.01), loads.fatigue_factor)
    lines = [plain(line) for line in notch_lines(dataclasses.replace(notched, notch_factors=factors), known.case)]
    assert lines == [
        "notch 0 mm from P: safety factor 3440 (± 1.0 %) against fatigue, does not decide",
        "notch 400 mm from P: safety factor 3 (± 3.0 %) against fatigue, decides",
    ]
    told = notch_lines(dataclasses.replace(notched, notch_factors=(None, None)), known.case)
    assert plain(told[0]) == "notch 0 mm from P: equivalent amplitude 0.05000 MPa, does not decide"
    case = dataclasses.replace(known, loads={"reference": dataclasses.replace(notched, notch_factors=factors)})
    names = {load.quantity: load for _, load in numbers_of_case(case)}
    assert names["notch_1_fatigue_factor"].value == 3440.0
    assert names["notch_2_equivalent_amplitude"].place == 0.4
    assert name_of("notch_1_fatigue_factor") == "safety against fatigue at notch 1"
    assert notch_lines(loads, known.case) == []


def test_an_interval_whose_ends_look_alike_is_an_error(known: CaseLoads) -> None:
    sharp = dataclasses.replace(known.loads["reference"], yield_factor=Factor(18.99, 18.985, 18.995, 3e-4))
    (row,) = (row for row in strength_table([CaseLoads(known.case, {"reference": sharp})]).rows if row["quantity"].value == "yield_factor")
    assert plain(row["error"].text) == "± 0.026 %"


@pytest.mark.parametrize(("part", "words"), [(0.3, "30 % of it: the safety factor is 0.5 (0.38"), (2.0, " or more)")])
def test_an_error_of_tens_of_percent_lets_nobody_judge(example: CaseResult, stress: ArmStress, part: float, words: str) -> None:
    run = example.runs["reference"]
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
    found = {number.quantity: number for engine, number in numbers_of_case(loads_of_case(example)) if engine in ("reference", "")}
    assert found["stress"].unit == "Pa"
    assert found["frequency_ratio"].value == pytest.approx(found["mean_first_frequency"].value / 2.0)  # 120 rpm
    assert found["yield_factor"].value == pytest.approx(240e6 / found["stress"].value)
