"""What the thesis saw: the heading, and the stiffness."""

import dataclasses

import pytest
from quickreturn.plugins.thesis.conclusions import CANNOT_FOLLOW, HOLDS, IN_PART, NOT, UNCHECKABLE
from quickreturn.plugins.thesis.finding.effects import effects
from quickreturn.plugins.thesis.sufficiency import Split, splits
from quickreturn.plugins.thesis.tests.made_up_finding import made_up_finding

from quickreturn.plugins.thesis.chapters.thesis import finding, stiffness_words
from quickreturn.plugins.thesis.experiment.stiffness import StiffnessReading, stiffness_reading
from quickreturn.plugins.thesis.page_data import finding_of as of_finding
from tests.reports.pages import finding_of, one_run, plain

OUTCOMES = [HOLDS, IN_PART, IN_PART, NOT, CANNOT_FOLLOW, *[UNCHECKABLE] * 8]
BY_ID = {effect.id: effect for effect in effects()}
SOFT, FRICTION = (Split(BY_ID[name], "20 kN/m", 0.002, -0.0204) for name in ("post-side", "friction"))


@pytest.mark.parametrize(
    ("found", "against", "symmetric", "ratios", "words"),
    [
        (
            [SOFT],
            "it was tightened",
            False,
            {},
            ["softer on one side", "by +0.2 % before and −2.0 %", "but it was", "no symmetric"],
        ),
        ([SOFT, FRICTION], "", True, {}, ["one that is not symmetric"]),
        ([], "", True, {"pre": [1.12, 1.14], "post": [1.13]}, ["stiff before and after the return alike (1.13 and 1.13", "2 and 1 runs"]),
        ([], "", True, {"pre": [1.10], "post": [1.15]}, ["stiff before and after the return (1.10 and 1.15"]),
        ([], "", True, {"pre": [0.90], "post": [0.95]}, ["soft before"]),
        ([], "", True, {"pre": [1.1], "post": []}, ["checked one by one"]),
    ],
)
def test_the_heading_names_what_makes_the_halves_differ_or_how_stiff_the_cubic_is(
    found: list[Split], against: str, symmetric: bool, ratios: dict[str, list[float]], words: list[str]
) -> None:
    told = plain(finding(found, against, symmetric, ratios, OUTCOMES))
    assert all(each in told for each in words), told
    assert told.endswith("13 statements: 1 holds, 2 hold in part, 1 does not hold, 1 cannot follow from the model, 8 cannot be checked")
    assert ("no symmetric" in told) == (bool(found) and not symmetric)


def test_the_heading_is_about_the_study_that_is_recorded() -> None:
    study = made_up_finding()
    told, (soft, *_) = finding_of(one_run(data={of_finding: study}), "thesis"), splits(study)
    assert soft.strength == "20 kN/m"
    assert told.startswith(
        "What made the halves differ is open. Of the effects tried one at a time, a roller that is softer on one side would: at 20 kN/m by "
    )
    assert "no symmetric effect tried" in told
    assert finding_of(one_run(), "thesis").startswith("Its one cubic is too stiff before and after the return alike (1.13 and 1.1")


def test_the_stiffness_stands_beside_that_of_aluminium() -> None:
    reading = StiffnessReading("2128.22 lbf*in^2", 64.2e9, (0.07, 0.09), 0.2)
    told = plain(stiffness_words(reading))
    assert all(each in told for each in ("2128.22 lbf in²", "64.2 GPa", "7 to 9 %", "20 % lower", "though not all the way"))
    assert "though" not in stiffness_words(dataclasses.replace(reading, needed=0.08))
    assert "lower" not in stiffness_words(dataclasses.replace(reading, needed=None))
    assert stiffness_words(stiffness_reading([])).startswith("EI = ")
