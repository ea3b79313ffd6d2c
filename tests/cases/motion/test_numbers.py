"""Numbers with their claims, and the catalogue's numbers of a turn in closed form."""

import math
from collections.abc import Mapping
from dataclasses import replace

import numpy as np
import pytest

from quickreturn.cases.library import library_case
from quickreturn.cases.motion.catalogue import MEASURES, numbers
from quickreturn.cases.motion.cycle import HALVES
from quickreturn.cases.motion.endings import Ending
from quickreturn.cases.motion.number import NO_NUMBER, Number
from quickreturn.cases.motion.of_turn import OF_TURN, by_spacing, rms_over_time
from quickreturn.cases.motion.request import Run
from quickreturn.cases.motion.time_scale import CHANNELS
from quickreturn.engines.error_parts import ErrorPart
from tests.reports.reported_results import reported_result

#: A turn in 0.5 s of a crank whose speed varies by 0.3 rad/s about its mean.
TURNED = np.linspace(0.0, 2.0 * np.pi, 1001)
TURN = {"time": TURNED / (4.0 * np.pi), "crank_angle": np.pi + TURNED, "crank_speed": 4.0 * np.pi + 0.15 * np.cos(TURNED)}


def test_a_number_in_another_unit_has_its_errors_and_their_parts_in_that_unit() -> None:
    part = ErrorPart("time", {"step": 1e-3}, {"step": 5e-4}, 0.02, 0.25, 4.0 / 3.0)
    number = Number(2.0, part.error, 0.1, 0.2, (part,), time=0.3, crank_angle=1.0, place=0.4).times(1e3)
    assert (number.value, number.measurement, number.settling) == pytest.approx((2e3, 1e2, 2e2))
    assert number.estimate == pytest.approx(sum(each.error for each in number.parts))
    assert (number.time, number.crank_angle, number.place) == (0.3, 1.0, 0.4)
    assert Number(2.0).times(3.0).estimate is None


def test_numbers_of_a_turn_are_those_of_the_closed_form() -> None:
    known = {"mean.crank_speed": 4.0 * np.pi, "variation.crank_speed": 0.3 / (4.0 * np.pi)}
    values = {each.name: each.of(TURN) for each in OF_TURN if each.name in known}
    assert values == pytest.approx(known)
    backwards = TURN | {"crank_angle": np.pi - TURNED, "crank_speed": -TURN["crank_speed"]}
    assert {each.name: each.of(backwards) for each in OF_TURN if each.name in known} == pytest.approx(values)


@pytest.mark.parametrize("rows", [40, 41, 400])
def test_a_number_of_a_turn_is_off_by_no_more_than_the_spacing_of_rows_says(rows: int) -> None:
    """The RMS of a sine's derivative by differences, whose error is of second order, and of first order at the ends."""

    def rms_of_rate(turn: Mapping[str, np.ndarray]) -> float:
        return rms_over_time(turn["time"], np.gradient(turn["crank_speed"], turn["time"]))

    time = np.linspace(0.0, 0.5, rows)
    turn = {"time": time, "crank_speed": np.sin(24.0 * np.pi * time)}
    error = abs(rms_of_rate(turn) - 24.0 * np.pi / np.sqrt(2.0))
    assert 1e-4 < error < by_spacing(rms_of_rate, turn, ("time", "crank_speed")) < 5.0 * error


def test_a_column_that_an_engine_does_not_give_leaves_no_number() -> None:
    mechanism = library_case("thesis-24").mechanism
    turn = {name: TURN[name] for name in ("time", "crank_angle")}
    run = Run(engine="foreign", estimate_of="total", status=Ending.SETTLED, cycle=turn)
    found = numbers(mechanism, run)
    assert found.keys() == MEASURES.keys()
    assert {name for name, number in found.items() if not math.isnan(number.value)} == {
        "mean.crank_speed",
        "period",
        *(f"{kind}.crank_angle" for kind in ("peak", "min", "max", "rms")),
    }
    assert found["variation.crank_speed"] == NO_NUMBER
    assert math.isnan(found["mean.crank_speed"].error)  # nothing was compared
    assert numbers(mechanism, Run(engine="foreign", estimate_of="total")) == {}


def test_what_is_left_to_the_steady_state_is_in_frequencies_and_amplitudes() -> None:
    """As far as the fit passes it on: by half of it relative to the signal for a frequency, by twice for an amplitude."""
    result, left = reported_result("thesis-24"), 1e-3
    run = result.runs["mujoco"]
    sizes = {name: rms_over_time(run.cycle["time"], run.cycle[name]) for name in CHANNELS}
    gains = {"first_mode_frequency_gain": 0.5, "first_mode_amplitude_gain": 2.0}
    measures = tuple(replace(each, variation=sizes[each.channel], **gains) for each in run.measured.measures)
    approach = replace(run.approach, settling_error=left)
    found = numbers(result.case.mechanism, replace(run, measured=replace(run.measured, measures=measures), approach=approach))
    for half in HALVES:
        for kind, gain in (("frequency", 0.5), ("amplitude", 2.0)):
            number = found[f"{half}.{kind}.strain_1"]
            assert number.settling == pytest.approx(gain * left * number.value)
        of_channels = [found[f"{half}.frequency.{name}"].settling for name in CHANNELS]
        resolved = [settling for settling in of_channels if settling > 0.0]
        assert found[f"{half}.frequency"].settling == pytest.approx(np.mean(resolved), rel=0.1)  # a weighted mean of those alike
