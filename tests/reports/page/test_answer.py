"""The numbers, verdicts, warnings and figures of the first screen."""

import dataclasses
from collections.abc import Sequence
from typing import Any

import pytest

from quickreturn.cases.comparison.engines import compare
from quickreturn.cases.comparison.pair import Difference
from quickreturn.cases.motion.cycle import HALVES
from quickreturn.cases.motion.number import Number
from quickreturn.cases.motion.time_scale import CHANNELS
from quickreturn.reports.engine_differences import Spread, spread
from quickreturn.reports.page.content import Subject
from quickreturn.reports.page.first_screen import Answer, Cubic, Figure, answer_of, sentences
from quickreturn.reports.words import size
from tests.reports import pages
from tests.reports.pages import content_of, plain
from tests.reports.plotted_results import ENGINES, with_run
from tests.reports.reported_results import reported_result


@pytest.mark.parametrize("missed", [0, 1, 12])
def test_an_engine_is_alike_as_long_as_few_of_its_numbers_depart(missed: int) -> None:
    result = reported_result("thesis-24")
    reference = result.runs["reference"]
    measures = list(reference.measured.measures)
    for number in range(missed):
        quantity = "maximum" if number < len(measures) else "minimum"
        place = number % len(measures)
        measures[place] = dataclasses.replace(measures[place], **{quantity: 1e9})  # type: ignore[arg-type]
    result = with_run(result, "mujoco", measures=tuple(measures), consensus=reference.measured.consensus)
    found = answer_of(content_of(results=[compare(result.case, result.runs)]))
    # 34 numbers of mujoco at most are compared: one is less than a twentieth, twelve are not
    assert ("mujoco" in found.alike) == (missed < 2)
    assert ("mujoco" in found.departing) == (missed == 12)
    assert found.alike[:1] in (["reference"], [])


def test_set_ups_in_which_nothing_could_be_judged_are_not_counted_among_those_that_agree() -> None:
    good, broken = reported_result("thesis-24"), reported_result("example", dict.fromkeys(ENGINES, "failed"))
    told = pages.text_of(content_of(results=[good, broken]))
    assert "the same motion in one of two set-ups" in told
    assert "What was compared" in told
    assert "What was compared" not in pages.text_of(content_of(results=[broken]))
    assert "the same motion in both set-ups" in pages.text_of(content_of(results=[good, reported_result("thesis-06")]))


def test_claims_as_wide_as_the_numbers_make_no_engine_alike_and_no_set_up_the_same() -> None:
    result = reported_result("thesis-24")
    for engine, run in result.runs.items():
        estimates = ("first_mode_frequency", "first_mode_amplitude", "minimum", "maximum")
        wide = [
            {f"{name}_estimate": number and abs(number.value) for name in estimates for number in [each.number(name)]}
            for each in run.measured.measures
        ]
        measures = tuple(dataclasses.replace(each, **changes) for each, changes in zip(run.measured.measures, wide, strict=True))
        waves = {name: dict.fromkeys(HALVES, run.peak(name)) for name in CHANNELS if run.usable}
        result = with_run(result, engine, measures=measures, extreme_estimates=waves, waveform_estimates=waves)
    result = compare(result.case, result.runs)
    assert result.agreement == {"agree": 0, "disagree": 0, "says_nothing": len(result.checks)}
    found = answer_of(content_of(results=[result]))
    assert (found.compared, found.alike, found.departing) == (0, [], [])
    assert "the same motion in one of two set-ups" in pages.text_of(content_of(results=[reported_result("thesis-06"), result]))


def test_the_answer_follows_from_the_numbers() -> None:
    told = pages.text_of(content_of(results=[reported_result("thesis-24")]))
    cubic = answer_of(content_of(results=[reported_result("thesis-24")])).cubic
    assert cubic.frequency.median == pytest.approx(0.13, abs=0.01)  # made up: 1.13 times, and 0.4 % of noise
    assert f"rings {size(cubic.frequency.median)} faster and shows".replace("\N{NO-BREAK SPACE}", " ") in told
    assert "4 of 4" in told


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
