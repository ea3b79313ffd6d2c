"""A message about a wrong name shows what was typed, once, and where."""

from collections.abc import Callable
from typing import Any

import pytest

import quickreturn as qr
from quickreturn.cases.files.errors import CaseError
from quickreturn.cases.files.keys import PATHS
from quickreturn.plugins.studies.sweep.grid import scenes_of
from quickreturn.plugins.studies.uncertainty.calibration import frees_of

SOLVED = {"time [s]": [0.0, 0.1], "crank_angle [rad]": [0.0, 1.0]}
WRONG = {"tip.mass": "uniform 0 g .. 1 g"}

#: An argument, and the call with a value of it.
ARGUMENTS: list[tuple[str, Callable[[Any], Any]]] = [
    ("measures", lambda given: qr.sweep("thesis-24", {"tip.mass": "0 g; 1 g"}, measures=given)),
    ("measures", lambda given: qr.resonance("thesis-24", range="60 rpm .. 90 rpm", measures=given)),
    ("measures", lambda given: qr.uncertainty("thesis-24", WRONG, given)),
    ("free", lambda given: qr.calibrate("thesis-24", SOLVED, given)),
    ("vary", lambda name: qr.sweep("thesis-24", {name: "0 g; 1 g"})),
    ("path", lambda name: qr.sweep("thesis-24", {"tip.mass": "0 g; 1 g"}, path=name)),
    ("range", lambda name: qr.resonance("thesis-24", name, "60 rpm .. 90 rpm")),
    ("uncertain", lambda name: qr.uncertainty("thesis-24", {name: "uniform 0 g .. 1 g"}, ["multiplier"])),
]


@pytest.mark.parametrize(("argument", "ask"), ARGUMENTS)
def test_a_wrong_name_is_told_once_with_its_argument(argument: str, ask: Callable[[Any], Any]) -> None:
    several = argument in ("measures", "free")
    for given in ("wrong.name", *([["wrong.name"]] if several else [])):
        with pytest.raises(CaseError) as wrong:
            ask(given)
        assert str(wrong.value).startswith(f"{argument}: ")
        assert str(wrong.value).count("wrong.name") == 1
    for given in [[1], 1, [None], ["multiplier", 2.5]] if several else []:
        with pytest.raises(CaseError, match=r"(1|None|2\.5) is not a text; give one or several, such as "):
            ask(given)


def test_a_scene_of_a_study_that_cannot_be_names_no_option() -> None:
    """The sentence is stored with the point, whoever asked: `qr.sweep`, `qr.uncertainty` or the command."""
    (scene,) = scenes_of(qr.case("thesis-24"), [{"crank.length": "21 in"}])
    assert scene.sentence.startswith('crank.length: "21 in"')


def test_the_range_that_is_advised_is_accepted() -> None:
    """For every parameter that a fit may have: the example of a message is what the next call takes."""
    case, advised = qr.case("rigid"), 0
    for key, about in PATHS.items():
        if not about.is_number or not about.moves or key.startswith(("simulation.", "base.spin_up")):
            continue
        try:
            frees_of([key], case)
        except CaseError as wrong:
            text = wrong.accepted.partition('"')[2].partition('"')[0]
            (free,) = frees_of([text], case)
            assert free.parameter.key == key
            advised += 1
    assert advised > 5
