"""The verdicts, warnings and figures of the first screen, for made-up numbers."""

import dataclasses
from collections.abc import Sequence
from typing import Any

import pytest

from quickreturn.cases.comparison.pair import Difference
from quickreturn.cases.motion.number import Number
from quickreturn.plugins.thesis.inference.tables import headline
from quickreturn.plugins.thesis.page_data import inference_of
from quickreturn.plugins.thesis.tests.made_up_inference import made_up_inference
from quickreturn.reports.engine_differences import Spread, spread
from quickreturn.reports.page.content import Subject
from quickreturn.reports.page.first_screen import Answer, Cubic, Figure, sentences
from tests.reports.pages import one_run, plain, text_of


def spread_of(*shares: float, case: str = "thesis-24", channel: str | None = None) -> Spread:
    """The spread of relative differences."""
    found = spread(
        [
            Difference(case, "a", "reference", "maximum", "pre", channel, Number(1.0 + share, 0, 0), Number(1.0, 0, 0), 1.0, 0.0)
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


def told(*, subject: Subject | None = None, **changes: Any) -> str:
    return plain(" ".join(sentences(answer(**changes), subject or Subject())))


def shown(found: Sequence[Figure]) -> dict[str, str]:
    return {plain(number): plain(meaning) for number, meaning in found}


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({}, ["Three programs", "both set-ups", "at most 1.2 %", "12 % faster", "97 % of the strain"]),
        ({"cases": 3, "compared": 2}, ["two of three set-ups"]),
        ({"departing": ["c", "d"], "alike": ["reference", "a"]}, ["c and d depart", "more than claimed"]),
        ({"alike": [], "departing": ["a"], "cubic": None}, ["differ by more than they claim: a from the others"]),
        ({"alike": [], "cubic": None, "settled": 0}, ["No program came to a steady state", "Provenance"]),
        ({"alike": [], "cubic": None, "engines": ["reference"]}, ["One program"]),
        ({"alike": [], "cubic": None}, ["could not be judged"]),
        ({"alike": [], "departing": [], "cubic": Cubic(spread_of(-0.05), None)}, ["5.0 % more slowly than the converged model"]),
        ({"subject": Subject(turning=1.0)}, ["turns a flexible arm fully"]),
    ],
)
def test_the_sentences_have_the_verdict_and_its_numbers(changes: dict[str, Any], words: list[str]) -> None:
    found = told(**changes)
    assert all(each in found for each in words), found


def test_the_inference_on_the_thesis_has_what_speaks_for_and_against_it() -> None:
    found = plain(headline(made_up_inference()))
    words = ("1.22 to 1.33 times", "60 %", "16 % if it is taken", "83 to 94 Hz where 132 Hz", "leaves it 0.4 %", "would decide")
    assert all(each in found for each in words), found
    assert found in text_of(one_run(data={inference_of: made_up_inference()}))
