"""Run by run: the sections of the cases, with what departs in them."""

import dataclasses

from quickreturn.cases.measures.number import Number
from quickreturn.cases.runs.comparison import Difference
from quickreturn.reports.chapters.each import departure, finding
from tests.reports.pages import finding_of, one_run, plain, text_of
from tests.reports.reported_results import reported_result


def test_the_heading_says_whose_signals_are_shown() -> None:
    assert finding(1) == "All signals, engines overlaid" == finding_of(one_run(), "each")
    several = one_run(reported_result("thesis-24"), reported_result("thesis-06"))
    assert finding(2) == "All signals of the run chosen above, engines overlaid" == finding_of(several, "each")


def test_a_departure_is_told_with_what_both_claim_and_a_lower_minimum_counts_as_more() -> None:
    number, other_number = Number(11.0, 0.2, 0.1), Number(10.0, 0.1, 0.1)
    high = Difference("run", "a", "b", "maximum", "pre", "strain_1", number, other_number, 20.0)
    low = dataclasses.replace(high, quantity="minimum", half="post", number=Number(-11.0, 0.2, 0.1), other_number=Number(-10.0, 0.1, 0.1))
    first = "maximum, pre-return, strain 1 +5.00 % (claimed together 2.50 %)"
    assert plain(departure("a", "b", [high])) == f"a and b differ by more than they claim in 1 number: {first}."
    second = "minimum, post-return, strain 1 +5.00 % (claimed together 2.50 %)"
    assert plain(departure("a", "b", [high, low])) == f"a and b differ by more than they claim in 2 numbers: {first}; {second}."


def test_a_section_has_the_notes_and_failures_of_its_case() -> None:
    result = reported_result("thesis-06", {"exudyn": "failed"})
    told = text_of(one_run(dataclasses.replace(result, case=dataclasses.replace(result.case, notes=("a note on it",)))))
    assert "A note on it." in told
    assert "exudyn: failed. failed at t = 0.25 s: the beam <snapped>" in told
