"""The numbers of the first screen."""

import dataclasses

import pytest

from quickreturn.cases.comparison.engines import compare
from quickreturn.cases.motion.cycle import HALVES
from quickreturn.cases.motion.time_scale import CHANNELS
from quickreturn.reports.page.first_screen import answer_of
from quickreturn.reports.words import size
from tests.reports import pages
from tests.reports.pages import content_of
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
