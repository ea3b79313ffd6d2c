"""How small an error the comparison of engines finds: the same whether planted in a number, in all numbers of a run, or in its motion."""

import dataclasses
import math
from collections.abc import Callable, Iterator

import pytest

from quickreturn.cases.comparison.engines import CaseResult, compare
from quickreturn.cases.comparison.pair import KINDS, WAVEFORM, Kind
from quickreturn.cases.motion.cycle import EXTREMES, VIBRATION
from quickreturn.cases.motion.request import Run
from quickreturn.cases.motion.time_scale import CHANNELS
from quickreturn.reports.chapters.agreement import Sharpness, sharpness, smallest_found
from tests.changed_run import changed_run
from tests.reports.reported_results import agreeing, reported_result

#: Part of an error by which planted ones are more, or less: rounding of a number that is larger than its error.
MARGIN = 2e-3
#: Numbers that an error of each kind scales; a consensus is made of its channels' frequencies.
SCALED: dict[Kind, tuple[str, ...]] = {"frequency": VIBRATION[:1], "amplitude": VIBRATION[1:], "extreme": EXTREMES}

RESULTS = [agreeing(reported_result("thesis-24")), agreeing(reported_result("thesis-06", seed=5))]


def found_of(results: list[CaseResult], engine: str, kind: Kind) -> Sharpness:
    (found,) = (each for each in sharpness(results) if (each.engine, each.kind) == (engine, kind))
    return found


def beyond(results: list[CaseResult], engine: str, kind: Kind, changed: Callable[[Run], Run]) -> tuple[int, int]:
    """In how many numbers of a kind an engine departs if its runs are changed, and in how many it is compared."""
    compared = [compare(result.case, result.runs | {engine: changed(result.runs[engine])}) for result in results]
    checks = [check for result in compared for check in result.checks if check.engine == engine and check.quantity in KINDS[kind]]
    return sum(not check.passed for check in checks), len(checks)


def scaled(kind: Kind, factor: float) -> Callable[[Run], Run]:
    """A run whose numbers of a kind are larger by a factor."""

    def change(run: Run) -> Run:
        def larger(each: object) -> dict[str, float]:
            return {name: factor * value for name in SCALED[kind] if (value := getattr(each, name, None)) is not None}

        measures = tuple(dataclasses.replace(each, **larger(each)) for each in run.measured.measures)
        return changed_run(run, measures=measures)

    return change


@pytest.mark.parametrize("engine", ["exudyn", "mujoco"])
@pytest.mark.parametrize("kind", list(SCALED))
def test_an_error_is_found_from_the_size_on_that_is_told(engine: str, kind: Kind) -> None:
    told = found_of(RESULTS, engine, kind)

    def counts(error: float) -> Iterator[tuple[int, int]]:
        yield from (beyond(RESULTS, engine, kind, scaled(kind, 1.0 + sign * error)) for sign in (1, -1))

    assert min(count for count, _ in counts(told.found_somewhere * (1.0 + MARGIN))) >= 1
    assert min(count for count, _ in counts(told.found_somewhere * (1.0 - MARGIN))) == 0
    assert min(2 * count >= total for count, total in counts(told.found_mostly * (1.0 + MARGIN)))
    assert not min(2 * count >= total for count, total in counts(told.found_mostly * (1.0 - MARGIN)))
    assert told.found_somewhere <= told.found_mostly


def test_a_number_is_found_to_be_off_where_its_difference_exceeds_what_both_claim() -> None:
    for check in [check for check in RESULTS[0].checks if check.quantity not in WAVEFORM][:20]:
        for sign in (1, -1):
            for margin, passes in ((-MARGIN, True), (MARGIN, False)):
                off = (1.0 + sign * (1.0 + margin) * smallest_found(check, sign)) * check.number.value
                assert dataclasses.replace(check, number=dataclasses.replace(check.number, value=off)).passed is passes


def test_what_departs_already_needs_no_error_and_a_zero_shows_none() -> None:
    check = RESULTS[0].checks[0]
    claim = dataclasses.replace(check.number, value=check.other_number.value + 2.0 * check.tolerance)
    assert smallest_found(dataclasses.replace(check, number=claim), 1) == 0.0
    nothing = dataclasses.replace(check, number=dataclasses.replace(check.number, value=0.0), unshared=2.0 * abs(check.other_number.value))
    assert smallest_found(nothing, 1) == math.inf


def test_a_gain_is_found_in_every_waveform_that_tells_a_smaller_one() -> None:
    told = found_of(RESULTS, "exudyn", "waveform")

    def louder(run: Run) -> Run:
        channels = {name: (1.0 + 1.01 * told.found_mostly) * run.cycle[name] for name in CHANNELS}
        return changed_run(run, cycle={**run.cycle, **channels})

    count, total = beyond(RESULTS, "exudyn", "waveform", louder)
    assert 2 * count >= total > 0
