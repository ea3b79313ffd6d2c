"""What the study claims of its numbers."""

import pytest

from quickreturn.cases.library.thesis.runs import run_case
from quickreturn.cases.motion.orbit import find_orbit
from quickreturn.cases.motion.time_scale import CHANNELS
from quickreturn.plugins.thesis.finding import study
from quickreturn.plugins.thesis.finding.effects import PUBLISHED, effects
from quickreturn.plugins.thesis.finding.response import Response, respond


def response(peak: float, factor: float) -> Response:
    return Response(peaks=dict.fromkeys(CHANNELS, peak), factor=factor)


@pytest.mark.parametrize("factor", [0.2, 0.25, 0.5])
def test_the_claim_is_the_error_whatever_part_of_it_the_finer_settings_leave(factor: float) -> None:
    """Made-up peaks: the change is 20 %, the usual settings say 30 %, and the finer ones err by the part of these 10 % that they name."""
    effect = next(each for each in effects() if each.id == "clearance")
    found = {(PUBLISHED.id, run, way): (response(1.0, 0.2 if way else 1.0),) for run in study.SAMPLE for way in ("", "finer")}
    for run in study.SAMPLE:
        found[effect.id, run, ""] = (response(1.3, 1.0),) * 3
        found[effect.id, run, "finer"] = (response(1.2 + factor * 0.1, factor),)
    *_, acceleration, strain, _ = study._claim(effect, found)
    assert acceleration == strain == pytest.approx(10.0, abs=0.01)  # the claim is rounded to that


@pytest.mark.parametrize(("way", "factor"), [("", 1.0), ("finer", 0.5)])
def test_a_response_says_what_part_of_the_error_its_settings_leave(way: str, factor: float) -> None:
    """Run 4 as published has two modes, which are compared with five (`engines/LADDERS.md`, section 1)."""
    (requests,) = study._job(PUBLISHED, 4, way, find_orbit(run_case(4).mechanism)).arguments
    assert [each.factor for each in respond(requests)] == [factor]
