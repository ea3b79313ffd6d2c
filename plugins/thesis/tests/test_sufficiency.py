"""What would suffice for which statement, from a made-up study whose answer is known beforehand."""

import dataclasses

import pytest

from quickreturn.plugins.thesis.sufficiency import Trial, ratios, splits, sufficiency, trials
from quickreturn.plugins.thesis.tests.made_up_finding import made_up_finding

SETS = trials(made_up_finding())


def sets_that_show(statement: str) -> set[str]:
    return {each.row.effect for each in SETS if each.shown.get(statement)}


def test_only_a_roller_that_is_softer_after_the_return_makes_the_excess_larger_there() -> None:
    assert sets_that_show("post-excess") == sets_that_show("joint-cause") == {"post-side", "post-side-alloy"}
    assert [(each.effect.id, each.strength, each.one_sided) for each in splits(made_up_finding())] == [
        ("post-side", "20 kN/m", True),
        ("post-side-alloy", "10 kN/m", True),
    ]


def test_a_stiffer_strip_alone_puts_the_frequency_before_the_return_right() -> None:
    # one cubic is 12 % too stiff; 7.0 and 10.5 % are added by the strip of either alloy
    assert sets_that_show("pre-frequency") == {"strip", "post-side-alloy"}


def test_the_ratio_is_that_of_the_simulation_over_the_experiment() -> None:
    rows = {(row.effect, row.strength): row for row in made_up_finding() if row.engine != "mujoco"}
    found = ratios("post_frequency", rows["cubic", "1 element"], rows["linear", "6 kN/m"])
    assert found[12] == pytest.approx(1.12 / 0.94)
    assert 1 not in ratios("post_over_pre_frequency", rows["cubic", "1 element"], rows["linear", "6 kN/m"])  # not resolvable before


def test_132_hz_with_its_signs_needs_a_vibration_that_would_be_seen() -> None:
    assert sets_that_show("second-mode") == sets_that_show("second-mode-signs") == {"clearance", "pre-side"}
    weak = [dataclasses.replace(row, example=(*row.example[:2], 0.1, *row.example[3:])) for row in made_up_finding()]
    assert not any(each.shown["second-mode"] for each in trials(weak))


def test_what_nothing_shows_has_no_sets() -> None:
    found = sufficiency(SETS)
    by_id = {each.statement.id: each for each in found}
    assert by_id["post-excess"].choices == 3  # side, stiffness, losses
    assert by_id["pre-amplitude-long-crank"].sets == []  # runs 1 to 8 have one amplitude in all sets, the simulation's
    assert isinstance(by_id["pre-amplitude-long-crank"].best, Trial)


def test_without_a_study_nothing_is_concluded() -> None:
    assert trials([]) == []
    assert splits([]) == []
