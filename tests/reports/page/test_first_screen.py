"""The sentences and figures of the first screen, written out for made-up numbers."""

import dataclasses
from collections.abc import Sequence
from typing import Any

from quickreturn.cases.measures.number import Number
from quickreturn.cases.runs.comparison import Difference
from quickreturn.plugins.thesis.effects import tightened_words
from quickreturn.plugins.thesis.page_data import finding_of, inference
from quickreturn.plugins.thesis.sufficiency import splits
from quickreturn.plugins.thesis.tests.made_up_finding import made_up_finding
from quickreturn.reports.page.answer import Answer, Cubic
from quickreturn.reports.page.content import Subject
from quickreturn.reports.page.first_screen import (
    Figure,
    agreement_screen,
    departure_words,
    figures,
    headline,
    machine_screen,
    missed_words,
    safety_figure,
    sentences,
)
from quickreturn.reports.results.engine_differences import Spread, spread
from quickreturn.reports.results.loads import CaseLoads
from tests.reports.made_up_loads import made_up_loads, without
from tests.reports.pages import one_run, plain, text_of

MOTOR = "A motor turns a crank; its slider swings a flexible arm to and fro, slowly out and quickly back."


def spread_of(*shares: float, case: str = "thesis-24", channel: str | None = None) -> Spread:
    """The spread of relative differences."""
    found = spread(
        [
            Difference(case, "a", "reference", "maximum", "pre", channel, Number(1.0 + share, 0, 0), Number(1.0, 0, 0), 1.0)
            for share in shares
        ]
    )
    assert found is not None
    return found


def answer(**changes: Any) -> Answer:
    """Three engines, of which all agree in two cases."""
    known = Answer(
        cases=2,
        compared=2,
        engines=["reference", "a", "b"],
        simulations=6,
        settled=6,
        missed=[],
        alike=["reference", "a", "b"],
        departing=[],
        frequency=spread_of(0.004, -0.012),
        amplitude=spread_of(0.036, case="thesis-06"),
        extreme=spread_of(0.05, channel="strain_2"),
        cubic=Cubic(spread_of(0.11, 0.12, 0.14), 0.972),
    )
    return dataclasses.replace(known, **changes)


def told(*, subject: Subject | None = None, **changes: Any) -> list[str]:
    return [plain(each) for each in sentences(answer(**changes), subject or Subject())]


def test_the_title_says_how_many_engines_agree() -> None:
    assert headline(answer()) == "Three simulations agree within their claims"
    assert headline(answer(engines=["reference", "a", "b", "c"])) == "Three of four simulations agree within their claims"
    assert headline(answer(alike=[], departing=["a"])) == "The simulations differ by more than they claim"
    assert plain(headline(answer(alike=[]))) == "2 set-ups, 3 engines"
    assert plain(headline(answer(alike=[], cases=1, engines=["a"]))) == "1 set-up, 1 engine"
    assert agreement_screen(answer(), Subject(), "Run 24", None).title == "Run 24"


def test_the_sentences_tell_the_set_ups_in_which_engines_agree() -> None:
    same = (
        "Three programs that model the arm in different ways compute the same motion in {}; its ringing frequency differs by at most 1.2 %."
    )
    cubic = "The 1999 model, which lets the arm bend in one simple curve only, rings 12 % faster and shows 97 % of the strain at mid-arm."
    assert told() == [MOTOR, same.format("both set-ups"), cubic]
    assert told(cases=1, compared=1)[1] == same.format("this set-up")
    assert told(cases=24, compared=24)[1] == same.format("all 24 set-ups")
    assert told(cases=3, compared=3)[1] == same.format("all three set-ups")
    assert told(cases=3, compared=2)[1] == same.format("two of three set-ups")
    assert told(frequency=None)[1] == "Three programs that model the arm in different ways compute the same motion in both set-ups."


def test_the_sentences_name_the_engines_that_depart() -> None:
    assert told(departing=["c"])[2] == "c departs from them by more than claimed."
    assert told(departing=["c", "d"], alike=["reference", "a"])[2] == "c and d depart from these by more than claimed."
    model = "The programs that model it in different ways differ by more than they claim:"
    assert told(alike=[], departing=["a"], cubic=None) == [MOTOR, f"{model} a from the others."]
    assert told(alike=[], departing=["a", "b"], cubic=None) == [MOTOR, f"{model} a and b from each other."]


def test_the_sentences_where_nothing_could_be_judged() -> None:
    nothing: dict[str, Any] = {"alike": [], "cubic": None}
    assert told(**nothing, settled=0)[1] == "No program came to a steady state in both set-ups: the chapter Provenance says why."
    assert told(**nothing, engines=["reference"])[1] == "One program computes its motion in both set-ups."
    unjudged = "The programs could not be judged against each other; they compute its motion in both set-ups."
    assert told(**nothing)[1] == unjudged


def test_the_1999_model_is_held_against_the_converged_one() -> None:
    slow = told(alike=[], departing=[], cubic=Cubic(spread_of(-0.05), None))[2]
    assert slow == "The 1999 model, which lets the arm bend in one simple curve only, rings 5.0 % more slowly than the converged model."


def test_a_subject_has_its_own_arm_and_inference() -> None:
    thin = told(subject=Subject("thin", 0.0, ", and the arm whips", "So it is."))
    assert thin[0] == "A motor turns a crank; its slider swings a thin arm to and fro, slowly out and quickly back, and the arm whips."
    assert thin[-1] == "So it is."
    assert told(subject=Subject(turning=0.5))[0] == MOTOR.replace("to and fro", "to and fro, or turns it fully")
    turning = "A motor turns a crank; its slider turns a flexible arm fully, one half of the turn slowly and the other quickly."
    assert told(subject=Subject(turning=1.0))[0] == turning
    found = plain(inference(splits(made_up_finding()), tightened_words(made_up_finding())))
    assert "A roller that is softer on one side would do that (+0.2 % before, −2.0 % after, at 20 kN/m), but section 3.2 says" in found
    # 60.1 GPa against 68.9 and 73.1 GPa; frequencies grow with the root
    assert "is 13 to 18 % below that of aluminium: with the usual one the arm rings 7 to 10 % faster in both halves." in found
    assert inference([], "") == ""
    assert found in text_of(one_run(data={finding_of: made_up_finding()}))


def test_simulations_that_miss_their_accuracy_are_named_up_to_three() -> None:
    assert missed_words(answer()) == ""
    assert plain(missed_words(answer(missed=["a: x"]))) == "1 simulation of 6 misses its accuracy: a: x."
    assert plain(missed_words(answer(missed=["a: x", "b: y"]))) == "2 simulations of 6 miss their accuracy: a: x; b: y."
    assert plain(missed_words(answer(missed=["a", "b", "c", "d"]))) == "4 simulations of 6 miss their accuracy: a; b; c; …."


def shown(found: Sequence[Figure]) -> list[tuple[str, str]]:
    return [(plain(number), plain(meaning)) for number, meaning in found]


def test_the_figures_are_what_settled_the_differences_and_a_last_one() -> None:
    settled = ("6 of 6", "simulations settled at the accuracy asked, by their own estimates")
    frequency = ("1.2 %", "largest frequency difference of the three that agree; largest amplitude difference 3.6 % (run 6)")
    peak = ("5.0 %", "largest difference of a peak (run 24, pre-return, strain 2)")
    assert shown(figures(answer(), Subject(), ("1 Hz", "f"))) == [settled, frequency, peak, ("1 Hz", "f")]
    over = "the 1999 model’s frequency over the converged one (median; 11 to 14 %); which is right is open: measured curves are lost"
    assert shown(figures(answer(), Subject(on_the_model=True), None))[2] == ("+12 %", over)
    assert shown(figures(answer(cubic=None), Subject(on_the_model=True), None))[2] == peak


def test_the_figures_without_comparisons_are_fewer() -> None:
    bare = answer(alike=[], amplitude=None, extreme=None)
    frequency = ("1.2 %", "largest frequency difference")
    assert shown(figures(bare, Subject(), ("1 Hz", "f")))[1:] == [frequency, ("1 Hz", "f")]
    assert shown(figures(dataclasses.replace(bare, frequency=None), Subject(), None))[1:] == []


def test_a_machine_is_told_its_stress_and_its_safety() -> None:
    case = made_up_loads()
    screen = machine_screen(case)
    length = case.case.mechanism.follower.length
    stress = f"The largest stress is 375 mm from P, at {100.0 * 0.375 / length:.0f} % of the arm’s length, when the crank stands at 324°."
    holds = "The arm holds: the safety factor is 2 (± 5.0 %) against yielding and 3 (± 3.0 %) against fatigue."
    assert [plain(each) for each in screen.sentences] == [holds, stress, ""]
    assert (screen.title, screen.warning) == (case.case.title, "")
    first, second, *_, last = shown(screen.figures)
    assert first == ("12.35 MPa", "largest stress in the arm: compression, 0.05000 MPa of it from the normal force; ± 1.0 %")
    assert second == ("2", "safety against yielding at 240 MPa; 3 against fatigue at an amplitude of 95 MPa")
    mode = "first mode (mean 18.40 Hz) over the crank’s frequency; ± 0.5 %"
    assert last == ("9.20", mode)


def test_a_machine_is_warned_of_results_that_miss_their_accuracy() -> None:
    screen = machine_screen(dataclasses.replace(made_up_loads(), missed=("a misses it", "b misses it")))
    beside = "An error beside a number below is the engine’s own estimate of it."
    assert screen.warning == f"These numbers miss their accuracy: a misses it; b misses it. {beside}"


def test_a_machine_whose_stress_no_engine_gives_says_so() -> None:
    screen = machine_screen(CaseLoads(made_up_loads().case, {}))
    assert screen.sentences == ["No engine gives the stress of this machine’s arm: the chapter Provenance gives the reasons."]
    assert screen.figures == []


def test_engines_that_find_other_stresses_are_told() -> None:
    case = made_up_loads()
    (loads,) = case.loads.values()
    assert loads.stress is not None

    def times(factor: float) -> Any:
        assert loads.stress is not None
        return dataclasses.replace(loads, stress=dataclasses.replace(loads.stress, largest=loads.stress.largest.times(factor)))

    two = CaseLoads(case.case, {"reference": loads, "a": times(1.1)})
    assert plain(departure_words(two)) == "reference says so; a finds 10 % more."
    three = CaseLoads(case.case, {"reference": loads, "a": times(1.1), "b": times(0.95)})
    assert plain(departure_words(three)) == "reference says so; a finds 10 % more and b finds 5.0 % less."
    assert departure_words(case) == ""


def test_the_safety_figure_gives_the_factors_that_are_known() -> None:
    case = made_up_loads()
    assert safety_figure(without(case, "fatigue_factor")) == ("2", "safety against yielding at 240 MPa")
    assert safety_figure(without(case, "yield_factor")) == ("3", "safety against fatigue at an amplitude of 95 MPa")
    code = "safety: give <code>yield_strength</code> and <code>fatigue_strength</code> in <code>[follower]</code>"
    assert safety_figure(without(case, "yield_factor", "fatigue_factor")) == ("–", code)
